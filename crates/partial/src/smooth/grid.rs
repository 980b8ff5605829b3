//! What the fit needs of every pixel, with room for a window around each.

use super::REACH;
use super::lanes::{LANES, Lanes};
use super::links::Links;
use super::quantity::Quantity;
use crate::BreakRule;
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use transect_device::{Neighbour, PairGeometry, View};

/// The image as the fit sees it.
#[derive(Debug)]
pub(super) struct Grid {
    stride: usize,
    /// The fitted quantity, 0 where missing or outside the image.
    quantities: Vec<f32>,
    /// Which pixels belong to one surface.
    pub links: Links,
    /// Distance between neighbouring rays of a row, and of a column, at each pixel; NaN where it
    /// has no neighbour on its surface.
    pub spacings: Vec<[f32; 2]>,
}

impl Grid {
    pub fn new(view: &View, rule: &BreakRule, quantity: Quantity) -> Self {
        let size = view.image().size();
        let stride = size.cols + 2 * REACH + LANES;
        let mut grid = Self {
            stride,
            quantities: vec![0.0; stride * (size.rows + 2 * REACH)],
            links: Links::new(size.rows, size.cols),
            spacings: vec![[f32::NAN; 2]; size.pixels()],
        };
        let mut pairs = [Neighbour::Left, Neighbour::Up]
            .map(|neighbour| (neighbour, vec![PairGeometry::MISSING; size.cols]));
        for row in 0..size.rows {
            grid.read_values(view, row, quantity);
            for (neighbour, pairs) in &mut pairs {
                view.frame().pair_row(view.image(), row, *neighbour, pairs);
            }
            let [(_, left), (_, up)] = &pairs;
            grid.read_pairs(view, row, rule, (left, up));
        }
        grid
    }

    /// The columns of the image, and those that a window sees beyond its sides, each with its
    /// place counted from `REACH` columns before the image.
    fn columns(view: &View) -> impl Iterator<Item = (usize, usize)> {
        let cols = view.image().size().cols;
        // A full circle goes on where it began; an image smaller than a window does not.
        let beyond = if view.frame().columns_wrap() && cols > 2 * REACH { REACH } else { 0 };
        let places = REACH - beyond..REACH + cols + beyond;
        places.map(move |place| ((place + cols - REACH) % cols, place))
    }

    fn read_values(&mut self, view: &View, row: usize, quantity: Quantity) {
        let values = view.image().row(row);
        let start = (row + REACH) * self.stride;
        for (col, place) in Self::columns(view) {
            if !values[col].is_nan() {
                let value = quantity.of_value(f64::from(values[col]));
                self.quantities[start + place] = value as f32;
            }
        }
    }

    fn read_pairs(
        &mut self,
        view: &View,
        row: usize,
        rule: &BreakRule,
        (left, up): (&[PairGeometry], &[PairGeometry]),
    ) {
        let cols = left.len();
        for (col, place) in Self::columns(view) {
            self.links.set(row, place, rule.holds(&left[col]), rule.holds(&up[col]));
        }
        for col in 0..cols {
            let pixel = row * cols + col;
            // The pair after the pixel counts, or else the one before: they differ by noise alone.
            let beside = [left[(col + 1) % cols], left[col]].into_iter().find(|p| rule.holds(p));
            self.spacings[pixel][0] = beside.map_or(f32::NAN, |pair| pair.lateral);
            if rule.holds(&up[col]) {
                self.spacings[pixel][1] = up[col].lateral;
                self.spacings[pixel.saturating_sub(cols)][1] = up[col].lateral;
            }
        }
    }

    /// The quantity of [`LANES`] pixels from a place that is off a pixel by some rows and columns;
    /// both offsets are counted from the window's corner.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, row: usize, col: usize) -> Lanes<S> {
        let start = row * self.stride + col;
        Lanes::from_slice(simd, &self.quantities[start..start + LANES])
    }
}
