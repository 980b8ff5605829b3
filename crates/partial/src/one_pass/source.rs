//! The source of rows: a view's numbers, made ready for inner loops.

use crate::SectionAxes;
use transect_device::{LinearForm, Neighbour, SeparableForm, View};
use transect_image::{BreakRule, PairTests, padded};

/// Level and in-plane coordinates of a sensor whose forms are separable.
#[derive(Debug, Clone)]
pub(super) struct Tables {
    pub level: SeparableForm,
    /// In-plane coordinates, from the sensor's; their columns begin with the one before column 0,
    /// as rows do.
    pub places: [SeparableForm; 2],
}

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
    pub tables: Option<Tables>,
    /// Left and up.
    pub tests: Option<[PairTests; 2]>,
    pub in_plane: [LinearForm; 2],
}

impl<'a> Source<'a> {
    pub fn new(view: &'a View, axes: &'a SectionAxes, rule: &'a BreakRule) -> Self {
        let (frame, size) = (view.frame(), view.frame().size());
        let form = |form: &LinearForm| {
            let mut tables = frame.separable_form(form)?;
            tables.columns = padded(tables.columns, size.cols);
            Some(tables)
        };
        let in_plane =
            axes.in_plane_gradients().map(|gradient| LinearForm { gradient, constant: 0.0 });
        let tables = || {
            let place = |k: usize| {
                let mut tables = form(&in_plane[k])?;
                let before = tables.columns.get(size.cols - 1).copied().unwrap_or_default();
                tables.columns.insert(0, before);
                Some(tables)
            };
            Some(Tables { level: form(axes.level())?, places: [place(0)?, place(1)?] })
        };
        let test = |neighbour| {
            let products = frame.ray_products(neighbour)?;
            Some(PairTests::new(&products, rule, size.cols))
        };
        let tests = || Some([test(Neighbour::Left)?, test(Neighbour::Up)?]);
        let (tables, tests) = (tables(), tests());
        let wraps = frame.columns_wrap();
        Self { view, axes, rule, cols: size.cols, rows: size.rows, wraps, tables, tests, in_plane }
    }

    /// Columns that rows have room for: whole words of masks.
    pub fn padded_cols(&self) -> usize {
        self.cols.next_multiple_of(64)
    }
}
