//! What the sweep keeps of one row of pixels, and how it is found: levels, and bit masks of pairs.
//!
//! Arrays have [`PAD`] places before column 0, the last of which stands for the column before it:
//! the last column of a full circle, and a missing pixel otherwise. They reach to the next multiple
//! of 64 columns, where pixels are missing. So inner loops know no special column.
//!
//! Numbers: `f32`, and multiplications and additions are never contracted, so every instruction set
//! gives the same bits.

use super::source::{PairTest, Source};
use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x8, i32x8};
use transect_device::{Neighbour, PairGeometry};

/// Places before column 0.
pub(super) const PAD: usize = 8;
/// Pixels per word of a mask.
const WORD: usize = 64;

/// One bit per pixel: its pair with one of its neighbours.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    /// Both samples belong to one surface.
    pub joined: Vec<u64>,
    /// Joined, and at least one plane passes between the samples.
    pub crossed: Vec<u64>,
    /// Where crossed: number of the crossing at level 0, so that level k has this number plus k.
    pub bases: Vec<u32>,
    /// Number of crossings of all pairs.
    pub count: usize,
}

/// What is kept of one row of pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Row {
    /// The image's values.
    pub values: Vec<f32>,
    /// Level of each pixel; any number where missing.
    pub levels: Vec<f32>,
    /// `ceil` of the level; plane k sees a pixel high if its ceiling exceeds k, so a tie is low.
    pub ceilings: Vec<i32>,
    /// Each pixel's pair with its left neighbour.
    pub left: Pairs,
    /// Each pixel's pair with the one above.
    pub up: Pairs,
    /// Which pixels are valid.
    valid: Vec<u64>,
    /// In-plane coordinates of the pixels, if they do not come from tables and `placed` is set.
    pub places: [Vec<f32>; 2],
    pub placed: bool,
    /// Pairs of valid pixels in this row that are not joined.
    pub jumps: usize,
    geometry: Vec<PairGeometry>,
}

impl Row {
    /// Makes room for a row; what it held is forgotten.
    pub fn fit(&mut self, cols: usize) {
        let words = cols.div_ceil(WORD);
        let places = PAD + words * WORD;
        self.values.clear();
        self.values.resize(places, f32::NAN);
        self.levels.clear();
        self.levels.resize(places, f32::NAN);
        self.ceilings.clear();
        self.ceilings.resize(places, 0);
        self.valid.clear();
        self.valid.resize(words, 0);
        for pairs in [&mut self.left, &mut self.up] {
            for mask in [&mut pairs.joined, &mut pairs.crossed] {
                mask.clear();
                mask.resize(words, 0);
            }
            pairs.bases.clear();
            pairs.bases.resize(places, 0);
            pairs.count = 0;
        }
        self.placed = false;
    }

    /// Reads row `i` of the image; `above` is the row before it, or one without values.
    pub fn read(&mut self, level: Level, source: &Source<'_>, i: usize, above: &Self) {
        self.placed = false;
        let values = source.view.image().row(i);
        for (place, value) in self.values.iter_mut().skip(PAD).zip(values) {
            *place = *value;
        }
        if let (true, Some(last)) = (source.wraps, values.last()) {
            self.values[PAD - 1] = *last;
        }
        if source.tables.is_none() {
            let levels = &mut self.levels[PAD..PAD + source.cols];
            source.view.frame().form_row(source.view.image(), i, source.axes.level(), levels);
        }
        if source.tests.is_none() {
            self.test_pairs(source, i);
        }
        dispatch!(level, simd => self.detect(simd, source, i, above));
    }

    /// The pair test of a sensor that has no tables for it.
    fn test_pairs(&mut self, source: &Source<'_>, i: usize) {
        let (frame, image) = (source.view.frame(), source.view.image());
        self.geometry.resize(source.cols, PairGeometry::MISSING);
        let both = [(Neighbour::Left, &mut self.left), (Neighbour::Up, &mut self.up)];
        for (neighbour, pairs) in both {
            frame.pair_row(image, i, neighbour, &mut self.geometry);
            for (word, pixels) in pairs.joined.iter_mut().zip(self.geometry.chunks(WORD)) {
                let bit = |(k, pair)| u64::from(source.rule.holds(pair)) << k;
                *word = pixels.iter().enumerate().map(bit).sum();
            }
        }
    }

    #[inline(always)]
    fn detect<S: Simd>(&mut self, simd: S, source: &Source<'_>, i: usize, above: &Self) {
        if let Some(tables) = &source.tables {
            let form = &tables.level;
            let [factor, addend] = form.rows.get(i).copied().unwrap_or_default();
            let levels = self.levels[PAD..].chunks_exact_mut(8);
            let samples = self.values[PAD..].chunks_exact(8).zip(form.columns.chunks_exact(8));
            for (level, (value, column)) in levels.zip(samples) {
                let per_value = f32x8::from_slice(simd, column) * factor + addend;
                let levels = f32x8::from_slice(simd, value) * per_value + form.constant;
                levels.store_slice(level);
            }
        }
        let ceilings = self.ceilings[PAD..].chunks_exact_mut(8);
        for (ceiling, level) in ceilings.zip(self.levels[PAD..].chunks_exact(8)) {
            let level = f32x8::from_slice(simd, level);
            let toward_zero: i32x8<S> = level.to_int();
            let below: f32x8<S> = toward_zero.to_float();
            // A mask's true is −1.
            (toward_zero - below.simd_lt(level).to_vector()).store_slice(ceiling);
        }
        let last = PAD + source.cols - 1;
        self.levels[PAD - 1] = self.levels[last];
        self.ceilings[PAD - 1] = self.ceilings[last];
        self.compare(simd, source, i, above);
    }

