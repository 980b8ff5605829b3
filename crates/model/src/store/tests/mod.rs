//! Views come and go; what is left is always what the views that are there make.

use super::test_media::Memory;
use super::*;
use crate::CodecError;
use crate::Section;
use crate::samples::{family, polyline, rectangle, strip, tangles};
use proptest::prelude::*;
use std::collections::BTreeMap;
use transect_geometry::{Curve, Isometry3, LengthUnit, PlaneIndex, Vector3};

mod copies;
mod damage;
mod files;
mod forged;
mod lines;
mod power;

type Curves = Vec<(PlaneIndex, Vec<Curve>)>;

fn header() -> StoreHeader {
    let (options, tool) = ("{\"order\":2}".to_owned(), "transect 0.1.0".to_owned());
    StoreHeader { unit: LengthUnit::Millimetre, planes: family(), options, tool }
}

fn entry(id: &str) -> ViewDescription {
    ViewDescription {
        id: id.into(),
        name: format!("view {id}"),
        sensor: "pinhole".to_owned(),
        source: format!("{id}.npy"),
        source_hash: "0123abcd".to_owned(),
        world_from_sensor: Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, 0.2, 0.3)),
        sigma: Some(0.1),
    }
}

/// Depends on the order of views, on their number and on every node.
fn fuse(plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
    let all = partials.iter().flat_map(|(_, curves)| curves.iter());
    let fused = all.map(|curve| {
        let nodes = curve.nodes().iter().map(|n| {
            let mut node = *n;
            node.position.x += partials.len() as f64 + plane.0 as f64;
            node
        });
        Curve::new(nodes.collect(), curve.is_closed()).unwrap()
    });
    fused.collect()
}

fn memory_store() -> (Memory, Store) {
    let memory = Memory::default();
    let store = Store::create_in(Path::new("memory"), memory.clone(), &header()).unwrap();
    (memory, store)
}

fn copy(id: &str) -> ViewCopy {
    ViewCopy(format!("copy of {id}").into_bytes())
}

fn add(store: &Store, id: &str, curves: &Curves) -> Result<StoredView, StoreError> {
    let mut view = store.begin_view(entry(id))?;
    view.set_copy(&copy(id))?;
    view.add_planes(curves.clone(), &fuse)?;
    view.commit()
}

