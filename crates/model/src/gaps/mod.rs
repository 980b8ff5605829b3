//! Gaps: unseen stretches of boundary (dissertation, sections 2.4.3 and 6.4).
//!
//! Problem: a model of real scans is open where surfaces were hidden, too dark or outside all
//! images. The gaps are a result too: they show where to scan next.
//!
//! Idea: the boundary of a solid has no ends. Where a curve ends, the boundary continues unseen to
//! the beginning of a curve. So the open ends of a plane form pairs of an end and a beginning.
//!
//! 1. Every end of an open curve is paired with a beginning, possibly its own, cheapest pair first.
//!    The cost is the straight distance, times up to five if the way turns back, because a boundary
//!    rarely does.
//! 2. A pair is a [`Gap`]; its width is the straight distance, the smallest possible length of the
//!    unseen boundary.
//! 3. The solid lies on the left of a gap, as on that of a curve. So the free side of a gap is
//!    known.
//! 4. [`KnownSpace`] is the space that the rays of the views crossed; [`next_views`] tries places
//!    in it for a sensor and adds up the gaps in sight of each.
//!
//! Departures from the source: 6.4 names the selection of views as future work; the method is ours.
//!
//! Cost: memory O(n) for n open curves of a plane, and 64 MiB at most. Each end looks at the free
//! beginnings within its cheapest cost: O(n log n) in all where few are so near. If all beginnings
//! are equally far from all ends, it is O(n²) and more. The chord of a gap is not a surface: the
//! boundary between its ends can be anywhere in the unseen space.
//!
//! ```
//! use transect_geometry::{Curve, Node, PlaneFrame, Point2, Point3, Vector3};
//! use transect_model::Section;
//! use transect_model::gaps::{KnownSpace, NextViewOptions, next_views};
//!
//! // A square that lacks its right side, which a sensor on the left has not seen.
//! let corners = [(2.0, 2.0), (0.0, 2.0), (0.0, 0.0), (2.0, 0.0)];
//! let nodes = corners.map(|(x, y)| Node::at(Point2::new(x, y))).to_vec();
//! let section = Section::new(vec![Curve::new(nodes, false)?]).ok_or("no curves")?;
//! let gap = section.gaps()[0];
//! assert_eq!((gap.width(), gap.ends[0]), (2.0, Point2::new(2.0, 0.0)));
//!
//! let frame = PlaneFrame::new(Point3::origin(), Vector3::z()).ok_or("no normal")?;
//! let patches = gap.patches(&frame, 0.1, 0.5);
//! // What is free: rays above and below the square, from left to right.
//! let ray = |k: i32| {
//!     let y = 3.0 + 0.01 * f64::from(k % 100) - if k < 100 { 0.0 } else { 4.5 };
//!     (Point3::new(-3.0, y, 0.0), Point3::new(5.0, y, 0.0))
//! };
//! let space = KnownSpace::from_rays(&(0..200).map(ray).collect::<Vec<_>>()).ok_or("no rays")?;
//! let options = NextViewOptions::new(1, 1.3, 10.0);
//! let view = next_views(&patches, &space, &options)[0];
//! assert!(view.position.x > 2.0, "the right side is seen from the right");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod known_space;
mod next_view;

pub use known_space::{Cell, KnownSpace};
pub use next_view::{NextView, NextViewOptions, UnseenPatch, next_views};

use crate::{CurveIndex, Section};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use transect_geometry::{Curve, EndReason, PlaneFrame, Point2, Vector2};

/// Largest number of pieces of one gap. Chosen by hand; doubled, the search for views takes longer.
const MOST_PATCHES: usize = 256;

/// An unseen stretch of boundary between two open ends of one plane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Gap {
    /// The curve whose end begins the gap.
    pub after: CurveIndex,
    /// The curve whose beginning ends it; may be the same.
    pub before: CurveIndex,
    /// Where it begins and ends, in plane coordinates.
    pub ends: [Point2; 2],
    /// Why the curve before the gap ends, and why the curve after it begins; `None` if unknown.
    pub reasons: [Option<EndReason>; 2],
}

impl Gap {
    fn between(end: &OpenEnd, begin: &OpenEnd) -> Self {
        Self {
            after: end.curve,
            before: begin.curve,
            ends: [end.position, begin.position],
            reasons: [end.reason, begin.reason],
        }
    }

    /// The straight distance between its ends, in the length unit: the least the unseen boundary
    /// can measure.
    pub fn width(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm()
    }

