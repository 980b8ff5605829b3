//! The first rounds: poses come near to the best fit, whatever the given ones are.
//!
//! **Problem.** How far poses were off follows from what contradicts after they have settled. Until
//! then nothing tells which patches are of other surfaces.
//!
//! **Steps.**
//! 1. Rounds with a loose prior and few observations. A stated prior is loosened: held away from
//!    the best fit, patches beside each other err alike and seem to say little. The rounds that
//!    follow hold the poses by it.
//! 2. All views return to their given poses if clearly fewer patches agree than there.

use super::Rounds;
use super::observations::{Observation, Pieces, State};
use super::pairs::Spread;
use crate::tuning::{GATE, OBSERVATIONS, SETTLING};

impl Rounds<'_> {
    /// Brings the poses near to the best fit. `None` if nothing determines the views.
    pub(super) fn first_rounds(&mut self) -> Option<()> {
        let given = self.agreeing();
        let prior = std::mem::replace(&mut self.prior, self.first);
        self.own_loosened = self.stated;
        let settled = (0..SETTLING).try_for_each(|round| {
            let spread = if round < SETTLING / 2 { Spread::Wide } else { Spread::Narrow };
            self.observe(self.first, OBSERVATIONS / 4, spread);
            self.step_by_known_priors()
        });
        self.prior = prior;
        self.own_loosened = false;
        settled?;
        // A loose prior lets patches of other surfaces draw views that were right. The standard
        // deviation of a count is its root.
        if self.agreeing() + GATE * given.sqrt() < given {
            self.poses = self.given.clone();
            self.last_change.fill(0.0);
        }
        Some(())
    }

    /// How many patches lie on those of other views, within noise.
    pub(super) fn agreeing(&self) -> f64 {
        let state = State { poses: &self.poses, cameras: &self.cameras };
        let pairs = self.observed(state, self.first, OBSERVATIONS / 4, Spread::Narrow);
        let within = |o: &&Observation| o.distance.powi(2) <= GATE.powi(2) * o.variance;
        let patches = pairs.iter().filter(|pair| pair.of == Pieces::Patches);
        let counts = patches.map(|pair| pair.observations.iter().filter(within).count());
        counts.sum::<usize>() as f64
    }
}