fn export(store: &Store) -> String {
    let mut text = Vec::new();
    store.export(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// The export of a store that was built from these views alone.
fn fresh(views: &BTreeMap<String, Curves>) -> String {
    let (_, store) = memory_store();
    for (id, curves) in views {
        add(&store, id, curves).unwrap();
    }
    export(&store)
}

fn curves() -> impl Strategy<Value = Curves> {
    prop::collection::btree_map((-3i64..4).prop_map(PlaneIndex), tangles(), 0..4)
        .prop_map(|planes| planes.into_iter().collect())
}

#[derive(Debug, Clone)]
enum Step {
    Add(u8, Curves),
    Remove(u8),
    /// Replaces views together: the old number, the new one and the new curves of each.
    Replace(Vec<(u8, u8, Curves)>),
    GiveUp(u8, Curves),
    /// Adds views at once, whose planes are fused at the end, or only after the next step.
    Defer(u8, Curves),
    Settle,
    Compact,
    Reopen,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let id = || 0..4u8;
    let step = prop_oneof![
        4 => (id(), curves()).prop_map(|(id, curves)| Step::Add(id, curves)),
        2 => id().prop_map(Step::Remove),
        2 => prop::collection::vec((id(), id(), curves()), 1..4).prop_map(Step::Replace),
        1 => (id(), curves()).prop_map(|(id, curves)| Step::GiveUp(id, curves)),
        3 => (id(), curves()).prop_map(|(id, curves)| Step::Defer(id, curves)),
        1 => Just(Step::Settle),
        1 => Just(Step::Compact),
        1 => Just(Step::Reopen),
    ];
    prop::collection::vec(step, 1..12)
}

/// Does a step to a store and to the plain map that it should be like.
fn take(step: Step, store: &mut Store, memory: &mut Memory, views: &mut BTreeMap<String, Curves>) {
    let name = |id: u8| format!("view-{id}");
    match step {
        Step::Add(id, curves) => {
            let known = views.contains_key(&name(id));
            assert_eq!(add(store, &name(id), &curves).is_err(), known);
            views.entry(name(id)).or_insert(curves);
        }
        Step::Remove(id) => {
            let known = views.remove(&name(id)).is_some();
            let removed = store.remove_view(&ViewId(name(id)), &fuse);
            assert_eq!(removed.is_ok(), known);
        }
        Step::Replace(all) => {
            let mut after = views.clone();
            let taken = all.iter().all(|(old, ..)| after.remove(&name(*old)).is_some());
            let put = |(_, new, curves): &(u8, u8, Curves)| {
                after.insert(name(*new), curves.clone()).is_none()
            };
            let possible = taken && all.iter().all(put);
            let replacement = |(old, new, planes): (u8, u8, Curves)| ViewReplacement {
                id: ViewId(name(old)),
                entry: entry(&name(new)),
                copy: Some(copy(&name(new))),
                planes,
            };
            let replacements = all.into_iter().map(replacement).collect();
            let replaced = store.replace_views::<Curves>(replacements, &fuse);
            assert_eq!(replaced.is_ok(), possible);
            if possible {
                *views = after;
            }
        }
        Step::GiveUp(id, curves) => {
            if let Ok(mut view) = store.begin_view(entry(&name(id))) {
                view.add_planes(curves, &fuse).unwrap();
            }
        }
        Step::Defer(id, curves) => {
            if let Ok(mut view) = store.begin_view(entry(&name(id))) {
                view.set_copy(&copy(&name(id))).unwrap();
                view.defer_planes(curves.clone()).unwrap();
                view.commit().unwrap();
                views.insert(name(id), curves);
            }
        }
        Step::Settle => _ = store.fuse_pending(&fuse).unwrap(),
        Step::Compact => _ = store.compact().unwrap(),
        Step::Reopen => {
            // As after a crash: the store was not closed.
            *memory = Memory::of(memory.image());
            *store = Store::open_in(Path::new("memory"), memory.clone()).unwrap();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn whatever_happened_the_store_is_that_of_the_views_in_it(steps in steps()) {
        let (mut memory, mut store) = memory_store();
        let mut views = BTreeMap::new();
        for step in steps {
            take(step, &mut store, &mut memory, &mut views);
            let pending = store.verify().unwrap().pending;
            prop_assert_eq!(store.read().unwrap().pending().unwrap().len() as u64, pending);
            if pending == 0 {
                prop_assert_eq!(export(&store), fresh(&views));
            } else {
                check_that_nothing_old_is_shown(&store, pending);
            }
        }
        store.fuse_pending(&fuse).unwrap();
        store.verify().unwrap();
        prop_assert_eq!(export(&store), fresh(&views));
    }

    #[test]
    fn the_order_in_which_views_come_leaves_no_trace(
        views in prop::collection::btree_map("[a-z]{1,3}", curves(), 1..5), rotation in 0..5usize,
    ) {
        let (_, mut store) = memory_store();
        let mut order: Vec<_> = views.iter().collect();
        order.rotate_left(rotation % views.len());
        for (id, curves) in order {
            add(&store, id, curves).unwrap();
        }
        prop_assert_eq!(export(&store), fresh(&views));
        let (_, mut other) = memory_store();
        for (id, curves) in &views {
            add(&other, id, curves).unwrap();
        }
        prop_assert_eq!(store.verify().unwrap(), other.verify().unwrap());
    }
}

fn check_that_nothing_old_is_shown(store: &Store, pending: u64) {
    let snapshot = store.read().unwrap();
    let refused = [
        snapshot.plane(PlaneIndex(0)).map(drop),
        snapshot.planes().map(drop),
        snapshot.model().map(drop),
        snapshot.volume().map(drop),
        snapshot.plane_count().map(drop),
        snapshot.export(Vec::new()),
        snapshot.stale_planes(&fuse).map(drop),
    ];
    for refused in refused {
        match refused.unwrap_err().problem {
            StoreProblem::Pending(count) => assert_eq!(count, pending),
            other => panic!("{other}"),
        }
    }
}

fn square(x: f64) -> Vec<Curve> {
    vec![rectangle(x, 0.0, x + 1.0, 1.0)]
}

#[test]
fn what_was_put_in_is_read_back() {
    let (_, store) = memory_store();
    let both = vec![(PlaneIndex(2), vec![strip()]), (PlaneIndex(-1), square(0.0))];
    let stored = add(&store, "b", &both).unwrap();
    assert_eq!(stored.planes, [PlaneIndex(-1), PlaneIndex(2)]);
    assert_eq!((stored.curves, stored.nodes), (2, 7));
    add(&store, "a", &vec![(PlaneIndex(2), square(5.0)), (PlaneIndex(3), Vec::new())]).unwrap();

    let snapshot = store.read().unwrap();
    assert_eq!(snapshot.header(), &header());
    let ids: Vec<_> = snapshot.views().unwrap().into_iter().map(|v| v.entry).collect();
    assert_eq!(ids, [entry("a"), entry("b")]);
    assert_eq!(snapshot.view(&"b".into()).unwrap(), Some(stored));
    assert_eq!(snapshot.view(&"c".into()).unwrap(), None);
    let expected = [(ViewId::from("a"), square(5.0)), (ViewId::from("b"), vec![strip()])];
    assert_eq!(snapshot.partials(PlaneIndex(2)).unwrap(), expected);
    let fused = Section::new(fuse(PlaneIndex(2), &expected));
    assert_eq!(snapshot.plane(PlaneIndex(2)).unwrap(), fused);
    assert_eq!(store.read().unwrap().plane(PlaneIndex(3)).unwrap(), None);
    assert_eq!(snapshot.stale_planes(&fuse).unwrap(), []);
    let nothing = |_: PlaneIndex, _: &[(ViewId, Vec<Curve>)]| Vec::new();
    assert_eq!(snapshot.stale_planes(&nothing).unwrap(), [PlaneIndex(-1), PlaneIndex(2)]);
}

#[test]
fn planes_are_walked_both_ways_and_make_the_model() {
    let (_, store) = memory_store();
    let planes = [-5, 0, 1, 7].map(|k| (PlaneIndex(k), square(k as f64)));
    add(&store, "a", &planes.to_vec()).unwrap();
    let snapshot = store.read().unwrap();
    let keys = |items: Vec<Result<(PlaneIndex, Section), StoreError>>| -> Vec<i64> {
        items.into_iter().map(|item| item.unwrap().0.0).collect()
    };
    assert_eq!(keys(snapshot.planes().unwrap().collect()), [-5, 0, 1, 7]);
    assert_eq!(keys(snapshot.planes().unwrap().rev().collect()), [7, 1, 0, -5]);
    assert_eq!(snapshot.plane_count().unwrap(), 4);
    let model = snapshot.model().unwrap();
    assert_eq!(model.check(), Ok(()));
    assert_eq!(model.sections().map(|(k, _)| k.0).collect::<Vec<_>>(), [-5, 0, 1, 7]);
    assert_eq!((model.views()[0].name.as_str(), model.views()[0].nodes), ("view a", 16));
}

#[test]
fn a_snapshot_sees_the_last_whole_view_and_nothing_later() {
    let (_, mut store) = memory_store();
    add(&store, "a", &vec![(PlaneIndex(0), square(0.0))]).unwrap();
    let mut view = store.begin_view(entry("b")).unwrap();
    view.add_planes([(PlaneIndex(0), square(3.0))], &fuse).unwrap();
    let during = store.read().unwrap();
    view.commit().unwrap();
    let count = |snapshot: &Snapshot| {
        let section = snapshot.plane(PlaneIndex(0)).unwrap().unwrap();
        (snapshot.views().unwrap().len(), section.curve_records().len())
    };
    assert_eq!(count(&during), (1, 1));
    assert_eq!(count(&store.read().unwrap()), (2, 2));
    std::thread::scope(|scope| {
        scope.spawn(|| assert_eq!(count(&during), (1, 1)));
    });
    for blocked in [store.compact().map(|_| ()), store.verify().map(|_| ())] {
        assert!(matches!(blocked.unwrap_err().problem, StoreProblem::Readers));
    }
    drop(during);
    store.compact().unwrap();
    store.verify().unwrap();
}

#[test]
fn what_cannot_be_done_says_why_and_changes_nothing() {
    let (_, store) = memory_store();
    add(&store, "a", &vec![(PlaneIndex(0), square(0.0))]).unwrap();
    let before = export(&store);
    let again = add(&store, "a", &Vec::new()).unwrap_err();
    assert!(matches!(again.problem, StoreProblem::ViewExists(_)), "{again}");
    let missing = store.remove_view(&"z".into(), &fuse).unwrap_err();
    let text = missing.to_string();
    assert!(text.starts_with("the model store ") && text.ends_with(" has no view \"z\""), "{text}");
    assert!(std::error::Error::source(&missing).is_none(), "its text holds all");
    let lost = ViewDescription { sigma: Some(f64::NAN), ..entry("b") };
    let lost = store.begin_view(lost).unwrap_err();
    assert!(matches!(lost.problem, StoreProblem::Invariant(_)), "{lost}");
    assert!(lost.to_string().ends_with(" would be invalid"), "{lost}");
    let cause = std::error::Error::source(&lost).map(ToString::to_string);
    assert!(cause.is_some_and(|cause| cause.contains("NaN")), "the cause follows the text");

    let mut view = store.begin_view(entry("b")).unwrap();
    let busy = store.begin_view(entry("c")).unwrap_err();
    assert!(matches!(busy.problem, StoreProblem::Busy));
    view.add_planes([(PlaneIndex(1), square(0.0))], &fuse).unwrap();
    let twice = view.add_planes([(PlaneIndex(1), square(1.0))], &fuse).unwrap_err();
    assert!(matches!(twice.problem, StoreProblem::PlaneTwice(PlaneIndex(1))));
    assert!(matches!(view.commit().unwrap_err().problem, StoreProblem::Failed));
    assert_eq!(export(&store), before);
}

#[test]
fn extreme_planes_and_ids_are_planes_and_ids() {
    let (_, mut store) = memory_store();
    let ends = [i64::MIN, 0, i64::MAX].map(|k| (PlaneIndex(k), vec![strip()]));
    for id in ["", "ü\u{10ffff}", "\0"] {
        add(&store, id, &ends.to_vec()).unwrap();
    }
    assert_eq!(store.verify().unwrap().partial_curves, 9);
    assert_eq!(store.read().unwrap().partials(PlaneIndex(i64::MAX)).unwrap().len(), 3);
    store.remove_view(&"".into(), &fuse).unwrap();
    assert_eq!(store.verify().unwrap().views, 2);
}

#[test]
fn world_sized_coordinates_keep_every_bit() {
    let (_, store) = memory_store();
    let (x, y) = (500_000.000_001, 5_400_000.000_001);
    let far = vec![polyline(&[(x, y), (x + 1e-6, y), (x, y + 1e-6)], true)];
    add(&store, "utm", &vec![(PlaneIndex(0), far.clone())]).unwrap();
    assert_eq!(store.read().unwrap().partials(PlaneIndex(0)).unwrap(), [("utm".into(), far)]);
}

#[test]
fn compaction_gives_space_back() {
    let (memory, mut store) = memory_store();
    let large: Vec<_> = (0..20_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
    let planes: Curves = (0..8).map(|k| (PlaneIndex(k), vec![polyline(&large, false)])).collect();
    add(&store, "a", &planes).unwrap();
    add(&store, "b", &vec![(PlaneIndex(0), square(0.0))]).unwrap();
    let full = memory.image().len();
    store.remove_view(&"a".into(), &fuse).unwrap();
    let before = export(&store);
    assert!(store.compact().unwrap());
    let compact = memory.image().len();
    assert!(compact * 2 < full, "{compact} of {full} bytes");
    assert_eq!(export(&store), before);
    drop(store);
    let again = Store::open_in(Path::new("memory"), Memory::of(memory.image())).unwrap();
    assert_eq!(export(&again), before);
}

#[test]
fn readers_share_a_file_and_leave_its_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("store");
    let store = Store::create(&path, &header()).unwrap();
    add(&store, "a", &vec![(PlaneIndex(0), square(0.0)), (PlaneIndex(1), vec![strip()])]).unwrap();
    let mut view = store.begin_view(entry("b")).unwrap();
    view.defer_planes([(PlaneIndex(1), square(3.0))]).unwrap();
    view.commit().unwrap();
    let refused = Store::open_read_only(&path).unwrap_err();
    assert!(matches!(refused.problem, StoreProblem::InUse), "{refused:?}");
    store.close().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    // A reader must not need the permission to write.
    let writable = std::fs::metadata(&path).unwrap().permissions();
    let mut permissions = writable.clone();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).unwrap();

    let (mut first, second) =
        (Store::open_read_only(&path).unwrap(), Store::open_read_only(&path).unwrap());
    assert_eq!(first.verify().unwrap().pending, 1);
    assert_eq!(first.fuse_pending(&fuse).unwrap(), 1);
    assert_eq!(
        first.read().unwrap().plane(PlaneIndex(1)).unwrap().unwrap().curve_records().len(),
        2
    );
    assert!(matches!(
        second.read().unwrap().plane(PlaneIndex(1)).unwrap_err().problem,
        StoreProblem::Pending(1)
    ));
    assert_eq!(second.views().unwrap().len(), 2);
    first.remove_view(&"a".into(), &fuse).unwrap();
    first.compact().unwrap();
    first.close().unwrap();
    std::fs::set_permissions(&path, writable).unwrap();
    let refused = Store::open(&path).unwrap_err();
    assert!(matches!(refused.problem, StoreProblem::BeingRead), "{refused:?}");
    drop(second);
    assert!(std::fs::read(&path).unwrap() == bytes);
    assert_eq!(Store::open(&path).unwrap().views().unwrap().len(), 2);
}

#[test]
fn a_whole_model_is_no_store_and_a_store_no_whole_model() {
    let folder = tempfile::tempdir().unwrap();
    let (model, store) = (folder.path().join("model"), folder.path().join("store"));
    crate::samples::small().save(&model).unwrap();
    let refused = Store::open(&model).unwrap_err();
    assert!(matches!(
        refused.problem,
        StoreProblem::Damaged(CodecError::WrongVersion { found: crate::SCHEMA_VERSION, .. })
    ));
    Store::create(&store, &header()).unwrap();
    let refused = crate::Model::load(&store).unwrap_err();
    let cause = std::error::Error::source(&refused).unwrap().to_string();
    let (store, model) = (STORE_VERSION, crate::SCHEMA_VERSION);
    let versions = format!("the file has format version {store}; version {model} is read here");
    assert!(cause.starts_with(&versions), "{cause}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn questions_to_a_store_are_answered_like_those_to_its_model(
        curves in curves(), capacity in 0..60usize,
        points in prop::collection::vec((-4.0..4.0, -2.0..2.0, -2.5..2.5), 1..40),
    ) {
        let (_, store) = memory_store();
        add(&store, "a", &curves).unwrap();
        let snapshot = store.read().unwrap();
        let model = snapshot.model().unwrap();
        prop_assert_eq!(snapshot.volume().unwrap(), model.volume());
        let mut query = SpaceQuery::new(snapshot, capacity);
        for (x, y, z) in points {
            let p = transect_geometry::Point3::new(x, y, z);
            prop_assert_eq!(query.locate(&p).unwrap(), model.locate(&p), "{}", p);
        }
    }
}

#[test]
fn only_planes_that_a_view_touches_are_fused() {
    let (_, store) = memory_store();
    let planes = |range: std::ops::Range<i64>| -> Curves {
        range.map(|k| (PlaneIndex(k), square(k as f64))).collect()
    };
    add(&store, "a", &planes(0..50)).unwrap();
    let fused = std::cell::RefCell::new(Vec::new());
    let counting = |plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]| {
        fused.borrow_mut().push((plane.0, partials.len()));
        fuse(plane, partials)
    };
    let mut view = store.begin_view(entry("b")).unwrap();
    view.add_planes(planes(48..51), &counting).unwrap();
    view.commit().unwrap();
    assert_eq!(fused.take(), [(48, 2), (49, 2), (50, 1)]);
    let planes = planes(49..50);
    let same = ViewReplacement { id: "b".into(), entry: entry("b"), copy: None, planes };
    store.replace_views(vec![same], &counting).unwrap();
    assert_eq!(fused.take(), [(48, 1), (49, 2)]);
    store.remove_view(&"b".into(), &counting).unwrap();
    assert_eq!(fused.take(), [(49, 1)]);
    assert_eq!(store.read().unwrap().plane(PlaneIndex(50)).unwrap(), None);
}
