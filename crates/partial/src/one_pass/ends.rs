//! Why a line ends: the reason in the cell where it would continue.

use super::bridge::Gaps;
use super::vertex::{Kind, Vertex};
use crate::continuation::alike;
use crate::pixel_grid::Grid;
use transect_device::Pixel;
use transect_geometry::EndReason;

/// The reasons for both ends of an open curve, whose first and last vertices are given with the
/// ones next to them.
pub(super) fn ends(gaps: &Gaps<'_>, [first, last]: [(&Vertex, &Vertex); 2]) -> [EndReason; 2] {
    [reason(gaps, first), reason(gaps, last)]
}

/// Why a curve ends; `neighbour` is the vertex next to the end.
fn reason(gaps: &Gaps<'_>, (end, neighbour): (&Vertex, &Vertex)) -> EndReason {
    let Gaps { view, contours, grid, .. } = gaps;
    let (kind, pair) = contours.pair(end);
    let own = cells(grid, kind, contours.pixel(end));
    let (beside, pixel) = (contours.pair(neighbour).0, contours.pixel(neighbour));
    let shared = cells(grid, beside, pixel);
    let corners = match (kind, outer(grid, &own, &shared, pixel)) {
        // A diagonal has one cell, of which a corner was left out.
        (Kind::Rising | Kind::Falling, _) => corners(grid, own[0]),
        (_, Some(cell)) => corners(grid, cell),
        (_, None) => Some(vec![pair[0], pair[1]]),
    };
    let Some(corners) = corners else { return EndReason::ImageBorder };
    let missing = |p: &Pixel| view.image().get(*p).is_none();
    if corners.iter().any(missing) && !hides_jump(gaps, pair, &corners) {
        EndReason::MissingPixel
    } else {
        EndReason::RangeJump
    }
}

/// Whether another surface begins beyond the missing corners of a cell: straight on from one of the
/// end's samples, within the largest gap that is bridged.
fn hides_jump(gaps: &Gaps<'_>, pair: [Pixel; 2], corners: &[Pixel]) -> bool {
    let valid = |p: &Pixel| gaps.view.image().get(*p).is_some();
    let beyond = |sample: Pixel, missing: &Pixel| {
        let (rows, cols) = gaps.grid.offset(sample, *missing);
        let step = |k: i32| gaps.grid.step(sample, k * rows as i32, k * cols as i32);
        // No gap is wider than the image.
        let size = gaps.grid.size();
        let widest = gaps.gap.min(size.rows.max(size.cols)) as i32;
        let next = (1..=widest + 1).map_while(step).find(valid)?;
        Some(!alike(gaps.view, gaps.rule, sample, next))
    };
    let missing = corners.iter().filter(|p| !valid(p));
    let mut ways = missing.flat_map(|missing| pair.map(|sample| beyond(sample, missing)));
    ways.any(|jump| jump == Some(true))
}

/// The cell of an end in which its curve would have gone on: the one that it does not share with
/// the neighbour. Where pixels are missing in between they share none, and it is the farther one.
fn outer(grid: &Grid, own: &[Pixel], shared: &[Pixel], neighbour: Pixel) -> Option<Pixel> {
    if own.iter().any(|cell| shared.contains(cell)) {
        return own.iter().copied().find(|cell| !shared.contains(cell));
    }
    let apart = |cell: &Pixel| {
        let (rows, cols) = grid.offset(*cell, neighbour);
        rows.abs() + cols.abs()
    };
    own.iter().copied().max_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// The one or two cells a pair belongs to, by their lower right pixel, which may lie outside.
fn cells(grid: &Grid, kind: Kind, Pixel { row, col }: Pixel) -> Vec<Pixel> {
    let next = if grid.wraps() { (col + 1) % grid.size().cols } else { col + 1 };
    let here = Pixel { row, col };
    match kind {
        Kind::Up => vec![here, Pixel { row, col: next }],
        Kind::Left => vec![here, Pixel { row: row + 1, col }],
        Kind::Rising | Kind::Falling => vec![here],
    }
}

/// The four pixels of a cell; `None` if it reaches beyond the image.
fn corners(grid: &Grid, cell: Pixel) -> Option<Vec<Pixel>> {
    let steps = [(-1, -1), (-1, 0), (0, -1), (0, 0)];
    steps.into_iter().map(|(rows, cols)| grid.step(cell, rows, cols)).collect()
}
