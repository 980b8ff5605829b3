//! Gaps of one to four missing pixels in a curve (3.5.1).
//!
//! An end of a curve is joined to the closest other end in its search window, on three conditions.
//! The other end is at the border that the search order expects. Its high pixel is on the same side
//! of the curve. The curve continues there in direction and range, by the rules of
//! `continuation.rs`.
//!
//! Under the printed test for a jump, both sides of the gap and the valid pixels in it must lie
//! near the plane instead.
//!
//! Closest pairs are joined first; of equally close ones the straightest.

use super::link::{Contour, End, Links};
use super::samples::Samples;
use super::search::SearchOrder;
use crate::continuation::{self, Place, REACH};
use transect_device::{Neighbour, Pixel};
use transect_geometry::Point2;

/// Joins ends across gaps.
pub(super) fn bridge(
    contour: &Contour,
    samples: &Samples,
    level: i32,
    order: &SearchOrder,
    links: &mut Links,
) {
    let gaps = Gaps { contour, samples, level, links };
    let mut candidates = gaps.candidates(order);
    candidates.sort_by(|a, b| {
        let key = |c: &Candidate| (c.distance, c.from, c.to);
        a.distance.cmp(&b.distance).then(a.turn.total_cmp(&b.turn)).then(key(a).cmp(&key(b)))
    });
    for c in candidates {
        if links.of(c.from).is_none() && links.of(c.to).is_none() {
            links.join(c.from, c.to, true);
        }
    }
}

/// Two ends that a gap may part.
struct Candidate {
    /// Squared distance in pixels.
    distance: i32,
    /// How much the curve turns at both ends together; no unit.
    turn: f64,
    from: End,
    to: End,
}

struct Gaps<'a> {
    contour: &'a Contour<'a>,
    samples: &'a Samples<'a>,
    level: i32,
    links: &'a Links,
}

impl Gaps<'_> {
    fn candidates(&self, order: &SearchOrder) -> Vec<Candidate> {
        let mut found = Vec::new();
        for from in self.links.open_ends() {
            let code = self.contour.code(from.pixel).number();
            for step in order.of(code).iter().filter(|s| !s.adjacent) {
                let Some(to) = self.contour.reach(from, step) else { continue };
                // Each pair is looked at from one side only.
                if to <= from || self.links.of(to).is_some() {
                    continue;
                }
                let distance = step.rows * step.rows + step.cols * step.cols;
                if let Some(turn) = self.turn(from, to).filter(|_| self.range_continues(from, to)) {
                    found.push(Candidate { distance, turn, from, to });
                }
            }
        }
        found
    }

    /// How much the curve turns across the gap; `None` if that is too much, or if it misses the
    /// other end.
    fn turn(&self, from: End, to: End) -> Option<f64> {
        // All relative to one pixel, so that the seam of a full circle does not show.
        let anchor = self.contour.pixels[from.pixel];
        let (tail, head) = (self.inward(from, anchor), self.inward(to, anchor));
        let pixels = [anchor, self.contour.pixels[to.pixel]];
        let surface = self.contour.surface;
        continuation::turn(&tail, &head, |miss| surface.continues(pixels[0], pixels[1], miss))
    }

    /// Places of the first few borders from an end into its curve.
    fn inward(&self, end: End, anchor: Pixel) -> Vec<Place> {
        let mut places = Vec::new();
        let mut at = end;
        while places.len() < REACH {
            let borders = [at, at.opposite()].map(|e| self.contour.side(e).border());
            let count = if borders[0] == borders[1] { 1 } else { 2 };
            let pixel = self.contour.pixels[at.pixel];
            places.extend(borders[..count].iter().filter_map(|b| self.place(pixel, *b, anchor)));
            match self.links.of(at.opposite()) {
                Some(next) if next.to.pixel != end.pixel => at = next.to,
                _ => break,
            }
        }
        places
    }

    fn place(&self, p: Pixel, border: Neighbour, anchor: Pixel) -> Option<Place> {
        let other = self.contour.grid.before(p, border)?;
        let level = f64::from(self.level);
        let (h, o) = (self.samples.level(p)? - level, self.samples.level(other)? - level);
        let back = (h / (h - o)).clamp(0.0, 1.0);
        let back = if back.is_nan() { 0.5 } else { back };
        let (row, col) = self.contour.grid.offset(anchor, p);
        let image = match border {
            Neighbour::Up => Point2::new(row - back, col),
            Neighbour::Left => Point2::new(row, col - back),
        };
        let view = self.samples.view;
        let (a, b) = (view.point_in_sensor(p)?, view.point_in_sensor(other)?);
        Some(Place { image, in_plane: self.samples.axes.in_plane(&(a + (b - a) * back)) })
    }

    /// Whether valid pixels beside the gap are of one surface all the way.
    fn range_continues(&self, from: End, to: End) -> bool {
        let pixels = |end: End| {
            let p = self.contour.pixels[end.pixel];
            let other = self.contour.grid.before(p, self.contour.side(end).border())?;
            let high = self.contour.labels.get(p) == Some(super::Label::High);
            Some(if high { [p, other] } else { [other, p] })
        };
        let (Some(a), Some(b)) = (pixels(from), pixels(to)) else { return false };
        a.iter().zip(&b).all(|(a, b)| self.one_surface(*a, *b))
    }

    fn one_surface(&self, a: Pixel, b: Pixel) -> bool {
        let valid = |p| self.samples.level(p).is_some();
        let alike = |a, b| self.contour.surface.alike(a, b);
        continuation::missing_between(&self.contour.grid, [a, b], valid, alike).is_some()
    }
}
