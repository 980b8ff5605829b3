//! Whether observations that were left out of an estimate agree better with it.
//!
//! **Problem.** Residuals fall in every fit, also in one that makes the poses worse.
//!
//! **Idea.** Cross-validation (Stone, 1974): the pairs of views are split into parts. All parts but
//! one move the views, and that one judges. Close to the solution all distances are linear in the
//! unknowns, so the systems of the parts are enough.
//!
//! A pair without which its two views are no longer held together can judge nothing as a whole: of
//! two views, or in a chain. One half of the blocks of its image moves the views then, and the
//! other half judges.

use super::Rounds;
use super::pairs::{Pair, Portion, scrambled};
use super::solve::System;
use crate::CoarseView;
use crate::tuning::PARTS;
use std::collections::BTreeMap;

/// Two views, by number, and both directions of their pair. These see the same error, so they stay
/// together.
type Both<'a> = ((usize, usize), Vec<&'a Pair>);

/// The pairs in parts: two at least, unless there is no pair.
pub fn parts<'a>(pairs: &'a [Pair], views: &[&CoarseView]) -> Vec<Vec<Portion<'a>>> {
    let mut mixed: BTreeMap<_, Both<'a>> = BTreeMap::new();
    for pair in pairs {
        let (a, b) = (pair.a.min(pair.b), pair.a.max(pair.b));
        let both = mixed.entry((scrambled((a << 16 | b) as u32), a, b));
        both.or_insert(((a, b), Vec::new())).1.push(pair);
    }
    let mixed: Vec<Both<'a>> = mixed.into_values().collect();
    let count = if mixed.is_empty() { 0 } else { mixed.len().clamp(2, PARTS) };
    let mut parts = vec![Vec::new(); count];
    for part in 0..count {
        let others = mixed.iter().enumerate().filter(|(k, _)| k % count != part);
        let groups = groups(others.map(|(_, (ends, _))| *ends), views.len());
        for ((a, b), both) in mixed.iter().skip(part).step_by(count) {
            let (Some(of_a), Some(of_b), Some(view)) =
                (groups.get(*a), groups.get(*b), views.get(*a))
            else {
                continue;
            };
            if of_a == of_b {
                parts[part].extend(both.iter().map(|pair| Portion { pair, half: None }));
            } else {
                for half in 0..2 {
                    let portion =
                        |pair: &&'a Pair| Portion { pair, half: Some((half, view.size())) };
                    parts[(part + half) % count].extend(both.iter().map(portion));
                }
            }
        }
    }
    parts
}

/// A number for each view, which it shares with the views that pairs connect to it.
fn groups(pairs: impl Iterator<Item = (usize, usize)>, views: usize) -> Vec<usize> {
    let mut groups: Vec<usize> = (0..views).collect();
    for (a, b) in pairs {
        let (Some(&from), Some(&to)) = (groups.get(a), groups.get(b)) else { continue };
        if from != to {
            groups.iter_mut().filter(|group| **group == from).for_each(|group| *group = to);
        }
    }
    groups
}

impl Rounds<'_> {
    /// Change of the squared distances of the parts, each under the estimate that did not know it,
    /// as a share; `None` without a pair.
    pub(super) fn left_out(&self, parts: &[System]) -> Option<f64> {
        let all = System::sum(parts)?;
        let (priors, moved) = (self.priors(), self.motions());
        let known_before = self.known_before(&priors, &moved);
        let back = known_before.back();
        let (mut before, mut after) = (0.0, 0.0);
        for part in parts {
            let solution = all.without(part).solve(self.independent, &known_before)?;
            before += part.square_after(&back);
            after += part.square_after(&solution.unknowns);
        }
        (before > 0.0).then(|| after / before - 1.0)
    }
}
