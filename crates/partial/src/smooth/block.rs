//! The robust fit of some neighbouring pixels of a row, side by side.
//!
//! As many pixels as the processor has numbers in a vector; a pixel's fit is the same to the bit however
//! many there are beside it. Places of the window are visited one after the other, and what a place holds
//! for all pixels is kept in the order of the visits, so inner loops step through plain slices.

use super::estimate::{Estimates, Fitted};
use super::grid::Grid;
use super::lanes::{MOST, Native, positive};
use super::links::WIDTH;
use super::normal_equations::{COLUMNS, Coefficients, Column, RowPolynomial, RowSums, Sums};
use super::{REACH, window};
use fearless_simd::Simd;
use fearless_simd::prelude::*;

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
    /// What the windows follow from; NaN for pixels that are not fitted.
    sizes: [[f32; MOST]; 3],
    /// `1 / radius²` in rows and columns; 0 for pixels that are not fitted.
    inverse_radii: [[f32; MOST]; 2],
    /// The same for the wider windows.
    wider: [[f32; MOST]; 2],
    inverse_cut: [f32; MOST],
    /// Largest radius of any pixel, in rows and in columns.
    largest: (f32, f32),
    radii: [f32; MOST],
}

/// A number for each pixel of a block, where vectors are read at once.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Numbers([f32; MOST]);

impl Numbers {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> Native<S> {
        Native::<S>::from_slice(simd, &self.0[..Native::<S>::LEN])
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, numbers: Native<S>) {
        numbers.store_slice(&mut self.0[..Native::<S>::LEN]);
    }
}

/// What is known of a place of the windows.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Relative to the centre's, in cuts.
    value: Numbers,
    /// Weight by distance from the centre; 0 where a pixel is of another surface.
    spatial: Numbers,
    /// Weight by distance and residual.
    robust: Numbers,
}

/// The places of a block's windows; a work space that blocks use one after another.
#[derive(Debug)]
pub(super) struct Weights {
    /// One after the other, in the order of [`Weights::columns`].
    places: Box<[Place]>,
    /// For each row of the window, the columns that are connected to each pixel's centre.
    connected: [[u32; MOST]; WIDTH],
    /// The first column and the one after the last, for each row of the window.
    columns: [(usize, usize); WIDTH],
    /// The first row of the window and the one after the last.
    rows: (usize, usize),
}

impl Weights {
    pub fn new() -> Self {
        let none = Numbers([0.0; MOST]);
        let none = Place { value: none, spatial: none, robust: none };
        Self {
            places: vec![none; PIXELS].into_boxed_slice(),
            connected: [[0; MOST]; WIDTH],
            columns: [(0, 0); WIDTH],
            rows: (0, 0),
        }
    }

    /// Where the windows of a block are at most; places without a connected pixel in any of them, whose
    /// weights are 0, are left out.
    fn frame(&mut self, largest: (f32, f32), seen: &[u32; WIDTH]) {
        let reach = (largest.0 as usize).min(REACH);
        // Rows go on from the centre's, so none is beyond one without a connected pixel.
        let rows = (REACH - reach..REACH).rev().take_while(|k| seen[*k] != 0);
        let top = rows.last().unwrap_or(REACH);
        let rows = (REACH + 1..=REACH + reach).take_while(|k| seen[*k] != 0);
        self.rows = (top, rows.last().unwrap_or(REACH) + 1);
        for (k, seen) in seen.iter().enumerate().take(self.rows.1).skip(self.rows.0) {
            let y = k as f32 - REACH as f32;
            // Room for rounding, so that a pixel's fit is the same whatever is fitted beside it.
            let share = (1.0 - (y / largest.0).powi(2)).max(0.0) + 1e-5;
            let half = ((share.sqrt() * largest.1) as usize).min(REACH);
            let (first, end) = (seen.trailing_zeros(), u32::BITS - seen.leading_zeros());
            let (first, end) =
                ((REACH - half).max(first as usize), (REACH + half + 1).min(end as usize));
            self.columns[k] = (first, end.max(first));
        }
    }
}

