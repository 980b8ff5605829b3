//! The robust fit of some neighbouring pixels of a row, side by side.
//!
//! A block has as many pixels as the processor has numbers in a vector. The fit of a pixel is the
//! same to the bit with any number of others beside it. The two places of a row at the same
//! distance from its middle are visited together: they share the weight by distance. The sums of
//! odd powers need their difference alone, the sums of even powers their sum. The numbers of a
//! place are kept in the order of the visits, so inner loops step through plain slices.

use super::estimate::{Estimates, Fitted};
use super::grid::Grid;
use super::lanes::{MOST, Native, all, positive};
use super::normal_equations::{COLUMNS, Coefficients, RowPolynomial, RowSums, Sums};
use super::{SmoothingSteps, window};
use crate::tuning::{CUT, HALF_WINDOW, WIDER, WIDEST_RADIUS, WINDOW_COLUMNS};
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
    /// One after the other, row by row: the middle, then pairs going outward.
    places: Box<[Place]>,
    /// For each row of the window, the columns that are connected to each pixel's centre.
    connected: [[u32; MOST]; WINDOW_COLUMNS],
    /// Columns on either side of the middle, for each row of the window.
    halves: [usize; WINDOW_COLUMNS],
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
            halves: [0; WINDOW_COLUMNS],
            rows: (0, 0),
        }
    }

    /// Sets the rows and columns that the windows of a block can reach. Places that are connected
    /// to none of its pixels are left out; their weights would be 0.
    #[inline(always)]
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
            // Even the centre's row has no connected pixel if all weights of the block are 0.
            let last = any.checked_ilog2().unwrap_or(0) as usize;
            let first = any.trailing_zeros() as usize;
            let farthest = HALF_WINDOW.saturating_sub(first).max(last.saturating_sub(HALF_WINDOW));
            self.halves[k] = half.min(farthest);
        }
    }
}

/// The inputs of a row of the windows.
struct Source<'a, S: Simd> {
    /// The image from the first pixel's place in the first column on.
    image: &'a [f32],
    connected: S::u32s,
}

/// A row of the windows of a block.
struct WindowRow<'a, S: Simd> {
    /// Rows from the centre's.
    y: f32,
    /// Columns on either side of the middle.
    half: usize,
    source: Source<'a, S>,
    middle: &'a mut Place,
    /// The places on the left and on the right, going outward.
    pairs: &'a mut [[Place; 2]],
}

/// The scales of the windows of a block, by lane; 0 for pixels that are not fitted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scales {
    /// Distances between neighbouring rays of the row.
    pub across: [f32; MOST],
    /// The same of the column.
    pub down: [f32; MOST],
    /// Standard deviation of the sample, as a length along the ray.
    pub sigma: [f32; MOST],
    /// 1 over the standard deviation of the fitted quantity.
    pub inverse_sigma: [f32; MOST],
}

