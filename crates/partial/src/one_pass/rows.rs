//! One row of pixels in the sweep: levels, and bit masks of pairs.
//!
//! Arrays have [`PAD`] places before column 0, the last of which stands for the column before it:
//! the last column of a full circle, and a missing pixel otherwise. They reach to the next multiple
//! of 64 columns, where pixels are missing. So inner loops have no special columns.
//!
//! Numbers: `f32`, and multiplications and additions are never contracted, so every instruction set
//! gives the same bits.

use super::band::capacity_bytes;
use super::source::Source;
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use transect_device::{Neighbour, PairGeometry};
use transect_image::{TestPairs, UniformTest};

/// Places before column 0.
pub(super) const PAD: usize = 16;
/// Pixels per word of a mask.
const WORD: usize = 64;
/// Words of masks that are combined at a time; masks are filled up to a multiple of it.
pub(super) const WORDS: usize = 4;

/// One bit per pixel: its pair with one of its neighbours.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    /// Both samples belong to one surface.
    pub joined: Vec<u64>,
    /// Joined, and at least one plane passes between the samples.
    pub crossed: Vec<u64>,
    /// Where crossed: number of the crossing at level 0, so that level k has this number plus k.
    pub bases: Vec<u32>,
}

/// The numbers of one row of pixels.
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
    /// Pairs of valid pixels in this row that are not joined.
    pub jumps: usize,
    geometry: Vec<PairGeometry>,
}

impl Row {
    /// Makes room for a row; its old contents are dropped.
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
                mask.resize(words.next_multiple_of(WORDS), 0);
            }
            pairs.bases.clear();
            pairs.bases.resize(places, 0);
        }
    }

    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        let floats = [&self.values, &self.levels].into_iter();
        let masks = [&self.left, &self.up].into_iter().flat_map(|p| [&p.joined, &p.crossed]);
        let bases = capacity_bytes(&self.left.bases) + capacity_bytes(&self.up.bases);
        floats.map(capacity_bytes).sum::<usize>()
            + masks.chain([&self.valid]).map(capacity_bytes).sum::<usize>()
            + bases
            + capacity_bytes(&self.ceilings)
            + capacity_bytes(&self.geometry)
    }

    /// Reads row `i` of the image; `above` is the row before it, or one without values.
    #[inline(always)]
    pub fn read<S: Simd>(&mut self, simd: S, source: &Source<'_>, i: usize, above: &Self) {
        let values = source.view.image().row(i);
        if let Some(places) = self.values.get_mut(PAD..PAD + values.len()) {
            places.copy_from_slice(values);
        }
        if let (true, Some(last)) = (source.wraps, values.last()) {
            self.values[PAD - 1] = *last;
        }
        if source.level.is_none() {
            let levels = &mut self.levels[PAD..PAD + source.cols];
            source.view.frame().form_row(source.view.image(), i, source.axes.level(), levels);
        }
        if source.tests.is_none() {
            self.test_pairs(source, i);
        }
        self.jumps = 0;
        self.detect(simd, source, i, above);
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
        let lanes = S::f32s::LEN;
        if let Some(form) = &source.level {
            let [factor, addend] = form.rows.get(i).copied().unwrap_or_default();
            let samples =
                self.values[PAD..].chunks_exact(lanes).zip(form.columns.chunks_exact(lanes));
            let out = self.levels[PAD..].chunks_exact_mut(lanes);
            let out = out.zip(self.ceilings[PAD..].chunks_exact_mut(lanes));
            for ((value, column), (level, ceiling)) in samples.zip(out) {
                let per_value = S::f32s::from_slice(simd, column) * factor + addend;
                let levels = S::f32s::from_slice(simd, value) * per_value + form.constant;
                levels.store_slice(level);
                ceil::<S>(levels).store_slice(ceiling);
            }
        } else {
            let ceilings = self.ceilings[PAD..].chunks_exact_mut(lanes);
            for (ceiling, level) in ceilings.zip(self.levels[PAD..].chunks_exact(lanes)) {
                ceil::<S>(S::f32s::from_slice(simd, level)).store_slice(ceiling);
            }
        }
        let last = PAD + source.cols - 1;
        self.levels[PAD - 1] = self.levels[last];
        self.ceilings[PAD - 1] = self.ceilings[last];
        match &source.tests {
            None => self.compare(simd, (source, i), above, None::<[UniformTest<S>; 2]>),
            Some([left, up]) => {
                let (left, up) = (left.at(i), up.at(i));
                if left.is_uniform() && up.is_uniform() {
                    let tests = [left, up].map(|test| UniformTest::new(simd, &test));
                    self.compare(simd, (source, i), above, Some(tests));
                } else {
                    self.compare(simd, (source, i), above, Some([left, up]));
                }
            }
        }
    }

    /// Finds the joined and the crossed pairs. Without tests, the joined ones are known already.
    #[inline(always)]
    fn compare<S: Simd, T: TestPairs<S>>(
        &mut self,
        simd: S,
        (source, i): (&Source<'_>, usize),
        above: &Self,
        tests: Option<[T; 2]>,
    ) {
        let mut valid_before = u64::from(!self.values[PAD - 1].is_nan());
        for word in 0..self.valid.len() {
            let at = PAD + word * WORD;
            let (Some(here), Some(before), Some(over)) =
                (block(&self.values, at), block(&self.values, at - 1), block(&above.values, at))
            else {
                return;
            };
            let (Some(ceilings), Some(ceilings_before), Some(ceilings_over)) = (
                block(&self.ceilings, at),
                block(&self.ceilings, at - 1),
                block(&above.ceilings, at),
            ) else {
                return;
            };
            let (mut joined_left, mut joined_up) = (0, 0);
            let (mut level_left, mut level_up, mut valid) = (0, 0, 0);
            for k in 0..WORD / S::f32s::LEN {
                let shift = S::f32s::LEN * k;
                let column = at - PAD + shift;
                let a = part(simd, here, k);
                valid |= a.simd_eq(a).to_bitmask() << shift;
                if let Some([left, up]) = &tests {
                    joined_left |= left.holds(simd, a, part(simd, before, k), column) << shift;
                    joined_up |= up.holds(simd, a, part(simd, over, k), column) << shift;
                }
                let c = whole_part(simd, ceilings, k);
                let same = c.simd_eq(whole_part(simd, ceilings_before, k));
                level_left |= same.to_bitmask() << shift;
                let same = c.simd_eq(whole_part(simd, ceilings_over, k));
                level_up |= same.to_bitmask() << shift;
            }
            if tests.is_none() {
                (joined_left, joined_up) = (self.left.joined[word], self.up.joined[word]);
            }
            let beside = valid << 1 | valid_before;
            valid_before = valid >> (WORD - 1);
            let mut jumps_left = valid & beside & !joined_left;
            let mut jumps_up = valid & above.valid[word] & !joined_up;
            if let Some(grazing) = &source.grazing {
                let left = grazing.joined(Neighbour::Left, i, word, jumps_left);
                let up = grazing.joined(Neighbour::Up, i, word, jumps_up);
                (joined_left, joined_up) = (joined_left | left, joined_up | up);
                (jumps_left, jumps_up) = (jumps_left & !left, jumps_up & !up);
            }
            self.jumps += (jumps_left.count_ones() + jumps_up.count_ones()) as usize;
            (self.left.joined[word], self.left.crossed[word]) =
                (joined_left, joined_left & !level_left);
            (self.up.joined[word], self.up.crossed[word]) = (joined_up, joined_up & !level_up);
            self.valid[word] = valid;
        }
    }
}

