//! Ground that no view measured: bridges that another view contradicts, and marks of the others.

use crate::ground::Ground;
use crate::sequence::neighbours;
use transect_geometry::{Curve, CurveUnit, EndReason, Node};

/// Longest unit without a look at its ground, in footprints. Theory: averaging keeps a node for
/// each unit of a view. Doubled: gaps of two samples count as measured.
const GAP_FOOTPRINTS: f64 = 1.5;

/// A view's curve without its bridges over ground in the shadow of another view.
pub(super) fn without_shadowed(curve: &Curve, ground: &Ground<'_>) -> Vec<Curve> {
    let goes = |(a, b): (&Node, &Node)| a.bridged && ground.is_in_shadow(&unit(a, b));
    let cuts: Vec<bool> = neighbours(curve.nodes(), curve.is_closed()).map(goes).collect();
    let Some(first) = cuts.iter().position(|cut| *cut) else { return vec![curve.clone()] };
    // A closed curve is opened at its first cut.
    let start = if curve.is_closed() { first + 1 } else { 0 };
    let mut nodes = curve.nodes().to_vec();
    nodes.rotate_left(start % cuts.len());
    let count = nodes.len();
    let last = |k: &usize| *k + 1 == count || cuts[(k + start) % cuts.len()];
    let mut begin =
        (0, if curve.is_closed() { Some(EndReason::RangeJump) } else { curve.ends()[0] });
    let mut pieces = Vec::new();
    for end in (0..count).filter(last) {
        let is_end = end + 1 == count && !curve.is_closed();
        let reason = if is_end { curve.ends()[1] } else { Some(EndReason::RangeJump) };
        let piece = Curve::new(nodes[begin.0..=end].to_vec(), false).ok();
        pieces.extend(piece.map(|piece| piece.with_ends([begin.1, reason])));
        begin = (end + 1, Some(EndReason::RangeJump));
    }
    pieces
}

/// A fused curve with a mark on each long unit whose ground no view measured within a distance.
/// `spacing` stands for footprints that are not known.
pub(super) fn marked(curve: Curve, ground: &Ground<'_>, spacing: f64, distance: f64) -> Curve {
    let mark = |(a, b): (&Node, &Node)| {
        let stated = f64::from(a.footprint.max(b.footprint));
        let footprint = if stated > 0.0 { stated } else { spacing };
        let unit = unit(a, b);
        a.bridged
            || unit.vector().norm() > GAP_FOOTPRINTS * footprint
                && !ground.is_measured(&unit, distance.max(footprint))
    };
    let marks: Vec<bool> = neighbours(curve.nodes(), curve.is_closed()).map(mark).collect();
    let nodes = curve.nodes().iter().zip(marks.iter().chain([&false]));
    let marked = nodes.map(|(node, mark)| node.with_bridged(*mark)).collect();
    let ends = curve.ends();
    Curve::new(marked, curve.is_closed()).map_or(curve, |marked| marked.with_ends(ends))
}

fn unit(a: &Node, b: &Node) -> CurveUnit {
    CurveUnit { start: a.position, end: b.position }
}