    /// Finds the joined and the crossed pairs.
    #[inline(always)]
    fn compare<S: Simd>(&mut self, simd: S, source: &Source<'_>, i: usize, above: &Self) {
        let tests = source.tests.as_ref().map(|[left, up]| (left.at(i), up.at(i)));
        let mut valid_before = u64::from(!self.values[PAD - 1].is_nan());
        let zero = i32x8::splat(simd, 0);
        let (mut count_left, mut count_up) = (zero, zero);
        self.jumps = 0;
        for word in 0..self.valid.len() {
            let at = PAD + word * WORD;
            let (Some(here), Some(before), Some(over)) = (
                block(&self.values, at),
                block(&self.values, at - 1),
                block(&above.values, at),
            ) else {
                return;
            };
            let (Some(ceilings), Some(ceilings_before), Some(ceilings_over)) = (
                block(&self.ceilings, at),
                block(&self.ceilings, at - 1),
                block(&above.ceilings, at),
            ) else {
                return;
            };
            let (mut joined_left, mut joined_up) = (self.left.joined[word], self.up.joined[word]);
            let (mut crossed_left, mut crossed_up, mut valid) = (0, 0, 0);
            if tests.is_some() {
                (joined_left, joined_up) = (0, 0);
            }
            for k in 0..WORD / 8 {
                let part = 8 * k..8 * k + 8;
                let a = f32x8::from_slice(simd, &here[part.clone()]);
                valid |= a.simd_eq(a).to_bitmask() << (8 * k);
                if let Some((left, up)) = &tests {
                    let column = at - PAD + 8 * k;
                    let b = f32x8::from_slice(simd, &before[part.clone()]);
                    joined_left |= left.holds(simd, a, b, column).to_bitmask() << (8 * k);
                    let b = f32x8::from_slice(simd, &over[part.clone()]);
                    joined_up |= up.holds(simd, a, b, column).to_bitmask() << (8 * k);
                }
                let c = i32x8::from_slice(simd, &ceilings[part.clone()]);
                let step = c - i32x8::from_slice(simd, &ceilings_before[part.clone()]);
                let crossed = step.simd_eq(zero).to_bitmask() ^ 0xff;
                crossed_left |= crossed << (8 * k);
                let mask = fearless_simd::mask32x8::from_bitmask(simd, joined_left >> (8 * k));
                count_left += mask.select(step.max(-step), zero);
                let step = c - i32x8::from_slice(simd, &ceilings_over[part]);
                let crossed = step.simd_eq(zero).to_bitmask() ^ 0xff;
                crossed_up |= crossed << (8 * k);
                let mask = fearless_simd::mask32x8::from_bitmask(simd, joined_up >> (8 * k));
                count_up += mask.select(step.max(-step), zero);
            }
            let beside = valid << 1 | valid_before;
            valid_before = valid >> (WORD - 1);
            let jumps_left = valid & beside & !joined_left;
            let jumps_up = valid & above.valid[word] & !joined_up;
            self.jumps += (jumps_left.count_ones() + jumps_up.count_ones()) as usize;
            (self.left.joined[word], self.left.crossed[word]) =
                (joined_left, crossed_left & joined_left);
            (self.up.joined[word], self.up.crossed[word]) = (joined_up, crossed_up & joined_up);
            self.valid[word] = valid;
        }
        self.left.count = total(count_left);
        self.up.count = total(count_up);
    }
}

#[inline(always)]
fn total<S: Simd>(counts: i32x8<S>) -> usize {
    counts.as_slice().iter().map(|c| usize::try_from(*c).unwrap_or(0)).sum()
}

#[inline(always)]
fn block<T>(values: &[T], at: usize) -> Option<&[T; WORD]> {
    values.get(at..)?.first_chunk()
}

impl PairTest<'_> {
    /// Whether eight samples `a` and their neighbours `b` belong to one surface.
    ///
    /// A comparison with NaN is false, which is what a missing pixel needs.
    #[inline(always)]
    fn holds<S: Simd>(
        &self,
        simd: S,
        a: f32x8<S>,
        b: f32x8<S>,
        column: usize,
    ) -> fearless_simd::mask32x8<S> {
        let Some([here, other, across]) = self.columns else {
            let along = (b * self.other - a * self.here).abs();
            return along.simd_le(b * self.across + self.slack);
        };
        let from = |table: &[f32]| match table.get(column..column + 8) {
            Some(part) => f32x8::from_slice(simd, part),
            None => f32x8::splat(simd, f32::NAN),
        };
        let here = from(here) + self.here;
        let along = (b * (from(other) + self.other) - a * here).abs();
        let limit = b * (from(across) + self.across);
        along.simd_le(limit + here.sqrt() * self.slack)
    }
}
