//! Ground that no view measured: it is marked, and a range jump that a view saw is not bridged.

use crate::scene::{SPACING, looks, outlines, see, slices};
use proptest::prelude::*;
use transect_fusion::{FusedPlane, FusionMethod, fuse_plane};
use transect_geometry::{Curve, EndReason, Node, Point2, Vector2};

fn methods() -> [FusionMethod; 2] {
    [FusionMethod::Consensus(Default::default()), FusionMethod::Pairwise(Default::default())]
}

/// Nodes a footprint apart along x, from a place on.
fn row(from: Point2, count: usize) -> Vec<Node> {
    let place = |k: usize| from + Vector2::x() * (SPACING * k as f64);
    let node = |k| Node::at(place(k)).with_sigma(0.001).with_footprint(SPACING as f32);
    (0..count).map(node).collect()
}

/// Two rows with a step of three footprints between them. One view sees two curves that end for a
/// reason there, another view one curve with a bridge.
fn step(reason: Option<EndReason>) -> [Vec<Curve>; 2] {
    let rows = [0.0, 3.0].map(|k: f64| {
        row(Point2::new(if k > 0.0 { 0.5 * SPACING } else { -49.0 * SPACING }, k * SPACING), 50)
    });
    let [lower, upper] = rows.clone().map(|row| Curve::new(row, false).unwrap());
    let two = vec![lower.with_ends([None, reason]), upper.with_ends([reason, None])];
    let mut nodes = rows.concat();
    nodes[49].bridged = true;
    [two, vec![Curve::new(nodes, false).unwrap()]]
}

/// Length of the units of some curves that cross the middle of the step, marked and not marked.
fn across(plane: &FusedPlane) -> [f64; 2] {
    let mut lengths = [0.0; 2];
    for curve in &plane.curves {
        for (unit, node) in curve.units().zip(curve.nodes()) {
            let height = 1.5 * SPACING;
            if (unit.start.y - height) * (unit.end.y - height) <= 0.0 {
                lengths[usize::from(!node.bridged)] += unit.vector().norm();
            }
        }
    }
    lengths
}

#[test]
fn no_bridge_crosses_a_range_jump_that_another_view_saw() {
    for method in methods() {
        let views = step(Some(EndReason::RangeJump));
        let fused = fuse_plane(&slices(&views), &method);
        assert_eq!((fused.curves.len(), across(&fused)), (2, [0.0; 2]), "{method:?}");
        assert!(fused.curves.iter().any(|c| c.ends()[1] == Some(EndReason::RangeJump)));
        assert!(fused.curves.iter().any(|c| c.ends()[0] == Some(EndReason::RangeJump)));
    }
}

#[test]
fn a_bridge_over_missing_pixels_stays_and_is_marked() {
    for method in methods() {
        let fused = fuse_plane(&slices(&step(Some(EndReason::MissingPixel))), &method);
        let [marked, unmarked] = across(&fused);
        assert_eq!(fused.curves.len(), 1, "{method:?}");
        assert!(marked > 0.0 && unmarked == 0.0, "{method:?}: {marked} {unmarked}");
    }
}

#[test]
fn a_closed_curve_with_a_bridge_over_a_range_jump_is_opened_there() {
    // A square with a step in its lower side, which another view saw as a range jump.
    let [two, one] = step(Some(EndReason::RangeJump));
    let mut nodes = one[0].nodes().to_vec();
    let corners = [[1.0, 1.0], [-1.0, 1.0]];
    let mut from = nodes[99].position;
    for to in corners.map(Point2::from).into_iter().chain([nodes[0].position]) {
        let count = ((to - from).norm() / SPACING).floor();
        let between = (1..count as u32).map(|k| from + (to - from) * (f64::from(k) / count));
        nodes.extend(between.map(|place| nodes[0].moved_to(place)).collect::<Vec<_>>());
        from = to;
    }
    let closed = vec![Curve::new(nodes, true).unwrap()];
    for method in methods() {
        let fused = fuse_plane(&slices(&[closed.clone(), two.clone()]), &method);
        assert_eq!((fused.curves.len(), across(&fused)[1] < 2.5), (1, true), "{method:?}");
        assert!(!fused.curves[0].is_closed(), "{method:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_long_unit_without_a_mark_lies_on_measured_ground(
        outline in outlines(), looks in looks(), sigma in 0.0..0.002_f64, gaps in 0..4_usize,
    ) {
        // Each view lacks four nodes at every gap.
        let cut = |curve: Curve| -> Vec<Curve> {
            let piece = curve.nodes().len() / (gaps + 1);
            let pieces = curve.nodes().chunks(piece.max(12));
            let kept = pieces.map(|p| p[..p.len().saturating_sub(4)].to_vec());
            let curves = kept.filter_map(|nodes| Curve::new(nodes, false).ok());
            curves.collect()
        };
        let views: Vec<Vec<Curve>> = looks.iter().map(|l| cut(see(&outline, l, sigma))).collect();
        for method in methods() {
            let fused = fuse_plane(&slices(&views), &method);
            for (unit, node) in fused.curves.iter().flat_map(|c| c.units().zip(c.nodes())) {
                if node.bridged || unit.vector().norm() <= 1.5 * SPACING {
                    continue;
                }
                let middle = unit.at(0.5);
                let measured = views.iter().flatten().map(|c| c.foot(&middle).distance);
                let nearest = measured.fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= fused.threshold.max(2.0 * SPACING), "{nearest} {unit:?}");
            }
        }
    }
}

#[test]
fn a_view_counts_once_at_a_node_however_often_it_saw_it() {
    // One view saw a row twice, as two curves that overlap; another saw it once, later.
    let [whole, first, second] = [(0, 60), (0, 40), (20, 40)]
        .map(|(k, count)| Curve::new(row(Point2::new(SPACING * f64::from(k), 0.0), count), false));
    let views = [Vec::new(), vec![first.unwrap(), second.unwrap()], vec![whole.unwrap()]];
    for method in methods() {
        let fused = fuse_plane(&slices(&views), &method);
        assert_eq!(fused.curves.len(), 1, "{method:?}");
        let counts: Vec<u32> = fused.curves[0].nodes().iter().map(Node::view_count).collect();
        assert!(counts.iter().all(|count| *count == 2), "{method:?}: {counts:?}");
        // A view without curves on the plane changes nothing.
        assert_eq!(fuse_plane(&slices(&views[1..]), &method).curves, fused.curves);
    }
}
