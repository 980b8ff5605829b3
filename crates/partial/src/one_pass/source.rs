//! The source of rows: a view's numbers, made ready for inner loops.

use crate::SectionAxes;
use transect_device::{Neighbour, SeparableForm, View};
use transect_image::{BreakRule, Grazing, PairTests, padded};

/// A view, a plane family and a rule, ready to be read row by row.
#[derive(Debug)]
pub(super) struct Source<'a> {
    pub view: &'a View,
    pub axes: &'a SectionAxes,
    pub rule: &'a BreakRule,
    pub cols: usize,
    pub rows: usize,
    /// Whether the last column is a neighbour of the first.
    pub wraps: bool,
    /// The level, of a sensor whose forms are separable.
    pub level: Option<SeparableForm>,
    /// Left and up.
    pub tests: Option<[PairTests; 2]>,
    pub grazing: Option<Grazing<'a>>,
}

impl<'a> Source<'a> {
    pub fn new(view: &'a View, axes: &'a SectionAxes, rule: &'a BreakRule) -> Self {
        let (frame, size) = (view.frame(), view.frame().size());
        let level = frame.separable_form(axes.level()).map(|mut form| {
            form.columns = padded(form.columns, size.cols);
            form
        });
        let test = |neighbour| {
            let products = frame.ray_products(neighbour)?;
            Some(PairTests::new(&products, rule, size.cols))
        };
        let tests = || Some([test(Neighbour::Left)?, test(Neighbour::Up)?]);
        let (tests, wraps) = (tests(), frame.columns_wrap());
        let (cols, rows, grazing) = (size.cols, size.rows, Grazing::of(view, rule));
        Self { view, axes, rule, cols, rows, wraps, level, tests, grazing }
    }

    /// Columns that rows have room for: whole words of masks.
    pub fn padded_cols(&self) -> usize {
        self.cols.next_multiple_of(64)
    }
}
