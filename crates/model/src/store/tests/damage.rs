//! Damaged files: the store as it was, or an error; never another store, never a panic.

use super::*;
use proptest::test_runner::{RngAlgorithm, TestRng};

/// A small store that went through removals, closed in good order.
fn image() -> (Vec<u8>, String) {
    let (memory, store) = memory_store();
    for (id, x) in [("a", 0.0), ("b", 2.0), ("c", 4.0)] {
        let curves = (0..6).map(|k| (PlaneIndex(k), square(x))).collect();
        add(&store, id, &curves).unwrap();
    }
    store.remove_view(&"b".into(), &fuse).unwrap();
    let text = export(&store);
    store.close().unwrap();
    (memory.image(), text)
}

/// Opens a store, reads and verifies all of it.
fn read_all(bytes: Vec<u8>) -> Result<(Store, String), StoreProblem> {
    let mut store = Store::open_in(Path::new("memory"), Memory::of(bytes))?;
    let mut text = Vec::new();
    store.export(&mut text).map_err(|e| e.problem)?;
    store.verify().map_err(|e| e.problem)?;
    Ok((store, String::from_utf8(text).unwrap()))
}

/// Changes a store and closes it.
fn change(store: Store) -> Result<(), StoreError> {
    add(&store, "later", &vec![(PlaneIndex(2), square(9.0))])?;
    store.remove_view(&"later".into(), &fuse)?;
    store.close()
}

/// Places that matter: a block that was never written is behind none of the database's references.
fn written_places(bytes: &[u8]) -> Vec<usize> {
    (0..bytes.len()).filter(|&i| bytes[i] != 0).collect()
}

fn mutate(bytes: &mut Vec<u8>, places: &[usize], rng: &mut TestRng) {
    for _ in 0..rng.random_range(1..=3) {
        let place = places[rng.random_range(0..places.len())].min(bytes.len() - 1);
        let end = (place + rng.random_range(1..600)).min(bytes.len());
        match rng.random_range(0..6) {
            0 | 1 => bytes[place] ^= 1 << rng.random_range(0..8),
            2 => bytes[place] = rng.random_range(0..=255) as u8,
            3 => bytes[place..end].fill(0),
            4 => {
                let from = rng.random_range(0..bytes.len() - (end - place));
                bytes.copy_within(from..from + (end - place), place);
            }
            _ => bytes.truncate(place.max(1)),
        }
    }
}

#[test]
fn an_undamaged_file_is_used_as_it_is() {
    let (bytes, text) = image();
    let (store, read) = read_all(bytes).unwrap();
    assert_eq!(read, text);
    change(store).unwrap();
}

#[test]
fn ten_thousand_mutated_files_are_the_same_store_or_an_error() {
    let (bytes, text) = image();
    let places = written_places(&bytes);
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let (mut refused, mut intact) = (0, 0);
    for round in 0..10_000 {
        let mut changed = bytes.clone();
        mutate(&mut changed, &places, &mut rng);
        match read_all(changed) {
            Ok((store, read)) => {
                assert_eq!(read, text, "round {round}");
                // Free pages are only read when they are used again, and may be refused then.
                let _ = change(store);
                intact += 1;
            }
            Err(_) => refused += 1,
        }
    }
    // Free pages and one copy of the head may be damaged without harm.
    assert!(refused > 1000 && intact > 100, "{refused} refused, {intact} intact");
}

#[test]
fn truncated_files_say_so() {
    let (bytes, _) = image();
    for length in (0..bytes.len()).step_by(997) {
        match read_all(bytes[..length].to_vec()).map(|(_, text)| text) {
            Err(StoreProblem::Damaged(CodecError::NotAModel | CodecError::Truncated { .. })) => (),
            other => panic!("{length} bytes: {other:?}"),
        }
    }
}
