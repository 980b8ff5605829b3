//! Poses of all views, refined together.
//!
//! **Problem.** Real poses err by more than the images do. Naive refinement makes good poses worse:
//! raw points are too crude, thousands of neighbouring pixels share one error of the sensor, and
//! what the views do not determine drifts.
//!
//! **Idea.** Point to plane (Chen and Medioni, 1992) over the patches of all pairs of views at
//! once, associated along the rays (Blais and Levine, 1995), with a robust weight. The given poses
//! are a prior, and how far they may be wrong follows from the views' contradictions (MacKay,
//! 1992). Observations count as far as they are independent (Kish, 1965).
//!
//! **Steps.**
//! 1. Pairs of views that overlap (`pairs.rs`), and where they see one surface (`observations.rs`).
//! 2. The poses settle under a loose prior: `first_rounds.rs`.
//! 3. Rounds: every patch is looked up in the other views; the most probable small motions of all
//!    views together (`solve.rs`); how far poses are wrong.
//!    The evidence also tells about which point poses err (`pivot.rs`), and whether they drift from
//!    view to view (`drift.rs`).
//! 4. The error that a depth camera makes alike in all its images is found beside the motions:
//!    `camera.rs`. Parts of it that poses can hide are tested afterwards: `wrong_cameras.rs`.
//! 5. The motion that all views share is taken out.
//! 6. Pairs that were left out judge the result, and wrong focal lengths: `left_out.rs`. Where a
//!    stated prior held the poses, the images judge it: `stated_prior.rs`.
//! 7. A view that does not fit the others, moves far or contradicts them at their new poses is left
//!    out, and the rounds are repeated. In the end it is brought back: `bring_back.rs`.
//!
//! Where all views but a few agree at their given poses, these few are left out from the start. A
//! view stays where it is if a scale of its lengths explains what contradicts.

mod bring_back;
mod camera;
mod common_motion;
mod drift;
mod first_rounds;
mod independent;
mod left_out;
mod motion;
mod observations;
mod odds;
mod outcome;
mod pairs;
mod pivot;
mod solve;
mod stated_prior;
#[cfg(test)]
mod tests;
mod uncertainty;
mod wrong_cameras;

use crate::coarse::CoarseView;
use crate::judge::{Suspects, suspects};
use crate::prior::{PosePrior, PriorError};
use crate::tuning::{
    BEFORE_MOMENTUM, EXACT, FIRST_ROTATION_DEGREES, FIRST_TRANSLATION, LEAST_FOR_SCALE,
    LEAST_LOOKED_UP, MOMENTUM, MOST_MISPLACED, OBSERVATIONS, PRIOR_ROUNDS, ROUNDS, SETTLED, SUMS,
};
use camera::Cameras;
use drift::{Drift, Errors, estimated_prior};
use independent::independent_share;
use motion::{Motion, motion_between, moved};
use nalgebra::{DMatrix, DVector};
use observations::{Pieces, Reach, Scene, State, facet_samples, samples};
use pairs::{Pair, Portion, Spread};
use pivot::Pivots;
use rayon::prelude::*;
use solve::{Before, Ground, Solution, System, variances};
use transect_device::{Isometry3, Point3, Vector3, median};

pub use outcome::{PoseOutcome, PoseRefinement, RefinedPose};

/// Options of [`refine`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RefineOptions {
    /// How far the given poses may be wrong, of views that do not state their own
    /// ([`CoarseView::with_prior`]); estimated from the views' contradictions if `None`.
    pub prior: Option<PosePrior>,
    /// Whether the images keep the error of their camera. Its scale is not looked for then: images
    /// with a wrong scale agree better at poses that hide it.
    pub images_stay: bool,
}

/// Refines the poses of all views together.
///
/// The result does not depend on the order of the views. Their names tell which ones follow each
/// other, as the poses of a camera that is carried drift from view to view.
///
/// # Errors
/// [`PriorError::OfAll`] if a number of the prior in the options is not finite or below 1e-12.
pub fn refine(views: &[CoarseView], options: &RefineOptions) -> Result<PoseRefinement, PriorError> {
    if let Some(prior) = options.prior.filter(|prior| !prior.is_sound()) {
        return Err(PriorError::OfAll(prior));
    }
    // Sums depend on their order, so the views are taken in an order of their own.
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by_cached_key(|k| views.get(*k).map(CoarseView::rank));
    let sorted: Vec<&CoarseView> = order.iter().filter_map(|k| views.get(*k)).collect();
    let mut refinement = refine_sorted(sorted, options);
    let mut poses: Vec<_> = order.into_iter().zip(refinement.poses).collect();
    poses.sort_by_key(|(k, _)| *k);
    refinement.poses = poses.into_iter().map(|(_, pose)| pose).collect();
    Ok(refinement)
}

