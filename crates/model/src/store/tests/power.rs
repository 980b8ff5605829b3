//! Power cuts at every moment, with and without what had not reached the disk, and full disks.

use super::test_media::{Operation, apply};
use super::*;
use proptest::test_runner::{RngAlgorithm, TestRng};
use std::sync::{Arc, Mutex};

const VIEWS: usize = 5;

fn curves_of(view: usize) -> Curves {
    // Neighbouring views share planes, and large values span several pages.
    let nodes: Vec<_> = (0..300 * view).map(|i| (i as f64, view as f64)).collect();
    let long = || polyline(&[&[(0.0, 1.0), (1.0, 1.0)][..], &nodes].concat(), false);
    (0..4).map(|k| (PlaneIndex((k + view) as i64), vec![long(), strip()])).collect()
}

/// Adds the views that are missing.
fn finish(store: &Store) {
    let there = store.views().unwrap().len();
    for view in there..VIEWS {
        add(store, &format!("view-{view}"), &curves_of(view)).unwrap();
    }
}

/// What is done to the medium while views are added, the exports after each, and the last one.
fn recorded() -> (Vec<Operation>, Vec<String>) {
    let log = Arc::new(Mutex::new(Vec::new()));
    let memory = Memory { log: Some(Arc::clone(&log)), ..Memory::default() };
    let store = Store::create_in(Path::new("memory"), memory, &header()).unwrap();
    let begin = log.lock().unwrap().len();
    let mut exports = vec![export(&store)];
    for view in 0..VIEWS {
        add(&store, &format!("view-{view}"), &curves_of(view)).unwrap();
        exports.push(export(&store));
    }
    drop(store);
    let mut operations = log.lock().unwrap().clone();
    // Creation is made whole by renaming the file, so no power cut can fall into it.
    operations.insert(begin, Operation::Sync);
    operations.splice(..0, [Operation::SetLen(begin as u64)]);
    (operations, exports)
}

fn check(bytes: Vec<u8>, exports: &[String], at: &str) -> usize {
    let opened = Store::open_in(Path::new("memory"), Memory::of(bytes));
    let mut store = opened.unwrap_or_else(|problem| panic!("{at}: {problem:?}"));
    store.verify().unwrap_or_else(|error| panic!("{at}: {error:?}"));
    let views = store.views().unwrap().len();
    assert_eq!(export(&store), exports[views], "{at}");
    finish(&store);
    assert_eq!(export(&store), exports[VIEWS], "{at}");
    views
}

#[test]
fn after_a_power_cut_a_whole_number_of_views_is_there() {
    let (operations, exports) = recorded();
    let Operation::SetLen(begin) = operations[0] else { panic!("not what was recorded") };
    let (begin, operations) = (begin as usize, &operations[1..]);
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut seen = [0; VIEWS + 1];
    for end in begin + 1..=operations.len() {
        let synced = operations[..end].iter().rposition(|o| matches!(o, Operation::Sync)).unwrap();
        // All of what was not synced reached the disk, none of it, or any part of it.
        let chance = [100, 0, 50][end % 3];
        let mut bytes = Vec::new();
        operations[..synced].iter().for_each(|o| apply(&mut bytes, o));
        let survives = |_: &&Operation| rng.random_range(0..100) < chance;
        let rest: Vec<_> = operations[synced..end].iter().filter(survives).collect();
        rest.into_iter().for_each(|o| apply(&mut bytes, o));
        seen[check(bytes, &exports, &format!("operation {end}, {chance} %"))] += 1;
    }
    assert!(seen.iter().all(|&count| count > 0), "{seen:?}");
}

#[test]
fn a_full_disk_is_an_error_and_loses_nothing() {
    let (_, exports) = recorded();
    let mut refused = 0;
    for kibibytes in (1100..3000).step_by(60) {
        let capacity = Arc::new(Mutex::new(u64::MAX));
        let memory = Memory { capacity: Some(Arc::clone(&capacity)), ..Memory::default() };
        let store = Store::create_in(Path::new("memory"), memory.clone(), &header()).unwrap();
        *capacity.lock().unwrap() = kibibytes << 10;
        let failed =
            (0..VIEWS).find_map(|v| add(&store, &format!("view-{v}"), &curves_of(v)).err());
        if let Some(error) = failed {
            let full = |e: &std::io::Error| e.kind() == std::io::ErrorKind::StorageFull;
            let StoreProblem::Io(cause) = &error.problem else { panic!("{error:?}") };
            assert!(full(cause), "{error:?}");
            refused += 1;
        }
        drop(store);
        check(memory.image(), &exports, &format!("{kibibytes} KiB"));
    }
    assert!(refused > 2, "the disk was never full");
}
