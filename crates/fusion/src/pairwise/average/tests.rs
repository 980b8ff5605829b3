//! Figures 5.10 to 5.12 of the dissertation, with numbers worked out by hand.

use super::*;
use crate::pairwise::verify::verify;
use crate::pattern::CurveRange;
use transect_geometry::{Curve, Point2};

const LIMITS: Limits = Limits { threshold: 0.5, least_cosine: 0.5 };

/// The whole of a curve as the enclosed part.
fn section(points: &[(f64, f64)]) -> Strand {
    let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    let curve = Curve::new(nodes, false).unwrap();
    Strand::new(&curve, &CurveRange { from: 0.0, to: curve.length() })
}

fn averaged(basis: &Strand, distant: &Strand) -> Averaged {
    let start = verify([basis, distant], &LIMITS).unwrap();
    average([basis, distant], &start, &LIMITS)
}

fn assert_places(found: &[Node], expected: &[(f64, f64)]) {
    let places: Vec<_> = found.iter().map(|n| (n.position.x, n.position.y)).collect();
    assert_eq!(places.len(), expected.len(), "{places:?}");
    for (p, q) in places.iter().zip(expected) {
        assert!((p.0 - q.0).abs() < 1e-12 && (p.1 - q.1).abs() < 1e-12, "{places:?}");
    }
}

#[test]
fn a_units_new_node_is_its_middle_moved_by_half_the_mean() {
    // Figure 5.10: three points over one unit, then two over the next.
    let basis = section(&[(0.0, 0.0), (4.0, 0.0), (8.0, 0.0)]);
    let distant = section(&[(0.5, 0.1), (1.5, 0.3), (3.0, 0.2), (5.0, -0.1), (7.0, 0.4)]);
    let found = averaged(&basis, &distant);
    assert_places(&found.nodes, &[(2.0, 0.6 / 6.0), (6.0, 0.3 / 4.0)]);
    assert_eq!((found.heads, found.tails), ([1, 0], [2, 5]));
    let first = &found.nodes[0];
    assert_eq!(first.weight, 4.0);
}

#[test]
fn new_nodes_lie_in_the_frame_of_their_unit() {
    // The same turned by a quarter, with the distant curve on the left at half a threshold.
    let basis = section(&[(0.0, 0.0), (0.0, 4.0)]);
    let distant = section(&[(-0.2, 1.0), (-0.4, 3.0)]);
    assert_places(&averaged(&basis, &distant).nodes, &[(-0.6 / 4.0, 2.0)]);
}

#[test]
fn errors_shrink_as_in_an_average() {
    let curve = |sigma: f32, points: &[(f64, f64)]| {
        let node = |&(x, y): &(f64, f64)| Node::at(Point2::new(x, y)).with_sigma(sigma);
        let curve = Curve::new(points.iter().map(node).collect(), false).unwrap();
        Strand::new(&curve, &CurveRange { from: 0.0, to: curve.length() })
    };
    let basis = curve(0.2, &[(0.0, 0.0), (4.0, 0.0)]);
    let distant = curve(0.4, &[(0.5, 0.1), (1.0, 0.1), (1.5, 0.1), (2.0, 0.1)]);
    // Half the middle of two nodes of 0.2, half the mean of four of 0.4.
    let expected = 0.5 * (0.02_f32 + 0.04).sqrt();
    assert!((averaged(&basis, &distant).nodes[0].sigma - expected).abs() < 1e-6);
}

