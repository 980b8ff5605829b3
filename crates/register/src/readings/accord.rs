//! How far all views of a scan agree at the places where they are taken to be.

use crate::coarse::CoarseView;
use crate::judge::pair::{Placed, Placing, Probe, Sample, probes, samples};
use rayon::prelude::*;

/// Patches of all views together that are compared with the other views, and most of one view. No
/// unit. Chosen by hand: shares are then known to 2 %. Doubled, explaining takes twice the time.
const COMPARED_PATCHES: [usize; 2] = [960, 80];

/// Distance up to which a patch is a little in front of a surface, over its radius. No unit.
/// Measured: at 0, distances in the kitchen that are 0.8 times the true ones are told as 0.816
/// times, which is off by more than 2 %. Doubled, by reasoning, small parts contradict less.
const A_LITTLE: f64 = 2.0;

/// How far all views agree under one reading of their poses.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Accord {
    /// Share of the patches that lie on a surface of another view.
    pub agreeing: f64,
    /// Share of the contradictions among all comparisons that agree or contradict.
    pub contradicting: f64,
}

impl Accord {
    /// How far the views agree, in one number: the agreeing share, less the contradictions.
    pub(super) fn score(&self) -> f64 {
        self.agreeing * (1.0 - self.contradicting)
    }
}

/// The patches of each view that are compared with the other views.
pub(super) fn probes_of(views: &[&CoarseView]) -> Vec<Vec<Probe>> {
    let count = COMPARED_PATCHES[0].div_ceil(views.len().max(1)).min(COMPARED_PATCHES[1]);
    views.par_iter().map(|view| probes(view, count)).collect()
}

/// How far views agree at the places that `of` gives.
pub(super) fn accord(
    views: &[&CoarseView],
    probes: &[Vec<Probe>],
    of: impl Fn(&CoarseView) -> Placing,
) -> Accord {
    accord_of(views, probes, views.iter().map(|view| of(view)).collect())
}

/// How far views agree at places, one for each view.
pub(super) fn accord_of(
    views: &[&CoarseView],
    probes: &[Vec<Probe>],
    placings: Vec<Placing>,
) -> Accord {
    let placed = |k: usize| Placed { view: views[k], at: placings[k] };
    let counts = |a: usize| {
        let (mut agree, mut good, mut bad) = (vec![false; probes[a].len()], 0, 0);
        for b in (0..views.len()).filter(|b| *b != a) {
            for sample in seen_by(&probes[a], placed(a), placed(b)) {
                if sample.met {
                    good += 1;
                    let probe = probes[a].binary_search_by_key(&sample.cell, |p| p.cell);
                    if let Some(agree) = probe.ok().and_then(|k| agree.get_mut(k)) {
                        *agree = true;
                    }
                } else if sample.distance > sample.radius {
                    bad += 1;
                }
            }
        }
        [agree.len(), agree.into_iter().filter(|a| *a).count(), good, bad]
    };
    let add = |a: [usize; 4], b: [usize; 4]| std::array::from_fn(|k| a[k] + b[k]);
    let [all, agreeing, good, bad] =
        (0..views.len()).into_par_iter().map(counts).reduce(|| [0; 4], add);
    let share = |part: usize, of: usize| part as f64 / of.max(1) as f64;
    Accord { agreeing: share(agreeing, all), contradicting: share(bad, good + bad) }
}

/// What a view says about patches of another one. What these say about its own surface is left to
/// its own patches, and a patch a little in front of a surface that it does not meet says nothing:
/// at wrong distances of all images, that is nearly everything.
fn seen_by<'a>(
    probes: &'a [Probe],
    own: Placed<'a>,
    other: Placed<'a>,
) -> impl Iterator<Item = Sample> + use<'a> {
    samples(probes, own, other, 1.0)
        .into_iter()
        .filter(|s| s.met || s.distance > A_LITTLE * s.radius)
}

/// The mean square of the distances of views from each other's surfaces, in `reach` radii of a
/// patch. Larger ones, and contradictions, count as 1.
pub(super) fn misfit(
    views: &[&CoarseView],
    probes: &[Vec<Probe>],
    of: impl Fn(&CoarseView) -> Placing,
    reach: f64,
) -> f64 {
    let placings: Vec<Placing> = views.iter().map(|view| of(view)).collect();
    let placed = |k: usize| Placed { view: views[k], at: placings[k] };
    let of_view = |a: usize| {
        let others = (0..views.len()).filter(|b| *b != a);
        let found = others.flat_map(|b| seen_by(&probes[a], placed(a), placed(b)));
        let square = |distance: f64| distance.powi(2).min(1.0);
        let squares = found.map(|sample| square(sample.distance / (reach * sample.radius)));
        squares.fold((0.0, 0_usize), |(sum, count), square| (sum + square, count + 1))
    };
    let of_views: Vec<(f64, usize)> = (0..views.len()).into_par_iter().map(of_view).collect();
    let (sum, count) = of_views.into_iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    sum / count.max(1) as f64
}
