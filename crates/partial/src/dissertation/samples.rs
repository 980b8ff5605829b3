//! The part of a view that all planes share: levels, and which neighbours are of one surface.

use super::JumpTest;
use crate::pixel_grid::Grid;
use crate::{SectionAxes, continuation};
use transect_device::{Neighbour, PairGeometry, Pixel, View};
use transect_image::BreakRule;

/// A view, prepared once for all planes.
#[derive(Debug)]
pub(super) struct Samples<'a> {
    pub view: &'a View,
    pub axes: &'a SectionAxes,
    pub grid: Grid,
    pub jump: JumpTest,
    /// Level of every pixel from the axes' base, in intervals; NaN where missing.
    levels: Vec<f64>,
    rule: BreakRule,
    up: Vec<bool>,
    left: Vec<bool>,
    /// Pairs of valid neighbours that are of two surfaces.
    pub jumps: usize,
}

impl<'a> Samples<'a> {
    /// `sigma` is the range noise in the length unit.
    pub fn new(view: &'a View, axes: &'a SectionAxes, jump: JumpTest, sigma: f64) -> Self {
        let grid = Grid::new(view.frame());
        let level = |p| view.point_in_sensor(p).map_or(f64::NAN, |p| axes.level().at(&p));
        let levels = grid.pixels().map(level).collect();
        let rule = jump.break_rule(sigma);
        let (up, left) = (Vec::new(), Vec::new());
        let mut samples = Self { view, axes, grid, jump, levels, rule, up, left, jumps: 0 };
        samples.up = samples.pairs(Neighbour::Up);
        samples.left = samples.pairs(Neighbour::Left);
        samples
    }

    /// Of every pixel, whether it and a neighbour are of one surface.
    fn pairs(&mut self, neighbour: Neighbour) -> Vec<bool> {
        let size = self.grid.size();
        let mut row_pairs = vec![PairGeometry::MISSING; size.cols];
        let mut joined = Vec::with_capacity(size.pixels());
        for row in 0..size.rows {
            self.view.frame().pair_row(self.view.image(), row, neighbour, &mut row_pairs);
            joined.extend(row_pairs.iter().map(|pair| self.rule.holds(pair)));
            let known = row_pairs.iter().filter(|p| !p.range_step.is_nan());
            self.jumps += known.filter(|p| !self.rule.holds(p)).count();
        }
        joined
    }

    /// Level of a pixel from the base; `None` where missing.
    pub fn level(&self, p: Pixel) -> Option<f64> {
        self.levels.get(self.grid.index(p)).copied().filter(|l| !l.is_nan())
    }

    /// Smallest and largest level.
    pub fn extremes(&self) -> (f64, f64) {
        let valid = self.levels.iter().filter(|l| !l.is_nan());
        valid.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), l| (l.min(a), l.max(b)))
    }

    /// Whether a pixel and a neighbour are of one surface; false where one is missing.
    pub fn joined(&self, p: Pixel, neighbour: Neighbour) -> bool {
        let pairs = match neighbour {
            Neighbour::Up => &self.up,
            Neighbour::Left => &self.left,
        };
        pairs.get(self.grid.index(p)).copied().unwrap_or(false)
    }

    /// Whether a curve that runs from one pixel towards another, and misses it by a length, stays
    /// on one surface.
    pub fn continues(&self, a: Pixel, b: Pixel, miss: Option<f64>) -> bool {
        continuation::continues(self.view, &self.grid, &self.rule, [a, b], miss)
    }

    /// Whether two pixels that need not be neighbours pass for samples of one surface.
    pub fn alike(&self, a: Pixel, b: Pixel) -> bool {
        continuation::alike(self.view, &self.rule, a, b)
    }
}