#[test]
fn a_point_beyond_the_next_unit_exchanges_basis_and_distant_curve() {
    // Figure 5.11 (b): q4 at x = 9 lies beyond p_c at 4. The new unit is q3 q4, from 1.5 to 9, and
    // p_b, p_c, p_d at 2, 4 and 6 are its points.
    let basis = section(&[(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (6.0, 0.0), (10.0, 0.0)]);
    let distant = section(&[(0.5, 0.3), (1.0, 0.3), (1.5, 0.3), (9.0, 0.3)]);
    let found = averaged(&basis, &distant);
    // The unit p_d p_e covers no point of its own: the distant curve has none behind q4.
    assert_places(&found.nodes, &[(1.0, 0.15), (5.25, 0.15)]);
    assert!(found.noise.is_empty());
}

#[test]
fn a_finer_curve_on_either_side_gives_the_same_place() {
    let coarse: Vec<_> = (0..6).map(|k| (2.0 * f64::from(k), 0.0)).collect();
    let fine: Vec<_> = (0..40).map(|k| (0.1 + 0.25 * f64::from(k), 0.2)).collect();
    let (coarse, fine) = (section(&coarse), section(&fine));
    for (a, b) in [(&coarse, &fine), (&fine, &coarse)] {
        let found = averaged(a, b);
        assert!(found.nodes.len() >= 4);
        assert!(found.nodes.iter().all(|n| (n.position.y - 0.1).abs() < 1e-12));
    }
}

/// Along x to a corner at (4, 0), then on in a direction, with nodes every half unit.
fn cornered(turn_degrees: f64, offset: f64) -> Strand {
    let turn = turn_degrees.to_radians();
    let before = (0..=8).map(|k| (0.5 * f64::from(k), 0.0));
    let behind = (1..=8).map(|k| {
        let s = 0.5 * f64::from(k);
        (4.0 + s * turn.cos(), s * turn.sin())
    });
    // Into the corner's inside, along its bisector.
    let (x, y) = (-(0.5 * turn).sin() * offset, (0.5 * turn).cos() * offset);
    let points: Vec<_> = before.chain(behind).map(|(u, v)| (u + x, v + y)).collect();
    section(&points)
}

#[test]
fn both_corners_of_figure_5_12_are_followed_from_inside_and_outside() {
    // (a): a turn below 90°, |y| rises. (b): a turn above 90°, x falls.
    for turn in [40.0, 75.0, 90.0, 110.0, 140.0] {
        for offset in [-0.3, -0.1, 0.1, 0.3] {
            let (basis, distant) = (cornered(turn, 0.0), cornered(turn, offset));
            let found = averaged(&basis, &distant);
            // The new curve comes up to the end of the second leg, half way between the two.
            let (last, leg) = (found.nodes.last().unwrap().position, turn.to_radians());
            let (x, y) = (last.x - 4.0, last.y);
            let (along, across) = (x * leg.cos() + y * leg.sin(), y * leg.cos() - x * leg.sin());
            assert!(along > 3.0, "{turn} {offset}: the leg ends at {along}");
            let half = 0.5 * offset * (0.5 * leg).cos();
            assert!((across - half).abs() < 1e-9, "{turn} {offset}: {across} for {half}");
            let steps = found.nodes.windows(2).map(|w| (w[1].position - w[0].position).norm());
            assert!(steps.fold(0.0, f64::max) < 2.0, "{turn} {offset}: a leap");
        }
    }
}

#[test]
fn points_in_the_wedge_outside_a_bend_count() {
    // Behind the end of the first unit and before the start of the second.
    let basis = section(&[(0.0, 0.0), (4.0, 0.0), (6.0, 12_f64.sqrt())]);
    let distant = section(&[(1.0, -0.2), (3.0, -0.2), (4.2, -0.25), (5.2, 1.7), (6.0, 3.1)]);
    let found = averaged(&basis, &distant);
    assert!(found.noise.is_empty());
    let weights: Vec<_> = found.nodes.iter().map(|n| n.weight).collect();
    // The corner itself stays, or the chord would cut it.
    assert_eq!(weights, [3.0, 1.0, 4.0]);
}

#[test]
fn a_corner_is_followed_though_noise_breaks_the_rise() {
    // Round the corner, |y| is 0.6, 0.55, 1, ...
    let basis = cornered(90.0, 0.0);
    let leg = [0.6, 0.55, 1.0, 1.4, 1.8, 2.3, 2.7, 3.1].map(|y| (3.7, y));
    let before = [0.2, 0.6, 1.1, 1.6, 2.1, 2.6, 3.1, 3.6].map(|x| (x, 0.3));
    let found = averaged(&basis, &section(&[before.as_slice(), &leg].concat()));
    assert!(found.noise.is_empty(), "{:?}", found.noise);
    assert!(found.nodes.last().unwrap().position.y > 2.4);
}

#[test]
fn a_point_that_turns_back_is_not_added_to_the_leg_before_the_corner() {
    // x falls to -0.2 and -0.8 in the unit from 3 to 4. The first of the two is near its start, but
    // on the way to the second, which lies on the other leg; nothing there is near enough to it.
    let leg = |s: f64| (4.0 - s * 0.75_f64.sqrt(), 0.5 * s);
    let along = [0.0, 1.0, 2.0, 3.0].map(|x| (x, 0.0));
    let basis = section(&[along, [0.0, 1.0, 2.0, 3.0].map(leg)].concat());
    let distant =
        [(0.5, 0.1), (1.5, 0.1), (2.5, 0.1), (3.3, 0.1), (2.8, 0.1), (2.2, 0.9), (1.6, 1.2)];
    assert_eq!(averaged(&basis, &section(&distant)).noise, [(1, 4)]);
}

#[test]
fn a_dimple_is_left_out() {
    // One point, and a run of points that rises beyond the threshold and falls again.
    for (from, tip) in [(9, 9), (8, 12)] {
        let basis: Vec<_> = (0..20).map(|k| (f64::from(k), 0.0)).collect();
        let height = |k: i32| {
            let depth = (k - from + 1).min(tip - k + 1).max(0);
            if depth > 0 { 0.6 + 0.2 * f64::from(depth) } else { 0.1 }
        };
        let distant: Vec<_> = (0..19).map(|k| (0.5 + f64::from(k), height(k))).collect();
        let found = averaged(&section(&basis), &section(&distant));
        let noise: Vec<_> = (from..=tip).map(|k| (1, k as usize)).collect();
        assert_eq!(found.noise, noise);
        let level = |n: &Node| (n.position.y - 0.05).abs() < 1e-12;
        assert!(found.nodes.iter().all(level), "{:?}", found.nodes);
        assert!(found.nodes.len() >= 14);
    }
}

#[test]
fn a_unit_does_not_end_in_the_tip_of_a_dimple() {
    // The tip at x = 4.5 lies beyond the unit that follows the one before it.
    let basis: Vec<_> = (0..10).map(|k| (f64::from(k), 0.0)).collect();
    let distant = [(0.5, 0.2), (1.5, 0.2), (4.5, 1.5), (6.5, 0.2), (8.5, 0.2)];
    let found = averaged(&section(&basis), &section(&distant));
    assert_eq!(found.noise, [(1, 2)]);
    assert!(found.nodes.iter().all(|n| (n.position.y - 0.1).abs() < 1e-12), "{:?}", found.nodes);
}

#[test]
fn a_sharp_corner_between_long_units_is_kept() {
    let basis = section(&[(0.0, 0.0), (8.0, 0.0), (8.0, 8.0)]);
    let distant = section(&[(1.0, 0.2), (4.0, 0.2), (7.8, 0.2), (7.8, 4.0), (7.8, 7.0)]);
    let found = averaged(&basis, &distant);
    assert!(found.nodes.iter().any(|n| n.position == Point2::new(8.0, 0.0)), "{:?}", found.nodes);
}

#[test]
fn zigzags_and_repeated_nodes_come_to_an_end() {
    let zigzag = section(&[(0.0, 0.0), (2.0, 0.4), (1.0, 0.0), (3.0, 0.4), (2.0, 0.0), (4.0, 0.4)]);
    let repeated = section(&[(0.0, 0.1), (1.0, 0.1), (1.0, 0.1), (1.0, 0.1), (4.0, 0.1)]);
    for (a, b) in [(&zigzag, &repeated), (&repeated, &zigzag), (&zigzag, &zigzag)] {
        assert!(averaged(a, b).nodes.len() < 20);
    }
}
