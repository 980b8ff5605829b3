//! The boundary loops of a plane: closed curves, and open curves joined over their gaps.
//!
//! Problem: an area needs a closed boundary, and curves of real scans have gaps.
//!
//! Idea: the gaps of a plane ([`Section::gaps`]) lead from the end of a curve to the beginning of
//! the next one. Along them open curves form loops, with a chord across every gap. The chord is not
//! the surface. So each loop states its *doubt*: the largest area that it can have too much or too
//! little.
//!
//! 1. A gap of width w, and a bridged unit of length w, counts w times half the diagonal of the
//!    plane's envelope. That bounds an unseen boundary which runs at most half the diagonal away
//!    from the chord, and encloses nothing wider than the gap.
//! 2. A measured unit counts its length times [`SIGMAS`] standard deviations.
//! 3. Where a curve bends, its units are chords, and its nodes lie on chords between pixels. For
//!    units of length h that turn by θ, the first leaves out h² θ / 12 of the area, the second
//!    moves a unit by h θ / 8 at most. Bends to the left and to the right take from each other.
//! 4. The parent of a loop is the smallest loop around it, by the even-odd rule, which ignores
//!    directions. Loop and parent run opposite ways round. Otherwise a direction is wrong, curves
//!    cross, or a surface between them was not seen. The loop's area is then in doubt for its
//!    parent.
//! 5. If the doubt exceeds the area, the gaps hide which way round the loop runs. Then its parent
//!    decides. Without a parent, the other loops without one decide: if all of them are surely
//!    around solid, the plane is free outside. Else the loop may be of either kind.
//! 6. Along a curved guide points farther away than its usable distance are not measured. A curve
//!    that ends there is *cut*: the surface goes on beyond, so its loop has no known bound.
//!
//! Cost: for n loops with m nodes each, O(n²) comparisons of envelopes, and O(m) for each pair of
//! nested envelopes. One node decides the parent of a loop that crosses others.

use crate::{CurveIndex, Section};
use std::collections::BTreeMap;
use transect_geometry::{Curve, CurveUnit, Envelope, Point2, Vector2};

/// Standard deviations by which a measured unit can be off along its whole length. Chosen by hand:
/// systematic errors of a view shift whole curves. Doubled, brackets of closed curves double.
const SIGMAS: f64 = 3.0;

/// Area that a bend may leave out, in squared lengths of units times its angle. Theory: step 3, a
/// twelfth and an eighth.
const BENT: f64 = 5.0 / 24.0;

/// Largest angle between two units that counts as a bend; 30°. A larger one is a corner, at which
/// nothing is left out. Chosen by hand: curves have a dozen nodes around their smallest bends.
/// Doubled, polygons of few nodes have bounds as wide as their sides are long.
const LARGEST_BEND: f64 = 0.52;

/// Share of the usable distance within which the end of a curve counts as cut. Measured: the
/// 180 ends in `bend_tunnel` along a guide with a radius of 3 m are up to 3 % of it short of it.
/// Doubled, gaps well within the usable distance make the largest area unknown, too.
const NEAR_LIMIT: f64 = 0.1;

/// Units at the end of a curve by which it may end short of the usable distance and still be cut.
/// Theory: the next sample is one unit away, and the last one may be left out. Doubled, coarse
/// curves far within the usable distance count as cut.
const UNITS_TO_LIMIT: f64 = 2.0;

/// A closed boundary, seen or joined over gaps.
#[derive(Debug)]
pub(crate) struct BoundaryLoop {
    /// Its curves in order; one for a closed curve.
    pub curves: Vec<CurveIndex>,
    /// Whether it is one closed curve.
    pub is_closed: bool,
    /// Whether one of its curves ends at the usable distance of a curved guide.
    pub is_cut: bool,
    /// Width of its widest gap, in the length unit; 0 for a closed curve.
    pub widest_gap: f64,
    /// Area with the gaps closed by chords: positive if the loop runs counter-clockwise.
    pub area: f64,
    /// First moment of that area about the least corner of the plane's envelope.
    pub moment: Vector2,
    /// Largest error of the area.
    pub doubt: f64,
    /// Number of the smallest loop around it.
    pub parent: Option<usize>,
    /// Whether the solid is within the loop, and free space around it.
    pub is_solid: bool,
    /// Whether it may as well be the other way round.
    pub is_either: bool,
    /// Whether its kind is that of its parent.
    pub contradicts_parent: bool,
    points: Vec<Point2>,
    envelope: Option<Envelope>,
}

