//! Files from outside may hold anything. Every reader answers with a value or an error that names
//! the file. It never panics, and takes no memory that the file does not justify.
//!
//! The corpus has a folder per target, with sound files and with cases that were found. The test
//! reads all of them, and mutations of them from a fixed seed: the same files on every machine.
//! `TRANSECT_FUZZ_CASES` sets the number of mutations per target. With a nightly compiler and
//! cargo-fuzz, `fuzz/readers.rs` searches further.

mod targets;

use std::path::{Path, PathBuf};
use targets::{STORE_LINES, TARGETS, Target};

/// Mutations per target of a usual test run: some seconds in all.
const CASES: usize = 100;
/// The share of [`CASES`] for the target that makes a store per case.
const STORE_SHARE: usize = 10;
/// Largest growth of the program's memory. The files have at most 16 KiB, so that four times their
/// size is far below what the test program itself needs.
const MOST_MEMORY_KIB: u64 = 64 << 10;
/// Pieces that readers give a meaning to.
const WORDS: [&[u8]; 14] = [
    b"0",
    b"-1",
    b"1e999",
    b"nan",
    b"4294967295",
    b"9999999999999999999",
    b"\n",
    b" ",
    b"{",
    b"]",
    b"null",
    b"\xef\xbb\xbf",
    b"\xff\xff\xff\xff",
    b"\x00\x00\x00\x80",
];

/// A fixed sequence of numbers (splitmix64, S. Vigna).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end.max(1) as u64) as usize
    }
}

/// A file with one to six changes: a byte, a cut, a piece that repeats or goes, a word.
fn mutated(sound: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for _ in 0..=random.below(6) {
        let (at, kind) = (random.below(bytes.len()), random.below(8));
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match kind {
            0 => bytes.truncate(at),
            1 => bytes.extend_from_within(at.min(end)..end),
            2 => drop(bytes.drain(at.min(end)..end)),
            3 | 4 => {
                let word = WORDS[random.below(WORDS.len())];
                let replaced = if kind == 3 { at..at } else { at.min(end)..end };
                drop(bytes.splice(replaced, word.iter().copied()));
            }
            5 => bytes.get_mut(at).into_iter().for_each(|b| *b ^= 1 << random.below(8)),
            6 => {
                bytes.get_mut(at).into_iter().for_each(|b| *b = b"0123456789-.eE"[random.below(14)])
            }
            _ => bytes.get_mut(at).into_iter().for_each(|b| *b = random.below(256) as u8),
        }
    }
    bytes
}

/// The files of a target's corpus in the order of their names.
fn corpus(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
    let entries =
        std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

/// Reads bytes; a panic leaves them in a file, to be added to the corpus.
fn survive(name: &str, target: Target, folder: &Path, bytes: &[u8]) -> Result<(), String> {
    let read = std::panic::AssertUnwindSafe(|| target(folder, bytes));
    std::panic::catch_unwind(read).unwrap_or_else(|_| {
        let found = std::env::temp_dir().join(format!("found-{name}"));
        std::fs::write(&found, bytes).unwrap();
        panic!("{name} panics; move {} into its corpus", found.display());
    })
}

fn run(name: &str, target: Target, cases: usize) {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(20_261_122);
    let files = corpus(name);
    assert!(files.iter().any(|f| is_sound(f)), "{name} has no sound file");
    for file in &files {
        let result = survive(name, target, folder.path(), &std::fs::read(file).unwrap());
        assert!(!is_sound(file) || result.is_ok(), "{}: {result:?}", file.display());
    }
    let sound: Vec<Vec<u8>> = files.iter().map(|f| std::fs::read(f).unwrap()).collect();
    let mut refused = 0;
    for case in 0..cases {
        let bytes = mutated(&sound[case % sound.len()], &mut random);
        refused += usize::from(survive(name, target, folder.path(), &bytes).is_err());
    }
    assert!(cases < 100 || refused > cases / 10, "{name}: only {refused} of {cases} refused");
}

fn is_sound(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name.to_string_lossy().starts_with("sound"))
}

/// Largest memory of this program so far; 0 where the system does not tell.
fn memory_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or_default()
}

#[test]
fn fuzzed_files_are_survived() {
    let cases = std::env::var("TRANSECT_FUZZ_CASES").ok().map_or(CASES, |n| n.parse().unwrap());
    let before = memory_kib();
    for (name, target) in TARGETS {
        run(name, target, cases);
        let grown = memory_kib().saturating_sub(before);
        assert!(grown < MOST_MEMORY_KIB, "{name}: the memory grew by {grown} KiB");
    }
    run(STORE_LINES.0, STORE_LINES.1, cases / STORE_SHARE);
}
