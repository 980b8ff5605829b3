//! The next pixels along the row or column of a pair.

use super::vertex::Kind;
use crate::pixel_grid::Grid;
use crate::subpixel::PairLine;
use transect_device::{Pixel, View};
use transect_image::BreakRule;

/// Finds the pixels before and after a pair, as far as they are on its surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct PairLines<'a> {
    pub view: &'a View,
    pub rule: &'a BreakRule,
    pub grid: Grid,
}

impl PairLines<'_> {
    /// The pair with the pixels next to it; `None` for a diagonal, which is no line of the scan.
    pub fn of(&self, kind: Kind, pair: [Pixel; 2]) -> Option<PairLine> {
        let line = self.untested(kind, pair)?;
        Some(PairLine {
            before: line.before.filter(|before| self.joined(line.first, *before)),
            after: line.after.filter(|after| self.joined(*after, line.second)),
            ..line
        })
    }

    /// The same, whether the next pixels are on the pair's surface or not.
    pub fn untested(&self, kind: Kind, pair: [Pixel; 2]) -> Option<PairLine> {
        let (rows, cols) = if kind == Kind::Up { (1, 0) } else { (0, 1) };
        let line = Self::bare(kind, pair)?;
        let before = self.grid.step(line.first, -rows, -cols);
        let after = self.grid.step(line.second, rows, cols);
        Some(PairLine { before, after, ..line })
    }

    /// The pair alone; `None` for a diagonal.
    pub fn bare(kind: Kind, [first, second]: [Pixel; 2]) -> Option<PairLine> {
        let line = PairLine { before: None, first, second, after: None };
        matches!(kind, Kind::Up | Kind::Left).then_some(line)
    }

    fn joined(&self, later: Pixel, earlier: Pixel) -> bool {
        let pair = self.view.frame().pair(self.view.image(), later, earlier);
        pair.is_some_and(|pair| self.rule.holds(&pair))
    }
}