fn refine_sorted(views: Vec<&CoarseView>, options: &RefineOptions) -> PoseRefinement {
    let given: Vec<Isometry3> = views.iter().map(|v| *v.world_from_sensor()).collect();
    let may_move = stated(&views, options).is_none();
    let Suspects { turned, scaled } = suspects(&views, &given);
    let scene = scene(views, &given);
    let mut misplaced = scaled.clone();
    misplaced.extend(turned.into_iter().filter(|_| may_move));
    let mut rounds = loop {
        let mut rounds = Rounds::new(&scene, given.clone(), options, &misplaced);
        rounds.run();
        let wrong = || rounds.farthest_off().or_else(|| rounds.contradicting_view(&misplaced));
        match rounds.worst_view().or_else(|| may_move.then(wrong).flatten()) {
            Some(view) if misplaced.len() < MOST_MISPLACED => misplaced.push(view),
            _ => break rounds,
        }
    };
    if may_move {
        rounds.bring_back(&mut misplaced, &scaled);
    }
    rounds.finish(&misplaced)
}

/// How far poses may be wrong, if that is stated for all of them.
fn stated(views: &[&CoarseView], options: &RefineOptions) -> Option<PosePrior> {
    let own: Option<Vec<PosePrior>> = views.iter().map(|view| view.prior()).collect();
    options.prior.or_else(|| own?.first().copied())
}

/// The samples of all views, as many as their pairs may have.
fn scene<'a>(views: Vec<&'a CoarseView>, poses: &[Isometry3]) -> Scene<'a> {
    let samples: Vec<_> = views.iter().map(|view| samples(view, usize::MAX)).collect();
    let places = samples.iter().zip(poses).flat_map(|(samples, pose)| {
        let middle = samples.iter().map(|s| s.in_sensor.coords).sum::<Vector3>();
        (!samples.is_empty()).then(|| pose * Point3::from(middle / samples.len() as f64))
    });
    let places: Vec<Point3> = places.collect();
    // A mean would lie far from all surfaces where one view of a survey in world coordinates has no
    // pose. The system of the motions would lose its digits.
    let middle = |axis: usize| median(places.iter().map(|p| p[axis])).unwrap_or(0.0);
    let origin = Point3::new(middle(0), middle(1), middle(2));
    let facets = views.iter().map(|view| facet_samples(view)).collect();
    Scene { views, samples, facets, origin }
}

/// How far poses may be off, before anything is known of them.
fn usual_prior(distance: f64) -> PosePrior {
    PosePrior {
        rotation: FIRST_ROTATION_DEGREES.to_radians(),
        translation: FIRST_TRANSLATION * distance,
    }
}

/// The pairs of views that overlap, without the misplaced ones.
fn candidates(
    scene: &Scene<'_>,
    state: State<'_>,
    PosePrior { rotation, translation }: PosePrior,
    misplaced: &[usize],
) -> Vec<(usize, usize)> {
    let mut pairs = scene.pairs(state, Reach { rotation, translation, unexplained: 0.0 });
    pairs.retain(|(a, b)| !misplaced.contains(a) && !misplaced.contains(b));
    pairs
}

/// The state of a refinement between its rounds.
#[derive(Clone)]
struct Rounds<'a> {
    scene: &'a Scene<'a>,
    given: Vec<Isometry3>,
    poses: Vec<Isometry3>,
    /// Median distance of the samples from their sensors.
    distance: f64,
    /// How far poses may be off before anything is known: at least as far as is usual.
    first: PosePrior,
    /// How far the poses of most views may be wrong, by what is known now.
    prior: PosePrior,
    /// Whether that was stated, so that it is not learned.
    stated: bool,
    /// Whether the views' own priors are left out, as all of them are stated and loosened at first.
    own_loosened: bool,
    /// Views that were brought back. Their errors tell nothing of those of the others.
    loose: Vec<bool>,
    /// How far these views may be off: as far as they were found from their given poses.
    prior_of_loose: PosePrior,
    /// Whether all other views stay where they are.
    others_stay: bool,
    /// Whether scales of cameras are not looked for.
    scales_stay: bool,
    cameras: Cameras,
    drift: Drift,
    pivots: Pivots,
    /// The ordered pairs of views that may overlap.
    candidates: Vec<(usize, usize)>,
    /// Those that do, with what was observed last.
    pairs: Vec<Pair>,
    /// The share of the observations that is independent.
    independent: f64,
    /// The last change of all unknowns.
    last_change: DVector<f64>,
    /// `fx` and `fy` of a camera over the true ones, if they were found wrong.
    focal_over_true: Option<[f64; 2]>,
}

