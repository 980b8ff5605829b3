//! How near the curves of a plane are to the truth, and the truth to them.

use super::index::{Nearby, UnitIndex};
use super::sample::{GROUP, Sample, runs};
use super::stretches::seen_stretches;
use super::{Ruler, SAMPLES_PER_TOLERANCE};
use transect_device::median;
use transect_geometry::{Curve, Point2};

/// Sums of the comparison of curves with the truth; lengths in the model's unit.
#[derive(Debug, Clone, Default)]
pub(super) struct Closeness {
    /// Planes with truth.
    pub planes: usize,
    /// Those of them whose curves are all closed, with at least one.
    pub planes_closed_only: usize,
    /// Those of the latter that have as many curves as the truth.
    pub planes_same_loops: usize,
    pub truth_pieces: usize,
    /// Stretches of the truth's curves that were seen.
    pub truth_stretches: usize,
    pub truth_length: f64,
    /// Length of the truth that was seen.
    pub truth_seen: f64,
    /// Length of the seen truth with a curve within the tolerance.
    pub truth_found: f64,
    /// Length of the curves within the tolerance of the truth.
    pub near: f64,
    /// Length of the curves beyond it.
    pub far: f64,
    /// Part of `near` that runs like the truth.
    pub oriented: f64,
    /// Part of `far` on planes that have no truth.
    pub without_truth: f64,
    /// Distance of each sample of the curves from the truth; infinite on planes without truth.
    pub distances: Vec<f64>,
}

/// Shortest stretch of the truth that is expected as a curve, in sample spacings of the views.
/// Shorter gaps do not end a stretch. Chosen by hand: the shortest curve that fusion keeps.
/// Doubled, fewer and longer curves are expected.
const SHORTEST_FOOTPRINTS: f64 = 4.0;

/// The views are asked about every n-th sample of the truth. Theory: a gap or a stretch between two
/// of them is shorter than the tolerance, so it ends no stretch. Measured: with 1, a score takes
/// 1.6 to 2.2 times as long, and the truth that the views could see differs by up to .02 %, its
/// completeness by .01 %. Doubled, gaps that end a stretch are missed.
const ASK_EVERY: usize = SAMPLES_PER_TOLERANCE as usize;

/// Which samples of a run were seen. A sample between two equal answers takes their answer. Between
/// different answers, the views are asked about every sample.
fn seen_of(run: &[Sample], seen: impl Fn(&[Point2]) -> Vec<bool>) -> Vec<bool> {
    let places: Vec<Point2> = run.iter().map(|sample| sample.position).collect();
    let last = places.len().saturating_sub(1);
    let numbers: Vec<usize> = (0..last).step_by(ASK_EVERY).chain([last]).collect();
    let apart: Vec<Point2> = numbers.iter().filter_map(|k| places.get(*k)).copied().collect();
    let answers = seen(&apart);
    let mut all = vec![false; places.len()];
    for (numbers, ends) in numbers.windows(2).zip(answers.windows(2)) {
        let between = numbers[0] + 1..numbers[1];
        if ends[0] == ends[1] {
            all[between].fill(ends[0]);
        } else {
            let answers = seen(&places[between.clone()]);
            all[between].iter_mut().zip(answers).for_each(|(all, seen)| *all = seen);
        }
    }
    numbers.into_iter().zip(answers).for_each(|(k, seen)| all[k] = seen);
    all
}

/// Median sample spacing of the nodes that a view measured; 0 without such nodes.
fn footprint(curves: &[Curve]) -> f64 {
    let seen = curves.iter().flat_map(Curve::nodes).filter(|n| n.views.is_some());
    median(seen.map(|n| f64::from(n.footprint))).unwrap_or(0.0)
}

