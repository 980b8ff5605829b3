//! Crossings solved again by another subpixel solution than the linear one (3.6).

use super::contours::Kind;
use super::crossing::Crossing;
use crate::dissertation::sensor_plane;
use crate::pixel_grid::Grid;
use crate::subpixel::{AngularGrid, PairLine, Solver, Subpixel};
use crate::{BreakRule, SectionAxes};
use transect_device::{Pixel, View};

/// The way to solve the crossings of one view.
pub(super) struct Refinement<'a> {
    view: &'a View,
    axes: &'a SectionAxes,
    rule: &'a BreakRule,
    grid: Grid,
    method: Subpixel,
    angles: Option<AngularGrid>,
}

impl<'a> Refinement<'a> {
    /// `None` for the linear solution, which crossings have already.
    pub fn new(
        view: &'a View,
        axes: &'a SectionAxes,
        rule: &'a BreakRule,
        method: Subpixel,
    ) -> Option<Self> {
        if method == Subpixel::Cartesian {
            return None;
        }
        let angles = method.uses_angles().then(|| AngularGrid::read(view.frame())).flatten();
        Some(Self { view, axes, rule, grid: Grid::new(view.frame()), method, angles })
    }

    /// The solver for the plane at a level.
    pub fn solver(&self, level: i32) -> Solver<'_> {
        let plane = sensor_plane(self.axes, level);
        Solver::new(self.view, plane, self.method, self.angles.as_ref())
    }

    /// Moves a crossing of a pair to where the solver finds it. Diagonals, which are no line of the
    /// scan, keep the linear solution.
    pub fn refine(&self, solver: &Solver<'_>, kind: Kind, pair: [Pixel; 2], at: &mut Crossing) {
        let Some(line) = self.line(kind, pair) else { return };
        let Some(meeting) = solver.meet(&line) else { return };
        at.position = self.axes.in_plane(&meeting.point);
    }

    /// The pair with its next pixels, as far as they are on its surface and the solution asks for
    /// them.
    fn line(&self, kind: Kind, [first, second]: [Pixel; 2]) -> Option<PairLine> {
        let (rows, cols) = match kind {
            Kind::Up => (1, 0),
            Kind::Left => (0, 1),
            Kind::Rising | Kind::Falling => return None,
        };
        let mut line = PairLine { before: None, first, second, after: None };
        if self.method == Subpixel::FourPoint {
            let before = self.grid.step(first, -rows, -cols);
            line.before = before.filter(|before| self.joined(first, *before));
            let after = self.grid.step(second, rows, cols);
            line.after = after.filter(|after| self.joined(*after, second));
        }
        Some(line)
    }

    fn joined(&self, later: Pixel, earlier: Pixel) -> bool {
        let pair = self.view.frame().pair(self.view.image(), later, earlier);
        pair.is_some_and(|pair| self.rule.holds(&pair))
    }
}
