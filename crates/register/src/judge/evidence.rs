//! Every pair of views, compared.

use super::blame::{Counts, Table};
use super::pair::{Placed, Placing, Probe, Sample, probes, samples};
use super::tuning::{
    COMPARED_PATCHES, CONTRADICTION, HARMLESS, LARGEST_USUAL, NOISE_FACTOR, REACH, USUAL_PAIR,
};
use crate::coarse::CoarseView;
use crate::tuning::{LEAST_MEETINGS, PARTNERS};
use rayon::prelude::*;
use std::collections::BTreeSet;
use transect_device::{Isometry3, Vector3, median, quantile};

/// The evidence of all pairs of views about each other at given places.
pub(super) struct Evidence<'a> {
    pub views: &'a [&'a CoarseView],
    pub placings: Vec<Placing>,
    pub probes: Vec<Vec<Probe>>,
    /// For each ordered pair of views, row by row: patches of the first in the second.
    samples: Vec<Vec<Sample>>,
    /// The distance by which surfaces of two views usually differ.
    pub usual: f64,
}

impl<'a> Evidence<'a> {
    /// At the given poses.
    pub fn new(views: &'a [&'a CoarseView]) -> Self {
        Self::placed(views, views.iter().map(|view| Placing::given(view)).collect())
    }

    /// At other poses.
    pub fn at(views: &'a [&'a CoarseView], poses: &[Isometry3]) -> Self {
        let placing = |pose: &Isometry3| Placing { world_from_sensor: *pose, scale: 1.0 };
        Self::placed(views, poses.iter().map(placing).collect())
    }

    fn placed(views: &'a [&'a CoarseView], placings: Vec<Placing>) -> Self {
        let probes: Vec<Vec<Probe>> =
            views.par_iter().map(|view| probes(view, COMPARED_PATCHES)).collect();
        let n = views.len();
        let partners = partners(&placings, &probes);
        let of = |k: usize| {
            let (a, b) = (k / n, k % n);
            if a == b || !(partners[a].contains(&b) || partners[b].contains(&a)) {
                return Vec::new();
            }
            let placed = |k: usize| Placed { view: views[k], at: placings[k] };
            samples(&probes[a], placed(a), placed(b), REACH)
        };
        let samples = (0..n * n).into_par_iter().map(of).collect();
        let mut evidence = Self { views, placings, probes, samples, usual: 0.0 };
        evidence.usual = evidence.usual();
        evidence
    }

    /// The patches of one view in another.
    pub fn between(&self, own: usize, other: usize) -> &[Sample] {
        &self.samples[own * self.views.len() + other]
    }

    /// Whether a patch contradicts what the other view measured.
    ///
    /// Where a cell lacks samples, its patch goes beyond them, and what it misses there is no
    /// contradiction: rods and rims have such cells alone. While such patches counted, the quick
    /// copies of ten scans of 57 with exact poses blamed a view. Now none do.
    pub fn contradicts(&self, sample: &Sample) -> bool {
        self.is_far(sample) && (sample.whole || !sample.met)
    }

    /// Whether a patch lies farther from what the other view measured than errors explain.
    fn is_far(&self, sample: &Sample) -> bool {
        let allowed = NOISE_FACTOR * sample.sigma + CONTRADICTION * self.usual;
        sample.distance.abs() > allowed + HARMLESS * sample.radius
    }

    /// How many of some samples agree and contradict. A patch a little in front of a surface that
    /// it does not meet says nothing. One far from a surface that may go beyond its samples is
    /// unclear.
    pub fn count<'s>(&self, samples: impl Iterator<Item = &'s Sample>) -> Counts {
        samples.fold(Counts::default(), |sum, sample| {
            let (bad, far) = (self.contradicts(sample), self.is_far(sample));
            let [good, unclear] = [!far, far && !bad].map(|is| usize::from(is && sample.met));
            sum + Counts { good, bad: usize::from(bad), unclear }
        })
    }

    pub fn table(&self) -> Table {
        let both = |a, b| self.between(a, b).iter().chain(self.between(b, a));
        Table::new(self.views.len(), |a, b| self.count(both(a, b)))
    }

    /// The median over the views of what is usual for the pairs of each. A wrong view spoils all of
    /// its own pairs and one pair of each other view; each of two equal groups keeps just less than
    /// half of its pairs.
    fn usual(&self) -> f64 {
        let n = self.views.len();
        let of_pair = |a: usize, b: usize| {
            let both = self.between(a, b).iter().chain(self.between(b, a));
            let met: Vec<f64> = both.filter(|s| s.met).map(|s| s.distance.abs()).collect();
            (met.len() >= LEAST_MEETINGS).then(|| median(met)).flatten()
        };
        let of_view = |a: usize| quantile((0..n).filter_map(|b| of_pair(a, b)), USUAL_PAIR);
        let usual = median((0..n).filter_map(of_view)).unwrap_or(0.0);
        let radii = self.probes.iter().flatten().map(|probe| probe.radius);
        usual.min(LARGEST_USUAL * median(radii).unwrap_or(0.0))
    }
}

