//! A store that views came to, left and were replaced in, against one run over the views that are
//! there.

use crate::objects::{noisy_views, setup, views};
use proptest::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use transect::{
    GrowError, Grower, LoadedView, ReconstructError, Setup, SourceError, Stage, Unwatched,
    ViewSource, Watch, reconstruct,
};
use transect_device::{ImageSize, Isometry3, View};
use transect_exchange::write_contours;
use transect_fusion::FusionMethod;
use transect_geometry::{LengthUnit, PlaneFamily, PlaneIndex, StraightGuide, Vector3};
use transect_model::Model;
use transect_model::store::{Store, StoreProblem, ViewId, ViewReplacement};
use transect_register::RefineOptions;
use transect_scene::{Description, Noise, Station};
use transect_sensors::{AngularScan, ImagingRadar};

fn contours(model: &Model) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_contours(model, &mut bytes).unwrap();
    bytes
}

/// The contour file of one run over some views, in order of their names.
fn at_once(views: &[View], setup: &Setup) -> Vec<u8> {
    if views.is_empty() {
        return contours(&Model::new(setup.unit, setup.planes.clone()));
    }
    let mut sorted = views.to_vec();
    sorted.sort_by(|a, b| a.name().cmp(b.name()));
    contours(&reconstruct(&sorted, setup, &Unwatched).unwrap().model)
}

fn stored(store: &Store) -> Vec<u8> {
    contours(&store.read().unwrap().model().unwrap())
}

fn names(store: &Store) -> Vec<String> {
    store.views().unwrap().into_iter().map(|view| view.entry.id.0).collect()
}

fn create(folder: &Path, setup: &Setup) -> Store {
    Store::create(folder.join("objects.transect"), &setup.store_header()).unwrap()
}

fn with_store(setup: &Setup, check: impl FnOnce(&mut Store)) {
    let folder = tempfile::tempdir().unwrap();
    check(&mut create(folder.path(), setup));
}

/// A better registration: the view a little to the side, and turned.
fn moved(view: &View) -> View {
    let by = Isometry3::new(Vector3::new(0.02, -0.01, 0.015), Vector3::new(0.0, 0.0, 0.01));
    view.with_pose(by * view.world_from_sensor()).unwrap()
}

fn changed(change: impl FnOnce(&mut Setup)) -> Setup {
    let mut setup = setup();
    change(&mut setup);
    setup
}

fn methods() -> [Setup; 2] {
    let pairwise = FusionMethod::Pairwise(Default::default());
    [setup(), changed(|s| s.fusion = pairwise)]
}

#[test]
fn any_order_of_views_gives_the_bytes_of_one_run() {
    let views = noisy_views();
    for setup in methods() {
        let whole = at_once(&views, &setup);
        for order in [[0, 1, 2, 3], [3, 1, 0, 2], [2, 3, 1, 0]] {
            with_store(&setup, |store| {
                let grower = Grower::new(store, &setup).unwrap();
                for k in order {
                    let view = grower.add_view(&views[k]).unwrap().unwrap();
                    assert!(view.planes.len() >= 10);
                }
                assert!(stored(store) == whole, "in the order {order:?}");
                store.verify().unwrap();
            });
        }
        with_store(&setup, |store| {
            Grower::new(store, &setup).unwrap().add_views(&views, &Unwatched).unwrap();
            assert!(stored(store) == whole, "all at once");
            let run = reconstruct(&views, &setup, &Unwatched).unwrap().model;
            let by_name = |model: &Model| {
                let mut views = model.views().to_vec();
                views.sort_by(|a, b| a.name.cmp(&b.name));
                views
            };
            assert_eq!(by_name(&store.read().unwrap().model().unwrap()), by_name(&run));
            assert_eq!(store.verify().unwrap().pending, 0);
        });
    }
}

