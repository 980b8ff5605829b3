//! What merging curve by curve keeps of the marks that came with the curves.

use transect_fusion::{FusedPlane, PairwiseOptions, pairwise};
use transect_geometry::{Curve, EndReason, Node, Point2};

/// Along x with nodes every 0.1 from a number of steps to another, displaced by a little; without
/// the nodes of a gap, which is bridged.
fn wall((from, to): (i32, i32), gap: std::ops::Range<i32>, (dx, y): (f64, f64)) -> Curve {
    let node =
        |k: i32| Node::at(Point2::new(0.1 * f64::from(k) + dx, y)).with_bridged(k + 1 == gap.start);
    let seen = (from..=to).filter(|k| !gap.contains(k));
    Curve::new(seen.map(node).collect(), false).unwrap()
}

fn fuse(first: Curve, second: Curve) -> Curve {
    let views = [[first], [second]];
    let slices: Vec<&[Curve]> = views.iter().map(<[Curve; 1]>::as_slice).collect();
    let FusedPlane { curves, .. } = pairwise(&slices, &PairwiseOptions::default());
    let [curve] = <[Curve; 1]>::try_from(curves).unwrap();
    curve
}

/// Where the bridged units of a curve along x begin and end.
fn bridged(curve: &Curve) -> Vec<(f64, f64)> {
    let marked = curve.nodes().iter().zip(curve.units()).filter(|(node, _)| node.bridged);
    marked.map(|(_, unit)| (unit.start.x, unit.end.x)).collect()
}

#[test]
fn ground_that_neither_view_saw_stays_bridged() {
    for dx in [0.0, 0.03, -0.04] {
        let curve = fuse(wall((0, 60), 21..30, (0.0, 0.0)), wall((0, 60), 21..30, (dx, 0.004)));
        let marked = bridged(&curve);
        assert!(
            !marked.is_empty(),
            "{dx}: {:?}",
            curve.nodes().iter().map(|n| (n.position.x, n.bridged)).collect::<Vec<_>>()
        );
        let (from, to) = (marked[0].0, marked[marked.len() - 1].1);
        assert!((1.8..=2.06).contains(&from) && (2.9..=3.2).contains(&to), "{dx}: {marked:?}");
        assert!(marked.windows(2).all(|w| w[0].1 == w[1].0), "{dx}: {marked:?}");
    }
}

#[test]
fn ground_that_one_of_two_views_saw_is_seen() {
    for swapped in [false, true] {
        let (gap, whole) = (wall((0, 60), 21..30, (0.0, 0.0)), wall((0, 60), 0..0, (0.03, 0.004)));
        let curve = if swapped { fuse(whole, gap) } else { fuse(gap, whole) };
        assert_eq!(bridged(&curve), [], "swapped: {swapped}");
    }
}

#[test]
fn a_bridge_outside_the_overlap_keeps_its_mark() {
    let curve = fuse(wall((0, 60), 11..20, (0.0, 0.0)), wall((40, 90), 0..0, (0.03, 0.004)));
    let marked = bridged(&curve);
    assert_eq!(marked.len(), 1, "{marked:?}");
    assert!((marked[0].0 - 1.0).abs() < 1e-9 && (marked[0].1 - 2.0).abs() < 1e-9, "{marked:?}");
}

#[test]
fn free_ends_keep_their_reasons() {
    let (left, right) = (wall((0, 60), 0..0, (0.0, 0.0)), wall((40, 90), 0..0, (0.03, 0.004)));
    let (missing, jump, border) =
        (Some(EndReason::MissingPixel), Some(EndReason::RangeJump), Some(EndReason::ImageBorder));
    let curve = fuse(left.with_ends([missing, jump]), right.with_ends([jump, border]));
    assert_eq!(curve.ends(), [missing, border]);
}
