//! The whole pipeline on a simulated scene: what must not matter does not, what is made is right.
//!
//! The scene is `fixtures/objects.scene.toml`: a block and a ball, seen from four sides.

use crate::objects::{description, frame_of, noisy_views, setup, views};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use transect::evaluate::{EvaluateOptions, evaluate};
use transect::{
    LoadedView, Posed, ReconstructError, Reconstruction, Setup, SourceError, Stage, Unwatched,
    ViewSource, Watch, reconstruct,
};
use transect_device::{ImageSize, Isometry3, RangeImage, View};
use transect_geometry::{
    Curve, CurveUnit, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, Point3, StraightGuide,
    Vector2, Vector3,
};
use transect_register::PosePrior;
use transect_scene::Noise;
use transect_sensors::{Intrinsics, Pinhole};

/// Two thirds of a pixel's footprint at the far side of the scene, 0.5° at 3.5 m, in metres.
///
/// A line between neighbouring samples cuts a corner by half a footprint, and by a little more
/// where a side of it is seen obliquely.
const SAMPLING: f64 = 0.02;

/// How far the truth's inscribed ball is from the round one, in metres.
const CHORD_ERROR: f64 = 1e-5;

fn run(views: &[View]) -> Reconstruction {
    reconstruct(views, &setup(), &Unwatched).unwrap()
}

type PlaneCurves = BTreeMap<PlaneIndex, Vec<Curve>>;

fn curves(result: &Reconstruction) -> PlaneCurves {
    result.model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect()
}

/// All orders of the numbers below `n`.
fn orders(n: usize) -> Vec<Vec<usize>> {
    let Some(last) = n.checked_sub(1) else { return vec![Vec::new()] };
    let shorter = orders(last);
    let with_last = |order: &Vec<usize>, at: usize| {
        let mut order = order.clone();
        order.insert(at, last);
        order
    };
    shorter.iter().flat_map(|o| (0..n).map(move |at| with_last(o, at))).collect()
}

#[test]
fn the_order_of_the_views_does_not_matter() {
    let views = noisy_views();
    let first = curves(&run(&views));
    assert!(first.len() >= 10, "only {} planes", first.len());
    let orders = orders(views.len());
    assert_eq!(orders.len(), 24);
    for order in orders {
        let reordered: Vec<View> = order.iter().map(|&k| views[k].clone()).collect();
        assert!(curves(&run(&reordered)) == first, "other curves in the order {order:?}");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let views = noisy_views();
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| run(&views))
    };
    let (one, two) = (with_threads(1), with_threads(2));
    assert!(one.model == two.model);
    assert!(one.model.curve_count() > 20);
    let report = |r: &Reconstruction| (r.report.views.len(), r.report.fusion.nodes);
    assert_eq!(report(&one), report(&two));
}

/// UTM coordinates of a place, in metres.
const FAR: Vector3 = Vector3::new(500_000.0, 5_400_000.0, 300.0);

fn moved(view: &View, by: &Vector3) -> View {
    let pose = Isometry3::translation(by.x, by.y, by.z) * view.world_from_sensor();
    let frame = frame_of(view.name());
    View::new(view.name(), view.image().clone(), frame, pose, view.sigma()).unwrap()
}

/// The same images under poses and planes that were moved together. Plane k of the moved family is
/// plane k of the first one, moved: its station grows by normal · shift, and so does the offset.
fn assert_same_far_away(normal: Vector3) {
    let (views, guide) = (noisy_views(), StraightGuide::along(normal).unwrap());
    let family = |offset| PlaneFamily::new(guide, offset, 0.08).unwrap();
    let (near, far) = (family(0.0137), family(0.0137 + guide.direction().dot(&FAR)));
    let model = |views: &[View], planes| {
        curves(&reconstruct(views, &Setup::new(LengthUnit::Metre, planes), &Unwatched).unwrap())
    };
    let here = model(&views, near.clone());
    let there = model(&views.iter().map(|v| moved(v, &FAR)).collect::<Vec<_>>(), far.clone());
    assert!(here.len() >= 10 && here.keys().eq(there.keys()), "other planes");
    let (mut compared, mut turned) = (0, 0);
    for ((k, a), b) in here.iter().zip(there.values()) {
        let shape = |c: &Curve| (c.is_closed(), c.nodes().len());
        assert!(a.iter().map(shape).eq(b.iter().map(shape)), "plane {k:?} has other curves");
        let nodes = |c: &[Curve]| c.iter().flat_map(|c| c.nodes().to_vec()).collect::<Vec<Node>>();
        for (p, q) in nodes(a).iter().zip(&nodes(b)) {
            let p = near.frame(*k).world_from_plane(&p.position) + FAR;
            let q = far.frame(*k).world_from_plane(&q.position);
            assert!((p - q).norm() < 1e-4, "plane {k:?}: {p} became {q}");
            compared += 1;
            turned += usize::from((p - q).norm() > 1e-6);
        }
    }
    // Coordinates in the millions are rounded to a nanometre, which may turn a sample over a
    // threshold of fusion, such as that of a window. The nodes beside it then move by a hundredth
    // of the noise.
    assert!(turned * 100 <= compared, "{turned} of {compared} nodes");
}

