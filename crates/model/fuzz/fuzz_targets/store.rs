//! Any bytes as a model store: an error, or a store that can be read, verified and exported.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::io::Write;
use transect_model::store::Store;

fuzz_target!(|bytes: &[u8]| {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    file.as_file().write_all(bytes).expect("room for it");
    let Ok(mut store) = Store::open(file.path()) else { return };
    let _ = store.views();
    let mut text = Vec::new();
    let exported = store.export(&mut text).is_ok();
    let verified = store.verify().is_ok();
    if exported && verified {
        let copy = file.path().with_extension("copy");
        let imported = Store::import(&copy, text.as_slice());
        let _ = std::fs::remove_file(&copy);
        let mut again = Vec::new();
        imported.expect("what was verified can be imported").export(&mut again).expect("and exported");
        assert!(text == again);
    }
});
