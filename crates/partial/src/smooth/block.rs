//! The robust fit of some neighbouring pixels of a row, side by side.

use super::grid::Grid;
use super::lanes::{LANES, Lanes};
use super::links::{Connected, WIDTH};
use super::normal_equations::{Coefficients, RowPolynomial, RowSums, Sums};
use super::{REACH, Window};

/// Residuals beyond this many standard deviations do not count: Tukey's biweight is 95 % as
/// efficient as least squares on normal noise with 4.685.
const CUT: f64 = 4.685;

/// Pixels of the largest window.
const PIXELS: usize = WIDTH * WIDTH;

/// The pixels that are fitted together, each with its own window.
#[derive(Debug)]
pub(super) struct Block {
    row: usize,
    first: usize,
    /// `1 / radius²` in rows and columns; 0 for pixels that are not fitted.
    inverse_radii: (Lanes, Lanes),
    inverse_cut: Lanes,
    /// For each row of the window, the connected pixels of each lane.
    connected: [[u32; LANES]; WIDTH],
    /// Largest radius of any pixel, in rows and in columns.
    largest: (f64, f64),
    radii: [f32; LANES],
}

/// The outcome for the pixels of a block.
#[derive(Debug)]
pub(super) struct BlockFit {
    change: Lanes,
    variance: Lanes,
    inverse_cut: Lanes,
}

/// The weights of a block's windows, and where in the window they are; a work space that blocks use
/// one after another.
#[derive(Debug)]
pub(super) struct Weights {
    /// By distance from the centre; 0 where a pixel is of another surface.
    spatial: Box<[Lanes]>,
    /// By distance and residual.
    robust: Box<[Lanes]>,
    /// Half the number of columns, for each row of the window.
    half_widths: [usize; WIDTH],
    /// The first row of the window and the one after the last.
    rows: (usize, usize),
}

impl Weights {
    pub fn new() -> Self {
        let zero = vec![Lanes::ZERO; PIXELS].into_boxed_slice();
        let (half_widths, rows) = ([0; WIDTH], (0, 0));
        Self { spatial: zero.clone(), robust: zero, half_widths, rows }
    }
}

impl Block {
    pub fn new(row: usize, first: usize) -> Self {
        Self {
            row,
            first,
            inverse_radii: (Lanes::ZERO, Lanes::ZERO),
            inverse_cut: Lanes::ZERO,
            connected: [[0; LANES]; WIDTH],
            largest: (0.0, 0.0),
            radii: [0.0; LANES],
        }
    }

    pub fn set(&mut self, lane: usize, window: &Window, connected: Connected) {
        let (rows, cols) = window.radii;
        self.inverse_radii.0.set(lane, (1.0 / (rows * rows)) as f32);
        self.inverse_radii.1.set(lane, (1.0 / (cols * cols)) as f32);
        let cut = CUT * window.sigma;
        self.inverse_cut.set(lane, (1.0 / cut) as f32);
        for (rows, row) in self.connected.iter_mut().zip(connected) {
            rows[lane] = row;
        }
        self.largest = (self.largest.0.max(rows), self.largest.1.max(cols));
        self.radii[lane] = (rows * cols).sqrt() as f32;
    }

    pub fn is_empty(&self) -> bool {
        self.largest.0 == 0.0
    }

    pub fn radius(&self, lane: usize) -> f32 {
        self.radii[lane]
    }

    /// Fits all pixels. The unit of values is the cut, so that single precision never runs out.
    pub fn fit(&self, grid: &Grid, weights: &mut Weights) -> BlockFit {
        self.weigh(weights);
        let first = self.first_pass(grid, weights).fit();
        let second = self.pass(grid, weights, &first).fit();
        let centre = self.pass(grid, weights, &second).centre_weights();
        let (change, variance) = self.centre(grid, weights, &centre);
        BlockFit { change, variance, inverse_cut: self.inverse_cut }
    }

