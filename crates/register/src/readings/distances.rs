//! The factor on the distances of all images under which the views agree.
//!
//! **Problem.** Depth images store counts, and several conventions say how many make a metre: 1000,
//! 4000, 5000, 10 000. Positions may be in inches beside images in millimetres. Read by another
//! unit, every view is sound in itself, and no two agree.
//!
//! **Idea.** Try factors on the distances while the positions stay. At the right one the views
//! agree, and on both sides of it they do not. The second half matters: at distances without end
//! all sensors stand in one place, where the views of a room agree whatever their positions are.
//! Stations that stand close together in a room are therefore not explained.

use super::accord::{Accord, accord, misfit};
use crate::coarse::CoarseView;
use crate::judge::pair::{Placing, Probe};

/// Ratio of neighbouring factors that are tried. No unit. Theory: half a step moves a surface by
/// 2.5 % of its distance, about the radius of a patch, within which surfaces meet. Doubled, the
/// right factor may lie between two that are tried.
const STEP: f64 = 1.05;

/// Steps to either side of 1: factors up to 490. Theory: that holds the ratios of counts and of
/// units below a thousand, which is a reading of the poses. Doubled, the search takes twice the
/// time.
const STEPS: i32 = 127;

/// Patches of all views together by which the factor is searched. No unit. Chosen by hand: shares
/// are then known to 3 %, and they fall off by more. Doubled, the search takes twice the time.
const SEARCHED: usize = 240;

/// Steps by which a factor must differ from 1, and in which the agreement must fall off around it.
/// Theory: refinement finds smaller errors, and the third step moves surfaces out of reach.
/// Doubled, a factor of 1.25 is not found.
const APART: usize = 3;

/// Factors to either side of the best one that are tried within a step. Chosen by hand: a parabola
/// through the best three tells the factor to a thousandth of the scan. Doubled, it takes twice the
/// time.
const FINER: i32 = 8;

/// The factor at which the views agree best, if they agree `better` times as well as at factors on
/// both sides of it.
pub(super) fn best_factor(
    views: &[&CoarseView],
    probes: &[Vec<Probe>],
    better: f64,
) -> Option<(f64, Accord)> {
    let times = |factor: f64| {
        move |view: &CoarseView| Placing {
            world_from_sensor: *view.world_from_sensor(),
            scale: factor,
        }
    };
    let few = thinned(probes);
    let tried: Vec<f64> = (-STEPS..=STEPS).map(|k| STEP.powi(k)).collect();
    let accords: Vec<Accord> =
        tried.iter().map(|factor| accord(views, &few, times(*factor))).collect();
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
    // Around the best one many factors bring all surfaces within reach.
    let at_step = |k: f64| tried[best] * STEP.powf(k / f64::from(FINER));
    let misfits: Vec<f64> =
        (-FINER..=FINER).map(|k| misfit(views, probes, times(at_step(f64::from(k))))).collect();
    let factor = at_step(lowest(&misfits) - f64::from(FINER));
    Some((factor, accord(views, probes, times(factor))))
}

/// The patches by which the factor is searched.
fn thinned(probes: &[Vec<Probe>]) -> Vec<Vec<Probe>> {
    let all: usize = probes.iter().map(Vec::len).sum();
    let step = all.div_ceil(SEARCHED).max(1);
    probes.iter().map(|of_view| of_view.iter().copied().step_by(step).collect()).collect()
}

/// The place of the lowest value, between its neighbours by a parabola.
fn lowest(values: &[f64]) -> f64 {
    let best = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let beside = |k: Option<usize>| k.and_then(|k| values.get(k)).copied();
    let (Some(before), Some(after)) = (beside(best.checked_sub(1)), beside(Some(best + 1))) else {
        return best as f64;
    };
    let bend = before - 2.0 * values[best] + after;
    let shift = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    best as f64 + shift
}

#[cfg(test)]
mod tests {
    use super::lowest;

    #[test]
    fn the_lowest_place_of_a_parabola_is_found_between_its_values() {
        let values: Vec<f64> = (0..9).map(|k| (f64::from(k) - 3.3).powi(2) + 2.0).collect();
        assert!((lowest(&values) - 3.3).abs() < 1e-12);
        assert_eq!(lowest(&[1.0, 2.0, 3.0]), 0.0);
        assert_eq!(lowest(&[1.0; 5]), 0.0);
    }
}
