//! Curves that only noise makes, where the surface is nearly tangent to the plane.
//!
//! **Problem.** Where a plane runs within the noise of a surface, the samples are over and under it
//! at random, and the section falls into loops and scraps. Their length tells nothing: a hole, a
//! leg or the top of a ball may be as short.
//!
//! **Idea.** A curve parts a region of high samples from a region of low ones. It is real if both
//! regions leave the plane by more than noise does. Noise moves a sample along its ray `d`, so its
//! height over the plane has the standard deviation `σ |d · m|` with the plane's normal `m`. σ
//! includes the noise that neighbours share: it moves a region as a whole. A plane that holds the
//! rays has no such noise, however obliquely it meets the surface. A region
//! that nowhere rises (or falls) by some of these deviations might as well not be there, and all
//! curves around it are left out together. This is the simplification of contours by persistence
//! (Edelsbrunner, Letscher and Zomorodian, 2002) with a threshold for each sample.
//!
//! **Steps**, for each line of a plane.
//! 1. The samples beside the line: on nearly all surfaces the first few leave the plane far enough
//!    on both sides.
//! 2. On a side where none does, the region is followed from sample to sample, along rows and
//!    columns and not across range jumps, until one does or it ends.
//!
//! **Cost.** Samples within noise of a plane are visited once for it, and others hardly at all.

use super::bridge::Solved;
use super::contours::Contours;
use crate::pixel_grid::Grid;
use crate::{MAX_LEVELS, SectionAxes};
use transect_device::{Pixel, View};
use transect_image::BreakRule;
use transect_image::PreparedView;

/// More than the level of any plane of a view, counted from its base.
const BEYOND_LEVELS: i32 = MAX_LEVELS as i32 + 1;

/// Finds the curves that only noise makes.
pub(super) struct NearTangent<'a> {
    view: &'a View,
    prepared: &'a PreparedView<'a>,
    axes: &'a SectionAxes,
    rule: &'a BreakRule,
    grid: Grid,
    /// Standard deviations that a region must leave the plane by.
    sigmas: f64,
    /// Of every pixel, what is known of its region for a plane; see [`Seen::packed`].
    seen: Vec<u32>,
    /// Pixels that are being followed.
    stack: Vec<Pixel>,
    visited: Vec<usize>,
}

/// The result for a pixel's region on the plane at a level.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    level: i32,
    leaves: bool,
}

impl Seen {
    /// As a number that is not 0: 0 stands for a pixel that was not visited, since memory full of
    /// it costs nothing where it is never looked at.
    fn packed(self) -> u32 {
        ((self.level + BEYOND_LEVELS) as u32) << 1 | u32::from(self.leaves)
    }

    fn of(packed: u32) -> Option<Self> {
        let level = (packed >> 1) as i32 - BEYOND_LEVELS;
        (packed > 0).then_some(Self { level, leaves: packed & 1 == 1 })
    }
}

impl<'a> NearTangent<'a> {
    pub fn new(
        view: &'a View,
        prepared: &'a PreparedView<'a>,
        axes: &'a SectionAxes,
        rule: &'a BreakRule,
        sigmas: f64,
    ) -> Self {
        let grid = Grid::new(view.frame());
        let (seen, stack, visited) = (Vec::new(), Vec::new(), Vec::new());
        Self { view, prepared, axes, rule, grid, sigmas, seen, stack, visited }
    }

    /// Whether noise alone explains a line.
    pub fn is_noise(&mut self, solved: &Solved<'_>, contours: &Contours<'_>) -> bool {
        if self.sigmas <= 0.0 || self.prepared.sigma() <= 0.0 {
            return false;
        }
        let mut leaves = [false; 2];
        for (vertex, crossing) in solved.line.vertices.iter().zip(solved.crossings) {
            let heights = crossing.heights();
            for (pixel, height) in contours.pair(vertex).1.into_iter().zip(heights) {
                let side = usize::from(height > 0.0);
                leaves[side] = leaves[side] || self.leaves(pixel, height);
            }
            if leaves == [true; 2] {
                return false;
            }
        }
        let level = solved.line.level;
        [0, 1].into_iter().any(|side| {
            let mut pixels = solved.line.vertices.iter().flat_map(|v| contours.pair(v).1);
            !leaves[side]
                && !pixels
                    .any(|p| self.side(p, level) == Some(side) && self.region_leaves(p, level))
        })
    }

    /// Height of a pixel's sample over a plane, in the length unit; `None` where missing.
    fn height(&self, p: Pixel, level: i32) -> Option<f64> {
        let point = self.view.point_in_sensor(p)?;
        Some((self.axes.level().at(&point) - f64::from(level)) * self.axes.interval())
    }

    /// 1 for a high pixel, 0 for a low one; a pixel on the plane counts as low.
    fn side(&self, p: Pixel, level: i32) -> Option<usize> {
        self.height(p, level).map(|height| usize::from(height > 0.0))
    }

    /// Whether a sample is farther from the plane than noise explains.
    fn leaves(&self, p: Pixel, height: f64) -> bool {
        let Some(ray) = self.view.frame().ray(p) else { return true };
        let rise = self.axes.turn(&ray.direction).z.abs();
        height.abs() >= self.sigmas * self.prepared.sigma_of_group(p) * rise
    }

    /// Whether the region of a pixel leaves the plane somewhere.
    fn region_leaves(&mut self, start: Pixel, level: i32) -> bool {
        let count = self.grid.size().pixels();
        if self.seen.len() != count {
            self.seen = vec![0; count];
        }
        let Some(side) = self.side(start, level) else { return true };
        self.stack.clear();
        self.visited.clear();
        let mut leaves = self.enter(start, level, side);
        while let (false, Some(p)) = (leaves, self.stack.pop()) {
            for other in self.joined(p).into_iter().flatten() {
                leaves = leaves || self.enter(other, level, side);
            }
        }
        for index in &self.visited {
            if let Some(seen) = self.seen.get_mut(*index) {
                *seen = Seen { level, leaves }.packed();
            }
        }
        leaves
    }

    /// Takes a pixel to the region if it is on its side; whether it is known to leave the plane.
    fn enter(&mut self, p: Pixel, level: i32, side: usize) -> bool {
        let index = self.grid.index(p);
        let Some(height) = self.height(p, level) else { return false };
        if usize::from(height > 0.0) != side {
            return false;
        }
        let leaves = self.leaves(p, height);
        let Some(seen) = self.seen.get_mut(index) else { return true };
        if let Some(known) = Seen::of(*seen).filter(|known| known.level == level) {
            return known.leaves;
        }
        *seen = Seen { level, leaves }.packed();
        self.visited.push(index);
        self.stack.push(p);
        leaves
    }

    /// The neighbours of a pixel on its surface.
    fn joined(&self, p: Pixel) -> [Option<Pixel>; 4] {
        let (view, frame) = (self.view, self.view.frame());
        [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(rows, cols)| {
            let other = self.grid.step(p, rows, cols)?;
            // As the sweep sees the pair: from the later pixel.
            let (later, earlier) = if rows + cols > 0 { (other, p) } else { (p, other) };
            let pair = frame.pair(view.image(), later, earlier)?;
            self.rule.holds(&pair).then_some(other)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_of_a_pixel_is_kept_in_a_number_that_is_not_0() {
        assert_eq!(Seen::of(0), None);
        for level in [-BEYOND_LEVELS + 1, -1, 0, 1, BEYOND_LEVELS] {
            for leaves in [false, true] {
                let seen = Seen { level, leaves };
                assert_eq!(Seen::of(seen.packed()), Some(seen));
            }
        }
    }
}
