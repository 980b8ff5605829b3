//! Columns of a rotating lidar by azimuth, where the file keeps no missing returns.
//!
//! **Idea.** The points in the order of their azimuth are cut into columns: a column ends where one
//! of its rings occurs again, or before a gap. Columns so follow the firings, whose spacing varies
//! with the speed of the motor, and the offsets between lasers. A grid of equal angles would put
//! two points into one cell and none into the next wherever the speed deviates.
//!
//! Cost: one sort of the points.

use super::cells::{Cells, Rings, is_valid};
use crate::error::Problem;
use std::f64::consts::TAU;
use transect_device::median;
use transect_geometry::Point3;

/// Two points of a ring within this share of the usual step are two returns of one pulse. Chosen by
/// hand: returns of a pulse share their azimuth to rounding, and firings vary by a fifth. Doubled,
/// firings of a jittering motor may count as one.
const SAME_PULSE: f64 = 0.25;

/// A gap of this share of the usual step separates columns. Chosen by hand: the lasers of a firing
/// are spread evenly or share one azimuth. Doubled, points of two firings come into one column
/// where the motor is slow.
const GAP: f64 = 0.5;

/// Azimuths less apart than this do not count as a step, in radians. Theory: 32-bit coordinates
/// round angles by 1e-7; the finest lidars step by 1e-3. Doubled, nothing changes.
const ROUNDING: f64 = 1e-6;

/// Most cells per point. Chosen by hand: lidars under an open sky miss four of five returns.
/// Doubled, the grid of a wrong step takes twice the memory before it is refused.
const MOST_CELLS: usize = 16;

/// Puts every point into the row of its ring and a column. Of two returns of a pulse the nearer one
/// stays: the space in front of it is free for certain.
pub(super) fn columns(
    points: &[Point3],
    rings: &Rings,
    notes: &mut Vec<String>,
) -> Result<Cells, Problem> {
    let order = by_azimuth(points);
    let step = usual_step(&order, rings)?;
    let first = order.first().map_or(0.0, |(azimuth, _)| *azimuth);
    let mut turn = Turn {
        step,
        start: first,
        previous: first,
        col: 0,
        last: vec![None; rings.count],
        cell: vec![None; points.len()],
        farther: 0,
    };
    for (azimuth, number) in order {
        let number = number as usize;
        let point = points.get(number).zip(rings.numbers.get(number));
        point.into_iter().for_each(|(p, ring)| turn.add(azimuth, number, *ring, p.coords.norm()));
    }
    turn.close(first);
    let (rows, cols, found) = (rings.count, turn.col as usize + 1, points.len());
    if cols.saturating_mul(rows) > found.saturating_mul(MOST_CELLS) {
        return Err(Problem::damaged(format!(
            "{rows} rings × {cols} columns by azimuth for {found} points: the grid is nearly \
             empty, so the rings are wrong, or z is not the axis of rotation"
        )));
    }
    let degrees = step.to_degrees();
    notes.push(format!("columns by azimuth: {cols} columns, usual step {degrees:.4}°"));
    if turn.farther > 0 {
        let farther = turn.farther;
        notes.push(format!("{farther} points left out: a nearer return of the same pulse stays"));
    }
    Ok(Cells { lasers: rows, cols, cell: turn.cell })
}

/// The azimuths of the returns with their numbers, in order. They count clockwise from above, so
/// that columns run to the right as the sensor sees them. The turn begins after its widest gap, so
/// that a scanner that sees a part of the circle gets no empty columns.
fn by_azimuth(points: &[Point3]) -> Vec<(f64, u32)> {
    let valid = points.iter().enumerate().filter(|(_, p)| is_valid(p));
    let mut order: Vec<(f64, u32)> =
        valid.map(|(k, p)| ((-p.y).atan2(p.x), u32::try_from(k).unwrap_or(u32::MAX))).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let ends = order.first().zip(order.last());
    let mut widest = (ends.map_or(0.0, |(first, last)| first.0 + TAU - last.0), 0);
    for (at, pair) in (1..).zip(order.windows(2)) {
        let gap = pair.last().zip(pair.first()).map_or(0.0, |(next, this)| next.0 - this.0);
        if gap > widest.0 {
            widest = (gap, at);
        }
    }
    order.rotate_left(widest.1);
    let before = order.len() - widest.1;
    order.iter_mut().skip(before).for_each(|(azimuth, _)| *azimuth += TAU);
    order
}

/// A point that was put into a column.
#[derive(Clone, Copy)]
struct Placed {
    azimuth: f64,
    range: f64,
    number: usize,
    col: u32,
}

/// The columns of a turn, while points come in the order of their azimuth.
struct Turn {
    step: f64,
    /// Azimuth of the first point of the current column.
    start: f64,
    /// Azimuth of the point before.
    previous: f64,
    /// The current column.
    col: u32,
    /// The last point of every ring.
    last: Vec<Option<Placed>>,
    cell: Vec<Option<(u16, u32)>>,
    /// Points behind another return of their pulse.
    farther: usize,
}

impl Turn {
    fn add(&mut self, azimuth: f64, number: usize, ring: u16, range: f64) {
        let before = self.last.get(usize::from(ring)).copied().flatten();
        let mut placed = Placed { azimuth, range, number, col: self.col };
        if let Some(before) = before.filter(|b| azimuth - b.azimuth < SAME_PULSE * self.step) {
            self.farther += 1;
            if before.range <= range {
                return;
            }
            self.cell.get_mut(before.number).into_iter().for_each(|cell| *cell = None);
            placed.col = before.col;
        } else {
            let ahead = azimuth - self.start;
            let gap = azimuth - self.previous;
            let is_taken = before.is_some_and(|b| b.col == self.col);
            if is_taken || ahead >= self.step || gap >= GAP * self.step {
                // Empty columns stand for directions without any return.
                self.col = self.col.saturating_add(((ahead / self.step).round() as u32).max(1));
                self.start = azimuth;
            }
            placed.col = self.col;
        }
        self.previous = azimuth;
        self.cell.get_mut(number).into_iter().for_each(|cell| *cell = Some((ring, placed.col)));
        self.last.get_mut(usize::from(ring)).into_iter().for_each(|last| *last = Some(placed));
    }

    /// Joins the last column with the first, if the turn begins within a firing.
    fn close(&mut self, first: f64) {
        let ends = self.col;
        let is_taken = |ring: u16| {
            self.last.get(usize::from(ring)).copied().flatten().is_some_and(|l| l.col == ends)
        };
        let is_one = first + TAU - self.start < self.step
            && !self.cell.iter().flatten().any(|(ring, col)| *col == 0 && is_taken(*ring));
        if is_one && ends > 0 {
            let cells = self.cell.iter_mut().flatten().filter(|(_, col)| *col == ends);
            cells.for_each(|(_, col)| *col = 0);
            self.col -= 1;
        }
    }
}

/// The median step between neighbouring points of a ring, in radians. Steps over missing returns
/// are left out by a second median, of the steps below 1.5 times the first.
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
    let first = median(steps.iter().copied()).ok_or_else(problem)?;
    median(steps.into_iter().filter(|step| *step < 1.5 * first)).ok_or_else(problem)
}
