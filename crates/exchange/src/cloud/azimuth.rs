//! Columns of a rotating lidar by azimuth, where the file keeps no missing returns.
//!
//! **Idea.** The points in the order of their azimuth are cut into columns: a column ends where one
//! of its rings occurs again. Columns so follow the firings, whose spacing varies with the speed of
//! the motor, and the offsets between lasers. A grid of equal angles would put two points into one
//! cell and none into the next wherever the speed deviates.
//!
//! Cost: one sort of the points.

use super::arrange::{Cells, Rings, is_valid, median};
use crate::error::Problem;
use transect_geometry::Point3;

/// Two points of a ring within this share of the usual step are two returns of one pulse. Chosen by
/// hand: returns of a pulse share their azimuth to rounding, and firings vary by a fifth. Doubled,
/// firings of a jittering motor may count as one.
const SAME_PULSE: f64 = 0.25;

/// Azimuths less apart than this do not count as a step, in radians. Theory: 32-bit coordinates
/// round angles by 1e-7; the finest lidars step by 1e-3. Doubled, nothing changes.
const ROUNDING: f64 = 1e-6;

/// Most cells per point. Chosen by hand: lidars under an open sky miss four of five returns.
/// Doubled, the grid of a wrong step takes twice the memory before it is refused.
const MOST_CELLS: usize = 16;

/// A point that was put into a column.
#[derive(Clone, Copy)]
struct Placed {
    azimuth: f64,
    number: usize,
    col: usize,
}

/// Puts every point into the row of its ring and a column. Of two returns of a pulse the nearer one
/// stays: the space in front of it is free for certain.
pub(super) fn columns(
    points: &[Point3],
    rings: &Rings,
    notes: &mut Vec<String>,
) -> Result<Cells, Problem> {
    let valid = points.iter().enumerate().filter(|(_, p)| is_valid(p));
    let mut order: Vec<(f64, u32)> =
        valid.map(|(k, p)| (p.y.atan2(p.x), u32::try_from(k).unwrap_or(u32::MAX))).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let step = usual_step(&order, rings)?;
    let mut cells = Cells { lasers: rings.count, cols: 0, cell: vec![None; points.len()] };
    let mut last: Vec<Option<Placed>> = vec![None; rings.count];
    let (mut start, mut col, mut farther) = (f64::NEG_INFINITY, 0, 0);
    let range = |number: usize| points.get(number).map_or(f64::NAN, |p| p.coords.norm());
    for (azimuth, number) in order {
        let number = number as usize;
        let Some(&ring) = rings.numbers.get(number) else { continue };
        let Some(before) = last.get_mut(usize::from(ring)) else { continue };
        if start == f64::NEG_INFINITY {
            start = azimuth;
        }
        let mut put = |number: usize, col: Option<usize>| {
            if let Some(cell) = cells.cell.get_mut(number) {
                *cell = col.and_then(|col| Some((ring, u32::try_from(col).ok()?)));
            }
        };
        if let Some(first) = before.filter(|b| azimuth - b.azimuth < SAME_PULSE * step) {
            farther += 1;
            if range(number) < range(first.number) {
                put(first.number, None);
                put(number, Some(first.col));
                *before = Some(Placed { azimuth, number, ..first });
            }
            continue;
        }
        let ahead = azimuth - start;
        if before.is_some_and(|b| b.col == col) || ahead >= step {
            // Empty columns stand for directions without any return.
            col += ((ahead / step).round() as usize).max(1);
            start = azimuth;
        }
        put(number, Some(col));
        *before = Some(Placed { azimuth, number, col });
    }
    cells.cols = col + 1;
    let found = points.len();
    if cells.cols.saturating_mul(rings.count) > found.saturating_mul(MOST_CELLS) {
        let (rows, cols) = (rings.count, cells.cols);
        return Err(Problem::damaged(format!(
            "{rows} rings × {cols} columns by azimuth for {found} points: the grid is nearly \
             empty, so the rings are wrong, or z is not the axis of rotation"
        )));
    }
    notes.push(format!(
        "columns by azimuth: {} columns, usual step {:.4}°",
        cells.cols,
        step.to_degrees()
    ));
    if farther > 0 {
        notes.push(format!("{farther} points left out: a nearer return of the same pulse stays"));
    }
    Ok(cells)
}

/// The median step between neighbouring points of a ring, in radians.
fn usual_step(order: &[(f64, u32)], rings: &Rings) -> Result<f64, Problem> {
    let mut before = vec![f64::NAN; rings.count];
    let mut steps = Vec::with_capacity(order.len());
    for (azimuth, number) in order {
        let ring = rings.numbers.get(*number as usize).copied().unwrap_or(0);
        let Some(before) = before.get_mut(usize::from(ring)) else { continue };
        let step = azimuth - std::mem::replace(before, *azimuth);
        steps.extend((step > ROUNDING).then_some(step));
    }
    let problem = || Problem::damaged("no ring has two points at different azimuths");
    median(&mut steps).ok_or_else(problem)
}
