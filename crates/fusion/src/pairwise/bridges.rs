//! Ground that no view measured: bridges that another view contradicts, and marks of the others.

use crate::ground::Ground;
use crate::sequence::{neighbours, without_units};
use transect_geometry::{Curve, CurveUnit, EndReason, Node};

/// A view's curve without its bridges over ground in the shadow of another view.
pub(super) fn without_shadowed(curve: &Curve, ground: &Ground<'_>) -> Vec<Curve> {
    let goes = |(a, b): (&Node, &Node)| a.bridged && ground.is_in_shadow(&unit(a, b));
    let cuts: Vec<bool> = neighbours(curve.nodes(), curve.is_closed()).map(goes).collect();
    if !cuts.contains(&true) {
        return vec![curve.clone()];
    }
    let is_cut = |unit: usize| cuts.get(unit) == Some(&true);
    without_units(curve, is_cut, Some(EndReason::RangeJump))
}

/// A fused curve as the views saw its ground within a distance: each unit that no view
/// measured is marked, and each node states how many views measured it. `spacing` stands for
/// footprints that are not known.
pub(super) fn seen(curve: Curve, ground: &Ground<'_>, spacing: f64, distance: f64) -> Curve {
    let footprint = |node: &Node| {
        if node.footprint > 0.0 { f64::from(node.footprint) } else { spacing }
    };
    let is_gap = |(a, b): (&Node, &Node)| {
        let footprint = footprint(a).max(footprint(b));
        !ground.is_measured(&unit(a, b), footprint, distance.max(footprint))
    };
    let gaps: Vec<bool> = neighbours(curve.nodes(), curve.is_closed()).map(is_gap).collect();
    let units: Vec<CurveUnit> = curve.units().collect();
    let seen = |(k, node): (usize, &Node)| {
        // The unit that begins at the node; at an open end, the one before.
        let unit = units.get(k.min(units.len() - 1));
        let way = unit.map(CurveUnit::vector).unwrap_or_default();
        let views = ground.views_at(&node.position, &way, [2.0 * footprint(node), distance]);
        let is_gap = gaps.get(k).is_some_and(|gap| *gap);
        node.with_views(views.len().max(1) as u32).with_bridged(is_gap)
    };
    let nodes = curve.nodes().iter().enumerate().map(seen).collect();
    let ends = curve.ends();
    Curve::new(nodes, curve.is_closed()).map_or(curve, |seen| seen.with_ends(ends))
}

fn unit(a: &Node, b: &Node) -> CurveUnit {
    CurveUnit { start: a.position, end: b.position }
}