#[test]
fn world_coordinates_of_any_size_keep_a_micrometre() {
    assert_same_far_away(Vector3::z());
}

#[test]
fn planes_across_large_coordinates_keep_a_micrometre() {
    // Stations and plane coordinates are both in the millions here.
    for normal in [[0.3, 0.5, 0.8], [0.1, 0.2, 0.9], [1.0, 0.0, 0.0], [-1.0, 2.0, 3.0]] {
        assert_same_far_away(Vector3::from(normal));
    }
}

/// Counts what a run reports, and asks it to stop after some steps of a stage.
#[derive(Default)]
struct Counter {
    begun: Mutex<Vec<(Stage, usize)>>,
    poses: AtomicUsize,
    views: AtomicUsize,
    planes: AtomicUsize,
    stop_after: Option<(Stage, usize)>,
    stopped: AtomicBool,
}

impl Counter {
    fn steps(&self, stage: Stage) -> &AtomicUsize {
        match stage {
            Stage::Poses => &self.poses,
            Stage::Views => &self.views,
            Stage::Planes => &self.planes,
        }
    }

    fn stopping_after(stage: Stage, steps: usize) -> Self {
        Self { stop_after: Some((stage, steps)), ..Self::default() }
    }

    fn counts(&self) -> (usize, usize) {
        (self.views.load(Ordering::SeqCst), self.planes.load(Ordering::SeqCst))
    }
}

impl Watch for Counter {
    fn begin(&self, stage: Stage, total: usize) {
        self.begun.lock().unwrap().push((stage, total));
        if self.stop_after == Some((stage, 0)) {
            self.stopped.store(true, Ordering::SeqCst);
        }
    }

    fn step(&self, stage: Stage) {
        let steps = self.steps(stage).fetch_add(1, Ordering::SeqCst) + 1;
        if self.stop_after == Some((stage, steps)) {
            self.stopped.store(true, Ordering::SeqCst);
        }
    }

    fn cancelled(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }
}

#[test]
fn progress_counts_every_view_and_every_plane() {
    let (views, counter) = (noisy_views(), Counter::default());
    let result = reconstruct(&views, &setup(), &counter).unwrap();
    let planes = result.model.sections().len();
    let begun = counter.begun.lock().unwrap().clone();
    assert_eq!(begun, [(Stage::Views, views.len()), (Stage::Planes, planes)]);
    assert_eq!(counter.counts(), (views.len(), planes));
}

#[test]
fn cancelling_stops_before_the_next_view_or_plane() {
    let views = noisy_views();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for (stage, steps, done) in [
        (Stage::Views, 0, (0, 0)),
        (Stage::Views, 2, (2, 0)),
        (Stage::Planes, 0, (4, 0)),
        (Stage::Planes, 3, (4, 3)),
    ] {
        let counter = Counter::stopping_after(stage, steps);
        let result = one.install(|| reconstruct(&views, &setup(), &counter));
        let error = result.map(drop).unwrap_err();
        assert!(matches!(error, ReconstructError::Cancelled), "{stage:?} {steps}: {error}");
        assert_eq!(counter.counts(), done, "{stage:?} {steps}");
    }
}

/// A view, or a source that cannot load one.
enum Source {
    Good(View),
    /// With the view it waits for before it fails.
    Broken(&'static str, Arc<AtomicBool>, bool),
}

impl ViewSource for Source {
    fn name(&self) -> &str {
        match self {
            Self::Good(view) => view.name(),
            Self::Broken(name, ..) => name,
        }
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        match self {
            Self::Good(view) => Ok(LoadedView { view: view.clone(), notes: Vec::new() }),
            Self::Broken(name, other_failed, waits) => {
                // Gives up waiting after a while, for pools in which nobody else runs.
                for _ in 0..200 {
                    if !*waits || other_failed.load(Ordering::SeqCst) {
                        break;
                    }
                    std::thread::sleep(std::time::Duration::from_millis(5));
                }
                other_failed.store(true, Ordering::SeqCst);
                Err(format!("{name}: the disk is gone").into())
            }
        }
    }
}

fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |e| e.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}; {cause}"))
}