#[test]
fn a_removed_view_leaves_no_trace_and_a_moved_one_is_as_if_it_had_always_been_there() {
    let views = noisy_views();
    for setup in methods() {
        for (k, view) in views.iter().enumerate() {
            with_store(&setup, |store| {
                let grower = Grower::new(store, &setup).unwrap();
                grower.add_views(&views, &Unwatched).unwrap();
                let mut others = views.clone();
                others[k] = moved(view);
                let replacement = [(view.name().into(), others[k].clone())];
                grower.replace_views(&replacement, &Unwatched).unwrap();
                assert!(stored(store) == at_once(&others, &setup), "view {k} moved");
                grower.remove_view(&view.name().into()).unwrap();
                others.remove(k);
                assert!(stored(store) == at_once(&others, &setup), "view {k} removed");
                store.verify().unwrap();
            });
        }
    }
}

/// Planes through the bundled room, and coarse scans of full circles from its stations. Some planes
/// have no curves of some views.
fn full_circles() -> (PlaneFamily, Vec<View>) {
    let text = include_str!("../../../../fixtures/room.scene.toml");
    let description = Description::parse(text).unwrap();
    let scene = description.scene();
    let view = |(k, station): (usize, &Station)| {
        let size = ImageSize { rows: 24, cols: 180 };
        let degrees = |first: f64, step: f64| {
            AngularScan::from_radians(first.to_radians(), step.to_radians())
        };
        let down = 20.0 * k as f64;
        let frame = ImagingRadar::new(size, degrees(180.0, -2.0), degrees(70.0 - down, -2.0));
        let place =
            Isometry3::from_parts(station.world_from_sensor.translation, Default::default());
        let noise = &description.noise;
        scene.view(station.name.clone(), Arc::new(frame.unwrap()), place, noise, k as u64).unwrap()
    };
    let views = description.stations.iter().take(4).enumerate().map(view).collect();
    let guide = StraightGuide::along(Vector3::z()).unwrap();
    (PlaneFamily::new(guide, 0.0337, 0.3).unwrap(), views)
}

#[derive(Debug, Clone)]
enum Step {
    Add(usize),
    AddAll(Vec<usize>),
    Remove(usize),
    Move(usize),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        2 => (0..4usize).prop_map(Step::Add),
        1 => prop::collection::btree_set(0..4usize, 1..4)
            .prop_map(|views| Step::AddAll(views.into_iter().collect())),
        1 => (0..4usize).prop_map(Step::Remove),
        1 => (0..4usize).prop_map(Step::Move),
    ];
    prop::collection::vec(step, 1..8)
}

