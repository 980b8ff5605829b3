use super::*;
use crate::{CurveUnit, Node};
use proptest::prelude::*;
use std::f64::consts::TAU;

fn curve(points: Vec<Point2>, closed: bool) -> Curve {
    Curve::new(points.into_iter().map(Node::at).collect(), closed).unwrap()
}

fn circle(radius: f64, count: u32) -> Curve {
    let at = |k: u32| TAU * f64::from(k) / f64::from(count);
    let point = |a: f64| Point2::new(5e5 + radius * a.cos(), 5.4e6 + radius * a.sin());
    curve((0..count).map(|k| point(at(k))).collect(), true)
}

/// Largest distance of the splines from the curve, by many samples, and back, beyond what their
/// chords explain.
fn apart(curve: &Curve, splines: &CurveSplines) -> [f64; 2] {
    let (mut samples, mut chords) = (Vec::new(), 0.0_f64);
    for piece in &splines.pieces {
        // Corners are at knots alone, so each span between knots has samples of its own.
        let spans = piece.knots().windows(2).filter(|knots| knots[1] > knots[0]);
        let count = (60 * piece.controls().len()).clamp(1500, 5000) / spans.clone().count();
        for knots in spans {
            let at = |k: usize| knots[0] + (knots[1] - knots[0]) * k as f64 / count.max(8) as f64;
            let own: Vec<_> = (0..=count.max(8)).map(|k| piece.point(at(k))).collect();
            // A sample leaves the chord of its neighbours by four times what the spline leaves its
            // own.
            let bend = |w: &[Point2]| CurveUnit { start: w[0], end: w[2] }.distance(&w[1]);
            chords = own.windows(3).map(bend).fold(chords, f64::max);
            samples.extend(own);
        }
    }
    let from_curve = samples.iter().map(|p| curve.foot(p).distance).fold(0.0, f64::max);
    let line = self::curve(samples, splines.closed);
    let along = curve.units().flat_map(|u| (0..4).map(move |k| u.at(f64::from(k) / 4.0)));
    let from_splines = along.map(|p| line.foot(&p).distance).fold(0.0, f64::max);
    [from_curve, from_splines - chords]
}

fn check(curve: &Curve, tolerance: f64) -> CurveSplines {
    let splines = fit_splines(curve, tolerance).unwrap();
    assert!(splines.deviation <= tolerance);
    let [a, b] = apart(curve, &splines);
    assert!(a <= splines.deviation + 1e-8, "{a} beyond the bound {}", splines.deviation);
    assert!(b <= splines.deviation + 1e-8, "{b} beyond the bound {}", splines.deviation);
    let ends =
        splines.pieces.iter().map(|p| (p.controls()[0], p.controls()[p.controls().len() - 1]));
    let ends: Vec<_> = ends.collect();
    assert!(ends.windows(2).all(|w| (w[0].1 - w[1].0).norm() < 1e-7), "pieces meet");
    if splines.closed {
        assert!((ends[ends.len() - 1].1 - ends[0].0).norm() < 1e-7, "the last meets the first");
    }
    for piece in &splines.pieces {
        assert_eq!(piece.knots().len(), piece.controls().len() + 4);
        assert!(piece.knots().is_sorted());
    }
    splines
}

#[test]
fn a_circle_is_one_periodic_spline_of_few_points() {
    let circle = circle(3.0, 720);
    let splines = check(&circle, 1e-3);
    assert_eq!(splines.pieces.len(), 1);
    assert!(splines.pieces[0].controls().len() < 40, "{}", splines.pieces[0].controls().len());
    // Smooth at the seam: the first and the last leg of its control polygon are in line.
    let c = splines.pieces[0].controls();
    let (first, last) = (c[1] - c[0], c[c.len() - 1] - c[c.len() - 2]);
    assert!(first.angle(&last) < 1e-6, "{}", first.angle(&last));
}

