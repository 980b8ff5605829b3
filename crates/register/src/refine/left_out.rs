//! Whether pairs that were left out of an estimate agree better with it.
//!
//! **Problem.** Residuals fall in every fit, also in one that makes the poses worse.
//!
//! **Idea.** Cross-validation (Stone, 1974): the pairs of views are split into parts. All parts but
//! one move the views, and that one judges. Close to the solution all distances are linear in the
//! unknowns, so the systems of the parts are enough.

use super::Rounds;
use super::pairs::{Pair, scrambled};
use super::solve::System;
use crate::tuning::PARTS;
use std::collections::BTreeMap;

/// The pairs in parts. Both directions of a pair see the same error, so they stay together.
pub fn parts(pairs: &[Pair]) -> Vec<Vec<&Pair>> {
    let mut mixed: BTreeMap<_, Vec<&Pair>> = BTreeMap::new();
    for pair in pairs {
        let (a, b) = (pair.a.min(pair.b), pair.a.max(pair.b));
        mixed.entry((scrambled((a << 16 | b) as u32), a, b)).or_default().push(pair);
    }
    let mut parts = vec![Vec::new(); mixed.len().min(PARTS)];
    for (k, pairs) in mixed.into_values().enumerate() {
        let part = k % parts.len();
        parts[part].extend(pairs);
    }
    parts
}

impl Rounds<'_> {
    /// Change of the squared distances of pairs that the estimate did not know, as a share; `None`
    /// if there is one pair only.
    pub(super) fn left_out(&self) -> Option<f64> {
        let parts = self.systems();
        if parts.len() < 2 {
            return None;
        }
        let all = System::sum(&parts)?;
        let (priors, moved) = (self.priors(), self.motions());
        let known_before = self.known_before(&priors, &moved);
        let back = known_before.back();
        let (mut before, mut after) = (0.0, 0.0);
        for part in &parts {
            let solution = all.without(part).solve(self.independent, &known_before)?;
            before += part.square_after(&back);
            after += part.square_after(&solution.unknowns);
        }
        (before > 0.0).then(|| after / before - 1.0)
    }
}
