//! Which neighbouring samples belong to one surface, a row of the image at a time, one bit each.

use crate::BreakRule;
use crate::one_pass::{PairTestOf, PairTests};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, SimdBase};
use transect_device::{Neighbour, PairGeometry, Pixel, RayProducts, View};

const WORD: usize = 64;

/// Both kinds of pairs.
const NEIGHBOURS: [Neighbour; 2] = [Neighbour::Left, Neighbour::Up];

/// The rule for the pairs of a view.
#[derive(Debug)]
pub(super) struct Pairs<'a> {
    view: &'a View,
    rule: &'a BreakRule,
    /// Of sensors that have tables.
    tables: Option<[(RayProducts, PairTests); 2]>,
    /// Of a row of sensors that have none.
    geometry: Vec<PairGeometry>,
}

/// A row of samples, NaN where missing: the one before column 0 and all others, filled up to whole
/// words.
#[derive(Debug, Clone)]
pub(super) struct Line(Vec<f32>);

impl Line {
    /// No sample.
    pub fn missing(cols: usize) -> Self {
        Self(vec![f32::NAN; 1 + cols.next_multiple_of(WORD)])
    }

    pub fn read(&mut self, values: &[f32], wraps: bool) {
        self.0[1..=values.len()].copy_from_slice(values);
        self.0[0] = values.last().copied().filter(|_| wraps).unwrap_or(f32::NAN);
    }
}

impl<'a> Pairs<'a> {
    pub fn new(view: &'a View, rule: &'a BreakRule) -> Self {
        let cols = view.image().size().cols;
        let table = |neighbour| {
            let products = view.frame().ray_products(neighbour)?;
            let tests = PairTests::new(&products, rule, cols);
            Some((products, tests))
        };
        let tables = || Some([table(NEIGHBOURS[0])?, table(NEIGHBOURS[1])?]);
        let tables = tables();
        let geometry =
            if tables.is_none() { vec![PairGeometry::MISSING; cols] } else { Vec::new() };
        Self { view, rule, tables, geometry }
    }

    /// Which pixels of a row are valid, and which are joined to their left neighbours and to those above.
    #[inline(always)]
    pub fn read<S: Simd>(&mut self, simd: S, row: usize, lines: [&Line; 2], bits: [&mut [u64]; 3]) {
        let [above, here] = lines.map(|line| &line.0);
        let [valid, left, up] = bits;
        compare(simd, Same, [&here[1..], &here[1..]], valid);
        match &self.tables {
            Some([(_, to_left), (_, upward)]) => {
                compare(simd, to_left.at(row), [&here[1..], here], left);
                compare(simd, upward.at(row), [&here[1..], &above[1..]], up);
            }
            None => {
                for (neighbour, bits) in NEIGHBOURS.into_iter().zip([left, up]) {
                    self.view.frame().pair_row(
                        self.view.image(),
                        row,
                        neighbour,
                        &mut self.geometry,
                    );
                    for (word, pairs) in bits.iter_mut().zip(self.geometry.chunks(WORD)) {
                        let bit = |(k, pair)| u64::from(self.rule.holds(pair)) << k;
                        *word = pairs.iter().enumerate().map(bit).sum();
                    }
                }
            }
        }
    }

    /// Distance between the rays of a pixel and a neighbour, at the neighbour's sample.
    pub fn lateral(&self, pixel: Pixel, neighbour: Neighbour) -> Option<f64> {
        let (frame, image) = (self.view.frame(), self.view.image());
        let other = frame.neighbour(pixel, neighbour)?;
        let Some(tables) = &self.tables else {
            return Some(f64::from(frame.pair(image, pixel, other)?.lateral));
        };
        let (products, _) = &tables[usize::from(neighbour == Neighbour::Up)];
        let of_row = products.rows.get(pixel.row)?;
        let of_column = products.columns.get(pixel.col).copied().unwrap_or_default();
        let here = f64::from(of_row.here) + f64::from(of_column.here);
        let across = f64::from(of_row.across) + f64::from(of_column.across);
        Some(f64::from(image.get(other)?) * across / here.sqrt())
    }
}

/// Compares samples with others, a word at a time.
#[inline(always)]
fn compare<S: Simd, T: PairTestOf<S>>(
    simd: S,
    test: T,
    [here, other]: [&[f32]; 2],
    bits: &mut [u64],
) {
    let lanes = S::f32s::LEN;
    for (word, bits) in bits.iter_mut().enumerate() {
        *bits = 0;
        for k in 0..WORD / lanes {
            let at = word * WORD + k * lanes;
            let a = S::f32s::from_slice(simd, &here[at..at + lanes]);
            let b = S::f32s::from_slice(simd, &other[at..at + lanes]);
            *bits |= test.holds(simd, a, b, at) << (k * lanes);
        }
    }
}

/// Whether there is a sample: NaN is not even itself.
#[derive(Debug, Clone, Copy)]
struct Same;

impl<S: Simd> PairTestOf<S> for Same {
    #[inline(always)]
    fn holds(&self, _: S, a: S::f32s, b: S::f32s, _: usize) -> u64 {
        a.simd_eq(b).to_bitmask()
    }
}
