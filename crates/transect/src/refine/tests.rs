//! Solids whose sections are known by formula.

use super::*;
use crate::RefinementError;
use std::f64::consts::{PI, TAU};
use transect_fusion::{FusedPlane, FusionCounts};
use transect_geometry::{Curve, LengthUnit, Node, Point2, StraightGuide, Vector3};
use transect_model::Model;

/// Planes across z every 0.5, halved four times.
fn refinement() -> Refinement {
    Refinement::new(0.06, 4).unwrap()
}

fn coarse() -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.0, 0.5).unwrap()
}

fn disc(radius: f64) -> Vec<Curve> {
    if radius.is_nan() || radius < 1e-9 {
        return Vec::new();
    }
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) * TAU / 2000.0).sin_cos();
        Node::at(Point2::new(radius * cos, radius * sin))
    };
    vec![Curve::new((0..2000).map(at).collect(), true).unwrap()]
}

/// Refines the solid of revolution whose radius at height z is `radius(z)`, between -3 and 3.
fn refined(radius: impl Fn(f64) -> f64 + Sync) -> (PlaneFamily, Refined) {
    let planes = refinement().family(&coarse()).unwrap();
    let found: Vec<(PlaneIndex, Vec<Curve>)> = (-96..=96)
        .map(|k| (PlaneIndex(k), disc(radius(planes.station(PlaneIndex(k))))))
        .filter(|(_, curves)| !curves.is_empty())
        .collect();
    let observed: Observed =
        found.iter().map(|(k, curves)| (*k, vec![PackedCurves::new(curves)])).collect();
    let fuse = |asked: &[PlaneIndex]| {
        let of = |k: &PlaneIndex| {
            let curves = observed.get(k)?[0].curves();
            let counts = FusionCounts::default();
            let plane = FusedPlane { curves, counts, ..FusedPlane::default() };
            Some(Fused { index: *k, plane, seen_through: 0, surface_sigmas: Vec::new() })
        };
        Ok(asked.iter().filter_map(of).collect())
    };
    let refined = refine(&refinement(), &planes, &observed, fuse).unwrap();
    (planes, refined)
}

fn model((planes, refined): &(PlaneFamily, Refined), keep: impl Fn(i64) -> bool) -> Model {
    let selected = refined.selected.iter().copied().filter(|k| keep(k.0));
    let mut model = Model::new(LengthUnit::Metre, planes.clone()).with_selection(selected);
    for fused in refined.fused.iter().filter(|f| keep(f.index.0)) {
        model.set_curves(fused.index, fused.plane.curves.clone());
    }
    model
}

/// The planes that were inserted, as stations.
fn inserted((planes, refined): &(PlaneFamily, Refined)) -> Vec<f64> {
    let inserted = refined.selected.iter().filter(|k| k.0 % 16 != 0);
    inserted.map(|k| planes.station(*k)).collect()
}

#[test]
fn a_step_gets_planes_down_to_the_smallest_interval_and_a_prism_none() {
    // It begins and ends within the first interval beyond -2 and 2, and steps at 0.3.
    let stepped = refined(|z| match z {
        z if z.abs() > 2.01 => 0.0,
        z if z < 0.3 => 1.0,
        _ => 0.6,
    });
    let near = |z: &f64, at: f64| (z - at).abs() < 0.5;
    let inserted = inserted(&stepped);
    assert!(inserted.iter().all(|z| near(z, 0.3) || near(z, -2.0) || near(z, 2.0)), "{inserted:?}");
    // Bisection asks for one plane on each level.
    assert_eq!(inserted.iter().filter(|z| near(z, 0.3)).count(), 4, "{inserted:?}");
    let report = &stepped.1.report;
    assert_eq!((report.planes_inserted, report.intervals_above_tolerance), (12, 3));
    let last: Vec<_> = report.gaps.iter().filter(|gap| gap.inserted.is_none()).collect();
    let reasons: Vec<_> = last.iter().map(|gap| gap.reason).collect();
    use DifferenceReason::{CurveAppears, CurveVanishes, CurvesMove};
    assert_eq!(reasons, [CurveAppears, CurvesMove, CurveVanishes]);
    let step = last[1];
    assert!(step.from_station < 0.3 && 0.3 <= step.to_station, "{step:?}");
    assert!((step.to_station - step.from_station - 0.5 / 16.0).abs() < 1e-12);
    assert!((step.distance.unwrap() - 0.4).abs() < 1e-3, "{step:?}");
    assert!((step.length - TAU * 1.6).abs() < 0.01, "{step:?}");
}

