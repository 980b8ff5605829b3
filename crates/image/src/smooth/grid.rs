//! The fitted quantity and the unbroken pairs of every pixel, with a margin for windows.

use super::lanes::MOST;
use super::links::Links;
use super::pairs::{Line, Pairs};
use super::quantity::Quantity;
use crate::tuning::HALF_WINDOW;
use crate::{BreakRule, RangeNoise};
use fearless_simd::Simd;
use transect_device::{ImageSize, Neighbour, Pixel, View};

/// The fitted quantity of an image, with a margin on all sides.
#[derive(Debug)]
pub(super) struct Grid<'a> {
    stride: usize,
    /// Columns beyond either side that a full circle has there once more.
    beyond: usize,
    /// The fitted quantity; 0 where missing or outside the image.
    quantities: Vec<f32>,
    /// Distance between the rows of a window that are read; the centre's row is one of them.
    pub rows_apart: usize,
    /// Which pixels belong to one surface.
    pub links: Links,
    size: ImageSize,
    pub pairs: Pairs<'a>,
}

impl<'a> Grid<'a> {
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        view: &'a View,
        (rule, noise): (&'a BreakRule, &RangeNoise),
        quantity: Quantity,
    ) -> Self {
        let size = view.image().size();
        let stride = size.cols + 2 * HALF_WINDOW + MOST;
        let wraps = view.frame().columns_wrap();
        let mut grid = Self {
            stride,
            // A full circle goes on where it began; an image smaller than a window does not.
            beyond: if wraps && size.cols > 2 * HALF_WINDOW { HALF_WINDOW } else { 0 },
            quantities: vec![0.0; stride * (size.rows + 2 * HALF_WINDOW)],
            rows_apart: if noise.is_mostly_shared() { 2 } else { 1 },
            links: Links::new(size.rows, size.cols),
            size,
            pairs: Pairs::new(view, rule),
        };
        let [mut above, mut here] = [Line::missing(size.cols), Line::missing(size.cols)];
        let mut bits = [0; 2].map(|_| vec![0; size.cols.div_ceil(64)]);
        for row in 0..size.rows {
            let values = view.image().row(row);
            grid.read_values(row, values, quantity);
            here.read(values, wraps);
            let [left, up] = &mut bits;
            grid.pairs.read(simd, row, [&above, &here], [left, up]);
            grid.links.set_row(row, bits.each_ref().map(Vec::as_slice), (size.cols, grid.beyond));
            std::mem::swap(&mut above, &mut here);
        }
        grid
    }

    #[inline(always)]
    fn read_values(&mut self, row: usize, values: &[f32], quantity: Quantity) {
        let start = (row + HALF_WINDOW) * self.stride;
        let line = &mut self.quantities[start..start + self.stride];
        let image = &mut line[HALF_WINDOW..HALF_WINDOW + values.len()];
        match quantity {
            Quantity::Value => image.copy_from_slice(values),
            Quantity::Inverse => {
                for (quantity, value) in image.iter_mut().zip(values) {
                    *quantity = 1.0 / *value;
                }
            }
        }
        for quantity in image {
            *quantity = if quantity.is_nan() { 0.0 } else { *quantity };
        }
        let cols = values.len();
        line.copy_within(
            HALF_WINDOW + cols - self.beyond..HALF_WINDOW + cols,
            HALF_WINDOW - self.beyond,
        );
        line.copy_within(HALF_WINDOW..HALF_WINDOW + self.beyond, HALF_WINDOW + cols);
    }

    /// Distances between neighbouring rays of the row, and of the column, at a pixel; `None` where
    /// it has no neighbour on its surface.
    #[inline(always)]
    pub fn spacings(&self, pixel: Pixel) -> Option<(f32, f32)> {
        let Pixel { row, col } = pixel;
        // The pair after the pixel counts, or else the one before: they differ by noise alone.
        let next = if col + 1 < self.size.cols { col + 1 } else { 0 };
        let right = Pixel { row, col: next };
        let below = Pixel { row: row + 1, col };
        let joined = |(of, kind): (Pixel, Neighbour)| {
            let (row, place) = (of.row + HALF_WINDOW, of.col + HALF_WINDOW);
            match kind {
                Neighbour::Left => self.links.left(row, place),
                Neighbour::Up => self.links.up(row, place),
            }
        };
        let one_of = |kind, later| {
            let later = (later, kind);
            let pair = if joined(later) {
                Some(later)
            } else {
                Some((pixel, kind)).filter(|p| joined(*p))
            };
            pair.and_then(|(of, kind)| self.pairs.lateral(of, kind))
        };
        Some((one_of(Neighbour::Left, right)?, one_of(Neighbour::Up, below)?))
    }

    /// The quantities from a place of a line on, for windows to be read from; rows, too, are
    /// counted from [`HALF_WINDOW`] before the image.
    pub fn line(&self, row: usize, place: usize) -> &[f32] {
        &self.quantities[row * self.stride + place..]
    }
}
