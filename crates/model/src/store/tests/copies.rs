//! Coarse copies come, are replaced and leave with their views.

use super::*;

fn squares(planes: std::ops::Range<i64>) -> Curves {
    planes.map(|k| (PlaneIndex(k), square(k as f64))).collect()
}

#[test]
fn a_copy_of_another_image_is_none() {
    let (_, mut store) = memory_store();
    add(&store, "a", &squares(0..2)).unwrap();
    let snapshot = store.read().unwrap();
    assert_eq!(snapshot.copy(&entry("a")).unwrap(), Some(copy("a")));
    assert_eq!(snapshot.copy(&entry("b")).unwrap(), None);
    let replaced = ViewDescription { source_hash: "another".to_owned(), ..entry("a") };
    assert_eq!(snapshot.copy(&replaced).unwrap(), None);
    drop(snapshot);
    store.remove_view(&"a".into(), &fuse).unwrap();
    assert_eq!(store.read().unwrap().copy(&entry("a")).unwrap(), None);
    store.verify().unwrap();
}

#[test]
fn a_store_without_a_table_of_copies_is_read_and_changed() {
    let (_, mut store) = memory_store();
    add(&store, "a", &squares(0..2)).unwrap();
    let transaction = store.write().unwrap();
    transaction.delete_table(COPIES).unwrap();
    transaction.commit().unwrap();
    assert_eq!(store.read().unwrap().copy(&entry("a")).unwrap(), None);
    store.verify().unwrap();
    add(&store, "b", &squares(1..3)).unwrap();
    assert_eq!(store.read().unwrap().copy(&entry("b")).unwrap(), Some(copy("b")));
    store.remove_view(&"a".into(), &fuse).unwrap();
    store.verify().unwrap();
}

#[test]
fn a_copy_without_a_view_is_found() {
    let (_, mut store) = memory_store();
    add(&store, "a", &squares(0..2)).unwrap();
    let transaction = store.write().unwrap();
    crate::store::copy::put(&transaction, &entry("lost"), &copy("lost")).unwrap();
    transaction.commit().unwrap();
    let problem = store.verify().unwrap_err().problem.to_string();
    assert!(problem.contains("a copy of a view lost"), "{problem}");
}
