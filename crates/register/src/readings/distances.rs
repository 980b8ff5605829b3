//! The factor on the distances of all images under which the views agree.
//!
//! **Problem.** Depth images store counts, and several conventions say how many make a metre: 1000,
//! 4000, 5000, 10 000. Read by another one, every view is sound in itself, and no two agree.
//!
//! **Idea.** Try factors on the distances while the positions stay. At the right one the views
//! agree, and on both sides of it they do not. The second half matters: at distances without end all
//! sensors stand in one place, where the views of a room agree whatever their positions are. Stations
//! that stand close together in a room are therefore not explained.

use super::accord::{Accord, accord};
use crate::coarse::CoarseView;
use crate::judge::pair::{Placing, Probe};

/// Ratio of neighbouring factors that are tried. No unit. Theory: half a step moves a surface by
/// 2.5 % of its distance, about the radius of a patch, within which surfaces meet. Doubled, the
/// right factor may lie between two that are tried.
const STEP: f64 = 1.05;

/// Steps to either side of 1: factors up to 16, which holds the conventions for counts that are
/// not a thousandfold (those are units). Doubled, the search takes twice the time.
const STEPS: i32 = 57;

/// Steps by which a factor must differ from 1, and in which the agreement must fall off around it.
/// Theory: refinement finds smaller errors, and the third step moves surfaces out of reach.
/// Doubled, a factor of 1.25 is not found.
const APART: usize = 3;

/// Parts of a step in which the factor is given. Doubled, it takes twice the time for digits that
/// the next constant does not tell.
const FINER: i32 = 25;

/// Reach of the surfaces, in radii of a patch, by which the factor is told within a step. No unit.
/// Chosen by hand: a tenth, 0.2 to 0.5 % of a distance. Doubled, the factor is known half as well.
const NARROW: f64 = 0.1;

/// The factor at which the views agree best, if they agree `better` times as well as at factors on
/// both sides of it.
pub(super) fn best_factor(
    views: &[&CoarseView],
    probes: &[Vec<Probe>],
    better: f64,
) -> Option<(f64, Accord)> {
    let at = |factor: f64, reach: f64| {
        accord(views, probes, reach, |view| Placing {
            world_from_sensor: *view.world_from_sensor(),
            scale: factor,
        })
    };
    let tried: Vec<f64> = (-STEPS..=STEPS).map(|k| STEP.powi(k)).collect();
    let accords: Vec<Accord> = tried.iter().map(|factor| at(*factor, 1.0)).collect();
    let scores: Vec<f64> = accords.iter().map(Accord::score).collect();
    let best = (0..scores.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b]))?;
    let falls_off = |k: Option<usize>| {
        let beside = k.and_then(|k| scores.get(k));
        beside.is_some_and(|beside| scores[best] > better * beside)
    };
    let apart = best.abs_diff(STEPS as usize) >= APART;
    let peak = falls_off(best.checked_sub(APART)) && falls_off(Some(best + APART));
    if !(apart && peak) {
        return None;
    }
    // Around the best one many factors bring all surfaces within reach; a shorter one tells more.
    let near = (-FINER..=FINER).map(|k| tried[best] * STEP.powf(f64::from(k) / f64::from(FINER)));
    let sharp = |factor: &f64| at(*factor, NARROW).score();
    let factor = near.max_by(|a, b| sharp(a).total_cmp(&sharp(b)))?;
    Some((factor, at(factor, 1.0)))
}