impl BoundaryLoop {
    fn new(section: &Section, curves: Vec<CurveIndex>, gaps: &[f64]) -> Self {
        let of_curves = || curves.iter().filter_map(|index| section.curve(*index));
        let nodes = of_curves().flat_map(Curve::nodes);
        let points: Vec<Point2> = nodes.map(|node| node.position).collect();
        let envelope = section.envelope();
        let (area, moment) = moments(&points, &envelope.min);
        let half_extent = 0.5 * envelope.size().norm();
        let unseen = gaps.iter().sum::<f64>() * half_extent;
        let doubt = of_curves().map(|curve| doubt(curve, half_extent)).sum::<f64>() + unseen;
        Self {
            is_closed: gaps.is_empty(),
            is_cut: false,
            widest_gap: gaps.iter().copied().fold(0.0, f64::max),
            parent: None,
            is_solid: area > 0.0,
            is_either: false,
            contradicts_parent: false,
            envelope: Envelope::around(&points),
            curves,
            area,
            moment,
            doubt,
            points,
        }
    }

    /// Whether the gaps hide which way round it runs.
    fn is_doubtful(&self) -> bool {
        self.doubt >= self.area.abs()
    }

    /// Its area, positive if it runs as loops of its kind do.
    pub fn own_area(&self) -> f64 {
        if self.is_solid { self.area } else { -self.area }
    }

    /// First moment of [`Self::own_area`].
    pub fn own_moment(&self) -> Vector2 {
        if self.is_solid { self.moment } else { -self.moment }
    }

    fn lies_within(&self, other: &Self) -> bool {
        let (Some(inner), Some(outer)) = (&self.envelope, &other.envelope) else { return false };
        let smaller = self.area.abs() < other.area.abs();
        let may = smaller && outer.contains(&inner.min) && outer.contains(&inner.max);
        may && self.points.first().is_some_and(|p| encloses(&other.points, p))
    }
}

impl Section {
    /// The loops of the plane: closed curves in their order, then the loops of open curves. Curves
    /// were sought up to the distance `usable` from the origin of the plane.
    pub(crate) fn loops(&self, usable: f64) -> Vec<BoundaryLoop> {
        let closed = self.curves().enumerate().filter(|(_, curve)| curve.is_closed());
        let mut loops: Vec<_> =
            closed.map(|(k, _)| BoundaryLoop::new(self, vec![CurveIndex(k)], &[])).collect();
        let gaps = self.gaps();
        let mut next: BTreeMap<_, _> =
            gaps.iter().map(|gap| (gap.after, (gap.before, gap.width()))).collect();
        while let Some((&first, _)) = next.first_key_value() {
            let (mut at, mut curves, mut widths) = (first, Vec::new(), Vec::new());
            while let Some((before, width)) = next.remove(&at) {
                curves.push(at);
                widths.push(width);
                at = before;
            }
            let mut of_curves = curves.iter().filter_map(|index| self.curve(*index));
            let is_cut = of_curves.any(|curve| is_cut(curve, usable));
            loops.push(BoundaryLoop { is_cut, ..BoundaryLoop::new(self, curves, &widths) });
        }
        find_parents(&mut loops);
        decide_kinds(&mut loops);
        loops
    }

    /// The closed curves that bound known solid, with the holes in it: what a drawing can fill.
    ///
    /// A curve around solid with an open curve directly in it is left out, because the open curve
    /// bounds an unknown part of it. So is one with a curve of contradicting direction in it.
    pub fn known_solid(&self) -> Vec<CurveIndex> {
        let loops = self.loops(f64::INFINITY);
        let mut known = Vec::new();
        for (number, outer) in loops.iter().enumerate() {
            let within = || loops.iter().filter(|inner| inner.parent == Some(number));
            let sound = within().all(|inner| inner.is_closed && !inner.contradicts_parent);
            if sound && outer.is_solid && outer.area > 0.0 && outer.is_closed {
                known.extend(within().chain([outer]).flat_map(|found| found.curves.clone()));
            }
        }
        known.sort_unstable();
        known
    }
}

fn find_parents(loops: &mut [BoundaryLoop]) {
    for k in 0..loops.len() {
        let around = loops.iter().enumerate().filter(|(_, other)| loops[k].lies_within(other));
        let parent = around.min_by(|(_, a), (_, b)| a.area.abs().total_cmp(&b.area.abs()));
        loops[k].parent = parent.map(|(number, _)| number);
    }
}

