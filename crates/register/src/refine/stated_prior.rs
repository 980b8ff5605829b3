//! Whether the images contradict what is stated of the poses.
//!
//! **Problem.** A prior that is far too small holds the poses where they are. The estimate is
//! certain of them then, whatever the images show.
//!
//! **Idea.** The pairs are solved once more with a loose prior, and tell how far the poses are off.
//! A prior that lets the poses move far enough leaves little of that. More than the stated prior
//! and the images leave uncertain contradicts the prior.

use super::Rounds;
use super::solve::System;
use super::uncertainty::independent;
use crate::prior::PosePrior;

/// Errors that the prior leaves in the poses, over those that it and the images allow, from which
/// the prior is contradicted: a root mean square. No unit. Theory: 1 for a right prior, and two
/// views exceed 2 once in 300 000 cases. Measured with `register --prior`: up to 0.9 for exact
/// poses. In the kitchen, whose poses err by 0.3° and 6 mm, 2.3 to 5.5 for priors up to 0.01° and 1
/// mm, and 1.2 for 0.03° and 1 mm, where views are refined. Doubled, the smallest priors pass.
const CONTRADICTED: f64 = 2.0;

impl Rounds<'_> {
    /// How far the given poses are wrong by the images, if what was stated of them holds them there
    /// against the images.
    pub(super) fn prior_by_images(&self, system: &System) -> Option<PosePrior> {
        if !self.stated {
            return None;
        }
        let (moved, stated) = (self.motions(), self.priors());
        let loose = vec![self.first; moved.len()];
        let solution = system.solve(self.independent, &self.known_before(&loose, &moved))?;
        // Uncertain is how the views lie to each other, not where the whole is.
        let met = self.with_pairs();
        let weights: Vec<f64> = met.iter().map(|met| f64::from(u8::from(*met))).collect();
        let uncertain = self.covariances_with(system, &loose, Some(&self.fit(&weights)))?;
        let (mut square, mut turns, mut shifts) = (0.0, 0.0, 0.0);
        for k in (0..moved.len()).filter(|k| met[*k]) {
            let (left, asked) = (solution.motion(k), moved[k] + solution.motion(k));
            let allowed = uncertain[k] + independent(&stated[k]);
            square += left.dot(&allowed.cholesky()?.solve(&left)) / 6.0;
            shifts += asked.fixed_rows::<3>(0).norm_squared() / 3.0;
            turns += asked.fixed_rows::<3>(3).norm_squared() / 3.0;
        }
        let count = weights.iter().sum::<f64>();
        let [ratio, rotation, translation] =
            [square, turns, shifts].map(|sum: f64| (sum / count).sqrt());
        (ratio > CONTRADICTED).then_some(PosePrior { rotation, translation })
    }
}
