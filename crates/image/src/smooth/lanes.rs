//! Several pixels side by side, one number each, in the vectors that the processor has.
//!
//! Multiplications and additions are never contracted and their order is fixed, so every
//! instruction set gives the same bits.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

/// Pixels whose connected windows are found together, with every instruction set.
pub(super) const LANES: usize = 8;

/// The most pixels that any instruction set takes together.
pub(super) const MOST: usize = 16;

/// One number per pixel, for as many pixels as a vector of the processor holds.
pub(super) type Native<S> = <S as Simd>::f32s;

/// The same number for all pixels.
#[inline(always)]
pub(super) fn all<S: Simd>(simd: S, value: f32) -> Native<S> {
    Native::<S>::splat(simd, value)
}

/// Each number, or 0 where it is negative.
#[inline(always)]
pub(super) fn positive<S: Simd>(simd: S, numbers: Native<S>) -> Native<S> {
    numbers.max(all(simd, 0.0))
}

/// `1 / number` where the number exceeds a bound, else 0.
#[inline(always)]
pub(super) fn inverse_above<S: Simd>(simd: S, numbers: Native<S>, bound: Native<S>) -> Native<S> {
    numbers.simd_gt(bound).select(all(simd, 1.0) / numbers, all(simd, 0.0))
}