/// A row of the windows of a block.
struct WindowRow<'a, S: Simd> {
    /// Rows from the centre's.
    y: f32,
    columns: &'a [Column],
    /// The image from the first pixel's place in the first column on.
    image: &'a [f32],
    connected: S::u32s,
    places: &'a mut [Place],
}

/// What a fit looks at again and again.
#[derive(Clone, Copy)]
struct Fit<'a, S: Simd> {
    simd: S,
    block: &'a Block,
    grid: &'a Grid<'a>,
    centre: Native<S>,
    inverse_cut: Native<S>,
}

impl Block {
    pub fn new(row: usize, first: usize) -> Self {
        Self {
            row,
            first,
            sizes: [[f32::NAN; MOST]; 3],
            inverse_radii: [[0.0; MOST]; 2],
            wider: [[0.0; MOST]; 2],
            inverse_cut: [0.0; MOST],
            largest: (0.0, 0.0),
            radii: [0.0; MOST],
        }
    }

    /// Has a pixel fitted: with a window that follows from the distances between its rays and its noise;
    /// `inverse_sigma` is that of its quantity.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, sizes: [f32; 3], inverse_sigma: f32) {
        for (all, size) in self.sizes.iter_mut().zip(sizes) {
            all[lane] = size;
        }
        self.inverse_cut[lane] = inverse_sigma * (1.0 / CUT) as f32;
    }

    /// Finds the windows of all pixels that are set.
    #[inline(always)]
    pub fn find_windows(&mut self) {
        let [mut tallest, mut widest] = [[0.0; MOST]; 2];
        for (lane, (tallest, widest)) in tallest.iter_mut().zip(&mut widest).enumerate() {
            let [rows, cols] = window::radii([0, 1, 2].map(|k| self.sizes[k][lane]));
            let fitted = (rows > 0.0) & (self.inverse_cut[lane] > 0.0);
            let only = |number: f32| if fitted { number } else { 0.0 };
            let inverse = |radius: f32| only(1.0 / (radius * radius));
            self.inverse_radii[0][lane] = inverse(rows);
            self.inverse_radii[1][lane] = inverse(cols);
            self.wider[0][lane] = inverse(window::wider(rows));
            self.wider[1][lane] = inverse(window::wider(cols));
            self.inverse_cut[lane] = only(self.inverse_cut[lane]);
            self.radii[lane] = (rows * cols).sqrt();
            (*tallest, *widest) = (only(rows), only(cols));
        }
        self.largest = (largest(tallest), largest(widest));
    }

    pub fn is_empty(&self) -> bool {
        self.largest.0 == 0.0
    }

    /// Radii of windows of which the wider ones have some shares.
    #[inline(always)]
    pub fn radii(&self, shares: &[f32; MOST]) -> [f32; MOST] {
        std::array::from_fn(|lane| window::between(self.radii[lane], shares[lane]))
    }

    /// Fits all pixels. The unit of values is the cut, so that single precision never runs out.
    #[inline(always)]
    pub fn fit<S: Simd>(&self, simd: S, grid: &Grid<'_>, weights: &mut Weights) -> Fitted<MOST> {
        let lanes = Native::<S>::LEN;
        let centre = &grid.line(self.row + REACH, self.first + REACH)[..lanes];
        let fit = Fit {
            simd,
            block: self,
            grid,
            centre: Native::<S>::from_slice(simd, centre),
            inverse_cut: Native::<S>::from_slice(simd, &self.inverse_cut[..lanes]),
        };
        let wider = (window::wider(self.largest.0), window::wider(self.largest.1));
        let reach = (wider.0 as usize).min(REACH);
        let at = (self.row, self.first);
        let connected = &mut weights.connected;
        let seen =
            grid.links.windows(simd, at, reach, &self.inverse_cut.map(|cut| cut > 0.0), connected);
        weights.frame(self.largest, &seen);
        let first = fit.first_pass(weights).fit();
        let second = fit.second_pass(weights, &first).fit();
        let narrow = fit.narrow(weights, &second);
        if !narrow.any(simd) {
            return narrow.fitted(simd, &narrow, &self.inverse_cut);
        }
        weights.frame(wider, &seen);
        let wide = fit.wide(weights, &second);
        narrow.fitted(simd, &wide, &self.inverse_cut)
    }
}

