//! The global model of a plane, which grows with every view (dissertation 5.2.2, 5.3.1).
//!
//! **Problem.** A view brings the curves of a partial model. Each may overlap none, one or several
//! of the curves that are already there.
//!
//! **Steps**, for each partial curve:
//! 1. Case 1: the plane has no curves yet; the partial curve is the first.
//! 2. Case 2: no envelope meets its envelope, or what met was no overlap; it is put beside them.
//! 3. Case 3: it overlaps a global curve. That curve is merged **into the partial one** and its
//!    record is cancelled. The grown curve goes on to the next candidate, so that a partial curve
//!    bridges any number of global ones. In the end it takes its place among the global curves.
//! 4. The envelopes of the curve and of the plane are exchanged with it.
//!
//! **Departures from the source.** Candidates are asked for again after each merge: a grown curve
//! may reach one that the partial curve did not. Each is tried once per partial curve, and once
//! more if the partial curve was cut. The curves of a view go in a canonical order, so that the
//! order in which a view lists them does not matter. The order of views does: it is the method's
//! nature.
//!
//! **Cost.** O(n) for n curves of the plane, and the length of the curves that meet.

use super::fork::Cut;
use super::splice::{Merged, Outcome, Refusal, merge};
use crate::consensus::measure::canonical;
use crate::envelopes::{EnvelopeMeeting, PlaneEnvelopes};
use crate::pattern::{OverlapTolerance, classify};
use crate::screening::may_overlap;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::Curve;

/// How the model of a plane grew with a view (5.2.2, step 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GrowthCase {
    /// Case 1: the plane was empty.
    NewPlane,
    /// Case 2: no curve of the view overlapped one of the plane.
    Appended,
    /// Case 3: some did.
    Merged,
}

/// Counts of the merges while planes grew.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct GrowthCounts {
    /// How often a view brought the first curves of a plane, curves that overlapped none, and
    /// curves that overlapped some: cases 1 to 3 of 5.2.2.
    pub cases: [usize; 3],
    /// Partial curves put beside the others.
    pub appended: usize,
    /// Global curves merged into partial ones.
    pub merged: usize,
    /// Of these, overlaps of the five patterns of Figure 5.7, in its order.
    pub patterns: [usize; 5],
    /// Of these, rings that two curves closed.
    pub rings: usize,
    /// Of these, overlaps where averaging would have lost a node, and one curve stayed as it was.
    pub kept_as_seen: usize,
    /// Forks at which a curve was cut.
    pub cut: usize,
    /// Pairs refused because of a fork at the beginning (1), at the end (2), at both (3).
    pub forks: [usize; 3],
    /// Pairs refused because they overlap in several places and make no ring.
    pub several: usize,
    /// Observations whose nodes, fused ones by their weight, were farther than the threshold from
    /// the curve that they were merged into, and those of curves without length.
    pub dropped: usize,
}

impl GrowthCounts {
    /// All pairs that the rules forbid to merge.
    pub fn refused(&self) -> usize {
        self.forks.iter().sum::<usize>() + self.several
    }

    /// Adds the counts of another plane.
    pub fn add(&mut self, other: &Self) {
        *self = Self {
            cases: sums(self.cases, other.cases),
            appended: self.appended + other.appended,
            merged: self.merged + other.merged,
            patterns: sums(self.patterns, other.patterns),
            rings: self.rings + other.rings,
            kept_as_seen: self.kept_as_seen + other.kept_as_seen,
            cut: self.cut + other.cut,
            forks: sums(self.forks, other.forks),
            several: self.several + other.several,
            dropped: self.dropped.saturating_add(other.dropped),
        };
    }

    fn refuse(&mut self, refusal: Refusal) {
        match refusal {
            Refusal::Fork(fork) => self.forks[fork as usize] += 1,
            Refusal::Several => self.several += 1,
        }
    }

    fn count(&mut self, merged: &Merged) {
        self.merged += 1;
        if let Some(pattern) = merged.pattern {
            self.patterns[pattern as usize] += 1;
        }
        self.rings += usize::from(merged.ring);
        self.kept_as_seen += usize::from(!merged.averaged);
        self.dropped = self.dropped.saturating_add(merged.dropped);
    }
}

fn sums<const N: usize>(mut a: [usize; N], b: [usize; N]) -> [usize; N] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

/// The curves of one plane, fused so far.
#[derive(Debug, Clone)]
pub struct GrowingPlane {
    tolerance: OverlapTolerance,
    /// By record number; a curve that grows gets a new one.
    curves: BTreeMap<usize, Curve>,
    envelopes: PlaneEnvelopes,
    next_record: usize,
    counts: GrowthCounts,
}