impl<'a> Rounds<'a> {
    fn new(
        scene: &'a Scene<'a>,
        given: Vec<Isometry3>,
        options: &RefineOptions,
        misplaced: &[usize],
    ) -> Self {
        let samples = scene.samples.iter().flatten();
        let distance = median(samples.map(|s| s.in_sensor.coords.norm())).unwrap_or(1.0);
        let usual = usual_prior(distance);
        let stated = stated(&scene.views, options);
        let prior = stated.unwrap_or(usual);
        let own = scene.views.iter().filter_map(|view| view.prior());
        // What was stated may be wrong, and only pairs that meet show it.
        let first = own.fold(usual.or_wider(prior), PosePrior::or_wider);
        let cameras = Cameras::of(&scene.views, distance);
        let state = State { poses: &given, cameras: &cameras };
        let candidates = candidates(scene, state, first, misplaced);
        let pivots = Pivots::at_sensors(scene, &given);
        let last_change = DVector::zeros(6 * given.len() + cameras.unknowns());
        Self {
            scene,
            poses: given.clone(),
            distance,
            given,
            first,
            prior,
            stated: stated.is_some(),
            own_loosened: false,
            loose: vec![false; scene.views.len()],
            prior_of_loose: prior,
            others_stay: false,
            scales_stay: options.images_stay || scene.views.len() < LEAST_FOR_SCALE,
            cameras,
            drift: Drift::of(scene.views.len()),
            pivots,
            candidates,
            pairs: Vec::new(),
            independent: 0.0,
            last_change,
            focal_over_true: None,
        }
    }

    fn run(&mut self) {
        if self.first_rounds().is_none() {
            return;
        }
        self.cameras.release();
        self.drift.release();
        self.run_rounds();
        let suspected = self.suspected_cameras();
        self.free_cameras(suspected);
        self.hold_levels();
    }

    /// Moves all views until they settle, and says whether they do.
    fn run_rounds(&mut self) -> bool {
        for round in 0..ROUNDS {
            let momentum = if round < BEFORE_MOMENTUM { 0.0 } else { MOMENTUM };
            self.observe(self.prior, OBSERVATIONS, Spread::Narrow);
            if self.step(PRIOR_ROUNDS, momentum).is_none_or(|largest| largest <= SETTLED) {
                return true;
            }
        }
        false
    }

    /// Finds the meetings at the poses as they are, about as many as wanted.
    fn observe(&mut self, reach: PosePrior, wanted: usize, spread: Spread) {
        let state = State { poses: &self.poses, cameras: &self.cameras };
        self.pairs = self.observed(state, reach, wanted, spread);
    }

    fn observed(
        &self,
        state: State<'_>,
        reach: PosePrior,
        wanted: usize,
        spread: Spread,
    ) -> Vec<Pair> {
        // Gates of the prior alone would shrink with it. Patches beyond them could no longer show
        // that poses err, and the next prior would be smaller still.
        let of_patches = self.pairs.iter().filter(|pair| pair.of == Pieces::Patches);
        let unexplained = median(of_patches.map(|pair| pair.excess)).unwrap_or(0.0);
        let PosePrior { rotation, translation } = reach;
        let reach = Reach { rotation, translation, unexplained };
        // Views of one scene share about half of what they see.
        let most = (2 * wanted / self.candidates.len().max(1)).max(LEAST_LOOKED_UP);
        self.scene.observe_all(&self.candidates, state, reach, most, spread)
    }

    /// Moves all views once, after some updates of the priors. Tells the largest change that the
    /// observations ask for, in standard deviations; `None` if nothing determines the views.
    fn step(&mut self, prior_rounds: usize, momentum: f64) -> Option<f64> {
        let (system, so_far) = (self.weighed_system()?, self.motions());
        let mut solution = self.solved(&system, &so_far)?;
        let mut root = solution.root();
        for _ in 0..prior_rounds {
            self.learn(&so_far, &solution, &root);
            solution = self.solved(&system, &so_far)?;
            root = solution.root();
        }
        let variances = variances(&root, so_far.len()).into_iter().enumerate();
        let free = variances.filter(|(k, _)| !self.is_exact(*k));
        let sizes = free.map(|(k, v)| solution.motion(k).component_div(&v.map(f64::sqrt)));
        let poses = sizes.map(|size| size.amax());
        let cameras = self.cameras.steps(&solution.unknowns, &root);
        let largest = poses.chain(cameras).fold(0.0, f64::max);
        // Momentum would carry settled views on.
        let settled = largest <= SETTLED;
        self.change(solution.unknowns, if settled { 0.0 } else { momentum });
        Some(largest)
    }

