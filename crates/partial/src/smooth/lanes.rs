//! Several pixels side by side, one number each, in whatever vectors the processor has.
//!
//! Multiplications and additions are never contracted and their order is fixed, so every instruction
//! set gives the same bits.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// Pixels that are taken together where every instruction set takes the same number.
pub(super) const LANES: usize = 8;

/// The most pixels that any instruction set takes together.
pub(super) const MOST: usize = 16;

/// One number per pixel, for as many pixels as the processor has room for.
pub(super) type Native<S> = <S as Simd>::f32s;

/// One number per pixel.
pub(super) type Lanes<S> = f32x8<S>;

/// The same number for all pixels.
#[inline(always)]
pub(super) fn all<S: Simd>(simd: S, value: f32) -> Lanes<S> {
    Lanes::splat(simd, value)
}

/// Each number, or 0 where it is negative.
#[inline(always)]
pub(super) fn positive<S: Simd>(simd: S, numbers: Native<S>) -> Native<S> {
    numbers.max(Native::<S>::splat(simd, 0.0))
}

/// `1 / lanes` where the number exceeds a bound, else 0.
#[inline(always)]
pub(super) fn inverse_above<S: Simd>(simd: S, numbers: Native<S>, bound: Native<S>) -> Native<S> {
    let [one, zero] = [1.0, 0.0].map(|number| Native::<S>::splat(simd, number));
    numbers.simd_gt(bound).select(one / numbers, zero)
}