/// Does a step to a store and to the plain list that it should be like.
fn take(step: Step, grower: &Grower, all: &[View], there: &mut [Option<View>]) {
    match step {
        Step::Add(k) => {
            let added = grower.add_view(there[k].as_ref().unwrap_or(&all[k])).unwrap();
            assert_eq!(added.is_some(), there[k].is_none());
            there[k].get_or_insert_with(|| all[k].clone());
        }
        Step::AddAll(ks) => {
            let views: Vec<View> =
                ks.iter().map(|&k| there[k].as_ref().unwrap_or(&all[k]).clone()).collect();
            let growth = grower.add_views(&views, &Unwatched).unwrap();
            assert_eq!(growth.report.views.len() + growth.present.len(), ks.len());
            ks.iter().for_each(|&k| _ = there[k].get_or_insert_with(|| all[k].clone()));
        }
        Step::Remove(k) => {
            let removed = grower.remove_view(&all[k].name().into());
            assert_eq!(removed.is_ok(), there[k].take().is_some());
        }
        Step::Move(k) => {
            let view = moved(there[k].as_ref().unwrap_or(&all[k]));
            let replacement = [(view.name().into(), view.clone())];
            let replaced = grower.replace_views(&replacement, &Unwatched);
            assert_eq!(replaced.is_ok(), there[k].is_some());
            there[k] = there[k].is_some().then_some(view);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn the_store_is_a_function_of_the_views_that_are_there(steps in steps()) {
        let (planes, room_views) = full_circles();
        let both = methods().map(|setup| (setup, noisy_views()));
        let rooms = methods().map(|mut setup| {
            setup.planes = planes.clone();
            (setup, room_views.clone())
        });
        for (setup, all) in both.into_iter().chain(rooms) {
            let folder = tempfile::tempdir().unwrap();
            let mut store = create(folder.path(), &setup);
            let mut there: Vec<Option<View>> = vec![None; all.len()];
            for step in steps.clone() {
                take(step, &Grower::new(&store, &setup).unwrap(), &all, &mut there);
                let views: Vec<View> = there.iter().flatten().cloned().collect();
                prop_assert!(stored(&store) == at_once(&views, &setup));
                prop_assert_eq!(store.verify().unwrap().views, views.len() as u64);
            }
        }
    }
}

#[test]
fn the_report_is_that_of_one_run() {
    let (setup, views) = (setup(), noisy_views());
    let once = reconstruct(&views, &setup, &Unwatched).unwrap().report;
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        let growth = grower.add_views(&views, &Unwatched).unwrap();
        assert_eq!(format!("{:?}", growth.report.views), format!("{:?}", once.views));
        assert_eq!(format!("{:?}", growth.report.fusion), format!("{:?}", once.fusion));
        assert_eq!((growth.present.len(), growth.fused), (0, once.fusion.planes));
        let again = grower.add_views(&views, &Unwatched).unwrap();
        assert_eq!((again.present.len(), again.report.views.len(), again.fused), (4, 0, 0));
        assert_eq!(again.report.fusion.nodes, once.fusion.nodes);
    });
}

#[test]
fn another_view_under_a_known_name_is_refused() {
    let (setup, views) = (setup(), noisy_views());
    let refused = |view: &View| {
        let mut text = String::new();
        with_store(&setup, |store| {
            let grower = Grower::new(store, &setup).unwrap();
            grower.add_view(&views[0]).unwrap();
            let before = stored(store);
            let error = grower.add_view(view).unwrap_err();
            assert!(matches!(error, GrowError::OtherView { .. }), "{error}");
            assert!(stored(store) == before);
            text = error.to_string();
        });
        text
    };
    let (pose, image) = (moved(&views[0]), crate::objects::views(&Noise::NONE)[0].clone());
    assert!(refused(&pose).contains("another pose"));
    assert!(refused(&image).contains("another image"));
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        let error = grower.add_views(&[views[0].clone(), pose.clone()], &Unwatched).unwrap_err();
        let expected = "views 0 and 1 (from 0) are both named east; give one of them another name";
        assert_eq!(error.to_string(), expected);
        assert_eq!(names(store), [""; 0]);
    });
}

#[test]
fn a_store_of_other_settings_says_which() {
    let setup = setup();
    with_store(&setup, |store| {
        let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.0137, 0.1);
        let others = [
            (changed(|s| s.unit = LengthUnit::Millimetre), "the store is in m and the scan in mm"),
            (
                changed(|s| s.planes = planes.unwrap()),
                "interval: the store has 0.08 m, this run 0.1 m",
            ),
            (methods()[1].clone(), "fusion: the store has consensus"),
        ];
        for (other, text) in others {
            let error = Grower::new(store, &other).unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
    });
}

/// A view that can be loaded, or not.
struct Source(View, bool);

impl ViewSource for Source {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        if self.1 { self.0.load() } else { Err("the disk is gone".into()) }
    }
}

#[test]
fn of_many_views_those_before_one_that_fails_are_there_and_no_others() {
    let (setup, views) = (setup(), noisy_views());
    for bad in 0..views.len() {
        let sources: Vec<Source> =
            views.iter().enumerate().map(|(k, v)| Source(v.clone(), k != bad)).collect();
        with_store(&setup, |store| {
            let grower = Grower::new(store, &setup).unwrap();
            let error = grower.add_views(&sources, &Unwatched).unwrap_err();
            assert_eq!(error.to_string(), format!("view {}", views[bad].name()));
            assert!(stored(store) == at_once(&views[..bad], &setup));
            grower.add_view(&sources[bad]).unwrap_err();
            let lost = [(views[0].name().into(), Source(views[bad].clone(), false))];
            grower.replace_views(&lost, &Unwatched).unwrap_err();
            assert!(stored(store) == at_once(&views[..bad], &setup));
            store.verify().unwrap();
        });
    }
}