/// The views that each view is compared with: all others, or where they are many, those whose
/// surfaces have the nearest middles.
fn partners(placings: &[Placing], probes: &[Vec<Probe>]) -> Vec<BTreeSet<usize>> {
    let middle = |(placing, probes): (&Placing, &Vec<Probe>)| {
        let sum: Vector3 = probes.iter().map(|p| placing.to_world(&p.point).coords).sum();
        sum / probes.len().max(1) as f64
    };
    let middles: Vec<Vector3> = placings.iter().zip(probes).map(middle).collect();
    let of_view = |a: usize| {
        let far = |b: &usize| (middles[a] - middles[*b]).norm();
        let mut others: Vec<usize> = (0..middles.len()).filter(|b| *b != a).collect();
        others.sort_by(|x, y| far(x).total_cmp(&far(y)).then(x.cmp(y)));
        others.into_iter().take(PARTNERS).collect()
    };
    (0..middles.len()).map(of_view).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::Point3;

    #[test]
    fn a_patch_that_may_go_beyond_its_samples_is_unclear() {
        let evidence = Evidence {
            views: &[],
            placings: Vec::new(),
            probes: Vec::new(),
            samples: Vec::new(),
            usual: 0.01,
        };
        let count = |distance: f64, met: bool, whole: bool| {
            let sample = Sample {
                cell: 0,
                other_cell: 0,
                point: Point3::origin(),
                normal: Vector3::z(),
                distance,
                sigma: 0.001,
                radius: 0.1,
                met,
                whole,
            };
            evidence.count([&sample].into_iter())
        };
        let counts = |good: usize, bad: usize, unclear: usize| Counts { good, bad, unclear };
        assert_eq!([count(0.02, true, true), count(0.02, true, false)], [counts(1, 0, 0); 2]);
        assert_eq!(count(0.2, true, true), counts(0, 1, 0));
        assert_eq!(count(0.2, true, false), counts(0, 0, 1));
        assert_eq!(count(0.2, false, false), counts(0, 1, 0));
        assert_eq!(count(0.02, false, false), counts(0, 0, 0));
    }

    #[test]
    fn a_view_of_many_is_compared_with_the_nearest() {
        let at = |k: usize| Isometry3::translation(k as f64, 0.0, 0.0);
        let placings: Vec<Placing> =
            (0..200).map(|k| Placing { world_from_sensor: at(k), scale: 1.0 }).collect();
        let probe = Probe {
            cell: 0,
            point: Point3::origin(),
            normal: Vector3::z(),
            sigma: 1.0,
            radius: 1.0,
            whole: true,
        };
        let found = partners(&placings, &vec![vec![probe]; 200]);
        assert!(found.iter().all(|partners| partners.len() == PARTNERS));
        assert_eq!(found[0], (1..=PARTNERS).collect());
        let few = partners(&placings[..4], &vec![vec![probe]; 4]);
        assert_eq!(few[2], BTreeSet::from([0, 1, 3]));
    }
}