fn decide_kinds(loops: &mut [BoundaryLoop]) {
    let mut sure = loops.iter().filter(|found| found.parent.is_none() && !found.is_doubtful());
    let is_free_outside =
        sure.next().is_some_and(|first| first.is_solid) && sure.all(|found| found.is_solid);
    let mut outermost_first: Vec<usize> = (0..loops.len()).collect();
    outermost_first.sort_by(|a, b| loops[*b].area.abs().total_cmp(&loops[*a].area.abs()));
    for k in outermost_first {
        let is_in_solid = loops[k].parent.map(|parent| loops[parent].is_solid);
        let is_doubtful = loops[k].is_doubtful();
        loops[k].is_either = is_doubtful && is_in_solid.is_none() && !is_free_outside;
        if is_doubtful && !loops[k].is_either {
            loops[k].is_solid = is_in_solid != Some(true);
        }
        loops[k].contradicts_parent = is_in_solid == Some(loops[k].is_solid);
    }
}

/// Whether an open curve begins or ends at this distance from the origin of its plane.
fn is_cut(curve: &Curve, usable: f64) -> bool {
    let (first, last) = (curve.units().next(), curve.units().last());
    let ends = first.map(|unit| (unit, unit.start)).into_iter();
    let mut ends = ends.chain(last.map(|unit| (unit, unit.end)));
    usable.is_finite()
        && ends.any(|(unit, end)| {
            let short = (NEAR_LIMIT * usable).max(UNITS_TO_LIMIT * unit.vector().norm());
            end.coords.norm() >= usable - short
        })
}

/// The area by which the true boundary can differ along a curve, in a plane of this half extent.
fn doubt(curve: &Curve, half_extent: f64) -> f64 {
    let doubts = curve.units().zip(curve.nodes()).map(|(unit, node)| {
        let off = if node.bridged { half_extent } else { SIGMAS * f64::from(node.sigma) };
        off * unit.vector().norm()
    });
    doubts.sum::<f64>() + BENT * bends(curve).abs()
}

/// The sum of the bends of a curve, each times the mean of the squared lengths on both sides.
fn bends(curve: &Curve) -> f64 {
    let units: Vec<Vector2> = curve.units().map(|unit| unit.vector()).collect();
    let around = if curve.is_closed() { units.len() } else { units.len().saturating_sub(1) };
    let bend = |k: usize| {
        let (a, b) = (units[k], units[(k + 1) % units.len()]);
        let angle = a.perp(&b).atan2(a.dot(&b));
        let squares = 0.5 * (a.norm_squared() + b.norm_squared());
        if angle.abs() <= LARGEST_BEND { angle * squares } else { 0.0 }
    };
    (0..around).map(bend).sum()
}

fn sides(points: &[Point2]) -> impl Iterator<Item = CurveUnit> + '_ {
    let ends = points.iter().cycle().skip(1);
    points.iter().zip(ends).map(|(start, end)| CurveUnit { start: *start, end: *end })
}

/// Signed area of a polygon and its first moment about `anchor`, by triangles from there.
///
/// An anchor close to the polygon keeps the precision of world-sized coordinates.
fn moments(points: &[Point2], anchor: &Point2) -> (f64, Vector2) {
    sides(points).fold((0.0, Vector2::zeros()), |(area, moment), side| {
        let (a, b) = (side.start - anchor, side.end - anchor);
        let triangle = 0.5 * a.perp(&b);
        (area + triangle, moment + (a + b) * (triangle / 3.0))
    })
}

