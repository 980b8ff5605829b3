//! Which neighbouring samples belong to one surface, a row of the image at a time, one bit each.

use crate::{BreakRule, Grazing, PairTests, TestPairs, length_per_value};
use fearless_simd::{Simd, SimdBase};
use transect_device::{Neighbour, PairGeometry, Pixel, Point3, RayProducts, View};

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
    /// Of sensors that have none.
    geometry: Geometry,
    grazing: Option<Grazing<'a>>,
}

/// The geometry of pairs that follows from the samples' points.
#[derive(Debug, Default)]
struct Geometry {
    /// Points of the row above and of this one.
    points: [Vec<Option<Point3>>; 2],
    /// Distances between the rays of each pixel and of both its neighbours, row-major; NaN where
    /// there is no pair.
    laterals: [Vec<f32>; 2],
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
        let size = view.image().size();
        let cols = size.cols;
        let table = |neighbour| {
            let products = view.frame().ray_products(neighbour)?;
            let tests = PairTests::new(&products, rule, cols);
            Some((products, tests))
        };
        let tables = || Some([table(NEIGHBOURS[0])?, table(NEIGHBOURS[1])?]);
        let tables = tables();
        let geometry = match tables {
            Some(_) => Geometry::default(),
            None => Geometry {
                points: [vec![None; cols], vec![None; cols]],
                laterals: NEIGHBOURS.map(|_| vec![f32::NAN; size.pixels()]),
            },
        };
        Self { view, rule, tables, geometry, grazing: Grazing::of(view, rule) }
    }

    /// Which pixels of a row are joined to their left neighbours and which to those above.
    #[inline(always)]
    pub fn read<S: Simd>(
        &mut self,
        simd: S,
        row: usize,
        lines: [&Line; 2],
        mut bits: [&mut [u64]; 2],
    ) {
        let [above, here] = lines.map(|line| &line.0);
        let [left, up] = bits.each_mut();
        match &self.tables {
            Some([(_, to_left), (_, upward)]) => {
                compare(simd, to_left.at(row), [&here[1..], here], left);
                compare(simd, upward.at(row), [&here[1..], &above[1..]], up);
            }
            None => {
                left.fill(0);
                up.fill(0);
                self.geometry.read(self.view, self.rule, row, [left, up]);
            }
        }
        let Some(grazing) = &self.grazing else { return };
        let cols = self.view.image().size().cols;
        for (neighbour, bits) in NEIGHBOURS.into_iter().zip(bits) {
            for (word, bits) in bits.iter_mut().enumerate() {
                let inside = u64::MAX >> (WORD - (cols - word * WORD).min(WORD));
                *bits |= grazing.joined(neighbour, row, word, !*bits & inside);
            }
        }
    }

    /// Distance between the rays of a pixel and a neighbour, at the neighbour's sample.
    #[inline(always)]
    pub fn lateral(&self, pixel: Pixel, neighbour: Neighbour) -> Option<f32> {
        let image = self.view.image();
        let which = usize::from(neighbour == Neighbour::Up);
        let Some(tables) = &self.tables else {
            let lateral = self.geometry.laterals[which][pixel.row * image.size().cols + pixel.col];
            return (!lateral.is_nan()).then_some(lateral);
        };
        let other = match neighbour {
            Neighbour::Up => *image.row(pixel.row.checked_sub(1)?).get(pixel.col)?,
            Neighbour::Left if pixel.col == 0 => *image.row(pixel.row).last()?,
            Neighbour::Left => *image.row(pixel.row).get(pixel.col - 1)?,
        };
        let (products, _) = &tables[which];
        let of_row = products.rows.get(pixel.row)?;
        let of_column = products.columns.get(pixel.col).copied().unwrap_or_default();
        let here = of_row.here + of_column.here;
        Some(other * (of_row.across + of_column.across) / here.sqrt())
    }

    /// Length along each ray of a row per unit of its value; NaN where the value means no point.
    #[inline(always)]
    pub fn lengths_per_value(&self, row: usize, values: &[f32], rates: &mut [f32]) {
        let Some([(products, _), _]) = &self.tables else {
            for (col, (rate, value)) in rates.iter_mut().zip(values).enumerate() {
                let pixel = Pixel { row, col };
                let found = length_per_value(self.view.frame(), pixel, f64::from(*value));
                *rate = found.map_or(f32::NAN, |rate| rate as f32);
            }
            return;
        };
        // A sample is its value times the ray.
        rates.fill(products.rows[row].here);
        for (rate, of_column) in rates.iter_mut().zip(&products.columns) {
            *rate += of_column.here;
        }
        rates.iter_mut().for_each(|rate| *rate = rate.sqrt());
    }
}

impl Geometry {
    /// Reads a row, which comes after the one above: each sample's point is found once, and pairs
    /// are looked at where there are two samples.
    fn read(&mut self, view: &View, rule: &BreakRule, row: usize, bits: [&mut [u64]; 2]) {
        let [left, up] = bits;
        let (frame, image) = (view.frame(), view.image());
        self.points.swap(0, 1);
        let [above, here] = &mut self.points;
        for (col, point) in here.iter_mut().enumerate() {
            let pixel = Pixel { row, col };
            *point = image.get(pixel).and_then(|d3| frame.point(pixel, f64::from(d3)));
        }
        for (col, point) in here.iter().enumerate() {
            let pixel = Pixel { row, col };
            let Some(point) = point else { continue };
            let Some(ray) = frame.ray(pixel) else { continue };
            let kinds = NEIGHBOURS.into_iter().zip([&*here, &*above]);
            for (((neighbour, points), laterals), bits) in
                kinds.zip(&mut self.laterals).zip([&mut *left, &mut *up])
            {
                let other = frame.neighbour(pixel, neighbour);
                let other = other.and_then(|o| points.get(o.col)?.as_ref());
                let Some(other) = other else { continue };
                let pair = PairGeometry::between(point, other, &ray.direction);
                laterals[row * image.size().cols + col] = pair.lateral;
                bits[col / WORD] |= u64::from(rule.holds(&pair)) << (col % WORD);
            }
        }
    }
}

/// Whether a bit is set.
pub(super) fn is_set(words: &[u64], at: usize) -> bool {
    words[at / WORD] >> (at % WORD) & 1 == 1
}

/// Compares samples with others, a word at a time.
#[inline(always)]
fn compare<S: Simd, T: TestPairs<S>>(
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
