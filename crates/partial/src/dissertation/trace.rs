//! Tracing: from links to chains of borders (3.5.1).
//!
//! A trace starts from a pixel first found, and goes back to where its curve begins. It then
//! follows the curve until no more neighbouring pixel is found or the first one is met again.

use super::link::{Contour, End, Links};
use super::samples::Samples;
use super::search::Side;
use transect_device::{Neighbour, Pixel};
use transect_geometry::EndReason;

/// A border crossed by the plane: the pixel and which neighbour it is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Border {
    pub pixel: Pixel,
    pub neighbour: Neighbour,
    /// Whether missing pixels lie between this border and the next.
    pub bridged_after: bool,
}

/// A curve in pixels.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    /// Borders in the order of the trace.
    pub borders: Vec<Border>,
    /// Why it begins and ends; `None` if closed.
    pub ends: Option<[EndReason; 2]>,
    /// Whether the high pixels are on its left, seen with rows running down.
    pub high_on_left: bool,
}

/// All curves, in the order in which their first pixels are found.
pub(super) fn trace(contour: &Contour, links: &Links, samples: &Samples) -> Vec<Trace> {
    let mut visited = vec![false; contour.pixels.len()];
    let mut traces = Vec::new();
    for pixel in 0..contour.pixels.len() {
        if !visited[pixel] {
            traces.push(follow(contour, links, samples, beginning(links, pixel), &mut visited));
        }
    }
    traces
}

/// The end on which a curve through a pixel is entered first; any for a closed curve.
fn beginning(links: &Links, pixel: usize) -> End {
    let start = End { pixel, slot: 1 };
    let mut at = start;
    while let Some(link) = links.of(at) {
        at = link.to.opposite();
        if at == start {
            break;
        }
    }
    at
}

fn follow(
    contour: &Contour,
    links: &Links,
    samples: &Samples,
    start: End,
    visited: &mut [bool],
) -> Trace {
    let mut borders = Vec::new();
    let mut entered = start;
    loop {
        visited[entered.pixel] = true;
        let leaves = entered.opposite();
        let next = links.of(leaves);
        push_pixel(contour, entered, next.is_some_and(|l| l.bridged), &mut borders);
        match next {
            Some(link) if link.to == start => {
                let high_on_left = contour.high_on_left(leaves);
                return Trace { borders, ends: None, high_on_left };
            }
            Some(link) => entered = link.to,
            None => {
                let ends = [start, leaves].map(|end| reason(contour, samples, end));
                let high_on_left = contour.high_on_left(leaves);
                return Trace { borders, ends: Some(ends), high_on_left };
            }
        }
    }
}

/// The one or two borders of a pixel, in the order in which the curve crosses them.
fn push_pixel(contour: &Contour, entered: End, bridged_after: bool, borders: &mut Vec<Border>) {
    let pixel = contour.pixels[entered.pixel];
    let [first, second] = [entered, entered.opposite()].map(|end| contour.side(end).border());
    if first != second {
        borders.push(Border { pixel, neighbour: first, bridged_after: false });
    }
    borders.push(Border { pixel, neighbour: second, bridged_after });
}

/// Why nothing follows an end: what is wrong with the cell it leads into.
fn reason(contour: &Contour, samples: &Samples, end: End) -> EndReason {
    let (p, side) = (contour.pixels[end.pixel], contour.side(end));
    let cell = match side {
        Side::East => [(-1, 1), (0, 1)],
        Side::West => [(-1, -1), (0, -1)],
        Side::North => [(-1, -1), (-1, 0)],
        Side::South => [(1, -1), (1, 0)],
    };
    let pixels = cell.map(|(rows, cols)| contour.grid.step(p, rows, cols));
    if pixels.contains(&None) {
        return EndReason::ImageBorder;
    }
    let missing = pixels.iter().flatten().any(|p| samples.level(*p).is_none());
    if missing { EndReason::MissingPixel } else { EndReason::RangeJump }
}
