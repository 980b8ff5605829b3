//! Stretches of a view's curves, and pairs of them that may run side by side.

use super::super::super::tuning::layers::{
    STRETCH_FOOTPRINTS, STRETCH_NODES, STRETCHES_SAME_WAY, WAY_ROUND,
};
use super::super::observations::Observation;
use super::super::spread::search_distance;
use crate::grid::PointGrid;
use transect_geometry::{Envelope, Point2, Vector2};

/// Nodes in a row of one view's curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    /// First observation, and the first behind the stretch.
    pub first: u32,
    pub end: u32,
    pub view: u32,
    /// Number of the curve.
    pub curve: u32,
    /// Length of the curve up to the first and the last of them.
    from: f64,
    to: f64,
    longest: f64,
    /// Sum of the directions.
    tangent: Vector2,
    envelope: Envelope,
    /// How far another stretch is searched for.
    search: f64,
}

impl Stretch {
    fn new(k: usize, o: &Observation, curve: u32, from: f64) -> Self {
        Self {
            first: k as u32,
            end: k as u32 + 1,
            view: o.view,
            curve,
            from,
            to: from,
            longest: STRETCH_FOOTPRINTS * o.footprint,
            tangent: o.tangent,
            envelope: Envelope { min: o.position, max: o.position },
            search: search_distance(o),
        }
    }

    /// Takes the next node of the curve, `to` along it, unless the stretch is long enough.
    fn take(&mut self, o: &Observation, to: f64) -> bool {
        if self.end - self.first >= STRETCH_NODES || to - self.from > self.longest {
            return false;
        }
        self.end += 1;
        self.to = to;
        self.tangent += o.tangent;
        let here = Envelope { min: o.position, max: o.position };
        self.envelope = self.envelope.merged(&here);
        self.search = self.search.max(search_distance(o));
        true
    }

    fn half_diagonal(&self) -> f64 {
        0.5 * self.envelope.size().norm()
    }

    /// Whether another stretch may run beside this one.
    fn may_have_beside(&self, other: &Self) -> bool {
        let cosine = self.tangent.dot(&other.tangent);
        cosine >= STRETCHES_SAME_WAY * self.tangent.norm() * other.tangent.norm()
            && self.envelope.grown(self.search).intersects(&other.envelope)
            && self.may_be_two_surfaces(other)
    }

    /// Whether two stretches of one curve are far enough apart along it. Neighbours are not.
    fn may_be_two_surfaces(&self, other: &Self) -> bool {
        let neighbours = self.first <= other.end && other.first <= self.end;
        let way = (self.to - other.from).max(other.to - self.from);
        let apart = (self.envelope.min - other.envelope.max)
            .sup(&(other.envelope.min - self.envelope.max))
            .sup(&Vector2::zeros());
        self.curve != other.curve || (!neighbours && way >= WAY_ROUND * apart.norm())
    }
}

/// The stretches of all curves, in the order of observations.
pub(super) fn stretches(seen: &[Observation]) -> Vec<Stretch> {
    let mut all: Vec<Stretch> = Vec::new();
    let (mut curve, mut way) = (0, 0.0);
    let mut before: Option<&Observation> = None;
    for (k, o) in seen.iter().enumerate() {
        let follows = before.filter(|b| b.next == k as u32);
        match follows {
            Some(b) => way += (o.position - b.position).norm(),
            None => (curve, way) = (curve + 1, 0.0),
        }
        let goes_on = follows.is_some_and(|b| !b.bridged);
        if !(goes_on && all.last_mut().is_some_and(|s| s.take(o, way))) {
            all.push(Stretch::new(k, o, curve, way));
        }
        before = Some(o);
    }
    all
}

/// Visits the pairs of one view's stretches that may run beside each other, in both orders.
pub(super) fn pairs(stretches: &[Stretch], mut visit: impl FnMut(&Stretch, &Stretch)) {
    let middles: Vec<Point2> =
        stretches.iter().map(|s| nalgebra::center(&s.envelope.min, &s.envelope.max)).collect();
    let largest = stretches.iter().map(Stretch::half_diagonal).fold(0.0, f64::max);
    let search = stretches.iter().map(|s| s.search).fold(0.0, f64::max);
    let grid = PointGrid::new(&middles, largest + 0.5 * search);
    for (a, middle) in stretches.iter().zip(&middles) {
        let radius = a.half_diagonal() + largest + a.search * std::f64::consts::SQRT_2;
        grid.within(middle, radius, |b, _| {
            if a.may_have_beside(&stretches[b]) {
                visit(a, &stretches[b]);
            }
        });
    }
}
