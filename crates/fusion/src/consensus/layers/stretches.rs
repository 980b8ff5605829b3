//! Stretches of a view's curves, and pairs of them that may run side by side.

use super::super::observations::Observation;
use super::super::spread::search_distance;
use crate::grid::PointGrid;
use transect_geometry::{Envelope, Point2, Vector2};

/// Most nodes of a stretch, and how far it reaches from its first, in footprints.
pub(super) const STRETCH_NODES: u32 = 8;
const STRETCH_FOOTPRINTS: f64 = 8.0;

/// Smallest cosine between the mean directions of two stretches whose nodes are looked at.
const STRETCHES_SAME_WAY: f64 = 0.2;

/// Nodes in a row of one view's curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    /// First observation, and first behind it.
    pub first: u32,
    pub end: u32,
    pub view: u32,
    /// Number of the curve.
    pub curve: u32,
    /// Sum of the directions.
    tangent: Vector2,
    envelope: Envelope,
    /// How far another one is looked for.
    search: f64,
}

impl Stretch {
    fn of(k: usize, o: &Observation, curve: u32) -> Self {
        Self {
            first: k as u32,
            end: k as u32 + 1,
            view: o.view,
            curve,
            tangent: o.tangent,
            envelope: Envelope { min: o.position, max: o.position },
            search: search_distance(o),
        }
    }

    fn add(&mut self, o: &Observation) {
        self.end += 1;
        self.tangent += o.tangent;
        let here = Envelope { min: o.position, max: o.position };
        self.envelope = self.envelope.merged(&here);
        self.search = self.search.max(search_distance(o));
    }

    fn takes(&self, seen: &[Observation], o: &Observation) -> bool {
        let first = &seen[self.first as usize];
        self.end - self.first < STRETCH_NODES
            && (o.position - first.position).norm() <= STRETCH_FOOTPRINTS * first.footprint
    }

    fn half_diagonal(&self) -> f64 {
        0.5 * self.envelope.size().norm()
    }

    /// Whether another one may run beside this one.
    fn may_have_beside(&self, other: &Self) -> bool {
        let cosine = self.tangent.dot(&other.tangent);
        let neighbour =
            self.curve == other.curve && (self.first <= other.end && other.first <= self.end);
        !neighbour
            && cosine >= STRETCHES_SAME_WAY * self.tangent.norm() * other.tangent.norm()
            && self.envelope.grown(self.search).intersects(&other.envelope)
    }
}

/// The stretches of all curves, in the order of observations.
pub(super) fn stretches(seen: &[Observation]) -> Vec<Stretch> {
    let mut all: Vec<Stretch> = Vec::new();
    let mut curve = 0;
    let mut before: Option<&Observation> = None;
    for (k, o) in seen.iter().enumerate() {
        let follows = before.is_some_and(|b| b.next == k as u32);
        curve += u32::from(!follows);
        let goes_on = follows && before.is_some_and(|b| !b.bridged);
        match all.last_mut().filter(|s| goes_on && s.takes(seen, o)) {
            Some(s) => s.add(o),
            None => all.push(Stretch::of(k, o, curve)),
        }
        before = Some(o);
    }
    all
}

/// Visits the pairs of one view's stretches that may run beside each other, each of both ways.
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
