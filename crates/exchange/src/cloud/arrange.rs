//! Rows and columns of a cloud: which point belongs to which cell of the grid.

use super::cells::{Cells, Rings, elevation, is_valid};
use super::{azimuth, firings, rings};
use crate::error::Problem;
use crate::point_table::Cloud;
use transect_device::{ImageSize, MISSING_POINT, median};
use transect_geometry::Point3;

/// Row-major points of a grid. Cells without a point are missing.
pub(super) fn arrange(
    cloud: Cloud,
    grid: Option<ImageSize>,
    stated_rings: Option<usize>,
    notes: &mut Vec<String>,
) -> Result<(ImageSize, Vec<Point3>), Problem> {
    let Cloud { points, rings, size, .. } = cloud;
    if let (Some(found), Some(asked)) = (size, grid.filter(|g| Some(*g) != size)) {
        let problem =
            format!("the header states {found}, the setting `grid` {asked}; leave the setting out");
        return Err(Problem::damaged(problem));
    }
    if let Some(size) = size.or(grid) {
        if stated_rings.is_some() {
            let problem = format!("the cloud has {size}; leave the setting `rings` out");
            return Err(Problem::damaged(problem));
        }
        return rectangle(size, points);
    }
    let fields = rings.map(|rings| Rings::of_field(&rings)).transpose()?;
    if let (Some(rings), Some(stated)) = (&fields, stated_rings) {
        let count = rings.count;
        if count > stated {
            let problem = format!(
                "the field of rings has {count} values; the setting `rings` states {stated}"
            );
            return Err(Problem::damaged(problem));
        }
    }
    let numbers = fields.as_ref().map(|r| r.numbers.as_slice());
    let cells = match firings::find(&points, numbers)
        .filter(|f| numbers.is_some() || stated_rings.is_none_or(|stated| stated == f.lasers))
    {
        Some(found) => {
            notes.push(found.note());
            found.cells(points.len())
        }
        None => {
            let rings = match (fields, stated_rings) {
                (Some(rings), _) => rings,
                (None, Some(count)) => rings::find(&points, count, notes)?,
                (None, None) => return Err(unorganised(points.len())),
            };
            azimuth::columns(&points, &rings, notes)?
        }
    };
    Ok(place(&points, &cells, notes))
}

/// Why points without any order are refused, and the ways out.
fn unorganised(points: usize) -> Problem {
    Problem::unsupported(format!(
        "the {points} points have no rows and columns (no grid in the header, no ring field, no \
         firings found), so no point has neighbours to trace. For a rotating lidar pass the \
         setting `rings`; for points stored row by row pass the setting `grid`; otherwise export \
         the scan structured, as E57, PTX or organised PCD"
    ))
}

fn rectangle(size: ImageSize, points: Vec<Point3>) -> Result<(ImageSize, Vec<Point3>), Problem> {
    if Some(points.len()) == size.rows.checked_mul(size.cols) {
        return Ok((size, points));
    }
    let found = points.len();
    let problem = format!(
        "the file has {found} points, {size} need {}; state the grid of the scanner, with one \
         point (0, 0, 0) or NaN for each missing return",
        size.pixels()
    );
    Err(Problem::damaged(problem))
}

/// Puts the points into their cells: the rows are the lasers from top to bottom. Lasers without any
/// return have no row.
fn place(points: &[Point3], cells: &Cells, notes: &mut Vec<String>) -> (ImageSize, Vec<Point3>) {
    let mut elevations = vec![Vec::new(); cells.lasers];
    for (point, cell) in points.iter().zip(&cells.cell) {
        let Some((laser, _)) = cell else { continue };
        if let (true, Some(list)) = (is_valid(point), elevations.get_mut(usize::from(*laser))) {
            list.push(elevation(point));
        }
    }
    let medians = elevations.into_iter().enumerate();
    let mut order: Vec<(f64, usize)> =
        medians.filter_map(|(laser, list)| Some((median(list)?, laser))).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    if let (Some(top), Some(bottom)) = (order.first(), order.last()) {
        let rows = order.len();
        let (top, bottom) = (top.0.to_degrees(), bottom.0.to_degrees());
        notes.push(format!("{rows} rows are the rings from {top:.2}° down to {bottom:.2}°"));
    }
    let size = ImageSize { rows: order.len(), cols: cells.cols };
    let mut row_of = vec![None; cells.lasers];
    for (row, (_, laser)) in order.iter().enumerate() {
        if let Some(place) = row_of.get_mut(*laser) {
            *place = Some(row);
        }
    }
    let mut placed = vec![MISSING_POINT; size.pixels()];
    for (point, cell) in points.iter().zip(&cells.cell) {
        let Some((laser, col)) = cell else { continue };
        let row = row_of.get(usize::from(*laser)).copied().flatten();
        let at = row.map(|row| row * size.cols + *col as usize);
        if let Some(place) = at.and_then(|at| placed.get_mut(at)) {
            *place = *point;
        }
    }
    (size, placed)
}
