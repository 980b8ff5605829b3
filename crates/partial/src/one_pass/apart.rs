//! Keeps an inner loop out of the function that calls it, for speed.

use fearless_simd::Simd;

/// Runs a loop as a function of its own, with the same instructions: in one function with all the
/// other loops, it would have too few registers.
#[inline(never)]
pub(super) fn apart<S: Simd, R>(simd: S, act: impl FnOnce() -> R) -> R {
    simd.vectorize(act)
}
