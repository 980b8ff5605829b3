//! How many curves come out: what belongs together is one, what is none is left out.

use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::{Curve, Node, Point2};

/// What one view sees of a polyline: nodes every `step` along each of its sides, none at its
/// corners.
fn seen(corners: &[[f64; 2]], step: f64) -> Vec<Curve> {
    let mut nodes = Vec::new();
    for side in corners.windows(2) {
        let (from, to) = (Point2::from(side[0]), Point2::from(side[1]));
        let count = ((to - from).norm() / step).floor().max(1.0);
        nodes.extend((0..count as u32).map(|k| {
            Node::at(from + (to - from) * ((f64::from(k) + 0.5) / count))
                .with_sigma(1e-5)
                .with_footprint(step as f32)
        }));
    }
    vec![Curve::new(nodes, false).unwrap()]
}

fn fuse(views: &[Vec<Curve>]) -> FusedPlane {
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    consensus(&slices, &ConsensusOptions::default())
}

#[test]
fn a_thin_leg_of_which_each_view_sees_two_samples_is_one_closed_curve() {
    // A square leg 2.5 samples wide, its solid to the left of each side.
    let corners = [[0.0, 0.0], [0.05, 0.0], [0.05, 0.05], [0.0, 0.05], [0.0, 0.0]];
    let views: Vec<_> = corners.windows(2).map(|side| seen(side, 0.02)).collect();
    let plane = fuse(&views);
    assert_eq!(plane.curves.len(), 1);
    assert!(plane.curves[0].is_closed());
}

#[test]
fn a_short_part_is_a_curve_if_two_views_measured_it() {
    // Two sides of the same leg, with a length of three footprints.
    let corners = [[0.0, 0.0], [0.05, 0.0], [0.05, 0.05]];
    let sides: Vec<_> = corners.windows(2).map(|side| seen(side, 0.02)).collect();
    let plane = fuse(&sides);
    assert_eq!(plane.curves.len(), 1);
    assert!(!plane.curves[0].is_closed());
    assert_eq!(plane.curves[0].nodes().iter().filter(|n| !n.bridged).count(), 4);
    assert_eq!(fuse(&[seen(&corners, 0.02)]).curves.len(), 0, "one view saw one side");
}

#[test]
fn two_scraps_with_a_gap_between_them_are_no_curve() {
    // Six footprints from end to end, and less than half of that was seen.
    let scrap = |x: f64| seen(&[[x, 0.0], [x + 0.03, 0.0]], 0.015);
    assert_eq!(fuse(&[scrap(0.0), scrap(0.073)]).curves.len(), 0);
}

#[test]
fn the_overshoot_of_one_view_along_a_closed_curve_is_no_curve() {
    // Noisy views saw the whole of a wide square; another ran past one side of it and bent away.
    let noisy = |curves: Vec<Curve>, closed: bool| {
        let nodes = curves.iter().flat_map(Curve::nodes).map(|n| n.with_sigma(0.005));
        vec![Curve::new(nodes.collect(), closed).unwrap()]
    };
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
    let square = noisy(corners.windows(2).flat_map(|side| seen(side, 0.02)).collect(), true);
    let threshold = fuse(std::slice::from_ref(&square)).threshold;
    let y = -2.5 * threshold;
    let stray = seen(&[[1.0, y], [1.2, y], [1.25, y - 0.04]], 0.02);
    let plane = fuse(&[square, noisy(stray, false)]);
    assert_eq!(plane.curves.len(), 1);
    assert!(plane.curves[0].is_closed());
}

#[test]
fn four_footprints_make_a_curve_and_three_do_not() {
    let line = |nodes: f64| seen(&[[0.0, 0.0], [0.02 * nodes, 0.0]], 0.02);
    assert_eq!(fuse(&[line(5.2)]).curves.len(), 1);
    assert_eq!(fuse(&[line(4.2)]).curves.len(), 0);
}