fn largest(radii: [f32; MOST]) -> f32 {
    radii.into_iter().fold(0.0, f32::max)
}

impl<S: Simd> Fit<'_, S> {
    /// Visits the rows of the windows.
    #[inline(always)]
    fn rows(&self, weights: &mut Weights, mut visit: impl FnMut(WindowRow<'_, S>)) {
        let (top, bottom) = weights.rows;
        let mut rest = &mut *weights.places;
        for k in top..bottom {
            let (first, end) = weights.columns[k];
            let (places, others) = rest.split_at_mut(end - first);
            rest = others;
            let image = self.grid.line(self.block.row + k, self.block.first + first);
            visit(WindowRow {
                y: k as f32 - REACH as f32,
                columns: &COLUMNS[first..end],
                image: &image[..end - first + Native::<S>::LEN - 1],
                connected: S::u32s::from_slice(self.simd, &weights.connected[k][..S::u32s::LEN]),
                places,
            });
        }
    }

    /// Values relative to the centre's, in cuts.
    #[inline(always)]
    fn value(&self, image: &[f32]) -> Native<S> {
        (Native::<S>::from_slice(self.simd, image) - self.centre) * self.inverse_cut
    }

    /// The weight by distance alone, 0 where a pixel is of another surface.
    #[inline(always)]
    fn spatial(
        &self,
        column: &Column,
        connected: S::u32s,
        [from_row, per_col]: [Native<S>; 2],
    ) -> Native<S> {
        let [one, zero] = [1.0, 0.0].map(|number| Native::<S>::splat(self.simd, number));
        let squared = from_row + per_col * column.powers[1];
        let fall = positive(self.simd, one - squared * squared);
        let apart = (connected & S::u32s::splat(self.simd, column.bit))
            .simd_eq(S::u32s::splat(self.simd, 0));
        apart.select(zero, fall * fall)
    }

    /// The weight by the residual of a value.
    #[inline(always)]
    fn robust(&self, value: Native<S>, expected: Native<S>) -> Native<S> {
        let residual = value - expected;
        let inside = positive(self.simd, Native::<S>::splat(self.simd, 1.0) - residual * residual);
        inside * inside
    }

    fn per_radius(&self, radii: &[[f32; MOST]; 2]) -> [Native<S>; 2] {
        radii.each_ref().map(|r| Native::<S>::from_slice(self.simd, &r[..Native::<S>::LEN]))
    }

    /// The sums with weights by distance alone.
    #[inline(always)]
    fn first_pass(&self, weights: &mut Weights) -> Sums<S> {
        let [per_row, per_col] = self.per_radius(&self.block.inverse_radii);
        let mut sums = Sums::zero(self.simd);
        self.rows(
            weights,
            #[inline(always)]
            |WindowRow { y, columns, image, connected, places }| {
                let from_row = per_row * (y * y);
                let mut row = RowSums::zero(self.simd);
                let images = image.windows(Native::<S>::LEN);
                for ((column, image), place) in columns.iter().zip(images).zip(places) {
                    let weight = self.spatial(column, connected, [from_row, per_col]);
                    let value = self.value(image);
                    place.spatial.store::<S>(weight);
                    place.value.store::<S>(value);
                    row.add_weight(column, weight);
                    row.add_value(column, weight * value);
                }
                sums.add_row(y, &row);
            },
        );
        sums
    }

    /// The sums with weights by distance and by the residuals of the last fit.
    #[inline(always)]
    fn second_pass(&self, weights: &mut Weights, last: &Coefficients<S>) -> Sums<S> {
        let mut sums = Sums::zero(self.simd);
        self.rows(
            weights,
            #[inline(always)]
            |WindowRow { y, columns, places, .. }| {
                let expected = RowPolynomial::<S>::new(last, y);
                let mut row = RowSums::zero(self.simd);
                for (column, place) in columns.iter().zip(places) {
                    let value = place.value.load::<S>(self.simd);
                    let robust = self.robust(value, expected.at(column.powers[0]));
                    let weight = place.spatial.load::<S>(self.simd) * robust;
                    row.add_weight(column, weight);
                    row.add_value(column, weight * value);
                }
                sums.add_row(y, &row);
            },
        );
        sums
    }

    /// The estimates by the windows that the first pass visited.
    #[inline(always)]
    fn narrow(&self, weights: &mut Weights, last: &Coefficients<S>) -> Estimates<MOST> {
        let mut sums = Sums::zero(self.simd);
        self.rows(
            weights,
            #[inline(always)]
            |WindowRow { y, columns, places, .. }| {
                let expected = RowPolynomial::<S>::new(last, y);
                let mut row = RowSums::zero(self.simd);
                for (column, place) in columns.iter().zip(places) {
                    let value = place.value.load::<S>(self.simd);
                    let robust = self.robust(value, expected.at(column.powers[0]));
                    let weight = place.spatial.load::<S>(self.simd) * robust;
                    place.robust.store::<S>(weight);
                    row.add_weight(column, weight);
                }
                sums.add_row(y, &row);
            },
        );
        self.at_centre(weights, &sums)
    }

    /// The same by the wider windows.
    #[inline(always)]
    fn wide(&self, weights: &mut Weights, last: &Coefficients<S>) -> Estimates<MOST> {
        let [per_row, per_col] = self.per_radius(&self.block.wider);
        let mut sums = Sums::zero(self.simd);
        self.rows(
            weights,
            #[inline(always)]
            |WindowRow { y, columns, image, connected, places }| {
                let from_row = per_row * (y * y);
                let expected = RowPolynomial::<S>::new(last, y);
                let mut row = RowSums::zero(self.simd);
                let images = image.windows(Native::<S>::LEN);
                for ((column, image), place) in columns.iter().zip(images).zip(places) {
                    let value = self.value(image);
                    let robust = self.robust(value, expected.at(column.powers[0]));
                    let weight = self.spatial(column, connected, [from_row, per_col]) * robust;
                    place.value.store::<S>(value);
                    place.robust.store::<S>(weight);
                    row.add_weight(column, weight);
                }
                sums.add_row(y, &row);
            },
        );
        self.at_centre(weights, &sums)
    }

    /// The fit at the centre from the sums of the weights: a weighted sum of values, and the sum of its
    /// squared weights.
    #[inline(always)]
    fn at_centre(&self, weights: &mut Weights, sums: &Sums<S>) -> Estimates<MOST> {
        let polynomial = sums.centre_weights();
        let zero = Native::<S>::splat(self.simd, 0.0);
        let (mut change, mut variance) = (zero, zero);
        self.rows(
            weights,
            #[inline(always)]
            |WindowRow { y, columns, places, .. }| {
                let of_row = RowPolynomial::<S>::new(&polynomial, y);
                for (column, place) in columns.iter().zip(places) {
                    let share = place.robust.load::<S>(self.simd) * of_row.at(column.powers[0]);
                    change += share * place.value.load::<S>(self.simd);
                    variance += share * share;
                }
            },
        );
        let mut found = Estimates::none();
        change.store_slice(&mut found.changes[..Native::<S>::LEN]);
        variance.store_slice(&mut found.variances[..Native::<S>::LEN]);
        found
    }
}