impl GrowingPlane {
    /// A plane without curves.
    pub fn new(tolerance: OverlapTolerance) -> Self {
        Self {
            tolerance,
            curves: BTreeMap::new(),
            envelopes: PlaneEnvelopes::new(tolerance.distance()),
            next_record: 0,
            counts: GrowthCounts::default(),
        }
    }

    /// Fuses the curves of one view into the plane.
    pub fn grow(&mut self, partial: &[Curve]) -> GrowthCase {
        let (was_empty, merged_before) = (self.curves.is_empty(), self.counts.merged);
        let mut curves: Vec<&Curve> = partial.iter().collect();
        curves.sort_by(|a, b| canonical(a, b));
        for curve in curves {
            if curve.length() > 0.0 {
                self.integrate(curve.clone());
            } else {
                self.counts.dropped += curve.nodes().len();
            }
        }
        let case = match (was_empty, self.counts.merged > merged_before) {
            (true, _) => GrowthCase::NewPlane,
            (false, false) => GrowthCase::Appended,
            (false, true) => GrowthCase::Merged,
        };
        // A view that does not cross the plane is no case.
        self.counts.cases[case as usize] += usize::from(!partial.is_empty());
        case
    }

    /// The global curves in order of their records.
    pub fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.curves.values()
    }

    /// The global curve of a record.
    pub fn curve(&self, record: usize) -> Option<&Curve> {
        self.curves.get(&record)
    }

    /// When two curves overlap.
    pub fn tolerance(&self) -> &OverlapTolerance {
        &self.tolerance
    }

    /// The envelopes of the global curves, by record.
    pub fn envelopes(&self) -> &PlaneEnvelopes {
        &self.envelopes
    }

    /// The counts so far.
    pub fn counts(&self) -> &GrowthCounts {
        &self.counts
    }

    /// The global curves, giving up the plane.
    pub fn into_curves(self) -> Vec<Curve> {
        self.curves.into_values().collect()
    }

    fn integrate(&mut self, partial: Curve) {
        let mut waiting = vec![partial];
        while let Some(curve) = waiting.pop() {
            let (curve, is_new) = self.merged_with_all(curve, &mut waiting);
            self.counts.appended += usize::from(is_new);
            self.put(curve);
        }
    }

    /// A curve with all global ones that it overlaps, and whether there are none. What is cut off
    /// at forks goes to the waiting curves.
    fn merged_with_all(&mut self, mut curve: Curve, waiting: &mut Vec<Curve>) -> (Curve, bool) {
        let (mut tried, mut is_new) = (BTreeSet::new(), true);
        while let Some(meeting) = self.next_candidate(&curve, &mut tried) {
            let number = meeting.curve;
            let Some(global) = self.curves.get(&number) else { continue };
            match self.try_to_merge(&curve, global, &meeting) {
                Outcome::Apart => {}
                Outcome::Refused(refusal) => self.counts.refuse(refusal),
                Outcome::Cut(Cut { side: 0, pieces: [first, second] }) => {
                    self.counts.cut += 1;
                    waiting.push(second);
                    curve = first;
                    tried.remove(&number);
                }
                Outcome::Cut(Cut { pieces, .. }) => {
                    self.counts.cut += 1;
                    self.remove(number);
                    pieces.into_iter().for_each(|piece| self.put(piece));
                }
                Outcome::Merged(merged) => {
                    self.remove(number);
                    self.counts.count(&merged);
                    curve = merged.curve;
                    is_new = false;
                }
            }
        }
        (curve, is_new)
    }

    fn remove(&mut self, number: usize) {
        self.curves.remove(&number);
        self.envelopes.remove(number);
    }

    fn put(&mut self, curve: Curve) {
        self.envelopes.insert(self.next_record, &curve);
        self.curves.insert(self.next_record, curve);
        self.next_record += 1;
    }

    /// The first global curve in order of record whose envelope meets the curve's, and that has not
    /// been tried.
    fn next_candidate(
        &self,
        curve: &Curve,
        tried: &mut BTreeSet<usize>,
    ) -> Option<EnvelopeMeeting> {
        let meetings = self.envelopes.meeting(curve);
        meetings.into_iter().find(|meeting| tried.insert(meeting.curve))
    }

    fn try_to_merge(&self, curve: &Curve, global: &Curve, meeting: &EnvelopeMeeting) -> Outcome {
        if !may_overlap(curve, global, &meeting.common, self.tolerance.max_angle_rad()) {
            return Outcome::Apart;
        }
        let overlaps = classify(curve, global, &self.tolerance);
        merge([curve, global], &overlaps, &self.tolerance)
    }
}