/// Stops after some views.
struct Stopping(AtomicUsize);

impl Watch for Stopping {
    fn begin(&self, _: Stage, _: usize) {}
    fn step(&self, _: Stage) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
    fn cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }
}

/// The stages in their order, each with the steps it announced and those it took.
#[derive(Default)]
struct Stages(Mutex<Vec<(Stage, usize, usize)>>);

impl Watch for Stages {
    fn begin(&self, stage: Stage, total: usize) {
        self.0.lock().unwrap().push((stage, total, 0));
    }
    fn step(&self, stage: Stage) {
        let mut stages = self.0.lock().unwrap();
        let last = stages.last_mut().filter(|last| last.0 == stage);
        last.expect("a step of a stage that has begun").2 += 1;
    }
}

#[test]
fn stages_of_a_store_announce_the_steps_that_they_take() {
    let (setup, views) = (setup(), noisy_views());
    with_store(&setup, |store| {
        let (grower, watch) = (Grower::new(store, &setup).unwrap(), Stages::default());
        grower.add_views(&views, &watch).unwrap();
        let replacement = [(views[1].name().into(), moved(&views[1]))];
        grower.replace_views(&replacement, &watch).unwrap();
        let stages = watch.0.into_inner().unwrap();
        let begun: Vec<Stage> = stages.iter().map(|(stage, ..)| *stage).collect();
        assert_eq!(begun, [Stage::Views, Stage::Planes, Stage::Views, Stage::Planes]);
        assert!(stages.iter().all(|(_, total, steps)| total == steps), "{stages:?}");
    });
}

#[test]
fn a_stopped_run_is_taken_up_where_it_stopped() {
    let (setup, views) = (setup(), noisy_views());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        let stopped = one.install(|| grower.add_views(&views, &Stopping(AtomicUsize::new(3))));
        let error = stopped.unwrap_err();
        assert!(matches!(error, GrowError::View(ReconstructError::Cancelled)), "{error}");
        assert_eq!(names(store).len(), 3);
        let pending = store.read().unwrap().model().unwrap_err().problem;
        assert!(matches!(pending, StoreProblem::Pending(1..)), "{pending}");
        let growth = grower.add_views(&views, &Unwatched).unwrap();
        assert_eq!((growth.present.len(), growth.report.views.len()), (3, 1));
        assert!(stored(store) == at_once(&views, &setup));
        assert_eq!(grower.fuse_pending(&Unwatched).unwrap(), 0);
        let replacement = [(views[0].name().into(), moved(&views[0]))];
        let stopped = grower.replace_views(&replacement, &Stopping(AtomicUsize::new(0)));
        let error = stopped.unwrap_err();
        assert!(matches!(error, GrowError::View(ReconstructError::Cancelled)), "{error}");
        assert!(stored(store) == at_once(&views, &setup));
    });
}

#[test]
fn views_that_no_plane_crosses_and_unknown_ones_are_told() {
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 50.0, 100.0);
    let setup = Setup::new(LengthUnit::Metre, planes.unwrap());
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        let error = grower.add_views(&views(&Noise::NONE), &Unwatched).unwrap_err();
        assert!(matches!(error, GrowError::View(ReconstructError::Nothing { views: 4, .. })));
        let unknown = grower.remove_view(&ViewId::from("attic")).unwrap_err();
        let GrowError::Store(unknown) = unknown else { panic!("{unknown}") };
        assert_eq!(unknown.problem.to_string(), "has no view \"attic\"");
    });
}

