//! Where rows come from: a view's numbers, made ready for inner loops.

use super::rows::{PAD, Row};
use crate::SectionAxes;
use fearless_simd::Simd;
use transect_device::{LinearForm, Neighbour, SeparableForm, View};
use transect_image::{BreakRule, PairTests, padded};

/// Level and in-plane coordinates of a sensor whose forms are separable.
#[derive(Debug, Clone)]
pub(super) struct Tables {
    pub level: SeparableForm,
    /// In-plane coordinates, from the sensor's; their columns begin with the one before column 0, as
    /// rows do.
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
    in_plane: [LinearForm; 2],
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

    /// Makes in-plane coordinates of a row available to [`Places`]; `many` if most of the row's pixels
    /// will be asked for.
    #[inline(always)]
    pub fn place<S: Simd>(&self, simd: S, i: usize, row: &mut Row, many: bool) {
        match &self.tables {
            // Both rows of a pair in the same way, whatever was done for the pair before.
            Some(_) if !many => row.placed = false,
            _ if row.placed => {}
            Some(tables) => row.place(simd, tables, i),
            None => self.place_one_by_one(i, row),
        }
    }

    /// Columns that rows have room for: whole words of masks.
    pub fn padded_cols(&self) -> usize {
        self.cols.next_multiple_of(64)
    }

    fn place_one_by_one(&self, i: usize, row: &mut Row) {
        let (frame, image) = (self.view.frame(), self.view.image());
        let len = row.values.len() - PAD + 1;
        for (form, places) in self.in_plane.iter().zip(&mut row.places) {
            places.clear();
            places.resize(len, f32::NAN);
            if let Some(places) = places.get_mut(1..=self.cols) {
                frame.form_row(image, i, form, places);
            }
            places[0] = places[self.cols];
        }
        row.placed = true;
    }

    /// In-plane coordinates of the pixel of row `i` in column `j`, or some columns before, none or one.
    pub fn place_at(&self, i: usize, row: &Row, (j, before): (usize, usize)) -> Option<[f32; 2]> {
        let at = 1 - before + j;
        match &self.tables {
            Some(tables) if !row.placed => {
                let value = *row.values.get(PAD - before + j)?;
                let place = |form: &SeparableForm| {
                    let [factor, addend] = form.rows.get(i).copied().unwrap_or_default();
                    Some(value * (factor * *form.columns.get(at)? + addend))
                };
                let [x, y] = &tables.places;
                Some([place(x)?, place(y)?])
            }
            _ => Some([*row.places[0].get(at)?, *row.places[1].get(at)?]),
        }
    }

    /// In-plane coordinates of the pixels of row `i`, from the sensor's, beginning some columns before
    /// column 0, none or one, and a number of columns long.
    #[inline(always)]
    pub fn places<'r>(
        &'r self,
        i: usize,
        row: &'r Row,
        before: usize,
        len: usize,
    ) -> Option<Places<'r>> {
        let first = 1 - before;
        let tables = match &self.tables {
            Some(tables) if !row.placed => tables,
            _ => {
                let [x, y] = &row.places;
                let places = [x.get(first..first + len)?, y.get(first..first + len)?];
                return Some(Places::Stored(Stored(places)));
            }
        };
        let [x, y] = &tables.places;
        let terms = |form: &SeparableForm| form.rows.get(i).copied().unwrap_or_default();
        Some(Places::Tables(TableRow {
            values: row.values.get(PAD - before..PAD - before + len)?,
            terms: [terms(x), terms(y)],
            columns: [x.columns.get(first..first + len)?, y.columns.get(first..first + len)?],
        }))
    }
}

/// In-plane coordinates of the pixels of one row, from the sensor's.
#[derive(Debug, Clone, Copy)]
pub(super) enum Places<'a> {
    Stored(Stored<'a>),
    Tables(TableRow<'a>),
}

/// Coordinates that were found for the whole row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stored<'a>([&'a [f32]; 2]);

/// Coordinates from a row's values; all slices are of one length.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableRow<'a> {
    values: &'a [f32],
    terms: [[f32; 2]; 2],
    columns: [&'a [f32]; 2],
}

/// In-plane coordinates by column.
pub(super) trait PlaceAt: Copy {
    fn at(&self, col: usize) -> Option<[f32; 2]>;
}

impl PlaceAt for Stored<'_> {
    #[inline(always)]
    fn at(&self, col: usize) -> Option<[f32; 2]> {
        let [x, y] = self.0;
        Some([*x.get(col)?, *y.get(col)?])
    }
}

impl PlaceAt for TableRow<'_> {
    #[inline(always)]
    fn at(&self, col: usize) -> Option<[f32; 2]> {
        let ([[fx, ax], [fy, ay]], [x, y]) = (self.terms, self.columns);
        let value = *self.values.get(col)?;
        Some([value * (fx * *x.get(col)? + ax), value * (fy * *y.get(col)? + ay)])
    }
}

impl PlaceAt for Places<'_> {
    #[inline(always)]
    fn at(&self, col: usize) -> Option<[f32; 2]> {
        match self {
            Places::Stored(places) => places.at(col),
            Places::Tables(places) => places.at(col),
        }
    }
}