#[test]
fn corners_are_kept_exactly() {
    let mut points = Vec::new();
    for (from, to) in [((0.0, 0.0), (4.0, 0.0)), ((4.0, 0.0), (4.0, 3.0)), ((4.0, 3.0), (0.0, 0.0))]
    {
        let (from, to) = (Point2::new(from.0, from.1), Point2::new(to.0, to.1));
        points.extend((0..50).map(|k| from + (to - from) * (f64::from(k) / 50.0)));
    }
    let splines = check(&curve(points, true), 1e-3);
    assert_eq!(splines.pieces.len(), 3);
    let starts: Vec<_> = splines.pieces.iter().map(|p| p.controls()[0]).collect();
    for corner in [Point2::new(0.0, 0.0), Point2::new(4.0, 0.0), Point2::new(4.0, 3.0)] {
        assert!(starts.contains(&corner), "{starts:?}");
    }
    assert!(
        splines.pieces.iter().all(|p| p.controls().len() == 4),
        "straight pieces need no knots"
    );
}

#[test]
fn any_tolerance_can_be_had_down_to_the_polyline_itself() {
    let zigzag = (0..60).map(|k| Point2::new(f64::from(k), if k % 2 == 0 { 0.0 } else { 0.1 }));
    let zigzag = curve(zigzag.collect(), false);
    for tolerance in [1.0, 0.1, 1e-2, 1e-4, 1e-9] {
        check(&zigzag, tolerance);
    }
    check(&curve(vec![Point2::new(0.0, 0.0), Point2::new(1.0, 2.0)], false), 1e-3);
    let triangle = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Point2::new(x, y));
    check(&curve(triangle.to_vec(), true), 1e-3);
}

#[test]
fn tolerances_that_are_none_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(fit_splines(&circle(1.0, 12), bad).is_err());
    }
}

/// A closed curve of two places runs there and back.
#[test]
fn a_closed_curve_with_a_repeated_node_stays_closed() {
    for apart in [2.0, 0.01] {
        let (a, b) = (Point2::origin(), Point2::new(apart, 0.0));
        for points in [[a, b, b], [a, a, b], [a, b, a]] {
            let splines = fit_splines(&curve(points.to_vec(), true), 0.1).unwrap();
            // The first and the last knot of a piece are repeated, so its curve ends there.
            let ends = |piece: &CubicSpline| {
                [piece.knots[0], piece.knots[piece.knots.len() - 1]].map(|at| piece.point(at))
            };
            let ends: Vec<_> = splines.pieces.iter().map(ends).collect();
            assert!(splines.closed);
            assert_eq!(ends, [[a, b], [b, a]], "{points:?}");
        }
    }
}

#[test]
fn a_curve_in_one_place_has_no_spline() {
    let place = vec![Point2::new(1.0, 2.0); 3];
    for closed in [false, true] {
        let splines = fit_splines(&curve(place.clone(), closed), 0.1).unwrap();
        assert!(splines.pieces.is_empty() && splines.deviation == 0.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn the_bound_holds_in_both_directions(
        radii in prop::collection::vec(0.6..1.4f64, 8..12), noise in 0.0..0.02f64, closed: bool,
        tolerance in -4.0..-1.0f64, seed in prop::collection::vec(-1.0..1.0f64, 200),
    ) {
        // A smooth ring through random radii, with noise across.
        let n = radii.len();
        let radius = |k: usize| {
            let at = k as f64 / 200.0 * n as f64;
            let (i, f) = (at as usize, at.fract());
            let blend = f * f * (3.0 - 2.0 * f);
            radii[i % n] * (1.0 - blend) + radii[(i + 1) % n] * blend + noise * seed[k]
        };
        let point = |k: usize| {
            let a = TAU * k as f64 / 200.0;
            Point2::new(radius(k) * a.cos(), radius(k) * a.sin())
        };
        check(&curve((0..200).map(point).collect(), closed), 10_f64.powf(tolerance));
    }

    #[test]
    fn wild_points_are_described_too(
        points in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 4..30), closed: bool,
    ) {
        let points = points.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
        check(&curve(points, closed), 0.05);
    }
}
