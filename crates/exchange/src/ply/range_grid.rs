//! Range images as Stanford's scanner wrote them: a grid of cells, each with a vertex or none.

use super::{Element, Ply};
use crate::input::read_bytes;
use crate::{Place, ReadError};
use std::path::Path;
use transect_device::{ImageSize, MAX_PIXELS, MISSING_POINT};
use transect_geometry::Point3;

/// An organised grid of points in the scanner's frame.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct RangeGrid {
    /// Rows and columns.
    pub size: ImageSize,
    /// Row-major, one per cell, NaN where the cell is empty; the file's length unit.
    pub points: Vec<Point3>,
    /// Content that the reader ignored or repaired.
    pub notes: Vec<String>,
}

/// Reads `obj_info num_cols`, `num_rows` and the elements `vertex` and `range_grid`.
///
/// # Errors
/// [`ReadError`] if the file is no PLY, is truncated, has no grid, or contradicts itself: a cell
/// that names a missing vertex is named by row and column.
pub fn read_range_grid(path: &Path) -> Result<RangeGrid, ReadError> {
    range_grid(path, &read_bytes(path)?)
}

pub(crate) fn range_grid(path: &Path, bytes: &[u8]) -> Result<RangeGrid, ReadError> {
    let mut ply = Ply::open(path, bytes)?;
    let size = grid_size(&ply)?;
    let (mut vertices, mut cells) = (Vec::new(), Vec::new());
    for element in ply.header.elements.clone() {
        match element.name.as_str() {
            "vertex" => vertices = ply.points(&element)?,
            "range_grid" => cells = read_cells(&mut ply, &element)?,
            _ => ply.skip(&element)?,
        }
    }
    ply.note_leftovers();
    let points = place(path, size, &vertices, &cells)?;
    let mut notes = ply.header.notes;
    notes.extend(oddities(&vertices, &cells));
    Ok(RangeGrid { size, points, notes })
}

/// The size in the header, which must be that of the element `range_grid`.
fn grid_size(ply: &Ply<'_>) -> Result<ImageSize, ReadError> {
    let damaged = |problem: String| Err(ReadError::damaged(ply.path, Place::Whole, problem));
    let elements = ply.header.element("vertex").zip(ply.header.element("range_grid"));
    let Some((_, grid)) = elements else {
        return damaged("no range grid: the elements vertex and range_grid are needed".to_owned());
    };
    let info = |name| ply.header.info(name);
    let Some((rows, cols)) = info("num_rows").zip(info("num_cols")) else {
        return damaged("no size: the lines obj_info num_rows and num_cols are needed".to_owned());
    };
    let cells = rows.checked_mul(cols).filter(|&n| n > 0 && n <= MAX_PIXELS);
    let Some(cells) = cells else {
        return damaged(format!("a grid of {rows} rows × {cols} columns is empty or absurd"));
    };
    if cells != grid.count {
        return damaged(format!(
            "num_rows {rows} × num_cols {cols} is {cells} cells, but range_grid announces {}",
            grid.count
        ));
    }
    Ok(ImageSize { rows, cols })
}

/// A cell's vertex. In the file, an empty list means "no vertex".
type Cell = Option<i64>;

fn read_cells(ply: &mut Ply<'_>, grid: &Element) -> Result<Vec<Cell>, ReadError> {
    let mut cells = Vec::with_capacity(ply.room_for(grid)?);
    ply.vertex_lists(grid, |indices| {
        if indices.len() > 1 {
            return Err(format!("{} vertices in one cell", indices.len()));
        }
        cells.push(indices.first().copied());
        Ok(())
    })?;
    Ok(cells)
}

/// Puts every cell's vertex at the cell.
fn place(
    path: &Path,
    size: ImageSize,
    vertices: &[Point3],
    cells: &[Cell],
) -> Result<Vec<Point3>, ReadError> {
    let point = |(number, cell): (usize, &Cell)| match cell {
        None => Ok(MISSING_POINT),
        Some(index) => {
            usize::try_from(*index).ok().and_then(|i| vertices.get(i)).copied().ok_or_else(|| {
                let pixel = size.pixel(number);
                let problem =
                    format!("vertex {index} does not exist; there are {}", vertices.len());
                ReadError::damaged(path, Place::Pixel(pixel), problem)
            })
        }
    };
    cells.iter().enumerate().map(point).collect()
}

/// Notes about vertices in no cell or in several cells, and about vertices that are not finite.
fn oddities(vertices: &[Point3], cells: &[Cell]) -> Vec<String> {
    let mut uses = vec![0_u8; vertices.len()];
    for index in cells.iter().flatten() {
        if let Some(n) = usize::try_from(*index).ok().and_then(|i| uses.get_mut(i)) {
            *n = n.saturating_add(1);
        }
    }
    let unused = uses.iter().filter(|&&n| n == 0).count();
    let repeated = uses.iter().filter(|&&n| n > 1).count();
    let wild = vertices.iter().filter(|v| !v.coords.iter().all(|c| c.is_finite())).count();
    let counted = [
        (unused, "vertices are in no cell of the grid and are dropped"),
        (repeated, "vertices are in several cells of the grid"),
        (wild, "vertices have a coordinate that is not finite and count as missing"),
    ];
    counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect()
}
