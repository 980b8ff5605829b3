//! The last step of every fusion: no curve crosses or touches itself or another one.
//!
//! **Problem.** The boundary of a solid does not cross itself, and no boundary forks. Curves from
//! measurements that contradict each other may.
//!
//! **Idea.** Of two units that cross, the one that more views saw stays. Units are only left out or
//! shortened. Rounding may make a shortened one touch another, so step 2 repeats until none does.
//!
//! **Steps.**
//! 1. Loops: where a curve crosses itself, a loop shorter than the shortest curve is cut off at the
//!    crossing.
//! 2. Units that still cross others are taken in order of the evidence around them: measured before
//!    bridged, then by the number of views times length. A unit that crosses an accepted one is
//!    left out, and its curve is opened there.
//! 3. Rests of cut curves that are shorter than the shortest curve are left out.
//!
//! **Source.** Not in the dissertation. Its rule table keeps pairs of curves apart (5.4), but
//! averaging moves them afterwards (5.5.2).

use crate::sequence::{arc_lengths, without_units};
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{Curve, CurveUnit, Node, Point2, UnitPlace, crossings};

/// Units on each side of a crossing whose evidence counts. By hand: a stray end has fewer units
/// beyond the crossing. Doubled: strays that follow a surface first win over it more often.
const EVIDENCE_UNITS: usize = 8;

/// Rounds of cutting off loops; loops within loops need more than one. By hand. Doubled: nothing
/// changes but for curves that are noise alone.
const LOOP_ROUNDS: usize = 4;

/// The length below which loops and rests are left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shortest {
    /// In mean footprints of the curve's nodes.
    pub footprints: f64,
    /// The footprint of nodes whose own one is not known.
    pub unknown: f64,
}

impl Shortest {
    fn of(self, nodes: &[Node]) -> f64 {
        let footprint = |node: &Node| match node.footprint {
            footprint if footprint > 0.0 => f64::from(footprint),
            _ => self.unknown,
        };
        self.footprints * nodes.iter().map(footprint).sum::<f64>() / nodes.len() as f64
    }
}

/// The curves without crossings, and the number of crossings that were found.
pub(crate) fn without_crossings(curves: Vec<Curve>, shortest: Shortest) -> (Vec<Curve>, usize) {
    let mut curves: Vec<Curve> = curves.into_iter().filter_map(without_repeats).collect();
    let mut found = crossings(&curves);
    let count = found.len();
    for _ in 0..LOOP_ROUNDS {
        if !found.iter().any(|(a, b)| a.curve == b.curve) {
            break;
        }
        cut_loops(&mut curves, &found, shortest);
        found = crossings(&curves);
    }
    // Cut loops shorten units, whose rounded ends may touch others.
    while !found.is_empty() {
        curves = opened(curves, &found, shortest);
        found = crossings(&curves);
    }
    (curves, count)
}

/// The curve without nodes in the place of the node before; `None` if too few are left.
fn without_repeats(curve: Curve) -> Option<Curve> {
    let nodes = curve.nodes();
    let differs = |k: usize| nodes[k].position != nodes[(k + 1) % nodes.len()].position;
    let last = nodes.len() - 1;
    if (0..nodes.len()).all(|k| differs(k) || (k == last && !curve.is_closed())) {
        return Some(curve);
    }
    let kept = (0..nodes.len()).filter(|&k| differs(k) || (k == last && !curve.is_closed()));
    let kept = kept.map(|k| nodes[k]).collect();
    Some(Curve::new(kept, curve.is_closed()).ok()?.with_ends(curve.ends()))
}

/// Cuts short loops off curves that cross themselves, as far as they do not overlap.
fn cut_loops(curves: &mut [Curve], found: &[(UnitPlace, UnitPlace)], shortest: Shortest) {
    // Crossings come in the order of their first curves.
    let own: Vec<_> = found.iter().filter(|(a, b)| a.curve == b.curve).collect();
    for own in own.chunk_by(|(a, _), (b, _)| a.curve == b.curve) {
        let Some(curve) = own.first().map(|(a, _)| &mut curves[a.curve]) else { continue };
        let arc = arc_lengths(curve.units().map(|unit| unit.vector().norm()));
        let loops = own.iter().map(|(a, b)| Loop::new(&arc, curve.is_closed(), a.unit, b.unit));
        let shortest = shortest.of(curve.nodes());
        let mut loops: Vec<_> = loops.filter(|l| l.length <= shortest).collect();
        loops.sort_by(|a, b| a.length.total_cmp(&b.length).then(a.units.cmp(&b.units)));
        let mut cut: Vec<Loop> = Vec::new();
        for one in loops {
            if !cut.iter().any(|other| other.overlaps(&one)) {
                cut.push(one);
            }
        }
        if let Some(shortened) = shortened(curve, &cut) {
            *curve = shortened;
        }
    }
}

