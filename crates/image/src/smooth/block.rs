//! The robust fit of some neighbouring pixels of a row, side by side.
//!
//! A block has as many pixels as the processor has numbers in a vector. The fit of a pixel is the
//! same to the bit with any number of others beside it. Places of the window are visited one after
//! the other, and the numbers of a place are kept in the order of the visits, so inner loops step
//! through plain slices.

use super::estimate::{Estimates, Fitted};
use super::grid::Grid;
use super::lanes::{MOST, Native, all, positive};
use super::normal_equations::{COLUMNS, Coefficients, Column, RowPolynomial, RowSums, Sums};
use super::{SmoothingSteps, window};
use crate::tuning::{CUT, HALF_WINDOW, WINDOW_COLUMNS};
use fearless_simd::Simd;
use fearless_simd::prelude::*;

/// The pixels that are fitted together, each with its own window.
#[derive(Debug)]
pub(super) struct Block {
    row: usize,
    first: usize,
    /// `1 / radius²` in rows and columns; 0 for pixels that are not fitted.
    inverse_radii: [[f32; MOST]; 2],
    /// The same for the wider windows.
    wider: [[f32; MOST]; 2],
    inverse_cut: [f32; MOST],
    /// Largest radius of any pixel, in rows and in columns.
    largest: [f32; 2],
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

/// The numbers of one place of the windows.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Relative to the centre's, in cuts.
    value: Numbers,
    /// Weight by distance from the centre; 0 where a pixel is of another surface.
    spatial: Numbers,
    /// Weight by distance and residual.
    weight: Numbers,
}

/// The places of a block's windows; memory that blocks use one after another.
#[derive(Debug)]
pub(super) struct Workspace {
    /// One after the other, in the order of [`Workspace::columns`].
    places: Box<[Place]>,
    /// For each row of the window, the columns that are connected to each pixel's centre.
    connected: [[u32; MOST]; WINDOW_COLUMNS],
    /// The first column and the one after the last, for each row of the window.
    columns: [(usize, usize); WINDOW_COLUMNS],
    /// The first row of the window and the one after the last.
    rows: (usize, usize),
}

impl Workspace {
    pub fn new() -> Self {
        let none = Numbers([0.0; MOST]);
        let none = Place { value: none, spatial: none, weight: none };
        Self {
            places: vec![none; WINDOW_COLUMNS * WINDOW_COLUMNS].into_boxed_slice(),
            connected: [[0; MOST]; WINDOW_COLUMNS],
            columns: [(0, 0); WINDOW_COLUMNS],
            rows: (0, 0),
        }
    }