    /// Weights by distance from the centre, 0 where a pixel is of another surface.
    fn weigh(&self, weights: &mut Weights) {
        let reach = (self.largest.0 as usize).min(REACH);
        weights.rows = (REACH - reach, REACH + reach + 1);
        for k in weights.rows.0..weights.rows.1 {
            let y = k as f64 - REACH as f64;
            let share = (1.0 - (y / self.largest.0).powi(2)).max(0.0);
            let half = ((share.sqrt() * self.largest.1) as usize).min(REACH);
            weights.half_widths[k] = half;
            let from_row = self.inverse_radii.0 * (y * y) as f32;
            for c in REACH - half..=REACH + half {
                let x = c as f32 - REACH as f32;
                let squared = from_row + self.inverse_radii.1 * (x * x);
                let fall = (Lanes::all(1.0) - squared * squared).positive();
                weights.spatial[k * WIDTH + c] = fall * fall * self.mask(k, c);
            }
        }
    }

    #[inline(always)]
    fn mask(&self, k: usize, c: usize) -> Lanes {
        Lanes::new(self.connected[k].map(|row| (row >> c & 1) as i32 as f32))
    }

    /// Values in the window relative to the centre's, in cuts.
    #[inline(always)]
    fn value(&self, grid: &Grid, centre: Lanes, k: usize, c: usize) -> Lanes {
        (grid.load(self.row + k, self.first + c) - centre) * self.inverse_cut
    }

    /// The sums with weights by distance alone.
    fn first_pass(&self, grid: &Grid, weights: &Weights) -> Sums {
        let centre = grid.load(self.row + REACH, self.first + REACH);
        let mut sums = Sums::ZERO;
        for k in weights.rows.0..weights.rows.1 {
            let half = weights.half_widths[k];
            let mut row = RowSums::ZERO;
            for c in REACH - half..=REACH + half {
                let value = self.value(grid, centre, k, c);
                row.add(c as f32 - REACH as f32, weights.spatial[k * WIDTH + c], value);
            }
            sums.add_row(k as f32 - REACH as f32, &row);
        }
        sums
    }

    /// The sums with weights by distance and by the residuals of the last fit.
    fn pass(&self, grid: &Grid, weights: &mut Weights, last: &Coefficients) -> Sums {
        let centre = grid.load(self.row + REACH, self.first + REACH);
        let mut sums = Sums::ZERO;
        for k in weights.rows.0..weights.rows.1 {
            let y = k as f32 - REACH as f32;
            let half = weights.half_widths[k];
            let expected = RowPolynomial::new(last, y);
            let mut row = RowSums::ZERO;
            for c in REACH - half..=REACH + half {
                let x = c as f32 - REACH as f32;
                let value = self.value(grid, centre, k, c);
                let residual = value - expected.at(x);
                let inside = (Lanes::all(1.0) - residual * residual).positive();
                let weight = weights.spatial[k * WIDTH + c] * (inside * inside);
                weights.robust[k * WIDTH + c] = weight;
                row.add(x, weight, value);
            }
            sums.add_row(y, &row);
        }
        sums
    }

    /// The fit at the centre as a weighted sum of values, and the sum of its squared weights.
    fn centre(&self, grid: &Grid, weights: &Weights, polynomial: &Coefficients) -> (Lanes, Lanes) {
        let centre = grid.load(self.row + REACH, self.first + REACH);
        let (mut change, mut variance) = (Lanes::ZERO, Lanes::ZERO);
        for k in weights.rows.0..weights.rows.1 {
            let half = weights.half_widths[k];
            let of_row = RowPolynomial::new(polynomial, k as f32 - REACH as f32);
            for c in REACH - half..=REACH + half {
                let share = weights.robust[k * WIDTH + c] * of_row.at(c as f32 - REACH as f32);
                change = change + share * self.value(grid, centre, k, c);
                variance = variance + share * share;
            }
        }
        (change, variance)
    }
}

impl BlockFit {
    /// The change of a pixel's quantity, and the factor of its standard deviation; `None` where the
    /// pixel stays as it is.
    pub fn at(&self, lane: usize) -> Option<(f32, f32)> {
        let (change, variance) = (self.change.get(lane), self.variance.get(lane));
        let inverse_cut = self.inverse_cut.get(lane);
        // A fit without pixels has variance 0. One that differs by a cut is of another surface.
        let better = variance > 0.0 && variance < 1.0 && change.abs() < 1.0;
        (inverse_cut > 0.0 && better).then(|| (change / inverse_cut, variance.sqrt()))
    }
}
