//! Figures 5.3 to 5.5 of the dissertation, and random curves.

use super::*;
use crate::envelopes::PlaneEnvelopes;
use crate::pattern::{OverlapTolerance, classify};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_3;
use transect_geometry::{Node, Point2};

const TOLERANCE: f64 = 0.1;

fn polyline(points: &[(f64, f64)]) -> Curve {
    let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, false).unwrap()
}

fn arc(centre: (f64, f64), radius: f64, degrees: std::ops::RangeInclusive<i32>) -> Curve {
    let at = |degree: i32| {
        let (sin, cos) = f64::from(degree).to_radians().sin_cos();
        (centre.0 + radius * cos, centre.1 + radius * sin)
    };
    polyline(&degrees.step_by(5).map(at).collect::<Vec<_>>())
}

/// Two curves whose envelopes meet, by their places in the two lists that were screened.
#[derive(Debug, PartialEq)]
struct CandidatePair {
    first: usize,
    second: usize,
    common: Envelope,
}

/// The pairs of curves from two lists whose envelopes, each grown by a tolerance, meet.
fn candidate_pairs(first: &[Curve], second: &[Curve], tolerance: f64) -> Vec<CandidatePair> {
    let mut envelopes = PlaneEnvelopes::new(tolerance);
    second.iter().enumerate().for_each(|(k, curve)| envelopes.insert(k, curve));
    let pairs_of = |(first, curve): (usize, &Curve)| {
        let meeting = envelopes.meeting(curve).into_iter();
        meeting.map(move |m| CandidatePair { first, second: m.curve, common: m.common })
    };
    first.iter().enumerate().flat_map(pairs_of).collect()
}

/// Whether envelopes meet; whether the common rectangle keeps the pair; how many overlaps there
/// are.
fn stages(a: &Curve, b: &Curve) -> (bool, bool, usize) {
    let pairs = candidate_pairs(std::slice::from_ref(a), std::slice::from_ref(b), TOLERANCE);
    let kept = pairs.iter().any(|pair| may_overlap(a, b, &pair.common, FRAC_PI_3));
    let tolerance = OverlapTolerance::within(TOLERANCE).unwrap();
    (!pairs.is_empty(), kept, classify(a, b, &tolerance).as_slice().len())
}

#[test]
fn envelopes_meet_in_the_three_patterns_of_figure_5_3() {
    // h1 is a quarter circle; an overlapping curve meets its envelope at a corner, at a side,
    // and from within.
    let h1 = arc((0.0, 0.0), 4.0, 0..=90);
    let at_a_corner = arc((0.0, 0.0), 4.0, 70..=130);
    let at_a_side = arc((0.0, 0.0), 4.0, -20..=20);
    let within = arc((0.0, 0.0), 4.0, 30..=60);
    for other in [&at_a_corner, &at_a_side, &within] {
        assert_eq!(stages(&h1, other), (true, true, 1));
    }
}

#[test]
fn the_dashed_envelopes_of_figure_5_3_are_rejected_by_the_common_rectangle() {
    // Straight diagonal curves leave two corners of their envelopes empty.
    let h1 = polyline(&[(0.0, 0.0), (4.0, 4.0)]);
    let at_the_corner = polyline(&[(3.5, -1.0), (5.0, 0.5)]);
    let at_the_side = polyline(&[(3.0, 0.5), (5.0, 1.0)]);
    let within = polyline(&[(2.5, 0.5), (3.5, 1.5)]);
    for other in [&at_the_corner, &at_the_side, &within] {
        assert_eq!(stages(&h1, other), (true, false, 0));
        assert_eq!(stages(other, &h1), (true, false, 0));
    }
}

#[test]
fn the_worst_cases_of_figure_5_4_are_left_to_verification() {
    // Both curves have units of one direction in the common rectangle, and yet do not overlap.
    let h1 = arc((0.0, 0.0), 4.0, 0..=90);
    let corner = arc((0.0, 0.0), 3.6, 60..=150);
    let side = arc((0.0, 0.0), 3.6, -40..=40);
    let within = arc((0.0, 0.0), 3.6, 30..=60);
    for other in [&corner, &side, &within] {
        assert_eq!(stages(&h1, other), (true, true, 0));
    }
}

#[test]
fn neighbouring_surfaces_that_face_each_other_are_rejected_by_direction() {
    // Figure 5.5: the two sides of a sheet, nearer to each other than the tolerance.
    let upper = polyline(&[(4.0, 0.05), (2.0, 0.05), (0.0, 0.05)]);
    let lower = polyline(&[(0.0, 0.0), (2.0, 0.0), (4.0, 0.0)]);
    assert_eq!(stages(&upper, &lower), (true, false, 0));
    assert_eq!(stages(&upper.reversed(), &lower), (true, true, 1));
}

#[test]
fn directions_are_compared_across_the_half_turn() {
    assert!(least_turn(3.1, &[-3.1, 0.0]) < 0.1);
    assert!(least_turn(-3.1, &[0.0, 3.1]) < 0.1);
    assert_eq!(least_turn(0.0, &[]), f64::INFINITY);
}

fn curves() -> impl Strategy<Value = Vec<Curve>> {
    let place = (-9.0..9.0, -9.0..9.0);
    let shape = prop::collection::vec((0.0..3.0, 0.0..1.0), 2..5);
    let curve = (place, shape).prop_map(|((x, y), shape)| {
        polyline(&shape.iter().map(|(u, v)| (x + u, y + v)).collect::<Vec<_>>())
    });
    prop::collection::vec(curve, 0..12)
}

proptest! {
    #[test]
    fn no_overlap_is_lost_by_screening(a in curves(), b in curves()) {
        let tolerance = OverlapTolerance::within(TOLERANCE).unwrap();
        for (p, q) in a.iter().zip(&b) {
            let found = classify(p, q, &tolerance).as_slice().len();
            prop_assert!(found == 0 || stages(p, q).1);
        }
    }

    #[test]
    fn a_rectangle_is_touched_by_what_has_a_point_in_it(
        a in (-2.0..2.0, -2.0..2.0), b in (-2.0..2.0, -2.0..2.0),
    ) {
        let rectangle = Envelope { min: Point2::new(-0.5, -0.3), max: Point2::new(0.7, 0.4) };
        let unit = CurveUnit { start: Point2::new(a.0, a.1), end: Point2::new(b.0, b.1) };
        let sampled = (0..=1000).any(|i| rectangle.contains(&unit.at(f64::from(i) / 1000.0)));
        let grown = rectangle.grown(-0.01);
        let safely = (0..=1000).any(|i| grown.contains(&unit.at(f64::from(i) / 1000.0)));
        prop_assert!(!sampled || touches(&unit, &rectangle));
        prop_assert!(touches(&unit, &rectangle) || !safely);
    }
}