impl Block {
    /// A block whose first pixel is in a row and a column of the image. Pixels whose noise is
    /// negligible are left out.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, row: usize, first: usize, scales: &Scales) -> Self {
        let lanes = ..Native::<S>::LEN;
        let read = |numbers: &[f32; MOST]| Native::<S>::from_slice(simd, &numbers[lanes]);
        let Scales { across, down, sigma, inverse_sigma } = scales;
        let inverse_sigma = read(inverse_sigma);
        let [zero, one] = [0.0, 1.0].map(|number| all(simd, number));
        let radii = window::radii(simd, [across, down, sigma].map(read));
        let fitted = radii[0].simd_gt(zero) & inverse_sigma.simd_gt(zero);
        let stored = |numbers: Native<S>| {
            let mut stored = [0.0; MOST];
            fitted.select(numbers, zero).store_slice(&mut stored[lanes]);
            stored
        };
        let wide = radii.map(|radius| (radius * WIDER).min(all(simd, WIDEST_RADIUS)));
        Self {
            row,
            first,
            inverse_radii: radii.map(|radius| stored(one / (radius * radius))),
            wider: wide.map(|radius| stored(one / (radius * radius))),
            inverse_cut: stored(inverse_sigma * (1.0 / CUT)),
            largest: radii.map(|radii| stored(radii).into_iter().fold(0.0, f32::max)),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.largest[0] == 0.0
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
            |WindowRow { y, half, source, middle, pairs }| {
                let expected = last.map(|last| RowPolynomial::<S>::new(last, y));
                let (mut fall, mut at) = (None, [None; 2]);
                let radii = radii.map(|[per_row, per_col]| [per_row * (y * y), per_col]);
                if let Some(radii) = radii {
                    fall = Some(self.fall(0.0, radii));
                }
                if let Some(expected) = &expected {
                    at[0] = Some(expected.middle());
                }
                let bit = 1 << HALF_WINDOW;
                let first = self.weigh::<VALUES>(middle, fall, (&source, half, bit), at[0]);
                let mut row = RowSums::new(self.simd, first);
                for (x, (column, [left, right_place])) in (1..).zip(COLUMNS.iter().zip(pairs)) {
                    if let Some(radii) = radii {
                        fall = Some(self.fall(column.powers[1], radii));
                    }
                    if let Some(expected) = &expected {
                        let [left, right] = expected.at(column);
                        at = [Some(left), Some(right)];
                    }
                    let [bit, other] = column.bits;
                    let left = self.weigh::<VALUES>(left, fall, (&source, half - x, bit), at[0]);
                    let right = (&source, half + x, other);
                    let right = self.weigh::<VALUES>(right_place, fall, right, at[1]);
                    row.add_weights(column, [left[0], right[0]]);
                    if VALUES {
                        row.add_values(column, [left[1], right[1]]);
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
        let apart = self.grid.rows_apart;
        for k in (top..bottom).filter(|k| k.abs_diff(HALF_WINDOW).is_multiple_of(apart)) {
            let half = work.halves[k];
            let (places, others) = rest.split_at_mut(1 + 2 * half);
            rest = others;
            let Some((middle, pairs)) = places.split_first_mut() else { return };
            let first = self.block.first + HALF_WINDOW - half;
            let image = &self.grid.line(self.block.row + k, first)[..2 * half + Native::<S>::LEN];
            let connected = S::u32s::from_slice(self.simd, &work.connected[k][..S::u32s::LEN]);
            visit(WindowRow {
                y: k as f32 - HALF_WINDOW as f32,
                half,
                source: Source { image, connected },
                middle,
                pairs: pairs.as_chunks_mut().0,
            });
        }
    }

    /// The weight of a place and its weighted value, from what the pass before left there. In a new
    /// window they follow from the weight by distance, the column and the bit of its connection.
    /// `expected` is the value of the last fit.
    #[inline(always)]
    fn weigh<const VALUES: bool>(
        &self,
        place: &mut Place,
        fall: Option<Native<S>>,
        (source, column, bit): (&Source<'_, S>, usize, u32),
        expected: Option<Native<S>>,
    ) -> [Native<S>; 2] {
        if let Some(fall) = fall {
            place.spatial.store::<S>(self.if_connected(fall, source.connected, bit));
            place.value.store::<S>(self.value(&source.image[column..]));
        }
        let value = place.value.load::<S>(self.simd);
        let mut weight = place.spatial.load::<S>(self.simd);
        if let Some(expected) = expected {
            weight *= self.robust(value - expected);
        }
        if !VALUES {
            place.weight.store::<S>(weight);
        }
        [weight, weight * value]
    }

    /// Values relative to the centre's, in cuts.
    #[inline(always)]
    fn value(&self, image: &[f32]) -> Native<S> {
        (Native::<S>::from_slice(self.simd, &image[..Native::<S>::LEN]) - self.centre)
            * self.inverse_cut
    }

    /// The weight by distance alone.
    #[inline(always)]
    fn fall(&self, x2: f32, [from_row, per_col]: [Native<S>; 2]) -> Native<S> {
        let squared = from_row + per_col * x2;
        let fall = positive(self.simd, all(self.simd, 1.0) - squared * squared);
        fall * fall
    }

    /// A weight, or 0 where the pixel of a bit is of another surface.
    #[inline(always)]
    fn if_connected(&self, weight: Native<S>, connected: S::u32s, bit: u32) -> Native<S> {
        let apart =
            (connected & S::u32s::splat(self.simd, bit)).simd_eq(S::u32s::splat(self.simd, 0));
        apart.select(all(self.simd, 0.0), weight)
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
        let mut sums = [all(self.simd, 0.0); 2];
        self.rows(
            work,
            #[inline(always)]
            |WindowRow { y, middle, pairs, .. }| {
                let of_row = RowPolynomial::<S>::new(&polynomial, y);
                self.add_share(middle, of_row.middle(), &mut sums);
                for (column, [left, right]) in COLUMNS.iter().zip(pairs) {
                    let at = of_row.at(column);
                    self.add_share(left, at[0], &mut sums);
                    self.add_share(right, at[1], &mut sums);
                }
            },
        );
        let [change, variance] = sums;
        Estimates::new(self.simd, change, variance)
    }

    /// Adds a place's share of the fit at the centre, and its square.
    #[inline(always)]
    fn add_share(&self, place: &Place, polynomial: Native<S>, sums: &mut [Native<S>; 2]) {
        let share = place.weight.load::<S>(self.simd) * polynomial;
        sums[0] += share * place.value.load::<S>(self.simd);
        sums[1] += share * share;
    }
}