    /// The gap as pieces of unseen surface in space, if its plane stands for `height` along the
    /// guide; all in the length unit. Each is at most `spacing` wide, unless that takes more than
    /// 256 pieces.
    pub fn patches(&self, frame: &PlaneFrame, spacing: f64, height: f64) -> Vec<UnseenPatch> {
        let (width, most) = (self.width(), MOST_PATCHES as f64);
        let Some(outward) = self.outward().filter(|_| spacing > 0.0) else {
            return Vec::new();
        };
        let count = (width / spacing).ceil().clamp(1.0, most) as usize;
        let outward = frame.x_axis() * outward.x + frame.y_axis() * outward.y;
        let patch = |k: usize| {
            let share = (k as f64 + 0.5) / count as f64;
            let middle = self.ends[0] + (self.ends[1] - self.ends[0]) * share;
            let area = width * height / count as f64;
            UnseenPatch { middle: frame.world_from_plane(&middle), outward, area }
        };
        (0..count).map(patch).collect()
    }

    /// Unit vector away from the solid, perpendicular to the chord, in plane coordinates; `None`
    /// for a gap without width.
    pub fn outward(&self) -> Option<Vector2> {
        let along = (self.ends[1] - self.ends[0]).try_normalize(0.0)?;
        Some(Vector2::new(along.y, -along.x))
    }
}

/// An open end of a curve, with the unit vector along the curve there.
struct OpenEnd {
    curve: CurveIndex,
    position: Point2,
    along: Vector2,
    reason: Option<EndReason>,
}

impl OpenEnd {
    /// Its place with the number of its curve.
    fn numbered(&self, number: usize) -> GeomWithData<[f64; 2], usize> {
        GeomWithData::new([self.position.x, self.position.y], number)
    }

    fn of(curve: &Curve, index: usize) -> Option<[Self; 2]> {
        let (first, last) = (curve.units().next()?, curve.units().last()?);
        let [begin_reason, end_reason] = curve.ends();
        let end = |position, along: Vector2, reason| Self {
            curve: CurveIndex(index),
            position,
            along: along.try_normalize(0.0).unwrap_or_else(Vector2::zeros),
            reason,
        };
        Some([
            end(first.start, first.vector(), begin_reason),
            end(last.end, last.vector(), end_reason),
        ])
    }
}

impl Section {
    /// The gaps of this plane, widest first; as many as it has open curves.
    pub fn gaps(&self) -> Vec<Gap> {
        let open = self.curves().enumerate().filter(|(_, curve)| !curve.is_closed());
        let ends: Vec<[OpenEnd; 2]> =
            open.filter_map(|(index, curve)| OpenEnd::of(curve, index)).collect();
        let between = |(a, b): (usize, usize)| Gap::between(&ends[a][1], &ends[b][0]);
        let mut gaps: Vec<Gap> = cheapest_pairs(&ends).into_iter().map(between).collect();
        gaps.sort_by(|x, y| y.width().total_cmp(&x.width()).then(x.after.cmp(&y.after)));
        gaps
    }
}

/// Pairs of an end and a beginning, by the numbers of their curves: the cheapest of all first, then
/// the cheapest of those that are left. Of equal costs, the first end and the first beginning.
///
/// Each end waits in a queue with a beginning that was its cheapest when it was queued. Costs only
/// rise as beginnings are taken, so an end whose beginning is taken is queued again.
fn cheapest_pairs(ends: &[[OpenEnd; 2]]) -> Vec<(usize, usize)> {
    let begin = |(b, [begin, _]): (usize, &[OpenEnd; 2])| begin.numbered(b);
    let mut free = RTree::bulk_load(ends.iter().enumerate().map(begin).collect());
    let mut is_taken = vec![false; ends.len()];
    let mut waiting: Vec<_> = ends.iter().map(|[_, end]| Waiting::new(end)).collect();
    let mut queue = BinaryHeap::with_capacity(ends.len());
    for (a, end) in waiting.iter_mut().enumerate() {
        queue.extend(end.next(ends, &free, &is_taken).map(|next| Reverse(next.queued(a))));
    }
    let mut pairs = Vec::with_capacity(ends.len());
    while let Some(Reverse((_, a, b))) = queue.pop() {
        if is_taken[b] {
            let next = waiting[a].next(ends, &free, &is_taken);
            queue.extend(next.map(|next| Reverse(next.queued(a))));
            continue;
        }
        is_taken[b] = true;
        free.remove(&begin((b, &ends[b])));
        waiting[a].cheapest = Vec::new();
        pairs.push((a, b));
    }
    pairs
}

/// Beginnings of curves, with the numbers of the curves.
type Beginnings = RTree<GeomWithData<[f64; 2], usize>>;

/// Most beginnings that all ends together keep in mind: 64 MiB. Chosen by hand. Doubled, ends far
/// from all beginnings search half as often, and take twice the memory.
const KEPT: usize = 1 << 22;

