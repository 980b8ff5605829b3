//! The first rounds: poses come near to the best fit, whatever the given ones are.
//!
//! **Problem.** How far poses were off follows from what contradicts after they have settled. Until
//! then nothing tells which patches are of other surfaces. And a view that is far off soon agrees
//! with the others in most patches, wherever it slides along them. The few patches that tell where
//! it belongs, as those of a small bore, are outliers then.
//!
//! **Idea.** In the pairs of wrong views, distances up to a tolerance count fully. The tolerance
//! shrinks from round to round (graduated non-convexity: Blake and Zisserman, 1987).
//!
//! **Steps.**
//! 1. Where some views are wrong, the others hold still until these have come to them. A stated
//!    prior is loosened: held away from the best fit, patches beside each other err alike and seem
//!    to say little. The rounds that follow hold the poses by it.
//! 2. Rounds with a loose prior and few observations.
//! 3. All views return to their given poses if clearly fewer patches agree than there.
//!
//! **Limit.** Where all poses err, there is no tolerance. Measured on 24 such simulated scans: with
//! one, lattices and plates erred by up to two thirds less, and cameras that drift by 5 % more.

use super::observations::{Observation, Pieces, State};
use super::pairs::Spread;
use super::{Rounds, usual_prior};
use crate::tuning::{EXACT, FIRST_TOLERANCE, GATE, NARROWING, OBSERVATIONS, SETTLING};

impl Rounds<'_> {
    /// Brings the poses near to the best fit. `None` if nothing determines the views.
    pub(super) fn first_rounds(&mut self) -> Option<()> {
        let (given, prior) = (self.agreeing(), self.prior);
        if self.loose.contains(&true) {
            self.prior.rotation *= EXACT;
            self.prior.translation *= EXACT;
        } else if self.stated {
            let usual = usual_prior(self.distance);
            self.prior.rotation = prior.rotation.max(usual.rotation);
            self.prior.translation = prior.translation.max(usual.translation);
        }
        let mut tolerance = FIRST_TOLERANCE * self.first.translation;
        for round in 0..SETTLING {
            let spread = if round < SETTLING / 2 { Spread::Wide } else { Spread::Narrow };
            self.observe(self.first, OBSERVATIONS / 4, spread);
            self.tolerate(tolerance);
            tolerance *= NARROWING;
            self.step(0, 0.0)?;
        }
        self.prior = prior;
        // A loose prior lets patches of other surfaces draw views that were right. The standard
        // deviation of a count is its root.
        if self.agreeing() + GATE * given.sqrt() < given {
            self.poses = self.given.clone();
            self.last_change.fill(0.0);
        }
        Some(())
    }

    /// Lets distances up to about a tolerance count in the pairs of wrong views.
    fn tolerate(&mut self, tolerance: f64) {
        let Self { pairs, loose, .. } = self;
        for pair in pairs.iter_mut().filter(|pair| loose[pair.a] || loose[pair.b]) {
            pair.excess = pair.excess.max(tolerance.powi(2));
        }
    }

    /// How many patches lie on those of other views, within noise.
    fn agreeing(&self) -> f64 {
        let state = State { poses: &self.poses, cameras: &self.cameras };
        let pairs = self.observed(state, self.first, OBSERVATIONS / 4, Spread::Narrow);
        let within = |o: &&Observation| o.distance.powi(2) <= GATE.powi(2) * o.variance;
        let patches = pairs.iter().filter(|pair| pair.of == Pieces::Patches);
        let counts = patches.map(|pair| pair.observations.iter().filter(within).count());
        counts.sum::<usize>() as f64
    }
}