/// `ceil` of levels, which are far below 2³¹; any number for NaN.
#[inline(always)]
fn ceil<S: Simd>(level: S::f32s) -> S::i32s {
    let toward_zero: S::i32s = level.to_int();
    let below: S::f32s = toward_zero.to_float();
    // A mask's true is −1.
    toward_zero - below.simd_lt(level).to_vector()
}

#[inline(always)]
fn part<S: Simd>(simd: S, block: &[f32; WORD], k: usize) -> S::f32s {
    S::f32s::from_slice(simd, &block[S::f32s::LEN * k..S::f32s::LEN * (k + 1)])
}

#[inline(always)]
fn whole_part<S: Simd>(simd: S, block: &[i32; WORD], k: usize) -> S::i32s {
    S::i32s::from_slice(simd, &block[S::f32s::LEN * k..S::f32s::LEN * (k + 1)])
}

/// The columns whose bits are set, in ascending order, in a list that is used again and again.
///
/// Words without any are left out, and of the others four are written at least, whether they are
/// there or not. Sparse masks, the most frequent ones, then need few branches that the processor
/// could guess wrong.
#[inline(always)]
pub(super) fn columns<'a>(mask: &[u64], list: &'a mut Vec<u32>) -> &'a [u32] {
    const AT_ONCE: usize = 4;
    let most = mask.len() * WORD + AT_ONCE;
    if list.len() < most {
        list.resize(most, 0);
    }
    let mut count = 0;
    for (start, words) in (0..).step_by(WORD * WORD).zip(mask.chunks(WORD)) {
        let some = |(k, word): (usize, &u64)| u64::from(*word != 0) << k;
        let mut filled = words.iter().enumerate().map(some).fold(0, |all, bit| all | bit);
        while filled != 0 {
            let word = filled.trailing_zeros();
            filled &= filled - 1;
            let first = start + WORD as u32 * word;
            let mut bits = words.get(word as usize).copied().unwrap_or_default();
            let end = count + bits.count_ones() as usize;
            while let Some(next) = list.get_mut(count..count + AT_ONCE) {
                for column in next {
                    *column = first + bits.trailing_zeros();
                    bits &= bits.wrapping_sub(1);
                }
                count += AT_ONCE;
                if count >= end {
                    break;
                }
            }
            count = end;
        }
    }
    list.get(..count).unwrap_or(&[])
}

#[inline(always)]
fn block<T>(values: &[T], at: usize) -> Option<&[T; WORD]> {
    values.get(at..)?.first_chunk()
}