    /// Sets the rows and columns that the windows of a block can reach. Places that are connected
    /// to none of its pixels are left out; their weights would be 0.
    fn frame(&mut self, [rows, cols]: [f32; 2], any: &[u32; WINDOW_COLUMNS]) {
        let reach = (rows as usize).min(HALF_WINDOW);
        // Rows go on from the centre's, so they end at the first without a connected pixel.
        let above = (HALF_WINDOW - reach..HALF_WINDOW).rev().take_while(|k| any[*k] != 0);
        let top = above.last().unwrap_or(HALF_WINDOW);
        let below = (HALF_WINDOW + 1..=HALF_WINDOW + reach).take_while(|k| any[*k] != 0);
        self.rows = (top, below.last().unwrap_or(HALF_WINDOW) + 1);
        for (k, any) in any.iter().enumerate().take(self.rows.1).skip(self.rows.0) {
            let y = k as f32 - HALF_WINDOW as f32;
            // Room for rounding, so that a pixel's fit does not depend on the others of its block.
            let share = (1.0 - (y / rows).powi(2)).max(0.0) + 1e-5;
            let half = ((share.sqrt() * cols) as usize).min(HALF_WINDOW);
            let (first, end) = (any.trailing_zeros(), u32::BITS - any.leading_zeros());
            let first = (HALF_WINDOW - half).max(first as usize);
            self.columns[k] = (first, (HALF_WINDOW + half + 1).min(end as usize).max(first));
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

impl Block {
    /// A block without pixels; its first pixel is in a row and a column of the image.
    pub fn new(row: usize, first: usize) -> Self {
        let none = [0.0; MOST];
        let (inverse_radii, wider) = ([none; 2], [none; 2]);
        Self { row, first, inverse_radii, wider, inverse_cut: none, largest: [0.0; 2], radii: none }
    }

    /// Adds a pixel with a window of some radii in rows and columns. `inverse_sigma` is 1 over the
    /// standard deviation of its quantity.
    #[inline(always)]
    pub fn add(&mut self, lane: usize, radii: [f32; 2], inverse_sigma: f32) {
        let inverse_square = |radius: f32| 1.0 / (radius * radius);
        for (axis, radius) in radii.into_iter().enumerate() {
            self.inverse_radii[axis][lane] = inverse_square(radius);
            self.wider[axis][lane] = inverse_square(window::wider(radius));
            self.largest[axis] = self.largest[axis].max(radius);
        }
        self.inverse_cut[lane] = inverse_sigma * (1.0 / CUT);
        self.radii[lane] = (radii[0] * radii[1]).sqrt();
    }

    pub fn is_empty(&self) -> bool {
        self.largest[0] == 0.0
    }

    /// Radii of the windows that the results come from.
    #[inline(always)]
    pub fn radii(&self, shares: &[f32; MOST]) -> [f32; MOST] {
        std::array::from_fn(|lane| window::between(self.radii[lane], shares[lane]))
    }

    /// Fits all pixels. The unit of values is the cut, so that single precision is enough.
    #[inline(always)]
    pub fn fit<S: Simd>(
        &self,
        simd: S,
        grid: &Grid<'_>,
        steps: SmoothingSteps,
        work: &mut Workspace,
    ) -> Fitted {
        let lanes = Native::<S>::LEN;
        let centre = &grid.line(self.row + HALF_WINDOW, self.first + HALF_WINDOW)[..lanes];
        let fit = Fit {
            simd,
            block: self,
            grid,
            centre: Native::<S>::from_slice(simd, centre),
            inverse_cut: Native::<S>::from_slice(simd, &self.inverse_cut[..lanes]),
        };
        let wider = self.largest.map(window::wider);
        let reach = (wider[0] as usize).min(HALF_WINDOW);
        let fitted = self.inverse_cut.map(|cut| cut > 0.0);
        let at = (self.row, self.first);
        let any = grid.links.windows(simd, at, reach, &fitted, &mut work.connected);
        work.frame(self.largest, &any);
        let radii = &self.inverse_radii;
        let mut last = None;
        let sums = if steps.robust_weights {
            let first = fit.pass::<true>(work, Some(radii), None).fit();
            let second = &*last.insert(fit.pass::<true>(work, None, Some(&first)).fit());
            fit.pass::<false>(work, None, Some(second))
        } else {
            fit.pass::<false>(work, Some(radii), None)
        };
        let narrow = fit.at_centre(work, &sums);
        if narrow.hold() == 0 || !steps.wider_window {
            return narrow.fitted(&narrow, fit.inverse_cut);
        }
        work.frame(wider, &any);
        let sums = fit.pass::<false>(work, Some(&self.wider), last.as_ref());
        narrow.fitted(&fit.at_centre(work, &sums), fit.inverse_cut)
    }
}

/// The fit of one block.
#[derive(Clone, Copy)]
struct Fit<'a, S: Simd> {
    simd: S,
    block: &'a Block,
    grid: &'a Grid<'a>,
    centre: Native<S>,
    inverse_cut: Native<S>,
}

impl<S: Simd> Fit<'_, S> {
    /// The sums over the windows, with weights by distance and, after a fit, by its residuals.
    ///
    /// `inverse_radii` are those of new windows; without them, values and weights by distance are
    /// those of the pass before. With `VALUES`, the sums hold the values for a fit; without, the
    /// weights are kept for [`Fit::at_centre`].
    #[inline(always)]
    fn pass<const VALUES: bool>(
        &self,
        work: &mut Workspace,
        inverse_radii: Option<&[[f32; MOST]; 2]>,
        last: Option<&Coefficients<S>>,
    ) -> Sums<S> {
        let radii = inverse_radii.map(|radii| {
            radii.each_ref().map(|r| Native::<S>::from_slice(self.simd, &r[..Native::<S>::LEN]))
        });
        let mut sums = Sums::zero(self.simd);
        self.rows(
            work,
            #[inline(always)]
            |WindowRow { y, columns, image, connected, places }| {
                let radii = radii.map(|[per_row, per_col]| [per_row * (y * y), per_col]);
                let expected = last.map(|last| RowPolynomial::<S>::new(last, y));
                let mut row = RowSums::zero(self.simd);
                let images = image.windows(Native::<S>::LEN);
                for ((column, image), place) in columns.iter().zip(images).zip(places) {
                    if let Some(radii) = radii {
                        place.spatial.store::<S>(self.spatial(column, connected, radii));
                        place.value.store::<S>(self.value(image));
                    }
                    let value = place.value.load::<S>(self.simd);
                    let mut weight = place.spatial.load::<S>(self.simd);
                    if let Some(expected) = &expected {
                        weight *= self.robust(value - expected.at(column.powers[0]));
                    }
                    row.add_weight(column, weight);
                    if VALUES {
                        row.add_value(column, weight * value);
                    } else {
                        place.weight.store::<S>(weight);
                    }
                }
                sums.add_row(y, &row);
            },
        );
        sums
    }

    /// Visits the rows of the windows.
    #[inline(always)]
    fn rows(&self, work: &mut Workspace, mut visit: impl FnMut(WindowRow<'_, S>)) {
        let (top, bottom) = work.rows;
        let mut rest = &mut *work.places;
        for k in top..bottom {
            let (first, end) = work.columns[k];
            let (places, others) = rest.split_at_mut(end - first);
            rest = others;
            let image = self.grid.line(self.block.row + k, self.block.first + first);
            visit(WindowRow {
                y: k as f32 - HALF_WINDOW as f32,
                columns: &COLUMNS[first..end],
                image: &image[..end - first + Native::<S>::LEN - 1],
                connected: S::u32s::from_slice(self.simd, &work.connected[k][..S::u32s::LEN]),
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
        let squared = from_row + per_col * column.powers[1];
        let fall = positive(self.simd, all(self.simd, 1.0) - squared * squared);
        let apart = (connected & S::u32s::splat(self.simd, column.bit))
            .simd_eq(S::u32s::splat(self.simd, 0));
        apart.select(all(self.simd, 0.0), fall * fall)
    }

    /// The weight by a residual: Tukey's biweight.
    #[inline(always)]
    fn robust(&self, residual: Native<S>) -> Native<S> {
        let inside = positive(self.simd, all(self.simd, 1.0) - residual * residual);
        inside * inside
    }

    /// The fit at the centre: a weighted sum of values, and the sum of its squared weights.
    #[inline(always)]
    fn at_centre(&self, work: &mut Workspace, sums: &Sums<S>) -> Estimates<S> {
        let polynomial = sums.centre_weights();
        let zero = all(self.simd, 0.0);
        let (mut change, mut variance) = (zero, zero);
        self.rows(
            work,
            #[inline(always)]
            |WindowRow { y, columns, places, .. }| {
                let of_row = RowPolynomial::<S>::new(&polynomial, y);
                for (column, place) in columns.iter().zip(places) {
                    let weight = place.weight.load::<S>(self.simd);
                    let share = weight * of_row.at(column.powers[0]);
                    change += share * place.value.load::<S>(self.simd);
                    variance += share * share;
                }
            },
        );
        Estimates::new(self.simd, change, variance)
    }
}
