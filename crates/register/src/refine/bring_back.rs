//! Views that are far off come back once the others are in place.
//!
//! **Problem.** One wrong view moves right ones, and makes their errors seem large. And the less
//! exactly the others lie, the less they tell about where it belongs.
//!
//! **Steps.**
//! 1. The others were refined without it.
//! 2. Poses are looked for at which it agrees with them: `judge/search`.
//! 3. It moves alone from each of these. Distances up to a tolerance count fully at first, since
//!    few patches may tell how it slides along the others (graduated non-convexity: Blake and
//!    Zisserman, 1987). The pose at which most patches agree and fewest contradict is taken, near
//!    ones before far ones.
//! 4. Rounds with all views, from there on. The prior of the others does not follow from its error,
//!    and its own one is as large as its error is.
//! 5. If it contradicts the others then, it keeps its given pose, and all is as it was before.

use super::motion::motion_between;
use super::observations::State;
use super::pairs::Spread;
use super::{Rounds, candidates};
use crate::coarse::CoarseView;
use crate::judge::{contradicting, likelihood, places_of, root_of_far, squares_apart, suspects};
use crate::prior::PosePrior;
use crate::tuning::{EXACT, MOTION_POINTS, NARROWING, OBSERVATIONS, SETTLING_ALONE};
use std::borrow::Cow;
use transect_device::Isometry3;

impl Rounds<'_> {
    /// Brings misplaced views back, but for those with a wrong scale, and takes them off the list.
    pub(super) fn bring_back(&mut self, misplaced: &mut Vec<usize>, scaled: &[usize]) {
        let sought = misplaced.iter().filter(|k| !scaled.contains(k));
        let place = |k: &usize| Some((*k, self.place_of(*k, misplaced)?));
        let mut found: Vec<(usize, Isometry3)> = sought.filter_map(place).collect();
        let without = self.clone();
        while !found.is_empty() {
            let back: Vec<usize> = found.iter().map(|(k, _)| *k).collect();
            let lost: Vec<usize> =
                misplaced.iter().copied().filter(|k| !back.contains(k)).collect();
            self.add(&found, &lost, 0.0);
            self.run_rounds();
            let views = self.corrected_views();
            let views: Vec<&CoarseView> = views.iter().map(AsRef::as_ref).collect();
            let wrong = contradicting(&views, &self.poses, misplaced);
            found.retain(|(k, _)| !wrong.contains(k));
            if found.len() == back.len() {
                *misplaced = lost;
                return;
            }
            *self = without.clone();
        }
    }

    /// A further view that contradicts the others now. At the given poses all may err too much to
    /// tell which one is wrong. Of five frames in a kitchen whose poses all err, each half a metre
    /// off, two are found by this, and the others since they move far.
    pub(super) fn contradicting_view(&self, misplaced: &[usize]) -> Option<usize> {
        let views = self.corrected_views();
        let views: Vec<&CoarseView> = views.iter().map(AsRef::as_ref).collect();
        let turned = suspects(&views, &self.poses).turned;
        turned.into_iter().find(|k| !misplaced.contains(k))
    }

    /// The pose at which a view agrees with the others, but for the misplaced ones.
    fn place_of(&self, view: usize, misplaced: &[usize]) -> Option<Isometry3> {
        let views = self.corrected_views();
        let views: Vec<&CoarseView> = views.iter().map(AsRef::as_ref).collect();
        let places = places_of(&views, &self.poses, view, misplaced)?;
        let lost: Vec<usize> = misplaced.iter().copied().filter(|k| *k != view).collect();
        let mut without = self.clone();
        without.pairs.clear();
        let settled = places.poses.iter().filter_map(|pose| {
            let mut alone = without.clone();
            alone.add(&[(view, *pose)], &lost, places.off);
            alone.settle(view, places.off)
        });
        let mut poses = self.poses.clone();
        let probable = settled.filter_map(|(pose, worth)| {
            poses[view] = pose;
            Some((pose, worth * likelihood(&views, &poses, view, misplaced)?))
        });
        probable.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(pose, _)| pose)
    }

    /// Moves one view alone that is off by so much. Returns its pose, and how probable it is.
    fn settle(&mut self, view: usize, off: f64) -> Option<(Isometry3, f64)> {
        self.candidates.retain(|(a, b)| *a == view || *b == view);
        let given = self.given[view];
        // The others hold still where they are now, whatever was stated of their poses, and the
        // view has no pose to go back to.
        self.given.clone_from(&self.poses);
        self.prior_of_loose = self.first;
        self.prior.rotation *= EXACT;
        self.prior.translation *= EXACT;
        self.others_stay = true;
        let mut tolerance = off;
        for _ in 0..SETTLING_ALONE {
            let reach = PosePrior { rotation: 0.0, translation: tolerance };
            self.observe(reach, OBSERVATIONS / 4, Spread::Narrow);
            for pair in &mut self.pairs {
                pair.excess = pair.excess.max(tolerance.powi(2));
            }
            tolerance *= NARROWING;
            self.step_by_known_priors()?;
        }
        let pose = self.poses[view];
        let samples = self.scene.samples[view].iter().take(MOTION_POINTS).map(|s| s.in_sensor);
        let apart = squares_apart(&given, &pose, samples);
        Some((pose, self.agreeing() / root_of_far(apart, off)))
    }

    /// The views without the errors of their cameras, which hide contradictions.
    fn corrected_views(&self) -> Vec<Cow<'_, CoarseView>> {
        let views = self.scene.views.iter().enumerate();
        let corrected = views.map(|(k, view)| match self.cameras.of_view(k) {
            Some(offsets) => Cow::Owned((*view).clone().corrected(&offsets)),
            None => Cow::Borrowed(*view),
        });
        corrected.collect()
    }

    /// Adds views at other poses than the given ones, at which their surfaces may be so far off.
    fn add(&mut self, found: &[(usize, Isometry3)], lost: &[usize], off: f64) {
        for (k, pose) in found {
            self.poses[*k] = *pose;
            self.loose[*k] = true;
        }
        self.drift.leave_out(&found.iter().map(|(k, _)| *k).collect::<Vec<_>>());
        let motion = |(k, pose): &(usize, Isometry3)| motion_between(&self.given[*k], pose);
        let first = self.first;
        self.prior_of_loose = found.iter().map(motion).fold(first, |prior, motion| PosePrior {
            rotation: prior.rotation.max(motion.fixed_rows::<3>(3).norm()),
            translation: prior.translation.max(motion.fixed_rows::<3>(0).norm()),
        });
        self.last_change.fill(0.0);
        let state = State { poses: &self.poses, cameras: &self.cameras };
        let reach = self.prior.or_wider(PosePrior { rotation: 0.0, translation: off });
        self.candidates = candidates(self.scene, state, reach, lost);
    }
}
