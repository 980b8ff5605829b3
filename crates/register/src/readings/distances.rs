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

/// Factors to either side of the best one that are tried within a step. Chosen by hand: the step
/// divided by it tells the factor to half a per cent. Doubled, it takes twice the time.
const FINER: i32 = 8;

/// Searches within a step, each in steps a quarter as long, for surfaces a quarter as far apart.
/// Measured on a part and a mask, at factors of 1/25.4, 1/304.8 and 25.4: the
/// factor errs by up to 1 % after one, and by up to 0.1 % after three. Doubled, it takes twice the
/// time.
const SEARCHES: i32 = 3;

/// Largest difference of a factor from a ratio of units or counts for which it is taken for that
/// ratio. Theory: three times the error of the search. At ten times that, depth cameras whose own
/// scale errs by 2 % are told 1/25 for 1/25.4.
const SAME_RATIO: f64 = 0.003;

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
    let (mut factor, mut finer) = (tried[best], 1.0);
    for _ in 0..SEARCHES {
        let at_step = |k: f64| factor * STEP.powf(k / (finer * f64::from(FINER)));
        let misfit = |k| misfit(views, probes, times(at_step(f64::from(k))), 1.0 / finer);
        let misfits: Vec<f64> = (-FINER..=FINER).map(misfit).collect();
        factor = at_step(lowest(&misfits) - f64::from(FINER));
        finer *= 4.0;
    }
    let factor = match ratio_near(factor) {
        Some(ratio) => rounded(ratio, 7),
        None => rounded(factor, 4),
    };
    Some((factor, accord(views, probes, times(factor))))
}

/// A number with so many significant digits.
fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.0$e}", digits.saturating_sub(1)).parse().unwrap_or(number)
}

/// The ratio of units, or of counts in a metre, that a factor is nearly: a power of ten times 1, 2,
/// 4, 5 or the centimetres of an inch or a foot, or the inverse of one.
fn ratio_near(factor: f64) -> Option<f64> {
    let off = |ratio: &f64| (factor / ratio - 1.0).abs();
    let tens = |number: f64| 10_f64.powi(number.log10().round() as i32);
    let direct = |first: f64| first * tens(factor / first);
    let inverse = |first: f64| 1.0 / (first * tens(1.0 / (factor * first)));
    let ratios = [1.0, 2.0, 4.0, 5.0, 2.54, 3.048];
    let nearest = ratios.into_iter().flat_map(|first| [direct(first), inverse(first)]);
    let nearest = nearest.min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.filter(|ratio| off(ratio) < SAME_RATIO)
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
    use super::{lowest, ratio_near, rounded};

    #[test]
    fn factors_have_the_digits_that_they_are_known_to() {
        assert_eq!(rounded(1.0 / 25.4, 7), 0.03937008);
        assert_eq!(rounded(0.0123456, 4), 0.01235);
        assert_eq!(rounded(304.8, 7), 304.8);
    }

    #[test]
    fn ratios_of_units_and_counts_are_known() {
        let ratios = [25.4, 1.0 / 25.4, 304.8, 1.0 / 304.8, 0.2, 5.0, 0.1, 4.0, 0.25, 100.0];
        for ratio in ratios {
            for off in [0.998, 1.0, 1.002] {
                let found = ratio_near(off * ratio).unwrap();
                assert!((found / ratio - 1.0).abs() < 1e-12, "{off} times {ratio}: {found}");
            }
        }
        assert_eq!([0.8, 1.25, 1.01, 25.6].map(ratio_near), [None; 4]);
    }

    #[test]
    fn the_lowest_place_of_a_parabola_is_found_between_its_values() {
        let values: Vec<f64> = (0..9).map(|k| (f64::from(k) - 3.3).powi(2) + 2.0).collect();
        assert!((lowest(&values) - 3.3).abs() < 1e-12);
        assert_eq!(lowest(&[1.0, 2.0, 3.0]), 0.0);
        assert_eq!(lowest(&[1.0; 5]), 0.0);
    }
}
