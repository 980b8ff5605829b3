//! The test for range jumps in the sweep, many pairs of neighbouring pixels at a time.
//!
//! `transect-image` makes the numbers of the tests ([`PairTest`]). The inner loop is here, because
//! a vector type in the interface of a crate would bind its users to one library.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use transect_image::PairTest;

/// A test of pairs side by side.
pub(super) trait TestPairs<S: Simd>: Copy {
    /// Whether samples `a` and their neighbours `b` belong to one surface, one bit per pair;
    /// `column` is that of the first pair. A missing pixel is NaN, and its pairs are never joined.
    fn holds(&self, simd: S, a: S::f32s, b: S::f32s, column: usize) -> u64;
}

impl<S: Simd> TestPairs<S> for PairTest<'_> {
    #[inline(always)]
    fn holds(&self, simd: S, a: S::f32s, b: S::f32s, column: usize) -> u64 {
        let of = |row: f32, table: usize| {
            let columns = self.columns.and_then(|c| c[table].get(column..column + S::f32s::LEN));
            columns.map_or(S::f32s::splat(simd, row), |c| S::f32s::from_slice(simd, c) + row)
        };
        let here = of(self.here, 0);
        let along = (b * of(self.other, 1) - a * here).abs();
        let limit = b * of(self.across, 2);
        along.simd_le(limit + here.sqrt() * self.slack).to_bitmask()
    }
}

/// The test of a row that [is uniform](PairTest::is_uniform), with fewer operations.
#[derive(Debug, Clone, Copy)]
pub(super) struct UniformTest<S: Simd> {
    other: S::f32s,
    across: S::f32s,
    slack: S::f32s,
}

impl<S: Simd> UniformTest<S> {
    /// The same test as a uniform one of a row.
    #[inline(always)]
    pub fn new(simd: S, test: &PairTest<'_>) -> Self {
        let [other, across, slack] =
            [test.other, test.across, test.slack].map(|v| S::f32s::splat(simd, v));
        Self { other, across, slack }
    }
}

impl<S: Simd> TestPairs<S> for UniformTest<S> {
    #[inline(always)]
    fn holds(&self, _: S, a: S::f32s, b: S::f32s, _: usize) -> u64 {
        (b * self.other - a).abs().simd_le(b * self.across + self.slack).to_bitmask()
    }
}