fn failure(sources: &[Source]) -> String {
    with_causes(&reconstruct(sources, &setup(), &Unwatched).map(drop).unwrap_err())
}

#[test]
fn a_failing_source_is_named_with_its_reason() {
    for at in 0..=4 {
        let mut sources: Vec<Source> = noisy_views().into_iter().map(Source::Good).collect();
        sources.insert(at, Source::Broken("shed", Arc::default(), false));
        assert_eq!(failure(&sources), "view shed; shed: the disk is gone");
    }
    let nothing: [View; 0] = [];
    let error = reconstruct(&nothing, &setup(), &Unwatched).map(drop).unwrap_err();
    assert_eq!(error.to_string(), "the scan has no views");
}

/// A view whose source states how far its pose may be wrong.
struct Known(View, PosePrior);

impl ViewSource for Known {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn pose_prior(&self) -> Option<PosePrior> {
        Some(self.1)
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        self.0.load()
    }
}

#[test]
fn sources_that_stand_elsewhere_and_at_other_poses_stay_what_they_are() {
    let views = noisy_views();
    let model = curves(&run(&views));
    let some: Vec<&View> = views.iter().collect();
    let of_all_kinds: Vec<Box<dyn ViewSource>> =
        views.iter().map(|view| Box::new(view.clone()) as Box<dyn ViewSource>).collect();
    assert!(curves(&reconstruct(&some, &setup(), &Unwatched).unwrap()) == model);
    assert!(curves(&reconstruct(&of_all_kinds, &setup(), &Unwatched).unwrap()) == model);
    let known = Known(views[0].clone(), PosePrior { rotation: 1e-9, translation: 1e-9 });
    let pose = Isometry3::translation(1.0, 0.0, 0.0);
    let posed = Posed { source: &known, pose, depth_offsets: None, surface_sigma: None };
    assert_eq!(posed.pose_prior(), known.pose_prior());
    assert_eq!(*posed.load().unwrap().view.world_from_sensor(), pose);
}

#[test]
fn a_source_with_a_prior_that_is_no_number_is_named() {
    let wrong = PosePrior { rotation: f64::NAN, translation: 1e-9 };
    let sources = [Known(noisy_views().swap_remove(0), wrong)];
    let mut setup = setup();
    setup.refine_poses = Some(Default::default());
    let error = reconstruct(&sources, &setup, &Unwatched).map(drop).unwrap_err().to_string();
    let view = format!("view {}: its pose has a standard deviation of NaN rad", sources[0].name());
    assert!(error.starts_with(&view), "{error}");
}

#[test]
fn a_model_without_curves_is_told() {
    let small = ImageSize { rows: 2, cols: 2 };
    let k = Intrinsics { fx: 20.0, fy: 20.0, cx: 0.5, cy: 0.5 };
    let camera = Arc::new(Pinhole::new(small, k).unwrap());
    let image = RangeImage::from_values(small, vec![1.0; 4]).unwrap();
    let view = View::new("small", image, camera, Isometry3::identity(), Some(0.001)).unwrap();
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::y()).unwrap(), 0.005, 0.02);
    let setup = Setup::new(LengthUnit::Metre, planes.unwrap());
    let Reconstruction { model, report } = reconstruct(&[view], &setup, &Unwatched).unwrap();
    assert_eq!((model.sections().count(), model.length().is_sign_negative()), (0, false));
    let told =
        report.notes.iter().any(|note| note.text.starts_with("the model has no curve: fusion"));
    assert!(told, "{:?}", report.notes);
}

#[test]
fn of_several_failing_sources_the_first_in_order_is_named() {
    let failed = Arc::<AtomicBool>::default();
    let sources =
        [Source::Broken("shed", failed.clone(), true), Source::Broken("yard", failed, false)];
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    assert_eq!(two.install(|| failure(&sources)), "view shed; shed: the disk is gone");
}

#[test]
fn views_that_no_plane_crosses_are_told_with_where_they_are() {
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 50.0, 100.0);
    let setup = Setup::new(LengthUnit::Metre, planes.unwrap());
    let error = reconstruct(&noisy_views(), &setup, &Unwatched).map(drop).unwrap_err();
    let ReconstructError::Nothing { views: 4, low, high, .. } = error else { panic!("{error}") };
    // The sensing volumes hold the solids, which reach from 0 m to 0.95 m, and are not much larger.
    assert!((-1.5..=0.0).contains(&low) && (0.95..=2.5).contains(&high), "{low} to {high}");
}

/// The result without noise and the exact sections.
fn clean() -> (Reconstruction, PlaneCurves) {
    let description = description();
    let truth = description.scene().sections(&description.planes, CHORD_ERROR).unwrap();
    (run(&views(&Noise::NONE)), truth)
}