#[test]
fn a_ball_gets_more_planes_near_its_poles_and_a_better_volume() {
    let ball = refined(|z| (2.25 - z * z).sqrt());
    let inserted = inserted(&ball);
    let between =
        |low: f64, high: f64| inserted.iter().filter(|z| (low..high).contains(&z.abs())).count();
    assert!(between(1.0, 1.5) > between(0.5, 1.0) && between(0.5, 1.0) > between(0.0, 0.5));
    assert!(between(0.0, 0.5) > 0 && ball.1.report.planes < 97, "{}", ball.1.report.planes);
    let exact = 4.0 / 3.0 * PI * 1.5_f64.powi(3);
    let volume = |keep: fn(i64) -> bool| model(&ball, keep).volume();
    let (fine, coarse) = (volume(|_| true), volume(|k| k % 16 == 0));
    let error = |volume: f64| (volume - exact).abs();
    let fine_error = error(fine.solid.bracket.estimate);
    let coarse_error = error(coarse.solid.bracket.estimate);
    assert!(fine_error < 0.1 * coarse_error, "{fine:?} {coarse:?}");
    assert!(fine_error < fine.solid.interval_error);
    assert_eq!(fine.runs.len(), 1);
}

#[test]
fn neighbours_of_the_result_differ_by_no_more_than_the_tolerance_or_are_reported() {
    let cone = refined(|z| if z.abs() < 1.2 { 0.3 + (z + 1.2) * 0.4 } else { 0.0 });
    let neighbours = cone.1.selected.iter().zip(cone.1.selected.iter().skip(1));
    let fused = |k: &PlaneIndex| {
        let found = cone.1.fused.iter().find(|fused| fused.index == *k);
        found.map_or(Vec::new(), |fused| fused.plane.curves.clone())
    };
    let mut reported = 0;
    for (a, b) in neighbours {
        let gap = cone.1.report.gaps.iter().find(|gap| (gap.from, gap.to) == (*a, *b));
        assert_eq!(difference(&fused(a), &fused(b), 0.06).is_some(), gap.is_some(), "{a} {b}");
        assert!(gap.is_none_or(|gap| gap.inserted.is_none() && b.0 - a.0 == 1));
        reported += usize::from(gap.is_some());
    }
    assert_eq!(reported, cone.1.report.intervals_above_tolerance);
    assert_eq!(reported, 2, "the two ends");
}

#[test]
fn what_lies_between_two_planes_without_curves_is_found() {
    let coin = refined(|z| if (z - 0.7).abs() < 0.05 { 1.0 } else { 0.0 });
    assert!(!coin.1.fused.is_empty());
    assert_eq!(coin.1.report.gaps[0].reason, DifferenceReason::CurvesBetween);
    assert!(inserted(&coin).iter().all(|z| (0.5..1.0).contains(z)));
}

#[test]
fn gaps_of_any_size_make_no_planes() {
    let curves = disc(1.0);
    let observed: Observed =
        [0, 1 << 40].map(|k| (PlaneIndex(k), vec![PackedCurves::new(&curves)])).into();
    let first = refinement().first_planes(&coarse(), &observed);
    let planes: Vec<i64> = first.into_iter().map(|k| k.0).collect();
    let far = 1_i64 << 40;
    assert_eq!(planes, [-16, 0, 16, far - 16, far, far + 16]);
}

#[test]
fn impossible_refinements_say_what_is_possible() {
    let text = |result: Result<Refinement, RefinementError>| result.unwrap_err().to_string();
    assert_eq!(text(Refinement::new(0.0, 2)), "the tolerance must be a positive length, got 0");
    assert_eq!(text(Refinement::new(1.0, 11)), "the interval can be halved 1 to 10 times, not 11");
    assert!(Refinement::new(f64::NAN, 2).is_err() && Refinement::new(1.0, 0).is_err());
    assert_eq!(Refinement::down_to(1.0, 0.8, 0.1), Refinement::new(1.0, 3));
    assert_eq!(
        text(Refinement::down_to(1.0, 0.8, 0.3)),
        "the smallest interval 0.3 is not 0.8 halved 1 to 10 times: 0.4, 0.2, 0.1, 0.05, …"
    );
    for least in [0.8, 0.0, -0.4, f64::NAN] {
        assert!(Refinement::down_to(1.0, 0.8, least).is_err(), "{least}");
    }
}