/// The way from a unit of a curve to a later one that crosses it. On closed curves it may lead over
/// the last node.
#[derive(Debug, Clone)]
struct Loop {
    /// The first and the last unit.
    units: (usize, usize),
    length: f64,
}

impl Loop {
    /// The shorter of the two ways between two units that cross, by the arc lengths of the curve.
    /// An open curve has one way.
    fn new(arc: &[f64], is_closed: bool, a: usize, b: usize) -> Self {
        let inside = arc[b] - arc[a + 1];
        let outside = arc[a] + arc[arc.len() - 1] - arc[b + 1];
        if is_closed && outside < inside {
            Self { units: (b, a), length: outside }
        } else {
            Self { units: (a, b), length: inside }
        }
    }

    fn holds(&self, unit: usize) -> bool {
        let (first, last) = self.units;
        if first <= last { (first..=last).contains(&unit) } else { unit >= first || unit <= last }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.holds(other.units.0) || self.holds(other.units.1) || other.holds(self.units.0)
    }
}

/// The curve that goes on at the crossing of each loop; `None` if nothing is left.
fn shortened(curve: &Curve, cut: &[Loop]) -> Option<Curve> {
    if cut.is_empty() {
        return None;
    }
    let nodes = curve.nodes();
    let units: Vec<CurveUnit> = curve.units().collect();
    let mut kept: Vec<Node> = Vec::with_capacity(nodes.len());
    for (k, node) in nodes.iter().enumerate() {
        // Nodes within a loop begin one of its later units.
        let within = |l: &&Loop| l.holds(k) && k != l.units.0;
        if !cut.iter().any(|l| within(&l)) {
            kept.push(*node);
        }
        if let Some(l) = cut.iter().find(|l| l.units.0 == k) {
            // The unit from the crossing on is the rest of the loop's last unit.
            let rest = &nodes[l.units.1];
            kept.push(rest.moved_to(crossing(&units[k], &units[l.units.1])));
        }
    }
    Some(Curve::new(kept, curve.is_closed()).ok()?.with_ends(curve.ends()))
}

/// Where two units cross; the start of the second one if they lie on one line.
fn crossing(a: &CurveUnit, b: &CurveUnit) -> Point2 {
    let (start, end) = (a.line_value(&b.start), a.line_value(&b.end));
    let share = start / (start - end);
    if share.is_finite() { b.at(share.clamp(0.0, 1.0)) } else { b.start }
}

/// The evidence for a unit: whether it was measured, and the views around it times their length.
fn evidence(curve: &Curve, unit: usize) -> (bool, f64) {
    let nodes = curve.nodes();
    let (n, units) = (nodes.len() as isize, curve.units().len() as isize);
    let reach = (EVIDENCE_UNITS as isize).min((units - 1) / 2);
    let around = (unit as isize - reach..=unit as isize + reach).filter_map(|k| {
        let k = if curve.is_closed() { k.rem_euclid(n) } else { k };
        (0..units).contains(&k).then(|| {
            let (a, b) = (&nodes[k as usize], &nodes[((k + 1) % n) as usize]);
            let views = if a.bridged { 0 } else { a.view_count().min(b.view_count()) };
            f64::from(views) * (b.position - a.position).norm()
        })
    });
    (!nodes[unit].bridged, around.sum())
}

