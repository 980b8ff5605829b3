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
//!
//! Views move only if the odds of the new poses exceed `POSE_ODDS` by that test. A smaller gain may
//! be noise, or an error that all observations of a surface share.
//!
//! The same test decides between two estimates. Odds that rest on standard deviations alone take
//! errors that no unknown explains for knowledge. Time-of-flight cameras measure depths too long
//! where walls light each other. That gave odds of 900 to 15 000 for focal lengths 0.3 to 0.5 %
//! off, and the pairs that were left out did not agree better with them.

use super::Rounds;
use super::pairs::{Pair, Portion};
use super::solve::System;
use crate::CoarseView;
use crate::scrambled::scrambled;
use crate::tuning::{PARTS, POSE_ODDS};
use std::collections::{BTreeMap, BTreeSet};

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

/// What pairs say about an estimate that did not know them.
pub(super) struct LeftOut {
    /// Change of their squared distances, as a share.
    pub change: f64,
    /// The natural logarithm of the odds of this estimate over the given poses.
    log_odds: f64,
}

impl LeftOut {
    /// Whether this estimate is clearly more probable than the given poses.
    pub fn is_clear(&self) -> bool {
        self.log_odds > POSE_ODDS.ln()
    }
}

impl Rounds<'_> {
    /// What the parts say, each about the estimate that did not know it; `None` without a pair.
    pub(super) fn left_out(&self, parts: &[System]) -> Option<LeftOut> {
        let before = self.square_as_given(parts);
        let change = self.left_of_parts(parts)?.iter().sum::<f64>() / before - 1.0;
        let log_odds = -0.5 * self.independent * before * change;
        change.is_finite().then_some(LeftOut { change, log_odds })
    }

    /// Sum of the weighted squared distances of all parts at the given poses.
    fn square_as_given(&self, parts: &[System]) -> f64 {
        let (priors, moved) = (self.priors(), self.motions());
        let back = self.known_before(&priors, &moved).back();
        parts.iter().map(|part| part.square_after(&back)).sum()
    }

    /// The weighted squared distances of each part under the estimate that did not know it.
    fn left_of_parts(&self, parts: &[System]) -> Option<Vec<f64>> {
        let all = System::sum(parts)?;
        let (priors, moved) = (self.priors(), self.motions());
        let known_before = self.known_before(&priors, &moved);
        let left = |part: &System| {
            let solution = all.without(part).solve(self.independent, &known_before)?;
            Some(part.square_after(&solution.unknowns))
        };
        parts.iter().map(left).collect()
    }

    /// Whether this estimate predicts the pairs that it did not know better than a simpler one
    /// does, by more than one standard error (Breiman, Friedman, Olshen and Stone, 1984). The
    /// parts, which are the same for both estimates, tell the standard error.
    pub(super) fn predicts_better_than(&self, simpler: &Self) -> bool {
        let both = &self.ends() & &simpler.ends();
        let left = |rounds: &Self| {
            let mut rounds = rounds.clone();
            rounds.pairs.retain(|pair| both.contains(&(pair.a, pair.b)));
            let parts = rounds.systems();
            let before = rounds.square_as_given(&parts);
            let left = rounds.left_of_parts(&parts)?;
            Some(left.into_iter().map(|left| left / before).collect::<Vec<f64>>())
        };
        let (Some(own), Some(others)) = (left(self), left(simpler)) else { return false };
        let gains: Vec<f64> = others.iter().zip(&own).map(|(other, own)| other - own).collect();
        let (count, sum) = (gains.len() as f64, gains.iter().sum::<f64>());
        let squares: f64 = gains.iter().map(|gain| (gain - sum / count).powi(2)).sum();
        let standard_error = (squares * count / (count - 1.0)).sqrt();
        sum > standard_error
    }

    /// The views of each pair.
    fn ends(&self) -> BTreeSet<(usize, usize)> {
        self.pairs.iter().map(|pair| (pair.a, pair.b)).collect()
    }
}
