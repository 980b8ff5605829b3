//! libFuzzer on one reader, which the environment variable `TRANSECT_FUZZ_TARGET` names:
//!
//! ```text
//! cd crates/exchange
//! TRANSECT_FUZZ_TARGET=ply_mesh cargo +nightly fuzz run readers fuzz/corpus/ply_mesh
//! ```
//!
//! Files that it finds belong into the corpus. The test `fuzzed_files_are_survived` reads them.
#![no_main]

#[path = "../tests/it/fuzz/targets.rs"]
mod targets;

use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;
use targets::{STORE_LINES, TARGETS, Target};
use tempfile::TempDir;

static TARGET: LazyLock<(Target, TempDir)> = LazyLock::new(|| {
    let wanted = std::env::var("TRANSECT_FUZZ_TARGET").unwrap_or_default();
    let mut known = TARGETS.into_iter().chain([STORE_LINES]);
    let found = known.find(|(name, _)| *name == wanted);
    let (_, target) = found.unwrap_or_else(|| panic!("TRANSECT_FUZZ_TARGET={wanted:?} is no target"));
    (target, tempfile::tempdir().unwrap())
});

fuzz_target!(|bytes: &[u8]| {
    let (target, folder) = &*TARGET;
    // An error is a good answer.
    let _ = target(folder.path(), bytes);
});