/// Whether a ray along +x from the point crosses the polygon an odd number of times.
fn encloses(points: &[Point2], p: &Point2) -> bool {
    let crossed = sides(points).filter(|side| {
        let (a, b) = (side.start, side.end);
        (a.y <= p.y) != (b.y <= p.y) && ((side.line_value(p) < 0.0) == (b.y > a.y))
    });
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{circle, polyline, rectangle, rings, strip};
    use proptest::prelude::*;

    fn loops(curves: Vec<Curve>) -> Vec<(f64, Option<usize>, bool)> {
        let found = Section::new(curves).unwrap().loops(f64::INFINITY);
        found.iter().map(|l| (l.area, l.parent, l.contradicts_parent)).collect()
    }

    #[test]
    fn plate_hole_and_island_alternate() {
        let hole = rectangle(1.0, 1.0, 9.0, 9.0).reversed();
        let island = rectangle(4.0, 4.0, 5.0, 5.0);
        let found = loops(vec![rectangle(0.0, 0.0, 10.0, 10.0), island.clone(), hole.clone()]);
        assert_eq!(found, [(100.0, None, false), (1.0, Some(2), false), (-64.0, Some(0), false)]);
        let turned = [rectangle(0.0, 0.0, 10.0, 10.0), island.reversed(), hole.reversed()];
        let found = loops(turned.to_vec());
        assert_eq!([found[1].2, found[2].2], [false, true]);
    }

    #[test]
    fn open_curves_are_joined_over_their_gaps() {
        let lower = polyline(&[(0.0, 1.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.0)], false);
        let upper = polyline(&[(4.0, 2.0), (4.0, 3.0), (0.0, 3.0), (0.0, 2.0)], false);
        let plate = Section::new(vec![upper, rectangle(1.0, 1.0, 2.0, 2.0).reversed(), lower]);
        let found = plate.unwrap().loops(f64::INFINITY);
        assert_eq!(found[1].curves, [CurveIndex(0), CurveIndex(2)]);
        assert_eq!((found[1].area, found[1].widest_gap), (12.0, 1.0));
        assert_eq!(found[1].doubt, 2.0 * 2.5, "two gaps of 1 times half of 5");
        assert_eq!((found[0].parent, found[0].doubt), (Some(1), 0.0));
    }

    #[test]
    fn bridges_and_noise_leave_a_doubt() {
        let bridged = |nodes: Vec<transect_geometry::Node>| {
            nodes.into_iter().enumerate().map(|(k, n)| n.with_sigma(0.01).with_bridged(k == 0))
        };
        let plate = rectangle(0.0, 0.0, 2.0, 3.0).into_nodes();
        let plate = Curve::new(bridged(plate).collect(), true).unwrap();
        let found = Section::new(vec![plate]).unwrap().loops(f64::INFINITY);
        assert!(
            (found[0].doubt - (13.0_f64.sqrt() + 3.0 * 0.01 * 8.0)).abs() < 1e-6,
            "{}",
            found[0].doubt
        );
    }

    #[test]
    fn chords_of_a_circle_leave_a_doubt_that_holds_what_they_leave_out() {
        let exact = std::f64::consts::PI * 4.0;
        for nodes in [16, 64, 256] {
            let circle = circle(Point2::new(1.0, 2.0), 2.0, nodes);
            let found = Section::new(vec![circle.clone()]).unwrap().loops(f64::INFINITY);
            let lacks = exact - found[0].area;
            // The chords' own twelfth, and an eighth for nodes between pixels.
            let share = found[0].doubt / lacks;
            assert!((2.4..2.6).contains(&share), "{nodes}: {share}");
            let hole = Section::new(vec![circle.reversed()]).unwrap().loops(f64::INFINITY);
            assert!((hole[0].doubt - found[0].doubt).abs() < 1e-12);
        }
    }

    #[test]
    fn only_known_solid_is_filled() {
        let filled = |curves: &[Curve]| -> Vec<usize> {
            let section = Section::new(curves.to_vec()).unwrap();
            section.known_solid().iter().map(|index| index.0).collect()
        };
        let (outer, hole) = (rectangle(-2.0, -2.0, 2.0, 2.0), rectangle(-1.0, -1.0, 1.0, 1.0));
        let island = rectangle(-0.5, -0.5, 0.5, 0.5);
        assert_eq!(filled(&[outer.clone(), hole.reversed(), island.clone()]), [0, 1, 2]);
        assert_eq!(filled(&[rectangle(-5.0, -5.0, 5.0, 5.0).reversed(), hole.clone()]), [1]);
        let bore = polyline(&[(0.0, 1.0), (1.0, 0.0), (0.0, -1.0)], false);
        assert_eq!(filled(&[outer.clone(), bore]), [] as [usize; 0]);
        assert_eq!(filled(&[outer, hole]), [1], "a contradicting direction");
        assert_eq!(filled(&[strip()]), [] as [usize; 0]);
    }

    proptest! {
        #[test]
        fn rings_nest_as_they_were_made(curves in rings()) {
            let parents: Vec<_> = loops(curves).iter().map(|found| found.1).collect();
            prop_assert_eq!(parents, [None, Some(0), None, Some(2)]);
        }
    }
}
