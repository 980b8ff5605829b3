//! The robust fit of some neighbouring pixels of a row, side by side.

use super::estimate::{Estimate, Fitted};
use super::grid::Grid;
use super::lanes::{LANES, Lanes, all, positive};
use super::links::{Connected, WIDTH};
use super::normal_equations::{Coefficients, RowPolynomial, RowSums, Sums};
use super::{REACH, Window, window};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, u32x8};

/// Residuals beyond this many standard deviations do not count: Tukey's biweight is 95 % as
/// efficient as least squares on normal noise with 4.685.
pub(super) const CUT: f64 = 4.685;

/// Pixels of the largest window.
const PIXELS: usize = WIDTH * WIDTH;

/// The pixels that are fitted together, each with its own window.
#[derive(Debug)]
pub(super) struct Block {
    row: usize,
    first: usize,
    /// `1 / radius²` in rows and columns; 0 for pixels that are not fitted.
    inverse_radii: [[f32; LANES]; 2],
    /// The same for the wider windows.
    wider: [[f32; LANES]; 2],
    inverse_cut: [f32; LANES],
    /// Largest radius of any pixel, in rows and in columns.
    largest: (f64, f64),
    radii: [f32; LANES],
}

/// The outcome for the pixels of a block.
#[derive(Debug)]
pub(super) struct BlockFit {
    narrow: [Estimate; LANES],
    wide: [Estimate; LANES],
    inverse_cut: [f32; LANES],
}

/// The weights of a block's windows, and where in the window they are; a work space that blocks use
/// one after another.
#[derive(Debug)]
pub(super) struct Weights {
    /// By distance from the centre; 0 where a pixel is of another surface.
    spatial: Box<[[f32; LANES]]>,
    /// By distance and residual.
    robust: Box<[[f32; LANES]]>,
    /// The first column and the one after the last, for each row of the window.
    columns: [(usize, usize); WIDTH],
    /// The first row of the window and the one after the last.
    rows: (usize, usize),
}

impl Weights {
    pub fn new() -> Self {
        let zero = vec![[0.0; LANES]; PIXELS].into_boxed_slice();
        let (columns, rows) = ([(0, 0); WIDTH], (0, 0));
        Self { spatial: zero.clone(), robust: zero, columns, rows }
    }

    /// Where the windows of a block are at most; places without a connected pixel in any of them, whose
    /// weights are 0, are left out.
    fn frame(&mut self, largest: (f64, f64), seen: &[u32; WIDTH]) {
        let reach = (largest.0 as usize).min(REACH);
        // Rows go on from the centre's, so none is beyond one without a connected pixel.
        let rows = (REACH - reach..REACH).rev().take_while(|k| seen[*k] != 0);
        let top = rows.last().unwrap_or(REACH);
        let rows = (REACH + 1..=REACH + reach).take_while(|k| seen[*k] != 0);
        self.rows = (top, rows.last().unwrap_or(REACH) + 1);
        for (k, seen) in seen.iter().enumerate().take(self.rows.1).skip(self.rows.0) {
            let y = k as f64 - REACH as f64;
            // Room for rounding, so that a pixel's fit is the same whatever is fitted beside it.
            let share = (1.0 - (y / largest.0).powi(2)).max(0.0) + 1e-5;
            let half = ((share.sqrt() * largest.1) as usize).min(REACH);
            let (first, end) = (seen.trailing_zeros(), u32::BITS - seen.leading_zeros());
            self.columns[k] =
                ((REACH - half).max(first as usize), (REACH + half + 1).min(end as usize));
        }
    }
}

/// What a fit looks at again and again.
#[derive(Clone, Copy)]
struct Values<'a, S: Simd> {
    simd: S,
    grid: &'a Grid<'a>,
    /// Row and column of the window's corner for the first pixel.
    corner: (usize, usize),
    centre: Lanes<S>,
    inverse_cut: Lanes<S>,
}

impl<S: Simd> Values<'_, S> {
    /// Values in the window relative to the centre's, in cuts.
    #[inline(always)]
    fn at(&self, k: usize, c: usize) -> Lanes<S> {
        let loaded = self.grid.load(self.simd, self.corner.0 + k, self.corner.1 + c);
        (loaded - self.centre) * self.inverse_cut
    }
}

