//! A store that grew and was registered in steps, against one that was registered once.

use crate::grow::room;
use crate::pose_error::Registered;
use transect::{Grower, PoseReport, Setup, Unwatched};
use transect_device::{Isometry3, Vector3, View};
use transect_model::store::{Store, StoredView, ViewId};
use transect_register::RefineOptions;

/// Small errors of the poses, others for every view.
fn shaken(views: &[View]) -> Vec<View> {
    let shake = |(k, view): (usize, &View)| {
        let wave = |n: usize| (2.4 * (7 * k + n) as f64).sin();
        let turn = 0.003 * Vector3::new(wave(1), wave(2), wave(3));
        let shift = 0.005 * Vector3::new(wave(4), wave(5), wave(6));
        view.with_pose(view.world_from_sensor() * Isometry3::new(shift, turn)).unwrap()
    };
    views.iter().enumerate().map(shake).collect()
}

/// A store and what registers it.
struct Map {
    store: Store,
    setup: Setup,
    _folder: tempfile::TempDir,
}

impl Map {
    fn new(setup: &Setup) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::create(folder.path().join("map.transect"), &setup.store_header());
        Self { store: store.unwrap(), setup: setup.clone(), _folder: folder }
    }

    fn grower(&self) -> Grower<'_> {
        Grower::new(&self.store, &self.setup).unwrap()
    }

    /// Of a room whose poses err, these views, and the views at their exact poses.
    fn of_room() -> (Self, Vec<View>, Vec<View>) {
        let (setup, exact) = room();
        let (map, views) = (Self::new(&setup), shaken(&exact));
        map.add(&views);
        (map, views, exact)
    }

    /// Adds views, and tells how many were there already.
    fn add(&self, views: &[View]) -> usize {
        self.grower().add_views(views, &Unwatched).unwrap().present.len()
    }

    /// The views that registration replaces, and its report.
    fn register(&self, views: &[View]) -> (usize, PoseReport) {
        let options = RefineOptions::default();
        let (replaced, report) = self.grower().refine_poses(views, &options, &Unwatched).unwrap();
        (replaced.len(), report.poses.unwrap())
    }

    fn views(&self) -> Vec<StoredView> {
        self.store.views().unwrap()
    }

    fn lines(&self) -> Vec<u8> {
        let mut lines = Vec::new();
        self.store.read().unwrap().export(&mut lines).unwrap();
        lines
    }
}

#[test]
fn steps_of_growth_and_registration_end_where_one_registration_does() {
    let (setup, exact) = room();
    let views = shaken(&exact);
    let (whole, mut grown) = (Map::new(&setup), Map::new(&setup));
    whole.add(&views);
    assert_eq!(whole.register(&views).0, views.len());
    for end in 2..=views.len() {
        grown.add(&views[end - 2..end]);
        grown.register(&views[..end]);
    }
    assert_eq!(grown.views(), whole.views());
    assert!(grown.lines() == whole.lines());
    grown.store.verify().unwrap();
}

#[test]
fn a_registered_store_is_not_registered_again() {
    let (map, views, _) = Map::of_room();
    let (replaced, first) = map.register(&views);
    let there = map.views();
    let (again, second) = map.register(&views);
    assert_eq!((replaced, again), (views.len(), 0));
    assert_eq!(second.notes(), first.notes());
    assert_eq!(map.views(), there);
    // A scan can be added again: its poses are those that the views were given.
    assert_eq!(map.add(&views), views.len());
    assert_eq!(map.views(), there);
}

#[test]
fn a_registered_store_of_a_registered_scan_grows_on() {
    let (setup, exact) = room();
    let state = |view: View| Registered(view, Some(0.001));
    let sources: Vec<Registered> = shaken(&exact).into_iter().map(state).collect();
    let mut map = Map::new(&setup);
    map.grower().add_views(&sources[..3], &Unwatched).unwrap();
    let options = RefineOptions::default();
    let register = |count: usize| {
        let sources = &sources[..count];
        map.grower().refine_poses(sources, &options, &Unwatched).unwrap().0.len()
    };
    assert_eq!((register(3), register(3)), (3, 0));
    let growth = map.grower().add_views(&sources, &Unwatched).unwrap();
    assert_eq!(growth.present.len(), 3);
    assert_eq!(register(4), 4);
    map.store.verify().unwrap();
}

#[test]
fn a_pose_that_takes_the_place_of_another_is_a_given_one() {
    let (map, views, exact) = Map::of_room();
    map.register(&views);
    let replacements: Vec<_> =
        exact.iter().map(|view| (ViewId(view.name().to_owned()), view.clone())).collect();
    map.grower().replace_views(&replacements, &Unwatched).unwrap();
    // The poses stay, and the nodes learn how far they may be off.
    let (first, report) = map.register(&views);
    let (second, _) = map.register(&views);
    assert_eq!((first, second), (views.len(), 0), "{:?}", report.notes());
    for there in map.views() {
        let exact = exact.iter().find(|view| view.name() == there.entry.name).unwrap();
        assert_eq!(there.entry.world_from_sensor, *exact.world_from_sensor());
    }
}
