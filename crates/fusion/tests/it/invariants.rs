//! What fusing must not depend on, and what views say about their own curves that must not be lost.

use crate::scene::{Look, Outline, SPACING, looks, moved, outlines, see, slices};
use proptest::prelude::*;
use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::{Curve, EndReason, Node, Point2, Vector2};

fn fuse(views: &[Vec<Curve>]) -> FusedPlane {
    consensus(&slices(views), &ConsensusOptions::default())
}

fn views_of(outline: &Outline, looks: &[Look], sigma: f64) -> Vec<Vec<Curve>> {
    looks.iter().map(|l| vec![see(outline, l, sigma)]).collect()
}

/// Largest distance from the nodes of some curves to the nearest of others.
fn farthest(from: &[Curve], to: &[Curve]) -> f64 {
    let nearest = |n: &Node| {
        let distance = |c: &Curve| c.foot(&n.position).distance;
        to.iter().map(distance).fold(f64::INFINITY, f64::min)
    };
    from.iter().flat_map(|c| c.nodes()).map(nearest).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn fusing_what_was_fused_changes_little(
        outline in outlines(), looks in looks(), sigma in 0.0..0.004_f64,
    ) {
        let once = fuse(&views_of(&outline, &looks, sigma)).curves;
        let twice = fuse(std::slice::from_ref(&once)).curves;
        let near = SPACING + 2.0 * sigma;
        prop_assert!(farthest(&twice, &once) < near, "{}", farthest(&twice, &once));
        prop_assert!(farthest(&once, &twice) < 4.0 * near, "{}", farthest(&once, &twice));
    }

    #[test]
    fn a_moved_plane_has_the_moved_answer(
        outline in outlines(), looks in looks(), sigma in 0.0..0.004_f64,
        angle in 0.0..TAU, shift in (-9.0..9.0_f64, -9.0..9.0_f64),
    ) {
        let views = views_of(&outline, &looks, sigma);
        let shift = Vector2::new(shift.0, shift.1);
        let move_all = |curves: &[Curve]| -> Vec<Curve> {
            curves.iter().map(|c| moved(c, angle, shift)).collect()
        };
        let turned: Vec<_> = views.iter().map(|v| move_all(v)).collect();
        let (there, here) = (fuse(&turned).curves, move_all(&fuse(&views).curves));
        let near = SPACING + 2.0 * sigma;
        prop_assert!(farthest(&there, &here) < 4.0 * near, "{}", farthest(&there, &here));
        prop_assert!(farthest(&here, &there) < 4.0 * near, "{}", farthest(&here, &there));
    }
}

/// A corner at the origin: along x towards it, then up. Nodes within `gap` of it are missing.
fn corner(gap: f64, phase: f64) -> Vec<Curve> {
    let before = (0..50).map(|k| Point2::new(-1.0 + SPACING * (f64::from(k) + phase), 0.0));
    let after = (0..50).map(|k| Point2::new(0.0, SPACING * (f64::from(k) + phase)));
    let seen: Vec<Point2> = before.chain(after).filter(|p| p.coords.norm() >= gap).collect();
    let node = |k: usize| {
        Node::at(seen[k])
            .with_sigma(0.001)
            .with_footprint(SPACING as f32)
            .with_bridged(k + 1 < seen.len() && (seen[k + 1] - seen[k]).norm() > 2.0 * SPACING)
    };
    vec![Curve::new((0..seen.len()).map(node).collect(), false).unwrap()]
}

#[test]
fn a_bridge_across_a_corner_gives_way_to_views_that_saw_it() {
    let views = [corner(0.1, 0.0), corner(0.0, 0.3), corner(0.0, 0.6)];
    let fused = fuse(&views).curves;
    assert_eq!(fused.len(), 1);
    assert!(fused[0].nodes().iter().all(|n| !n.bridged), "seen ground is not bridged");
    // The bridge's middle is 0.07 from the corner.
    let tip = Point2::origin();
    assert!(fused[0].foot(&tip).distance < 0.015, "{}", fused[0].foot(&tip).distance);
}

#[test]
fn ground_that_every_view_bridged_is_marked() {
    let fused = fuse(&[corner(0.1, 0.0), corner(0.1, 0.3)]).curves;
    assert_eq!(fused.len(), 1);
    let marked: f64 = {
        let units = fused[0].units().zip(fused[0].nodes()).filter(|(_, n)| n.bridged);
        units.map(|(u, _)| u.vector().norm()).sum()
    };
    assert!((0.1..0.2).contains(&marked), "{marked}");
}

#[test]
fn nodes_between_bridges_alone_are_no_observation() {
    let line = |k: i32| {
        Node::at(Point2::new(0.06 * f64::from(k), 0.0))
            .with_footprint(SPACING as f32)
            .with_bridged(true)
    };
    let only = Curve::new((0..6).map(line).collect(), false).unwrap();
    assert!(fuse(&[vec![only]]).curves.is_empty());
}

#[test]
fn fused_ends_have_the_reasons_of_the_views() {
    let arc = |from: f64, seed: u64, ends: [Option<EndReason>; 2]| {
        let look = Look { from, sweep: 1.5, spacing: SPACING, seed };
        vec![see(&Outline::CIRCLE, &look, 0.0).with_ends(ends)]
    };
    let (jump, missing) = (Some(EndReason::RangeJump), Some(EndReason::MissingPixel));
    let fused = fuse(&[arc(0.0, 1, [jump, missing]), arc(0.8, 2, [missing, None])]).curves;
    assert_eq!(fused.len(), 1);
    assert_eq!(fused[0].ends(), [jump, None]);
}