impl Block {
    pub fn new(row: usize, first: usize) -> Self {
        Self {
            row,
            first,
            inverse_radii: [[0.0; LANES]; 2],
            wider: [[0.0; LANES]; 2],
            inverse_cut: [0.0; LANES],
            largest: (0.0, 0.0),
            radii: [0.0; LANES],
        }
    }

    pub fn set(&mut self, lane: usize, window: &Window) {
        let (rows, cols) = window.radii;
        self.inverse_radii[0][lane] = (1.0 / (rows * rows)) as f32;
        self.inverse_radii[1][lane] = (1.0 / (cols * cols)) as f32;
        for (axis, radius) in [rows, cols].into_iter().enumerate() {
            self.wider[axis][lane] = (1.0 / window::wider(radius).powi(2)) as f32;
        }
        self.inverse_cut[lane] = (1.0 / (CUT * window.sigma)) as f32;
        self.largest = (self.largest.0.max(rows), self.largest.1.max(cols));
        self.radii[lane] = (rows * cols).sqrt() as f32;
    }

    pub fn is_empty(&self) -> bool {
        self.largest.0 == 0.0
    }

    /// Radius of a window of which the wider one has a share.
    pub fn radius(&self, lane: usize, share: f32) -> f32 {
        let (radius, wider) = (self.radii[lane], window::wider(f64::from(self.radii[lane])));
        radius + share * (wider as f32 - radius)
    }

    /// Fits all pixels. The unit of values is the cut, so that single precision never runs out.
    #[inline(always)]
    pub fn fit<S: Simd>(&self, simd: S, grid: &Grid<'_>, weights: &mut Weights) -> BlockFit {
        let values = Values {
            simd,
            grid,
            corner: (self.row, self.first),
            centre: grid.load(simd, self.row + REACH, self.first + REACH),
            inverse_cut: Lanes::load_array_ref(simd, &self.inverse_cut),
        };
        let wider = (window::wider(self.largest.0), window::wider(self.largest.1));
        let reach = (wider.0 as usize).min(REACH);
        let connected = grid.links.connected(simd, (self.row, self.first), reach);
        let fitted =
            u32x8::load_array(simd, self.inverse_cut.map(|c| if c > 0.0 { !0 } else { 0 }));
        let seen = connected.map(|row| (row & fitted).to_array().into_iter().fold(0, |a, b| a | b));
        weights.frame(self.largest, &seen);
        let first = self.first_pass(&values, weights, &connected).fit();
        let second = pass::<S, true>(&values, weights, &first).fit();
        let narrow = at_centre(&values, weights, &second);
        if !narrow.iter().any(Estimate::holds) {
            return BlockFit { narrow, wide: narrow, inverse_cut: self.inverse_cut };
        }
        weights.frame(wider, &seen);
        self.weigh_wider(simd, weights, &connected);
        let wide = at_centre(&values, weights, &second);
        BlockFit { narrow, wide, inverse_cut: self.inverse_cut }
    }

    /// Weights of the wider windows by distance alone.
    #[inline(always)]
    fn weigh_wider<S: Simd>(&self, simd: S, weights: &mut Weights, connected: &Connected<S>) {
        let [per_row, per_col] = self.wider.map(|r| Lanes::load_array(simd, r));
        let (one, zero, none) = (all(simd, 1.0), all(simd, 0.0), u32x8::splat(simd, 0));
        let (top, bottom) = weights.rows;
        for (k, connected) in connected.iter().enumerate().take(bottom).skip(top) {
            let y = k as f32 - REACH as f32;
            let (first, end) = weights.columns[k];
            let from_row = per_row * (y * y);
            for c in first..end {
                let x = c as f32 - REACH as f32;
                let squared = from_row + per_col * (x * x);
                let fall = positive(simd, one - squared * squared);
                let apart = (*connected & (1_u32 << c)).simd_eq(none);
                let weight = apart.select(zero, fall * fall);
                weight.store_slice(&mut weights.spatial[k * WIDTH + c]);
            }
        }
    }