/// The curves without the units that cross better ones.
fn opened(curves: Vec<Curve>, found: &[(UnitPlace, UnitPlace)], shortest: Shortest) -> Vec<Curve> {
    let mut crossed_by: BTreeMap<UnitPlace, Vec<UnitPlace>> = BTreeMap::new();
    for (a, b) in found {
        crossed_by.entry(*a).or_default().push(*b);
        crossed_by.entry(*b).or_default().push(*a);
    }
    let mut ranked: Vec<_> =
        crossed_by.keys().map(|p| (evidence(&curves[p.curve], p.unit), *p)).collect();
    ranked.sort_by(|((seen_a, a), at_a), ((seen_b, b), at_b)| {
        seen_b.cmp(seen_a).then(b.total_cmp(a)).then(at_a.cmp(at_b))
    });
    let (mut accepted, mut left_out) = (BTreeSet::new(), BTreeSet::new());
    for (_, place) in ranked {
        let is_worse = crossed_by[&place].iter().any(|other| accepted.contains(other));
        if is_worse {
            left_out.insert(place)
        } else {
            accepted.insert(place)
        };
    }
    let is_long = |part: &Curve| part.length() >= shortest.of(part.nodes());
    let parts = |(curve, whole): (usize, Curve)| {
        let all = UnitPlace { curve, unit: 0 }..=UnitPlace { curve, unit: usize::MAX };
        if left_out.range(all).next().is_none() {
            return vec![whole];
        }
        let is_left_out = |unit| left_out.contains(&UnitPlace { curve, unit });
        let mut parts = without_units(&whole, is_left_out, None);
        parts.retain(is_long);
        parts
    };
    curves.into_iter().enumerate().flat_map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORTEST: Shortest = Shortest { footprints: 4.0, unknown: 0.1 };

    fn curve(places: &[(f64, f64)], views: u32, closed: bool) -> Curve {
        let node = |&(x, y): &(f64, f64)| {
            Node::at(Point2::new(x, y)).with_views(views).with_footprint(0.1)
        };
        Curve::new(places.iter().map(node).collect(), closed).unwrap()
    }

    fn line(from: (f64, f64), to: (f64, f64), views: u32) -> Curve {
        let at = |k: u32| f64::from(k) / 20.0;
        let place = |k| (from.0 + (to.0 - from.0) * at(k), from.1 + (to.1 - from.1) * at(k));
        curve(&(0..=20).map(place).collect::<Vec<_>>(), views, false)
    }

    #[test]
    fn the_curve_that_more_views_saw_stays_whole() {
        let (wall, stray) = (line((0.0, 0.0), (2.0, 0.0), 5), line((0.97, -1.03), (1.07, 0.97), 1));
        let (curves, count) = without_crossings(vec![stray, wall.clone()], SHORTEST);
        assert_eq!(count, 1);
        assert!(curves.contains(&wall));
        assert_eq!(curves.len(), 3, "two parts of the stray");
        assert_eq!(crossings(&curves), []);
    }

    #[test]
    fn the_short_rest_beyond_a_crossing_goes() {
        let (wall, stray) = (line((0.0, 0.0), (2.0, 0.0), 5), line((1.0, -0.2), (1.1, 1.8), 1));
        let (curves, _) = without_crossings(vec![wall, stray], SHORTEST);
        let lowest = curves[1].nodes().iter().map(|n| n.position.y).fold(f64::INFINITY, f64::min);
        assert_eq!((curves.len(), lowest > 0.0), (2, true), "{lowest}");
    }

    #[test]
    fn a_small_loop_is_cut_off_at_its_crossing() {
        let looped =
            curve(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.1), (0.9, 0.1), (0.9, -1.0)], 1, false);
        let (curves, count) = without_crossings(vec![looped], SHORTEST);
        let places: Vec<_> = curves[0].nodes().iter().map(|n| n.position).collect();
        let wanted = [(0.0, 0.0), (0.9, 0.0), (0.9, -1.0)].map(|(x, y)| Point2::new(x, y));
        assert_eq!((count, places), (1, wanted.to_vec()));
    }

    #[test]
    fn a_loop_is_short_whether_footprints_are_known_or_not() {
        let places = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.1), (0.9, 0.1), (0.9, -1.0)];
        let unknown = |n: &Node| n.with_footprint(0.0);
        let looped = curve(&places, 1, false);
        let without: Vec<Node> = looped.nodes().iter().map(unknown).collect();
        let [known, without] = [looped, Curve::new(without, false).unwrap()].map(|curve| {
            let (curves, _) = without_crossings(vec![curve], SHORTEST);
            curves.iter().map(|c| c.nodes().len()).collect::<Vec<_>>()
        });
        assert_eq!((known, without), (vec![3], vec![3]));
    }

    #[test]
    fn a_closed_curve_loses_a_loop_over_its_first_node() {
        let nodes = [(0.0, 0.1), (0.1, 0.1), (0.1, -2.0), (2.0, -2.0), (2.0, 0.0), (0.0, 0.0)];
        let (curves, _) = without_crossings(vec![curve(&nodes, 1, true)], SHORTEST);
        assert!(curves[0].is_closed());
        assert_eq!(curves[0].nodes().len(), 4);
        assert!(curves[0].nodes().iter().any(|n| n.position == Point2::new(0.1, 0.0)));
    }

    #[test]
    fn a_large_loop_stays_and_is_opened() {
        let eight = curve(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)], 1, true);
        let (curves, _) = without_crossings(vec![eight], SHORTEST);
        assert_eq!(crossings(&curves), []);
        assert!(curves.iter().map(Curve::length).sum::<f64>() > 6.0);
    }

    #[test]
    fn a_bridge_gives_way_to_measured_ground() {
        let node = |x: f64, y: f64| Node::at(Point2::new(x, y)).with_views(9).with_footprint(0.1);
        let ends =
            [node(1.0, -1.0), node(1.0, -0.5).with_bridged(true), node(1.0, 0.5), node(1.0, 1.0)];
        let bridged = Curve::new(ends.to_vec(), false).unwrap();
        let wall = line((0.0, 0.0), (2.0, 0.03), 1);
        let (curves, _) = without_crossings(vec![bridged, wall.clone()], SHORTEST);
        assert!(curves.contains(&wall));
        assert_eq!(curves.len(), 3);
    }
}
