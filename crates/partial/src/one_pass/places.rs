//! In-plane coordinates of the pixels of a row.

use super::rows::{PAD, Row};
use super::source::Source;
use fearless_simd::Simd;
use transect_device::SeparableForm;

impl Source<'_> {
    /// Makes in-plane coordinates of a row available to [`Places`]; `many` if most of the row's
    /// pixels will be asked for.
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

    /// In-plane coordinates of the pixel of row `i` in column `j`, or some columns before, none or
    /// one.
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

    /// In-plane coordinates of the pixels of row `i`, from the sensor's, beginning some columns
    /// before column 0, none or one, and a number of columns long.
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