/// A beginning and what it costs. The order is that of costs, then of numbers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// The bits of the cost. Those of numbers that are not negative have their order.
    cost: u64,
    begin: usize,
}

impl Candidate {
    /// The entry of an end in the queue.
    fn queued(self, end: usize) -> (u64, usize, usize) {
        (self.cost, end, self.begin)
    }
}

/// An end that has no beginning yet.
struct Waiting<'a> {
    end: &'a OpenEnd,
    /// The cheapest beginnings that were free at the last search; the very cheapest is last.
    cheapest: Vec<Candidate>,
    /// How many of them the next search looks for.
    wanted: usize,
    /// Whether the last search met all free beginnings. The order of the tree only costs time then.
    is_far: bool,
}

impl<'a> Waiting<'a> {
    fn new(end: &'a OpenEnd) -> Self {
        Self { end, cheapest: Vec::new(), wanted: 1, is_far: false }
    }

    /// The cheapest free beginning. Searches again if all that it knows are taken.
    fn next(
        &mut self,
        ends: &[[OpenEnd; 2]],
        free: &Beginnings,
        is_taken: &[bool],
    ) -> Option<Candidate> {
        while self.cheapest.last().is_some_and(|last| is_taken[last.begin]) {
            self.cheapest.pop();
        }
        if self.cheapest.is_empty() {
            self.search(ends, free);
        }
        self.cheapest.last().copied()
    }

    /// Finds the cheapest of the free beginnings, the nearest ones first. No cost is below the
    /// distance, so the search ends where the distance exceeds the largest cost.
    fn search(&mut self, ends: &[[OpenEnd; 2]], free: &Beginnings) {
        let mut found = BinaryHeap::with_capacity(self.wanted + 1);
        if self.is_far {
            free.iter().for_each(|begin| self.keep(begin.data, ends, &mut found));
        } else {
            let place = [self.end.position.x, self.end.position.y];
            let mut seen = 0;
            for (begin, squared) in free.nearest_neighbor_iter_with_distance_2(place) {
                let least = squared.sqrt() * (1.0 - ROUNDING);
                let most = found.peek().filter(|_| found.len() == self.wanted);
                if most.is_some_and(|most: &Candidate| least > f64::from_bits(most.cost)) {
                    break;
                }
                self.keep(begin.data, ends, &mut found);
                seen += 1;
            }
            self.is_far = seen == free.size();
        }
        self.cheapest = found.into_sorted_vec();
        self.cheapest.reverse();
        // More each time, as far as all ends together have room.
        self.wanted = (MORE * self.wanted).min((KEPT / free.size().max(1)).max(1));
    }

    /// Adds a beginning to the cheapest ones, and takes the dearest away if they are too many.
    fn keep(&self, begin: usize, ends: &[[OpenEnd; 2]], found: &mut BinaryHeap<Candidate>) {
        let cost = cost(self.end, &ends[begin][0]).to_bits();
        found.push(Candidate { cost, begin });
        if found.len() > self.wanted {
            found.pop();
        }
    }
}

/// How many times more beginnings an end looks for at its next search. Measured: an end far from
/// all beginnings searches a few times. Doubled, ends near their beginnings look too far.
const MORE: usize = 8;

/// By how much a cost may be less than the distance. Theory: some ten roundings of 2⁻⁵³. Doubled,
/// nothing changes.
const ROUNDING: f64 = 1e-12;

