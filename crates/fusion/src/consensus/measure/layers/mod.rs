//! Layers: surfaces that run side by side the same way, closer than the overlap threshold.
//!
//! **Problem.** The overlap threshold is as wide as views may be misplaced. Two surfaces that face
//! the same way and lie closer than that would become one.
//!
//! **Idea.** Within one view nothing is misplaced, and a view sees each surface once. So where two
//! stretches of *one* view's curves run the same way side by side, there are two surfaces. Each has
//! half of the gap for itself, and observations are assigned within this half gap.
//!
//! **Steps.**
//! 1. Stretches of a few nodes of each view's curves, and pairs of one view that lie near each other
//!    and run the same way. Usually there are none, and the rest is skipped.
//! 2. For each node of such a stretch its distance across to the other.
//! 3. Where several nodes in a row have one, their mean is the gap there.
//! 4. Observations of all views around get half of the mean of these gaps, if that is large against
//!    the nodes' own errors. Noise makes gaps of its own size.
//! 5. The spread between views is measured within the half gaps. Half gaps that are small against it
//!    are taken back (`scale.rs`).
//!
//! Nodes at open ends do not count, since scanners overshoot there. Two surfaces that no view saw
//! together look like one surface that views disagree about, and become one.
//!
//! **Cost.** A few nodes' work for each stretch; single nodes are compared only where there are
//! layers.

mod gaps;
mod stretches;

use super::super::tuning::layers::{GAP_SIGMAS, LIMIT_RANGE, VALID_FOOTPRINTS};
use super::super::window::Window;
use super::observations::{Observation, Observations};
use crate::grid::PointGrid;
use gaps::{Gap, Gaps};
use transect_geometry::Point2;

/// Half the gap to another layer around every observation. Empty where no view saw layers.
pub(super) fn half_gaps(observations: &Observations, same_way: f64) -> Vec<f64> {
    let mut gaps = Gaps::new(&observations.all, same_way);
    let stretches = stretches::stretches(&observations.all);
    for of_view in stretches.chunk_by(|a, b| a.view == b.view) {
        stretches::pairs(of_view, |a, b| gaps.compare(a, b));
    }
    let gaps = gaps.in_rows();
    if gaps.is_empty() { Vec::new() } else { around(observations, &gaps, same_way) }
}

/// Takes back half gaps smaller than about a length; returns whether there were any.
pub(super) fn take_back_small(half_gaps: &mut Vec<f64>, least: f64) -> bool {
    let least = limit(half_gaps, least);
    let mut taken = false;
    for half_gap in half_gaps.iter_mut().filter(|r| **r < least) {
        *half_gap = f64::INFINITY;
        taken = true;
    }
    if half_gaps.iter().all(|r| r.is_infinite()) {
        half_gaps.clear();
    }
    taken
}

/// A limit from `least` on that lies as far as possible from all half gaps, so that those of one
/// sheet are all above it or all below.
fn limit(half_gaps: &[f64], least: f64) -> f64 {
    let most = LIMIT_RANGE * least;
    let between = half_gaps.iter().copied().filter(|r| *r > least && *r < most);
    let mut near: Vec<f64> = between.collect();
    near.extend([least, most]);
    near.sort_unstable_by(f64::total_cmp);
    let wider = |a: (f64, f64), b: (f64, f64)| if b.1 - b.0 > a.1 - a.0 { b } else { a };
    near.windows(2).map(|w| (w[0], w[1])).fold((least, least), wider).1
}