    /// The sums with weights by distance alone, 0 where a pixel is of another surface.
    #[inline(always)]
    fn first_pass<S: Simd>(
        &self,
        values: &Values<'_, S>,
        weights: &mut Weights,
        connected: &Connected<S>,
    ) -> Sums<S> {
        let simd = values.simd;
        let [per_row, per_col] = self.inverse_radii.map(|r| Lanes::load_array(simd, r));
        let (one, zero, none) = (all(simd, 1.0), all(simd, 0.0), u32x8::splat(simd, 0));
        let mut sums = Sums::zero(simd);
        let (top, bottom) = weights.rows;
        for (k, connected) in connected.iter().enumerate().take(bottom).skip(top) {
            let y = k as f32 - REACH as f32;
            let (first, end) = weights.columns[k];
            let from_row = per_row * (y * y);
            let mut row = RowSums::zero(simd);
            for c in first..end {
                let x = c as f32 - REACH as f32;
                let squared = from_row + per_col * (x * x);
                let fall = positive(simd, one - squared * squared);
                let apart = (*connected & (1_u32 << c)).simd_eq(none);
                let weight = apart.select(zero, fall * fall);
                weight.store_slice(&mut weights.spatial[k * WIDTH + c]);
                row.add_weight(c, weight);
                row.add_value(c, weight * values.at(k, c));
            }
            sums.add_row(y, &row);
        }
        sums
    }
}

/// The sums with weights by distance and by the residuals of the last fit; those of the values only
/// if asked for.
#[inline(always)]
fn pass<S: Simd, const WITH_VALUES: bool>(
    values: &Values<'_, S>,
    weights: &mut Weights,
    last: &Coefficients<S>,
) -> Sums<S> {
    let simd = values.simd;
    let one = all(simd, 1.0);
    let mut sums = Sums::zero(simd);
    for k in weights.rows.0..weights.rows.1 {
        let y = k as f32 - REACH as f32;
        let (first, end) = weights.columns[k];
        let expected = RowPolynomial::new(last, y);
        let mut row = RowSums::zero(simd);
        for c in first..end {
            let x = c as f32 - REACH as f32;
            let value = values.at(k, c);
            let residual = value - expected.at(x);
            let inside = positive(simd, one - residual * residual);
            let spatial = Lanes::load_array_ref(simd, &weights.spatial[k * WIDTH + c]);
            let weight = spatial * (inside * inside);
            row.add_weight(c, weight);
            if WITH_VALUES {
                row.add_value(c, weight * value);
            } else {
                weight.store_slice(&mut weights.robust[k * WIDTH + c]);
            }
        }
        sums.add_row(y, &row);
    }
    sums
}

/// The fit at the centre with weights by the residuals of the last fit: a weighted sum of values,
/// and the sum of its squared weights.
#[inline(always)]
fn at_centre<S: Simd>(
    values: &Values<'_, S>,
    weights: &mut Weights,
    last: &Coefficients<S>,
) -> [Estimate; LANES] {
    let polynomial = pass::<S, false>(values, weights, last).centre_weights();
    let zero = all(values.simd, 0.0);
    let (mut change, mut variance) = (zero, zero);
    for k in weights.rows.0..weights.rows.1 {
        let (first, end) = weights.columns[k];
        let of_row = RowPolynomial::new(&polynomial, k as f32 - REACH as f32);
        for c in first..end {
            let robust = Lanes::load_array_ref(values.simd, &weights.robust[k * WIDTH + c]);
            let share = robust * of_row.at(c as f32 - REACH as f32);
            change += share * values.at(k, c);
            variance += share * share;
        }
    }
    let (change, variance) = (change.to_array(), variance.to_array());
    std::array::from_fn(|lane| Estimate { change: change[lane], variance: variance[lane] })
}

impl BlockFit {
    /// What becomes of a pixel; `None` where it stays as it is.
    pub fn at(&self, lane: usize) -> Option<Fitted> {
        self.narrow[lane].fitted(&self.wide[lane], self.inverse_cut[lane])
    }
}