impl Closeness {
    /// The sums of one plane, from its curves and an index of their units.
    ///
    /// `seen` tells which of some neighbouring samples of the truth count for completeness.
    pub fn of(
        curves: (&[Curve], &UnitIndex),
        truth: &[Curve],
        seen: impl Fn(&[Point2]) -> Vec<bool>,
        ruler: &Ruler,
    ) -> Self {
        let (curves, curve_index) = curves;
        let closed_only = !curves.is_empty() && curves.iter().all(Curve::is_closed);
        let planes = usize::from(!truth.is_empty());
        let planes_closed_only = if closed_only { planes } else { 0 };
        let same = curves.len() == truth.len();
        let mut sums = Self {
            planes,
            planes_closed_only,
            planes_same_loops: if same { planes_closed_only } else { 0 },
            truth_pieces: truth.len(),
            ..Self::default()
        };
        let shortest = ruler.tolerance.max(SHORTEST_FOOTPRINTS * footprint(curves));
        let truth_index = UnitIndex::new(truth);
        for run in curves.iter().flat_map(|c| runs(c, ruler.step)) {
            for group in run.chunks(GROUP) {
                let nearby = truth_index.nearest_to(group);
                group.iter().for_each(|sample| sums.add_curve_sample(sample, &nearby, ruler));
            }
        }
        for curve in truth {
            let looked = runs(curve, ruler.step).flat_map(|run| {
                let seen = seen_of(&run, &seen);
                let looked: Vec<_> = run.into_iter().zip(seen).collect();
                for group in looked.chunks(GROUP) {
                    sums.add_truth_samples(group, curve_index, ruler);
                }
                looked
            });
            let stretches = seen_stretches(looked, curve.is_closed(), shortest);
            sums.truth_stretches += stretches;
        }
        sums
    }

    /// Adds a group of samples of the truth, each with whether it was seen.
    fn add_truth_samples(&mut self, looked: &[(Sample, bool)], curves: &UnitIndex, ruler: &Ruler) {
        let seen: Vec<Sample> = looked.iter().filter(|l| l.1).map(|l| l.0).collect();
        let mut nearby = curves.within(&seen, ruler.tolerance, |_| true);
        self.truth_length = looked.iter().fold(self.truth_length, |sum, l| sum + l.0.length);
        for sample in &seen {
            self.truth_seen += sample.length;
            if nearby.reaches(&sample.position, ruler.tolerance) {
                self.truth_found += sample.length;
            }
        }
    }

    fn add_curve_sample(&mut self, sample: &Sample, truth: &Nearby, ruler: &Ruler) {
        let Some(nearest) = truth.nearest(&sample.position) else {
            self.far += sample.length;
            self.without_truth += sample.length;
            self.distances.push(f64::INFINITY);
            return;
        };
        self.distances.push(nearest.distance);
        // The comparison is strict, so that a distance of exactly the tolerance counts as far.
        if nearest.distance < ruler.tolerance {
            self.near += sample.length;
            if truth.agrees(&sample.position, &sample.direction, &nearest) {
                self.oriented += sample.length;
            }
        } else {
            self.far += sample.length;
        }
    }

    /// The sum over planes, in their order.
    pub fn total(planes: Vec<Self>) -> Self {
        let samples = planes.iter().map(|p| p.distances.len()).sum();
        let start = Self { distances: Vec::with_capacity(samples), ..Self::default() };
        planes.into_iter().fold(start, Self::plus)
    }

    fn plus(mut self, plane: Self) -> Self {
        self.planes += plane.planes;
        self.planes_closed_only += plane.planes_closed_only;
        self.planes_same_loops += plane.planes_same_loops;
        self.truth_pieces += plane.truth_pieces;
        self.truth_stretches += plane.truth_stretches;
        self.truth_length += plane.truth_length;
        self.truth_seen += plane.truth_seen;
        self.truth_found += plane.truth_found;
        self.near += plane.near;
        self.far += plane.far;
        self.oriented += plane.oriented;
        self.without_truth += plane.without_truth;
        self.distances.extend(plane.distances);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::Vector2;

    /// Which samples of a curve count as seen if the views see those written as `#`.
    fn looked(samples: &str) -> String {
        let run: Vec<Sample> = (0..samples.len())
            .map(|k| Sample {
                position: Point2::new(k as f64, 0.0),
                direction: Vector2::x(),
                length: 1.0,
                along: k as f64,
            })
            .collect();
        let is_seen = |p: &Point2| samples.as_bytes()[p.x as usize] == b'#';
        let seen = seen_of(&run, |points| points.iter().map(is_seen).collect());
        seen.into_iter().map(|seen| if seen { '#' } else { '.' }).collect()
    }

    #[test]
    fn parts_of_a_tolerance_and_more_are_found_to_the_sample() {
        let shortest = SAMPLES_PER_TOLERANCE as usize;
        let lengths = (0..9).flat_map(|b| (shortest..9).map(move |p| (b, p, (3 * b + p) % 7)));
        for (before, part, after) in lengths {
            for [outside, inside] in [["#", "."], [".", "#"]] {
                let samples =
                    [outside.repeat(before), inside.repeat(part), outside.repeat(after)].concat();
                assert_eq!(looked(&samples), samples);
            }
        }
        assert_eq!(looked(""), "");
        assert_eq!(looked("##.###.#####"), "############", "a gap that ends no stretch");
    }
}
