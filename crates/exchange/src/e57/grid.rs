//! The grid of a structured scan, from its records and its stated bounds.

use super::EXPORT;
use super::records::Cell;
use e57::IndexBounds;
use transect_device::{ImageSize, MISSING_POINT};
use transect_geometry::Point3;

/// Most cells of a grid per record. Chosen by hand: a grid that is 99 % empty is an object cut out
/// of a full scan, or a mistake in the indices. Doubled, a damaged index takes twice the memory.
const MOST_CELLS: usize = 100;

/// Row-major points of the grid; NaN where there is no valid record. An error is a sentence.
pub(super) fn of(
    cells: Vec<Cell>,
    stated: Option<&IndexBounds>,
    notes: &mut Vec<String>,
) -> Result<(ImageSize, Vec<Point3>), String> {
    let rows = span(cells.iter().map(|c| c.row)).ok_or("the scan holds no point")?;
    let cols = span(cells.iter().map(|c| c.col)).ok_or("the scan holds no point")?;
    let bounds = |min: fn(&IndexBounds) -> Option<i64>, max: fn(&IndexBounds) -> Option<i64>| {
        stated.and_then(|b| Some((min(b)?, max(b)?)))
    };
    let rows = settle("rows", rows, bounds(|b| b.row_min, |b| b.row_max), notes);
    let cols = settle("columns", cols, bounds(|b| b.column_min, |b| b.column_max), notes);
    let size = size_of(rows, cols, cells.len())?;
    let mut points = vec![MISSING_POINT; size.pixels()];
    let mut repeated = 0;
    for Cell { row, col, point } in &cells {
        let (row, col) = (i64::from(*row) - rows.0, i64::from(*col) - cols.0);
        let at = row as usize * size.cols + col as usize;
        let Some(place) = points.get_mut(at) else { continue };
        // The first valid record of a cell is the first return of its pulse.
        if place.x.is_nan() {
            *place = *point;
        } else if !point.x.is_nan() {
            repeated += 1;
        }
    }
    check_repeated(repeated, cells.len(), notes)?;
    Ok((size, points))
}

/// The smallest and the largest of some indices.
fn span(indices: impl Iterator<Item = i32>) -> Option<(i64, i64)> {
    let least_and_largest = indices.fold(None, |found, index| {
        let (least, largest) = found.unwrap_or((index, index));
        Some((least.min(index), largest.max(index)))
    });
    least_and_largest.map(|(least, largest)| (least.into(), largest.into()))
}

/// The stated bounds if all records lie within them; otherwise those of the records.
fn settle(
    what: &str,
    found: (i64, i64),
    stated: Option<(i64, i64)>,
    notes: &mut Vec<String>,
) -> (i64, i64) {
    match stated {
        Some(stated) if stated.0 <= found.0 && found.1 <= stated.1 => stated,
        None => found,
        Some((least, largest)) => {
            notes.push(format!(
                "indexBounds states {what} {least} to {largest}, but the records have {} to {}; \
                 the records count",
                found.0, found.1
            ));
            found
        }
    }
}

fn size_of(rows: (i64, i64), cols: (i64, i64), records: usize) -> Result<ImageSize, String> {
    let count = |(least, largest): (i64, i64)| {
        largest.checked_sub(least).and_then(|n| usize::try_from(n).ok()?.checked_add(1))
    };
    let (Some(rows), Some(cols)) = (count(rows), count(cols)) else {
        return Err(format!("indexBounds states rows {rows:?} and columns {cols:?}; {EXPORT}"));
    };
    let size = ImageSize { rows, cols };
    if rows < 2 || cols < 2 {
        return Err(format!("the scan has {size}, so no cell has neighbours; {EXPORT}"));
    }
    if rows.checked_mul(cols).is_none_or(|all| all / MOST_CELLS > records) {
        return Err(format!(
            "the grid has {size}, but {records} records; at least 1 of {MOST_CELLS} cells must \
             have a record; {EXPORT}"
        ));
    }
    Ok(size)
}

/// Several records of one cell are several returns of a pulse. If most records repeat a cell, rows
/// and columns mean something else.
fn check_repeated(repeated: usize, records: usize, notes: &mut Vec<String>) -> Result<(), String> {
    if repeated > records / 2 {
        return Err(format!(
            "{repeated} of {records} records have the row and column of an earlier one, so they \
             form no grid; {EXPORT}"
        ));
    }
    if repeated > 0 {
        notes.push(format!(
            "{repeated} of {records} records left out: another record of their row and column \
             comes first"
        ));
    }
    Ok(())
}