    /// Moves all views once, with the priors as they are. `None` if nothing determines the views.
    fn step_by_known_priors(&mut self) -> Option<()> {
        let (system, so_far) = (self.weighed_system()?, self.motions());
        let solution = self.solved(&system, &so_far)?;
        self.change(solution.unknowns, 0.0);
        Some(())
    }

    /// The equations of all views, after the independent share of the observations is updated.
    fn weighed_system(&mut self) -> Option<System> {
        // Poses that the prior holds away from the best fit give neighbours a common error. It
        // would weaken what they tell, and hold the poses all the more.
        let share = independent_share(&self.scene.views, &self.pairs);
        self.independent = self.independent.max(share);
        self.whole_system()
    }

    /// The solution of the equations with the priors as they are.
    fn solved(&self, system: &System, so_far: &[Motion]) -> Option<Solution> {
        system.solve(self.independent, &self.known_before(&self.priors(), so_far))
    }

    /// Whether the given pose of a view is taken for exact: it holds the view where it is.
    fn is_exact(&self, view: usize) -> bool {
        self.prior_of(view).is_none() && self.prior.rotation < EXACT * self.first.rotation
    }

    /// Learns how large the errors of poses and cameras are, and how much views err alike.
    fn learn(&mut self, so_far: &[Motion], solution: &Solution, root: &DMatrix<f64>) {
        self.cameras.learn(&solution.unknowns, root);
        let total = so_far.iter().enumerate().map(|(k, moved)| moved + solution.motion(k));
        let motions: Vec<Motion> = total.collect();
        if !self.stated {
            let lever = self.pivots.lever();
            self.pivots.learn(&motions, root, &self.priors(), self.drift.precision());
            let longer = self.pivots.lever() / lever;
            self.prior.translation *= longer;
            self.prior_of_loose.translation *= longer;
        }
        let priors = self.priors();
        let before = self.known_before(&priors, so_far);
        let errors = Errors::new(&motions, root, |k| before.in_units(k));
        if !self.stated {
            let of_others = self.drift.size(&errors, |k| self.prior_of(k).is_none());
            self.prior = estimated_prior(&self.prior, &of_others);
        }
        self.drift.learn(&errors);
    }

    /// Changes all unknowns, and goes on by a share of the last change (Polyak, 1964).
    fn change(&mut self, asked: DVector<f64>, momentum: f64) {
        let change = asked + &self.last_change * momentum;
        for (k, pose) in self.poses.iter_mut().enumerate() {
            *pose = moved(pose, &change.fixed_rows::<6>(6 * k).into_owned());
        }
        self.cameras.change(&change.rows_range(6 * self.poses.len()..));
        self.last_change = change;
    }

    /// The system of all pairs; `None` without pairs.
    fn whole_system(&self) -> Option<System> {
        let all: Vec<Portion<'_>> = self.pairs.iter().map(Portion::from).collect();
        let parts = all.par_chunks(all.len().div_ceil(SUMS).max(1));
        System::sum(&parts.map(|portions| self.system(portions)).collect::<Vec<_>>())
    }

    /// The systems of the parts of the pairs that judge each other.
    fn systems(&self) -> Vec<System> {
        let parts = left_out::parts(&self.pairs, &self.scene.views);
        parts.par_iter().map(|portions| self.system(portions)).collect()
    }

    /// The system of some pairs.
    fn system(&self, portions: &[Portion<'_>]) -> System {
        let sensors: Vec<Point3> =
            self.poses.iter().map(|p| Point3::from(p.translation.vector)).collect();
        let ground =
            Ground { sensors: &sensors, origin: self.scene.origin, cameras: &self.cameras };
        System::of(portions, &ground)
    }

    fn known_before<'b>(&'b self, priors: &'b [PosePrior], moved: &'b [Motion]) -> Before<'b> {
        Before { priors, moved, drift: &self.drift, pivots: &self.pivots, cameras: &self.cameras }
    }

    /// How far each view's pose may be wrong.
    fn priors(&self) -> Vec<PosePrior> {
        self.own_or(self.prior)
    }

    /// How far a view's pose may be wrong, if it is not as far as the others'.
    fn prior_of(&self, view: usize) -> Option<PosePrior> {
        let loose = || self.loose[view].then_some(self.prior_of_loose);
        let is_left_out = self.others_stay || self.own_loosened;
        let own = self.scene.views[view].prior().filter(|_| !is_left_out);
        own.or_else(loose)
    }

    /// How far the views have moved from their given poses.
    fn motions(&self) -> Vec<Motion> {
        let pairs = self.given.iter().zip(&self.poses);
        pairs.map(|(from, to)| motion_between(from, to)).collect()
    }
}
