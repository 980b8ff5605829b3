//! Contents that no transaction would write, behind right checksums.

use super::*;
use crate::codec::HASH_OF_NOTHING;
use crate::codec::values::hash_piece;
use crate::store::tables::{encode_curves, encode_fused};
use redb::TableDefinition;

fn stored() -> Store {
    let (_, store) = memory_store();
    for id in ["a", "b"] {
        add(&store, id, &vec![(PlaneIndex(0), square(0.0)), (PlaneIndex(1), vec![strip()])])
            .unwrap();
    }
    store
}

/// Writes past the drivers.
fn forge(store: &Store, change: impl FnOnce(&WriteTransaction)) {
    let transaction = store.write().unwrap();
    change(&transaction);
    transaction.commit().unwrap();
}

fn verdict(change: impl FnOnce(&WriteTransaction)) -> StoreProblem {
    let mut store = stored();
    store.verify().unwrap();
    forge(&store, change);
    store.verify().unwrap_err().problem
}

fn unsound(change: impl FnOnce(&WriteTransaction)) -> String {
    match verdict(change) {
        StoreProblem::Unsound(problem) => problem,
        other => panic!("not found unsound: {other:?}"),
    }
}

fn put_partial(plane: i64, id: &str, bytes: &[u8]) -> impl FnOnce(&WriteTransaction) {
    move |t| _ = t.open_table(PARTIALS).unwrap().insert((plane, id), bytes).unwrap()
}

fn put_fused(plane: i64, bytes: Vec<u8>) -> impl FnOnce(&WriteTransaction) {
    move |t| _ = t.open_table(FUSED).unwrap().insert(plane, bytes.as_slice()).unwrap()
}

#[test]
fn verifying_finds_every_broken_promise() {
    let curves = encode_curves(&square(3.0)).unwrap();
    for (problem, found) in [
        (
            "plane 0 was fused from other curves than those in the store",
            unsound(put_partial(0, "a", &curves)),
        ),
        ("plane 7 was not fused", unsound(put_partial(7, "a", &curves))),
        (
            "there are fused curves or marks on planes without partial curves",
            unsound(put_fused(7, encode_fused(0, &square(0.0)).unwrap())),
        ),
        (
            "there are fused curves or marks on planes without partial curves",
            unsound(|t| _ = t.open_table(tables::PENDING).unwrap().insert(7, ()).unwrap()),
        ),
        (
            "there are curves of a view b, which has no record",
            unsound(|t| drop(t.open_table(VIEWS).unwrap().remove("b").unwrap())),
        ),
        (
            "plane 1 was not fused",
            unsound(|t| drop(t.open_table(FUSED).unwrap().remove(1).unwrap())),
        ),
    ] {
        assert_eq!(found, problem);
    }
}

#[test]
fn verifying_counts_the_curves_of_every_view() {
    let forged = |change: fn(&mut StoredView)| {
        move |t: &WriteTransaction| {
            let mut views = t.open_table(VIEWS).unwrap();
            let mut view = tables::read_view(&views, &"b".into()).unwrap().unwrap();
            change(&mut view);
            views.insert("b", view.encode().unwrap().as_slice()).unwrap();
        }
    };
    let wrong = "the curves of view b are not those in its record";
    assert_eq!(unsound(forged(|view| view.nodes += 1)), wrong);
    assert_eq!(unsound(forged(|view| view.curves -= 1)), wrong);
    assert_eq!(unsound(forged(|view| view.planes.truncate(1))), wrong);
    let order = unsound(forged(|view| view.planes.reverse()));
    assert_eq!(order, "view b lists its planes out of order");
    let lost = verdict(forged(|view| view.entry.sigma = Some(-1.0)));
    assert!(matches!(lost, StoreProblem::Invariant(_)), "{lost:?}");
}

#[test]
fn fused_curves_that_fusion_would_not_make_are_stale() {
    let store = stored();
    let snapshot = store.read().unwrap();
    let made_of = tables::read_partials(&snapshot.partials, PlaneIndex(1)).unwrap();
    let by_hand = made_of.by_view.iter().fold(HASH_OF_NOTHING, |hash, (id, curves)| {
        hash_piece(hash_piece(hash, id.0.as_bytes()), &encode_curves(curves).unwrap())
    });
    assert_eq!(made_of.hash, by_hand);
    forge(&store, put_fused(1, encode_fused(made_of.hash, &square(0.0)).unwrap()));
    assert_eq!(store.read().unwrap().stale_planes(&fuse).unwrap(), [PlaneIndex(1)]);
}

#[test]
fn hostile_lengths_in_values_set_no_memory_aside() {
    // 253 announces a 64-bit integer: a list, or a text, of 2^60 items.
    let wild = [&[253][..], &(1_u64 << 60).to_le_bytes()].concat();
    // One curve of 2^60 nodes; the hash of what fused curves were made of, then 2^60 curves.
    let wild_curve = [&[1][..], &wild].concat();
    let wild_fused = [&[0][..], &wild].concat();
    let text = |table: TableDefinition<'static, &'static str, &'static [u8]>, key: &'static str| {
        let bytes = wild.clone();
        move |t: &WriteTransaction| {
            t.open_table(table).unwrap().insert(key, bytes.as_slice()).unwrap();
        }
    };
    for (what, found) in [
        ("partial model of view a on plane 0", verdict(put_partial(0, "a", &wild))),
        ("partial model of view a on plane 0", verdict(put_partial(0, "a", &wild_curve))),
        ("partial model of view a on plane 0", verdict(put_partial(0, "a", &[]))),
        ("section on plane 0", verdict(put_fused(0, wild_fused))),
        ("view b", verdict(text(VIEWS, "b"))),
    ] {
        let StoreProblem::Value { what: named, .. } = &found else { panic!("{found:?}") };
        assert_eq!(named, what);
    }
    let unread = verdict(text(HEADER, "header"));
    assert!(matches!(unread, StoreProblem::Value { .. }), "{unread:?}");
}

#[test]
fn random_values_are_refused_or_sound() {
    use proptest::test_runner::{RngAlgorithm, TestRng};
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let sound = encode_curves(&[square(0.0), vec![strip()]].concat()).unwrap();
    let mut accepted = 0;
    for _ in 0..2000 {
        let mut bytes = sound.clone();
        for _ in 0..rng.random_range(1..4) {
            let place = rng.random_range(0..bytes.len());
            bytes[place] = rng.random_range(0..=255) as u8;
        }
        if let Ok(curves) = tables::decode_curves(PlaneIndex(0), "a", &bytes) {
            // Sound means usable: these would panic on a malformed curve.
            let _ = Section::new(curves).map(|section| (section.measures(), section.known_solid()));
            accepted += 1;
        }
    }
    assert!(accepted > 0, "the changes never reach past the decoder");
}
