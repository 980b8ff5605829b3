//! Orders that look random and are always the same.

/// A number that looks random, different for every input (multiplication by an odd number is a
/// bijection; the constants are those of a common integer hash).
pub fn scrambled(k: u32) -> u32 {
    let x = (k ^ (k >> 16)).wrapping_mul(0x45d9_f3b5);
    (x ^ (x >> 16)).wrapping_mul(0x45d9_f3b5)
}
