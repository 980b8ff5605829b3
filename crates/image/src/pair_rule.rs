//! The test for range jumps, many pairs of neighbouring pixels at a time.
//!
//! A sensor with tables ([`RayProducts`]) has [`PairTests`]: the rule as products of a number of
//! the row and one of the column. Arithmetic is `f32`, and multiplications and additions are never
//! contracted, so every instruction set gives the same bits.

use crate::BreakRule;
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use transect_device::{RayProduct, RayProducts};

/// The test for range jumps with one kind of neighbour, for all rows.
#[derive(Debug, Clone)]
pub struct PairTests {
    rows: Vec<[f32; 3]>,
    columns: Option<[Vec<f32>; 3]>,
    slack: f32,
}

impl PairTests {
    /// The tests of a sensor with `cols` columns from its table.
    pub fn new(products: &RayProducts, rule: &BreakRule, cols: usize) -> Self {
        let terms = |p: &RayProduct| [p.here, p.other, p.across * rule.tan_incidence()];
        let columns = (!products.columns.is_empty()).then(|| {
            [0, 1, 2].map(|k| padded(products.columns.iter().map(|p| terms(p)[k]).collect(), cols))
        });
        let rows = products.rows.iter().map(terms).collect();
        Self { rows, columns, slack: rule.slack() }
    }

    /// The test of one row; a row outside the image has no joined pair.
    pub fn at(&self, row: usize) -> PairTest<'_> {
        let [here, other, across] = self.rows.get(row).copied().unwrap_or([f32::NAN; 3]);
        let columns = self.columns.as_ref().map(|c| c.each_ref().map(Vec::as_slice));
        PairTest { here, other, across, slack: self.slack, columns }
    }
}

/// The test of one row: `|b · other − a · here| ≤ b · across + slack · √here`.
///
/// Each of the three products is the sum of a number of the row and one of the column. `across`
/// holds the rule's tangent.
#[derive(Debug, Clone, Copy)]
pub struct PairTest<'a> {
    here: f32,
    other: f32,
    across: f32,
    slack: f32,
    columns: Option<[&'a [f32]; 3]>,
}

impl PairTest<'_> {
    /// Whether all rays have length 1 and all neighbours of the row the same angle between them.
    pub fn is_uniform(&self) -> bool {
        self.columns.is_none() && self.here == 1.0
    }
}

/// A test of pairs side by side.
pub trait TestPairs<S: Simd>: Copy {
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
pub struct UniformTest<S: Simd> {
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

/// A table of columns, filled up with zeros to whole words of 64.
pub fn padded(mut table: Vec<f32>, cols: usize) -> Vec<f32> {
    table.resize(cols.next_multiple_of(64), 0.0);
    table
}
