//! Why a line ends: what is wrong with the cell in which it would have gone on.

use super::contours::{Contours, Kind, Polyline, Vertex};
use crate::EndReason;
use transect_device::{ImageSize, Pixel, View};

/// The reasons for both ends of an open line; `None` for a lone vertex.
pub(super) fn ends(
    view: &View,
    line: &Polyline<'_>,
    contours: &Contours<'_>,
) -> Option<[EndReason; 2]> {
    let [first, second, ..] = line.vertices else { return None };
    let [.., before, last] = line.vertices else { return None };
    Some([reason(view, contours, first, second), reason(view, contours, last, before)])
}

/// Why a line does not go on from an end; `neighbour` is the vertex next to it.
fn reason(view: &View, contours: &Contours<'_>, end: &Vertex, neighbour: &Vertex) -> EndReason {
    let (kind, pair) = contours.pair(end);
    let own = cells(view, kind, contours.pixel(end));
    let (beside, pixel) = (contours.pair(neighbour).0, contours.pixel(neighbour));
    let shared = cells(view, beside, pixel);
    let corners = match (kind, own.iter().find(|cell| !shared.contains(cell))) {
        // A diagonal has one cell, of which a corner was left out.
        (Kind::Rising | Kind::Falling, _) => corners(view, own[0]),
        (_, Some(cell)) => corners(view, *cell),
        (_, None) => Some(vec![pair[0], pair[1]]),
    };
    match corners {
        None => EndReason::ImageBorder,
        Some(pixels) if pixels.iter().any(|p| view.image().get(*p).is_none()) => {
            EndReason::MissingPixel
        }
        Some(_) => EndReason::RangeJump,
    }
}

/// The one or two cells a pair belongs to, by their lower right pixel, which may lie outside.
fn cells(view: &View, kind: Kind, Pixel { row, col }: Pixel) -> Vec<Pixel> {
    let cols = view.frame().size().cols;
    let next = if view.frame().columns_wrap() { (col + 1) % cols } else { col + 1 };
    let here = Pixel { row, col };
    match kind {
        Kind::Up => vec![here, Pixel { row, col: next }],
        Kind::Left => vec![here, Pixel { row: row + 1, col }],
        Kind::Rising | Kind::Falling => vec![here],
    }
}

/// The four pixels of a cell; `None` if it reaches beyond the image.
fn corners(view: &View, Pixel { row, col }: Pixel) -> Option<Vec<Pixel>> {
    let ImageSize { rows, cols } = view.frame().size();
    let up = row.checked_sub(1)?;
    let before =
        if col == 0 && view.frame().columns_wrap() { cols - 1 } else { col.checked_sub(1)? };
    let inside = row < rows && col < cols;
    let all = [(up, before), (up, col), (row, before), (row, col)];
    inside.then(|| all.iter().map(|&(r, c)| Pixel::new(r, c)).collect())
}
