//! Whether pairs that were left out of an estimate agree better with it.
//!
//! **Problem.** Residuals fall in every fit, also in one that makes the poses worse.
//!
//! **Idea.** Cross-validation (Stone, 1974): the pairs of views are split into parts. All parts but
//! one move the views, and that one judges. Close to the solution all distances are linear in the
//! motions, so the sums of the last round are enough.

use super::Rounds;
use super::pairs::{Pair, Sums, scrambled};
use super::solve::{Motion, System, about};
use crate::tuning::PARTS;
use std::collections::{BTreeMap, BTreeSet};

impl Rounds<'_> {
    /// Change of the squared distances of pairs that the estimate did not know, as a share; `None`
    /// if there is one pair only.
    pub(super) fn left_out(&self) -> Option<f64> {
        let sums: Vec<Sums> = self.pairs.iter().map(Pair::sums).collect();
        // Both directions of a pair see the same error, so they stay together.
        let unordered = |s: &Sums| (s.a.min(s.b), s.a.max(s.b));
        let mixed = |(a, b): (usize, usize)| (scrambled((a << 16 | b) as u32), a, b);
        let ranks: BTreeSet<_> = sums.iter().map(|s| mixed(unordered(s))).collect();
        let parts = ranks.len().min(PARTS);
        if parts < 2 {
            return None;
        }
        let ranks: BTreeMap<_, usize> = ranks.into_iter().zip((0..parts).cycle()).collect();
        let (mut before, mut after) = (0.0, 0.0);
        let so_far = self.motions();
        let back: Vec<Motion> = so_far.iter().map(|m| -m).collect();
        for part in 0..parts {
            let left_out = |s: &&Sums| ranks.get(&mixed(unordered(s))) == Some(&part);
            let (unknown, known): (Vec<&Sums>, Vec<&Sums>) = sums.iter().partition(left_out);
            let system = System::new(&self.sensors(), self.scene.origin, known, self.independent);
            let motions = system.solve(&self.priors(), &so_far)?.motions;
            before += unknown.iter().map(|s| self.square(s, &back)).sum::<f64>();
            after += unknown.iter().map(|s| self.square(s, &motions)).sum::<f64>();
        }
        (before > 0.0).then(|| after / before - 1.0)
    }

    /// Weighted squares of a pair after small motions of all views.
    fn square(&self, sums: &Sums, motions: &[Motion]) -> f64 {
        let about_origin = |k: usize| {
            let (Some(motion), Some(pose)) = (motions.get(k), self.poses.get(k)) else {
                return Motion::zeros();
            };
            about(&(pose.translation.vector - self.scene.origin.coords)).transpose() * motion
        };
        let motion = about_origin(sums.a) - about_origin(sums.b);
        sums.square + 2.0 * sums.vector.dot(&motion) + motion.dot(&(sums.matrix * motion))
    }
}