/// Half the mean gap around every observation; infinite where there is none.
fn around(observations: &Observations, gaps: &[Gap], same_way: f64) -> Vec<f64> {
    let seen = &observations.all;
    let places: Vec<Point2> = gaps.iter().map(|g| seen[g.observation as usize].position).collect();
    let largest = gaps.iter().map(|g| g.gap).fold(0.0, f64::max);
    let grid = PointGrid::new(&places, VALID_FOOTPRINTS * observations.spacing());
    let half_gap = |o: &Observation| {
        let window = Window {
            centre: o.position,
            tangent: o.tangent,
            reach: VALID_FOOTPRINTS * o.footprint,
            across: largest,
            same_way,
        };
        let (mut sum, mut sigmas, mut count) = (0.0, 0.0, 0.0);
        window.visit(
            &grid,
            |g| seen[gaps[g].observation as usize].tangent,
            |g, _, y| {
                if y.abs() <= gaps[g].gap {
                    sum += gaps[g].gap;
                    sigmas += gaps[g].sigmas;
                    count += 1.0;
                }
            },
        );
        if sigmas > GAP_SIGMAS * count { 0.5 * sum / count } else { f64::INFINITY }
    };
    seen.iter().map(half_gap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consensus::options::Steps;
    use transect_geometry::{Curve, Node};

    const SIGMA: f64 = 0.001;
    const FOOTPRINT: f64 = 0.01;

    /// A curve along x whose height is a function of x, with errors of ±σ in turn.
    fn along_x(from: f64, to: f64, height: impl Fn(f64) -> f64) -> Curve {
        let node = |k: u32| {
            let x = from + FOOTPRINT * f64::from(k);
            let error = SIGMA * [1.0, -1.0, -1.0, 1.0][k as usize % 4];
            let place = Point2::new(x, height(x) + error);
            Node::at(place).with_sigma(SIGMA as f32).with_footprint(FOOTPRINT as f32)
        };
        Curve::new((0..((to - from) / FOOTPRINT) as u32).map(node).collect(), false).unwrap()
    }

    fn collected(views: &[Vec<Curve>]) -> (Observations, Vec<f64>) {
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let observations = Observations::collect(&slices, &Steps::default());
        let half_gaps = half_gaps(&observations, 0.64);
        (observations, half_gaps)
    }

    #[test]
    fn room_is_half_the_gap_where_one_view_saw_two_layers() {
        let gap = 8.0 * SIGMA;
        let both = vec![along_x(0.0, 2.0, |_| 0.0), along_x(0.5, 1.5, |_| gap)];
        // Another view saw one of them, and has as much room there.
        let one = vec![along_x(0.003, 1.997, |_| 0.0)];
        let (observations, half_gaps) = collected(&[both, one]);
        for (o, half_gap) in observations.all.iter().zip(&half_gaps) {
            let x = o.position.x;
            if (0.7..1.3).contains(&x) {
                assert!((half_gap / (0.5 * gap) - 1.0).abs() < 0.1, "{x} {half_gap}");
            } else if !(0.45..1.55).contains(&x) {
                assert!(half_gap.is_infinite(), "{x} {half_gap}");
            }
        }
    }

    #[test]
    fn what_is_no_layer_of_one_view_has_no_room() {
        let flat = |y: f64| along_x(0.0, 2.0, move |_| y);
        // Two views apart; two layers as close as noise makes them; far apart; of opposite direction.
        let apart = [vec![flat(0.0)], vec![flat(8.0 * SIGMA)]];
        let noise = [vec![flat(0.0), flat(3.5 * SIGMA)]];
        let far = [vec![flat(0.0), flat(50.0 * SIGMA)]];
        let back = [vec![flat(0.0), flat(8.0 * SIGMA).reversed()]];
        let apart: [&[Vec<Curve>]; 4] = [&apart, &noise, &far, &back];
        for views in apart {
            assert!(collected(views).1.iter().all(|r| r.is_infinite()), "{views:?}");
        }
        // Ends that pass each other, where scanners overshoot.
        let ends = vec![along_x(0.0, 1.0, |_| 0.0), along_x(0.96, 2.0, |_| 8.0 * SIGMA)];
        assert_eq!(collected(&[ends]).1, []);
    }

    #[test]
    fn bends_and_folds_of_one_curve_are_no_layers() {
        let wave = along_x(0.0, 2.0, |x| 0.05 * (12.0 * x).sin());
        // A fold: there and back, a little beside.
        let nodes = |curve: Curve| curve.nodes().to_vec();
        let there = nodes(along_x(0.0, 1.0, |_| 0.0));
        let back = nodes(along_x(0.0, 1.0, |_| 8.0 * SIGMA)).into_iter().rev();
        let fold = Curve::new(there.into_iter().chain(back).collect(), true).unwrap();
        assert_eq!(collected(&[vec![wave], vec![fold]]).1, []);
    }

    #[test]
    fn small_half_gaps_are_taken_back() {
        let mut half_gaps = vec![1.0, 3.0, f64::INFINITY];
        assert!(take_back_small(&mut half_gaps, 2.0));
        assert_eq!(half_gaps, [f64::INFINITY, 3.0, f64::INFINITY]);
        assert!(!take_back_small(&mut half_gaps, 2.0));
        // All half_gaps of a sheet go or all stay, although some lie on either side of the length.
        let mut half_gaps = vec![1.9, 2.0, 2.1, 2.15];
        assert!(take_back_small(&mut half_gaps, 2.0));
        assert_eq!(half_gaps, []);
        let mut half_gaps = vec![3.0, f64::INFINITY];
        assert!(take_back_small(&mut half_gaps, 4.0));
        assert_eq!(half_gaps, []);
    }
}