/// The straight distance from an end to a beginning, with a larger factor the more the way must
/// turn.
fn cost(end: &OpenEnd, begin: &OpenEnd) -> f64 {
    let across = begin.position - end.position;
    let straight = across.norm();
    let direction = across.try_normalize(0.0).unwrap_or_else(Vector2::zeros);
    straight * (3.0 - end.along.dot(&direction) - begin.along.dot(&direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_geometry::Node;

    fn curve(points: &[(f64, f64)], closed: bool) -> Curve {
        let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
        Curve::new(nodes, closed).unwrap()
    }

    #[test]
    fn the_open_side_of_a_square_is_its_gap() {
        // Solid on the left: the square runs counter-clockwise and lacks its left side.
        let square = curve(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)], false)
            .with_ends([Some(EndReason::ImageBorder), Some(EndReason::RangeJump)]);
        let gaps = Section::new(vec![square]).unwrap().gaps();
        assert_eq!(gaps.len(), 1);
        assert_eq!(gaps[0].ends, [Point2::new(0.0, 2.0), Point2::new(0.0, 0.0)]);
        assert_eq!(gaps[0].reasons, [Some(EndReason::RangeJump), Some(EndReason::ImageBorder)]);
        assert_eq!(gaps[0].width(), 2.0);
        assert_eq!(gaps[0].outward(), Some(Vector2::new(-1.0, 0.0)));
    }

    #[test]
    fn short_pieces_in_a_row_continue_each_other_and_do_not_close_over_themselves() {
        let piece = |k: usize| {
            let x = 0.3 * k as f64;
            curve(&[(x, 0.0), (x + 0.1, 0.0)], false)
        };
        let gaps = Section::new((0..5).map(piece).collect()).unwrap().gaps();
        let next = gaps.iter().filter(|g| g.before.0 == g.after.0 + 1).count();
        assert_eq!(next, 4);
        assert_eq!((gaps[0].after, gaps[0].before), (CurveIndex(4), CurveIndex(0)));
    }

    #[test]
    fn patches_share_the_area_of_a_gap_and_look_away_from_the_solid() {
        let square = curve(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)], false);
        let gap = Section::new(vec![square]).unwrap().gaps()[0];
        let origin = transect_geometry::Point3::new(7.0, 8.0, 9.0);
        let frame = PlaneFrame::new(origin, transect_geometry::Vector3::z()).unwrap();
        let patches = gap.patches(&frame, 0.3, 0.5);
        assert_eq!(patches.len(), 7);
        assert!((patches.iter().map(|p| p.area).sum::<f64>() - 1.0).abs() < 1e-12);
        let middle = frame.world_from_plane(&Point2::new(0.0, 1.0));
        assert!((patches[3].middle - middle).norm() < 1e-12);
        assert!((patches[3].outward + frame.x_axis()).norm() < 1e-12);
        assert_eq!(gap.patches(&frame, 0.0, 0.5), []);
        assert_eq!(gap.patches(&frame, 1e-9, 0.5).len(), MOST_PATCHES);
    }

    #[test]
    fn closed_curves_have_no_gaps() {
        let ring = curve(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)], true);
        assert_eq!(Section::new(vec![ring]).unwrap().gaps(), []);
    }

    /// The slow twin: all pairs, sorted by cost.
    fn all_pairs(ends: &[[OpenEnd; 2]]) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for (a, [_, end]) in ends.iter().enumerate() {
            pairs.extend(ends.iter().enumerate().map(|(b, [begin, _])| (cost(end, begin), a, b)));
        }
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let (mut ended, mut begun) = (vec![false; ends.len()], vec![false; ends.len()]);
        let mut found = Vec::new();
        for (_, a, b) in pairs {
            if !ended[a] && !begun[b] {
                (ended[a], begun[b]) = (true, true);
                found.push((a, b));
            }
        }
        found
    }

    proptest! {
        /// Whole coordinates make many costs equal, and some curves begin where others end.
        #[test]
        fn the_queue_pairs_ends_as_a_list_of_all_pairs_does(
            curves in prop::collection::vec(
                prop::collection::vec((-9_i8..9, -9_i8..9), 2..4), 0..40),
            scale in prop::sample::select(vec![1.0, 0.1, 1e-9, 1e9]),
        ) {
            let place = |(x, y): (i8, i8)| (scale * f64::from(x), scale * f64::from(y));
            let ends: Vec<[OpenEnd; 2]> = curves.into_iter().enumerate().filter_map(|(k, places)| {
                let places: Vec<_> = places.into_iter().map(place).collect();
                OpenEnd::of(&curve(&places, false), k)
            }).collect();
            prop_assert_eq!(cheapest_pairs(&ends), all_pairs(&ends));
        }

        /// A ring cut into pieces is mended where it was cut, whatever the order of the pieces.
        #[test]
        fn a_cut_ring_is_mended_where_it_was_cut(
            pieces in 2_usize..12,
            offset in 0_usize..12,
        ) {
            let at = |k: usize| {
                let angle = std::f64::consts::TAU * k as f64 / (8 * pieces) as f64;
                (angle.cos(), angle.sin())
            };
            // Of every eight steps one is missing.
            let piece = |k: usize| -> Curve {
                curve(&(8 * k..8 * k + 8).map(at).collect::<Vec<_>>(), false)
            };
            let order: Vec<usize> = (0..pieces).map(|k| (k * 7 + offset) % pieces).collect();
            prop_assume!((0..pieces).all(|k| order.contains(&k)));
            let section = Section::new(order.iter().map(|&k| piece(k)).collect()).unwrap();
            for gap in section.gaps() {
                let (from, to) = (order[gap.after.0], order[gap.before.0]);
                prop_assert_eq!((from + 1) % pieces, to);
                let middle = nalgebra::center(&gap.ends[0], &gap.ends[1]);
                prop_assert!(gap.outward().unwrap().dot(&middle.coords) > 0.0);
            }
        }
    }
}
