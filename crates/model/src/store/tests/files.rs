//! Files of stores: made by one process alone, locked, and opened again.

use super::*;

#[test]
fn files_are_created_locked_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.transect");
    let store = Store::create(&path, &header()).unwrap();
    add(&store, "a", &vec![(PlaneIndex(0), square(0.0))]).unwrap();
    let second = Store::open(&path).unwrap_err();
    assert!(matches!(second.problem, StoreProblem::InUse));
    assert!(second.to_string().contains("room.transect"), "{second}");
    let before = export(&store);
    store.close().unwrap();
    let store = Store::open(&path).unwrap();
    assert_eq!(export(&store), before);
    let exists = Store::create(&path, &header()).unwrap_err();
    assert!(matches!(exists.problem, StoreProblem::Exists));
    for open in [Store::open, Store::open_read_only] {
        let refused = open(folder.path().to_owned()).unwrap_err();
        let StoreProblem::Io(refused) = refused.problem else { panic!("{refused:?}") };
        let refused = refused.to_string();
        assert!(refused.contains("a folder, where a regular file was expected"), "{refused}");
    }
    let missing = Store::open(folder.path().join("missing")).unwrap_err();
    assert!(matches!(missing.problem, StoreProblem::Io(_)));
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1);
}

#[test]
fn of_stores_that_are_made_at_once_one_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.transect");
    for _ in 0..20 {
        let together = std::sync::Barrier::new(4);
        let make = || {
            together.wait();
            let store = Store::create(&path, &header())?;
            add(&store, "a", &vec![(PlaneIndex(0), square(0.0))]).unwrap();
            store.close()
        };
        let made: Vec<Result<(), StoreError>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(make)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let problems = made.into_iter().filter_map(|made| made.err().map(|e| e.problem));
        let problems: Vec<StoreProblem> = problems.collect();
        assert!(problems.iter().all(|p| matches!(p, StoreProblem::Exists)), "{problems:?}");
        assert_eq!(problems.len(), 3);
        assert_eq!(Store::open(&path).unwrap().views().unwrap().len(), 1);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
