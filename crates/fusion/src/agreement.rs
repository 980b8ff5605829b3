//! Whether the views agree where they overlap: the sign of a wrong pose.
//!
//! **Idea.** Where two views saw the same surface, a node of one has the other's curve of the same
//! direction right beside it. A curve of the same direction that runs a little *farther* off is
//! rare between well registered views: neighbouring surfaces mostly face other ways. It is the rule
//! between wrongly registered ones, whose outlines lie across each other. So of the nodes that have
//! another view's curve abreast at all, the share with one close by tells right from wrong.

use crate::consensus::Steps;
use crate::consensus::measure::{Observation, Observations};
use crate::grid::PointGrid;
use transect_geometry::Curve;

/// Closer than this, in footprints and standard deviations, two views agree. Standard deviations
/// are those of independent noise, which smoothing lowers. It does not lower the errors that all
/// pixels of a neighbourhood share, and these are no sign of a wrong pose.
const CLOSE_FOOTPRINTS: f64 = 3.0;
const CLOSE_SIGMAS: f64 = 6.0;

/// Farther than this many times that, a curve is another surface and tells nothing.
const ABREAST: f64 = 4.0;

/// Nodes of a plane that are looked at: each is compared with all views around it, and a model has
/// many planes.
const SAMPLES: usize = 300;

/// Cosine of the largest angle between curves that run abreast.
const SAME_WAY: f64 = 0.8;

/// How often one view agreed with the others, and how often it ran abreast of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Agreement {
    /// Samples with another view's curve right beside them.
    pub close: u64,
    /// Samples with another view's curve of the same direction a little farther off.
    pub abreast: u64,
}

impl Agreement {
    /// Fewest samples from which anything is concluded.
    const ENOUGH: u64 = 40;

    /// Share of abreast samples that a right view of a noisy sensor may have where rooms are full
    /// of edges. Measured: 0.61 in one of the 50 right views of the red kitchen. Doubled, no view
    /// is ever contradicted.
    const EDGE_SHARE: f64 = 0.6;

    /// Excess over that share that chance explains, in standard deviations of independent samples.
    /// Neighbouring samples are not independent, so real chance is larger. Chosen by hand: one view
    /// in 44 at that share exceeds it. Doubled, a view needs four times the samples to be named.
    const CHANCE_SIGMAS: f64 = 2.0;

    /// Adds the counts of another plane.
    pub fn add(&mut self, other: &Self) {
        self.close += other.close;
        self.abreast += other.abreast;
    }

    /// Whether the view contradicts the others clearly more often than it agrees with them: more
    /// than three times for every two, and by more than the chance of as many independent samples.
    pub fn is_contradicted(&self) -> bool {
        let samples = (self.close + self.abreast) as f64;
        let excess = self.abreast as f64 - Self::EDGE_SHARE * samples;
        let deviation = (Self::EDGE_SHARE * (1.0 - Self::EDGE_SHARE) * samples).sqrt();
        samples >= Self::ENOUGH as f64 && excess > Self::CHANCE_SIGMAS * deviation
    }
}

/// The agreement of each view with all others on one plane, in the order given.
pub fn agreement(views: &[&[Curve]]) -> Vec<Agreement> {
    between(&Observations::collect(views, &Steps::default()), views.len())
}

/// The same from what was collected of some views.
pub(crate) fn between(observations: &Observations, views: usize) -> Vec<Agreement> {
    let mut result = between_different(observations, views);
    // A view agrees with its twin, and with the other views as the twin does.
    for &(view, twin) in &observations.twins {
        result[view].close += 1;
        result[twin] = result[view];
    }
    result
}

/// The same for views that differ. Of identical ones, all but the first count nothing.
fn between_different(observations: &Observations, views: usize) -> Vec<Agreement> {
    let mut result = vec![Agreement::default(); views];
    if observations.sources.len() < 2 || observations.all.is_empty() {
        return result;
    }
    let grid = PointGrid::new(&observations.positions(), 4.0 * observations.spacing());
    let step = observations.all.len().div_ceil(SAMPLES);
    let mut nearest = vec![f64::INFINITY; observations.sources.len()];
    for here in observations.all.iter().step_by(step) {
        nearest.fill(f64::INFINITY);
        let close = close(here);
        let Observation { tangent, footprint, .. } = *here;
        grid.within(&here.position, ABREAST * close, |j, d| {
            let there = &observations.all[j];
            let along = d.dot(&there.tangent).abs();
            // Most nodes around lie ahead and behind: nothing else is computed of them.
            let beside = along <= footprint || along <= there.footprint;
            if beside && there.tangent.dot(&tangent) >= SAME_WAY {
                let across = d.perp(&there.tangent).abs();
                let place = &mut nearest[there.view as usize];
                *place = place.min(across);
            }
        });
        let counts = &mut result[observations.sources[here.view as usize]];
        for (view, across) in nearest.iter().enumerate() {
            if view != here.view as usize && across.is_finite() {
                counts.close += u64::from(*across <= close);
                counts.abreast += u64::from(*across > close);
            }
        }
    }
    result
}

fn close(o: &Observation) -> f64 {
    CLOSE_FOOTPRINTS * o.footprint + CLOSE_SIGMAS * o.sigma
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::{Node, Point2};

    /// An ellipse seen from one side, turned about the origin.
    fn arc(turn: f64, from: f64, to: f64) -> Vec<Curve> {
        let node = |k: i32| {
            let a: f64 = from + (to - from) * f64::from(k) / 200.0;
            let (x, y) = (2.0 * a.cos(), a.sin());
            let position =
                Point2::new(x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos());
            Node::at(position).with_sigma(0.001).with_footprint(0.02)
        };
        vec![Curve::new((0..=200).map(node).collect(), false).unwrap()]
    }

    #[test]
    fn a_turned_view_is_found_and_the_others_are_not() {
        let views =
            [arc(0.0, 0.0, 3.0), arc(0.0, 1.0, 4.0), arc(0.0, 2.0, 5.5), arc(0.15, 0.5, 3.5)];
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let found: Vec<bool> = agreement(&slices).iter().map(Agreement::is_contradicted).collect();
        assert_eq!(found, [false, false, false, true]);
    }

    #[test]
    fn a_share_that_chance_explains_is_no_contradiction() {
        let contradicted = |abreast, close| Agreement { close, abreast }.is_contradicted();
        assert!(!contradicted(79, 50) && !contradicted(88, 41) && contradicted(89, 40));
        assert!(!contradicted(630, 370) && contradicted(632, 368));
        assert!(!contradicted(39, 0) && contradicted(40, 0));
    }

    #[test]
    fn identical_views_agree() {
        let views = [arc(0.0, 0.0, 3.0), arc(0.0, 0.0, 3.0), arc(0.15, 0.5, 3.5)];
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let pair = agreement(&slices[..2]);
        assert!(pair[0].close > 0 && pair[0] == pair[1], "{pair:?}");
        let all = agreement(&slices);
        assert!(all[0].abreast > 0 && all[0] == all[1], "{all:?}");
    }

    #[test]
    fn views_without_a_direction_say_nothing() {
        let nowhere =
            |x: f64| vec![Curve::new(vec![Node::at(Point2::new(x, 0.0)); 3], false).unwrap()];
        let views = [nowhere(0.0), nowhere(1.0)];
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        assert_eq!(agreement(&slices), [Agreement::default(); 2]);
    }

    #[test]
    fn views_of_different_ground_say_nothing() {
        let views = [arc(0.0, 0.0, 1.0), arc(0.0, 2.0, 3.0)];
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        assert_eq!(agreement(&slices), [Agreement::default(); 2]);
    }
}