#[test]
fn a_view_that_is_replaced_twice_at_once_is_told() {
    let (setup, views) = (setup(), noisy_views());
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        grower.add_views(&views, &Unwatched).unwrap();
        let id = ViewId::from(views[0].name());
        let twice = [(id.clone(), &views[0]), (id, &views[0])];
        let error = grower.replace_views(&twice, &Unwatched).unwrap_err();
        assert!(matches!(error, GrowError::SameId { first: 0, second: 1, .. }), "{error}");
        let again = [&views[0], &views[1], &views[0]];
        let error = grower.refine_poses(&again, &RefineOptions::default(), &Unwatched).unwrap_err();
        assert!(matches!(error, GrowError::SameId { first: 0, second: 2, .. }), "{error}");
    });
}

/// The views of the bundled room.
pub fn room() -> (Setup, Vec<View>) {
    let (_, text) =
        transect_scene::BUNDLED_SCENES.iter().find(|(name, _)| *name == "room").unwrap();
    let description = Description::parse(text).unwrap();
    let scene = description.scene();
    let view = |(k, station): (usize, &Station)| {
        let (pose, noise) = (station.world_from_sensor, &description.noise);
        scene.view(station.name.clone(), station.frame().unwrap(), pose, noise, k as u64).unwrap()
    };
    let own = &description.planes;
    let planes = PlaneFamily::new(own.guide().clone(), own.offset(), 1.0).unwrap();
    let views = description.stations.iter().enumerate().map(view).collect();
    (Setup::new(description.unit, planes), views)
}

#[test]
fn a_wrong_pose_is_told_by_the_copies_of_earlier_images() {
    let (setup, views) = room();
    let (last, first) = views.split_last().unwrap();
    let turn = Isometry3::rotation(Vector3::new(0.0, 0.0, 10_f64.to_radians()));
    let turned = last.with_pose(last.world_from_sensor() * turn).unwrap();
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        assert_eq!(grower.add_views(first, &Unwatched).unwrap().report.warnings(), [""; 0]);
        let growth = grower.add_views(&[turned], &Unwatched).unwrap();
        let warnings = growth.report.warnings();
        let expected = format!("view {} contradicts the others", last.name());
        assert!(warnings.len() == 1 && warnings[0].starts_with(&expected), "{warnings:?}");
        assert_eq!(grower.judge_poses(&[]).unwrap().unwrap().warnings(), warnings);
        let replacement = [(ViewId(last.name().to_owned()), last.clone())];
        let (_, report) = grower.replace_views(&replacement, &Unwatched).unwrap();
        assert_eq!(report.warnings(), [""; 0]);
        assert!(grower.judge_poses(&[]).unwrap().is_none());
        // Judging changes nothing, and copies leave with their views.
        assert_eq!(stored(store), at_once(&views, &setup));
        store.verify().unwrap();
    });
}

#[test]
fn views_of_a_store_without_copies_are_told() {
    let (setup, views) = room();
    with_store(&setup, |store| {
        let grower = Grower::new(store, &setup).unwrap();
        let (first, others) = views.split_first().unwrap();
        grower.add_view(first).unwrap();
        // What a program that makes no copies leaves.
        let there = store.views().unwrap().remove(0);
        let mut entry = there.entry;
        entry.source_hash = "another image".to_owned();
        let snapshot = store.read().unwrap();
        let of_plane = |k| (k, snapshot.partials(k).unwrap().remove(0).1);
        let planes: Vec<_> = there.planes.into_iter().map(of_plane).collect();
        let replacement = ViewReplacement { id: entry.id.clone(), entry, copy: None, planes };
        let keep = |_: PlaneIndex, partials: &[(ViewId, Vec<_>)]| partials[0].1.clone();
        store.replace_views(vec![replacement], &keep).unwrap();
        let growth = grower.add_views(others, &Unwatched).unwrap();
        let told = growth.report.notes.iter().any(|note| note.text.contains("1 of 4 views"));
        assert!(told, "{:?}", growth.report.notes);
        assert_eq!(growth.report.warnings(), [""; 0]);
    });
}
