//! Beads: short pieces of the curves of single views, which common courses go through.

use super::super::tuning::settle::*;
use super::observations::{Observation, Observations};
use super::reach::Reach;
use transect_geometry::{Point2, Vector2};

/// A short piece of a view's curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bead {
    /// Weighted mean of its observations.
    pub position: Point2,
    /// Unit vector: their weighted mean direction.
    pub tangent: Vector2,
    /// Length that its observations stand for.
    pub length: f64,
    /// Variance of its view's error, over that of a typical view.
    pub variance: f64,
    pub view: u32,
    /// Whether it goes on where the bead before it ends.
    pub follows: bool,
}

impl Bead {
    /// Takes in the bead that follows.
    fn join(&mut self, next: &Self) {
        let length = self.length + next.length;
        let share = if length > 0.0 { next.length / length } else { 0.5 };
        self.position += (next.position - self.position) * share;
        let tangent = self.tangent + (next.tangent - self.tangent) * share;
        self.tangent = tangent.try_normalize(0.0).unwrap_or(self.tangent);
        self.variance += (next.variance - self.variance) * share;
        self.length = length;
    }
}

/// Cuts the views' curves into beads, and says which bead each observation is in.
pub(super) fn beads(observations: &Observations, reach: &Reach) -> (Vec<Bead>, Vec<u32>) {
    let all = &observations.all;
    let length_at =
        |k: usize| all.get(k).map_or(0.0, |o| reach.at(reach.variance(o)).along / BEADS_PER_REACH);
    let (mut beads, mut bead_of) = (Vec::new(), Vec::with_capacity(all.len()));
    let (mut start, mut begun, mut length) = (0, false, length_at(0));
    for k in 0..all.len() {
        bead_of.push(beads.len() as u32);
        let follows = all[k].next as usize == k + 1 && !all[k].bridged;
        let fits = |next: &Point2| (next - all[start].position).norm() <= length;
        if !(follows && fits(&all[k + 1].position)) {
            beads.push(Bead { follows: begun, ..bead(&all[start..=k], reach) });
            (start, begun, length) = (k + 1, follows, length_at(k + 1));
        }
    }
    (beads, bead_of)
}

/// Joins up to `most` beads that follow each other in one direction. Each longer bead comes with
/// the number of beads it is made of.
pub(super) fn joined(beads: &[Bead], most: usize) -> Vec<(usize, Bead)> {
    let mut joined: Vec<(usize, Bead)> = Vec::with_capacity(beads.len() / most + 1);
    for bead in beads {
        match joined.last_mut() {
            Some((count, last))
                if *count < most
                    && bead.follows
                    && bead.tangent.dot(&last.tangent) >= JOINED_COSINE =>
            {
                last.join(bead);
                *count += 1;
            }
            _ => joined.push((1, *bead)),
        }
    }
    joined
}

fn bead(members: &[Observation], reach: &Reach) -> Bead {
    let first = &members[0];
    let (mut length, mut place, mut tangent) = (0.0, Vector2::zeros(), Vector2::zeros());
    let mut variance = 0.0;
    for o in members {
        let weight = o.support * o.footprint;
        length += weight;
        variance += weight * reach.variance(o);
        place += (o.position - first.position) * weight;
        tangent += o.tangent * weight;
    }
    Bead {
        position: first.position + place / length.max(f64::MIN_POSITIVE),
        tangent: tangent.try_normalize(0.0).unwrap_or(first.tangent),
        length,
        variance: if length > 0.0 { variance / length } else { reach.variance(first) },
        view: first.view,
        follows: false,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Beads along an arc of a view: angles in parts of a circle of radius 1.
    pub fn arc(view: u32, parts: u32, count: u32, radius: f64) -> Vec<Bead> {
        let bead = |k: u32| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(parts)).sin_cos();
            Bead {
                position: Point2::new(radius * cos, radius * sin),
                tangent: Vector2::new(-sin, cos),
                length: radius * TAU / f64::from(parts),
                variance: 1.0,
                view,
                follows: k > 0,
            }
        };
        (0..count).map(bead).collect()
    }

    #[test]
    fn beads_are_joined_along_one_direction_of_one_curve() {
        let counts = |beads: &[Bead], most| -> Vec<usize> {
            joined(beads, most).iter().map(|(count, _)| *count).collect()
        };
        let straight = arc(0, 3600, 9, 1.0);
        assert_eq!(counts(&straight, 4), [4, 4, 1]);
        let two_curves = [&straight[..3], &straight[..3]].concat();
        assert_eq!(counts(&two_curves, 4), [3, 3], "a curve ends");
        assert_eq!(counts(&arc(0, 8, 4, 1.0), 4), [1; 4], "the direction turns");
        let length = |beads: Vec<(usize, Bead)>| beads.iter().map(|(_, b)| b.length).sum::<f64>();
        let short: f64 = straight.iter().map(|bead| bead.length).sum();
        assert!((length(joined(&straight, 4)) - short).abs() < 1e-12);
    }
}
