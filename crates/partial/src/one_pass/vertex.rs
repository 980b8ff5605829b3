//! The vertices of lines, and the numbers of the pixel pairs that they lie on.

use transect_device::Pixel;

/// A plane crossing a pair of neighbouring samples, with its linear subpixel solution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Vertex {
    /// The pair, see [`Contours::pair`](super::Contours::pair).
    pub edge: u32,
    /// Where between the pair's first sample (0) and its second (1).
    pub t: f32,
}

/// The kind of a pair of neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A pixel and the one above, which is the first sample.
    Up,
    /// A pixel and the one to its left, which is the first sample.
    Left,
    /// The diagonal of a cell from its upper right pixel to its lower left one.
    Rising,
    /// The diagonal of a cell from its upper left pixel to its lower right one.
    Falling,
}

/// Number of a pair: ascending by row, then upward pairs, left pairs, diagonals, each by column.
/// Row and column are those of the lower right pixel of the cells that the pair belongs to.
pub(super) fn edge_code(row: usize, kind: Kind, col: usize, cols: usize) -> u32 {
    let within = match kind {
        Kind::Up => col,
        Kind::Left => cols + col,
        Kind::Rising => 2 * (cols + col),
        Kind::Falling => 2 * (cols + col) + 1,
    };
    (row * 4 * cols + within) as u32
}

/// Kind of a pair, and the pixel it is numbered by.
pub(super) fn decode(edge: u32, cols: usize) -> (Kind, Pixel) {
    let (row, within) = (edge as usize / (4 * cols), edge as usize % (4 * cols));
    let (kind, col) = match within / cols {
        0 => (Kind::Up, within),
        1 => (Kind::Left, within - cols),
        _ if within % 2 == 0 => (Kind::Rising, within / 2 - cols),
        _ => (Kind::Falling, within / 2 - cols),
    };
    (kind, Pixel::new(row, col))
}
