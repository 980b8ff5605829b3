//! Several pixels side by side, one number each, in whatever vectors the processor has.
//!
//! Multiplications and additions are never contracted and their order is fixed, so every instruction
//! set gives the same bits.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// Pixels that are fitted together.
pub(super) const LANES: usize = 8;

/// One number per pixel.
pub(super) type Lanes<S> = f32x8<S>;

/// The same number for all pixels.
#[inline(always)]
pub(super) fn all<S: Simd>(simd: S, value: f32) -> Lanes<S> {
    Lanes::splat(simd, value)
}

/// Each number, or 0 where it is negative.
#[inline(always)]
pub(super) fn positive<S: Simd>(simd: S, lanes: Lanes<S>) -> Lanes<S> {
    lanes.max(all(simd, 0.0))
}

/// `1 / lanes` where the number exceeds a bound, else 0.
#[inline(always)]
pub(super) fn inverse_above<S: Simd>(simd: S, lanes: Lanes<S>, bound: Lanes<S>) -> Lanes<S> {
    lanes.simd_gt(bound).select(all(simd, 1.0) / lanes, all(simd, 0.0))
}