/// Distance of a point from the nearest of some curves.
fn distance(curves: &[Curve], p: &Point2) -> f64 {
    curves.iter().map(|c| c.foot(p).distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn without_noise_every_node_is_within_half_its_footprint_of_the_truth() {
    let (result, truth) = clean();
    let mut nodes = 0;
    for (k, curves) in curves(&result) {
        for node in curves.iter().flat_map(Curve::nodes) {
            let off = distance(&truth[&k], &node.position);
            let bound = SAMPLING.min(0.5 * f64::from(node.footprint)) + CHORD_ERROR;
            assert!(
                off <= bound,
                "plane {k:?}: {} is off by {off}, {bound} allowed",
                node.position
            );
            nodes += 1;
        }
    }
    assert!(nodes > 1000, "{nodes} nodes");
}

#[test]
fn without_noise_curves_lie_on_the_truth_once() {
    let (result, truth) = clean();
    let options = EvaluateOptions::new(SAMPLING + CHORD_ERROR);
    let a = evaluate(&description().planes, &curves(&result), &truth, &options).unwrap();
    assert_eq!((a.off, a.duplicated), (Some(0.0), Some(0.0)), "{a:?}");
    assert!(a.max.is_some_and(|m| m < SAMPLING), "{a:?}");
    // Most samples lie on flat sides and sides so round that a pixel's chord is a tenth of a
    // millimetre off.
    assert!(a.median.is_some_and(|m| m < 2e-4), "{a:?}");
    // The ball's underside and the ground below it are seen by nobody.
    assert!(a.completeness.is_some_and(|c| c > 0.92), "{a:?}");
    // A line that cuts a corner may stand at right angles to the nearer side: half a footprint of
    // it at some of the block's four corners on ten planes. All else runs like the truth.
    let at_corners = 40.0 * SAMPLING / a.length;
    assert!(a.oriented.is_some_and(|o| o > 1.0 - 0.1 * at_corners), "{a:?}");
}

/// Whether a point of the truth is next to a corner: a turn of more than 30°.
fn near_corner(truth: &[Curve], p: &Point2) -> bool {
    let direction = |u: &CurveUnit| u.vector().normalize();
    let corners = truth.iter().flat_map(|c| {
        let units: Vec<CurveUnit> = c.units().filter(|u| u.vector().norm() > 0.0).collect();
        let next = units.clone().into_iter().cycle().skip(1);
        units.into_iter().zip(next).filter(|(u, v)| direction(u).dot(&direction(v)) < 0.866)
    });
    let mut corners = corners.map(|(u, _)| u.end);
    corners.any(|corner| (corner - p).norm() < 2.0 * SAMPLING)
}

#[test]
fn away_from_corners_every_unit_runs_like_the_truth() {
    let (result, truth) = clean();
    let mut checked = 0;
    for (k, curves) in curves(&result) {
        let truth = &truth[&k];
        for unit in curves.iter().flat_map(Curve::units) {
            let middle = unit.at(0.5);
            let feet = truth.iter().map(|c| (c, c.foot(&middle)));
            let nearest = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
            let (curve, foot) = nearest.unwrap();
            if unit.vector().norm() == 0.0 || near_corner(truth, &foot.point) {
                continue;
            }
            let true_unit = curve.units().nth(foot.unit).unwrap().vector().normalize();
            let cosine = true_unit.dot(&unit.vector().normalize());
            assert!(cosine > 0.9, "plane {k:?}: {unit:?} runs at cosine {cosine} to the truth");
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked} units");
}

#[test]
fn the_solid_is_on_the_left_of_every_unit() {
    let (result, scene) = (clean().0, description().scene());
    let planes = description().planes;
    for (k, curves) in curves(&result) {
        let frame = planes.frame(k);
        // A unit much shorter than the sampling bound may point anywhere, as at a corner.
        let long = |u: &CurveUnit| u.vector().norm() > 0.25 * SAMPLING;
        for unit in curves.iter().flat_map(Curve::units).filter(long) {
            // Tolerance: nearer than the sampling bound, the curve itself may be off that far.
            let along = unit.vector().normalize();
            // Nor is it where the unit cuts a corner, by half its length at most.
            let tolerance = SAMPLING + 0.5 * unit.vector().norm();
            let aside = Vector2::new(-along.y, along.x) * tolerance;
            let inside = |p: Point2| -> bool {
                let p: Point3 = frame.world_from_plane(&p);
                scene.contains(&p)
            };
            let middle = unit.at(0.5);
            assert!(inside(middle + aside), "plane {k:?}: no solid left of {unit:?}");
            assert!(!inside(middle - aside), "plane {k:?}: solid right of {unit:?}");
        }
    }
}
