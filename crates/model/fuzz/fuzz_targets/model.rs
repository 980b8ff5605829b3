//! Any bytes as a plain model file: an error, or a model that keeps every promise and can be asked.
#![no_main]

use libfuzzer_sys::fuzz_target;
use transect_model::Model;

/// Where the payload begins, and its length and hash before it.
const HEADER: usize = 28;

fuzz_target!(|bytes: &[u8]| {
    check(bytes);
    // Few mutations would get past the hash, so it is also made right.
    if bytes.len() >= HEADER {
        check(&with_right_hash(bytes));
    }
});

fn check(bytes: &[u8]) {
    let Ok(model) = Model::from_reader(bytes) else { return };
    model.check().expect("a model that was read is sound");
    for (_, section) in model.sections() {
        let _ = (section.measures(), section.known_solid());
    }
    let _ = model.volume();
    let mut again = Vec::new();
    model.to_writer(&mut again).expect("a model that was read can be written");
    let read = Model::from_reader(again.as_slice()).expect("and read again");
    let mut twice = Vec::new();
    read.to_writer(&mut twice).expect("and written again");
    assert!(again == twice);
}

fn with_right_hash(bytes: &[u8]) -> Vec<u8> {
    let payload = &bytes[HEADER..];
    let fnv = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let hash = payload.iter().fold(0xcbf2_9ce4_8422_2325, fnv);
    let mut right = bytes[..12].to_vec();
    right.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    right.extend_from_slice(&hash.to_le_bytes());
    right.extend_from_slice(payload);
    right
}
