//! Linking: in every cell of four pixels, what enters leads to what leaves.

use super::band::{Band, FOLLOWS};
use super::cell::{self, BOTTOM, LEFT, LINKS, RIGHT, SADDLE_TL_BR, SADDLE_TR_BL, Shapes, TOP};
use super::contours::{Kind, edge_code};
use super::emit::{cross, sample};
use super::rows::{PAD, Row, columns};
use super::source::Source;

/// Four neighbouring pixels: corners TL, TR, BL, BR; edges in the order of [`cell`].
struct Cell {
    /// Column of the lower right pixel in the rows' arrays.
    at: usize,
    ceilings: [i32; 4],
    bases: [u32; 4],
}

/// What cells need of two rows; all slices are of one length, so that one test of an index is enough.
struct Rows<'a> {
    above: &'a Row,
    row: &'a Row,
    ceilings: [&'a [i32]; 2],
    /// Numbers of top, upward and bottom pairs.
    bases: [&'a [u32]; 3],
}

impl<'a> Rows<'a> {
    fn new(above: &'a Row, row: &'a Row) -> Option<Self> {
        let n = row.ceilings.len();
        let ceilings = [above.ceilings.get(..n)?, row.ceilings.get(..n)?];
        let bases = [above.left.bases.get(..n)?, row.up.bases.get(..n)?, row.left.bases.get(..n)?];
        Some(Self { above, row, ceilings, bases })
    }

    /// The cell whose lower right corner is in column `j`.
    #[inline(always)]
    fn cell(&self, j: usize) -> Cell {
        let ([above, row], [top, up, bottom]) = (self.ceilings, self.bases);
        let at = (PAD + j).min(row.len() - 1);
        Cell {
            at,
            ceilings: [above[at - 1], above[at], row[at - 1], row[at]],
            bases: [top[at], up[at - 1], up[at], bottom[at]],
        }
    }

    /// Whether the mean of a cell's four levels exceeds a plane (saddles only, which are rare).
    #[cold]
    fn middle_exceeds(&self, cell: &Cell, level: i32) -> bool {
        let Cell { at, .. } = *cell;
        let levels = [
            self.above.levels[at - 1],
            self.above.levels[at],
            self.row.levels[at - 1],
            self.row.levels[at],
        ];
        levels.iter().map(|l| f64::from(*l)).sum::<f64>() > 4.0 * f64::from(level)
    }
}

/// Work space: which cells of a row carry crossings, and their columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells {
    /// All four pairs joined.
    whole: Vec<u64>,
    columns: Vec<u32>,
}

/// Links the crossings of the cells between row `i` and the one above.
#[inline(always)]
pub(super) fn link_row(
    source: &Source<'_>,
    i: usize,
    (above, row): (&Row, &Row),
    band: &mut Band,
    cells: &mut Cells,
) {
    let Some(rows) = Rows::new(above, row) else { return };
    let (mut joined_before, mut crossed_before) = before_first(source, row);
    cells.whole.clear();
    for word in 0..row.up.joined.len() {
        let (joined_up, crossed_up) = (row.up.joined[word], row.up.crossed[word]);
        let joined = [
            above.left.joined[word],
            joined_up << 1 | joined_before,
            joined_up,
            row.left.joined[word],
        ];
        let crossed = above.left.crossed[word]
            | (crossed_up << 1 | crossed_before)
            | crossed_up
            | row.left.crossed[word];
        (joined_before, crossed_before) = (joined_up >> 63, crossed_up >> 63);
        let shapes = Shapes::of(joined);
        cells.whole.push(shapes.whole & crossed);
        let triangles = shapes.without.iter().fold(0, |all, mask| all | mask);
        if (shapes.open | triangles) & crossed != 0 {
            each(shapes.open & crossed, word, |j| {
                let joined = joined.map(|mask| mask >> (j % 64) & 1 == 1);
                link(&rows, &rows.cell(j), &joined, band);
            });
            each(triangles & crossed, word, |j| {
                let corner = shapes.without.iter().position(|mask| mask >> (j % 64) & 1 == 1);
                link_triangle(source, i, &rows, (j, corner.unwrap_or(0)), band);
            });
        }
    }
    for &j in columns(cells.whole.iter().copied(), &mut cells.columns) {
        link(&rows, &rows.cell(j as usize), &[true; 4], band);
    }
}

/// The bits of the upward pair to the left of column 0.
fn before_first(source: &Source<'_>, row: &Row) -> (u64, u64) {
    let last = source.cols - 1;
    let bit = |mask: &[u64]| if source.wraps { mask[last / 64] >> (last % 64) & 1 } else { 0 };
    (bit(&row.up.joined), bit(&row.up.crossed))
}

#[inline(always)]
fn each(mut bits: u64, word: usize, mut act: impl FnMut(usize)) {
    while bits != 0 {
        act(64 * word + bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

#[inline(always)]
fn link(rows: &Rows<'_>, cell: &Cell, joined: &[bool; 4], band: &mut Band) {
    let [a, b, c, d] = cell.ceilings;
    for level in a.min(b).min(c.min(d))..a.max(b).max(c.max(d)) {
        let [a, b, c, d] = [a > level, b > level, c > level, d > level].map(usize::from);
        let code = a | b << 1 | c << 2 | d << 3;
        if code == SADDLE_TL_BR || code == SADDLE_TR_BL {
            // Of which the mean of the corners decides, as in most contouring programs.
            for pair in cell::saddle(code, rows.middle_exceeds(cell, level)) {
                connect(cell, joined, level, pair, band);
            }
        } else {
            connect(cell, joined, level, LINKS[code & 15], band);
        }
    }
}

#[inline(always)]
fn connect(cell: &Cell, joined: &[bool; 4], level: i32, [from, to]: [u8; 2], band: &mut Band) {
    let (from, to) = (usize::from(from & 3), usize::from(to & 3));
    if joined[from] && joined[to] {
        let number = |edge: usize| cell.bases[edge].wrapping_add(level as u32);
        let (from, to) = (number(from), number(to));
        band.next[from as usize] = to;
        band.marks[to as usize] = FOLLOWS;
    }
}

/// Links three corners of a cell; a crossing of the diagonal ends or begins a curve.
fn link_triangle(
    source: &Source<'_>,
    i: usize,
    rows: &Rows<'_>,
    (j, corner): (usize, usize),
    band: &mut Band,
) {
    let triangle = cell::TRIANGLES[corner];
    let Rows { above, row, .. } = *rows;
    let mut cell = rows.cell(j);
    cell.ceilings[triangle.missing] = cell.ceilings[triangle.onto];
    let before = if j == 0 { source.cols - 1 } else { j - 1 };
    let (over, here) = (source.places(i - 1, above), source.places(i, row));
    let (kind, from, to) =
        if triangle.falls { (Kind::Falling, before, j) } else { (Kind::Rising, j, before) };
    let (a, b) = (sample(above, &over, from, 0), sample(row, &here, to, 0));
    let mut at = band.count;
    let edge = edge_code(i, kind, j, source.cols);
    cell.bases[usize::from(triangle.diagonal)] = cross(band, &mut at, edge, a, b);
    if band.full {
        // The diagonal has no crossings to link; the sweep ends after this row.
        return;
    }
    band.add(at);
    let mut joined = [TOP, LEFT, RIGHT, BOTTOM].map(|edge| {
        // The two pairs of the corner opposite the missing one, and the diagonal.
        let pairs = [[RIGHT, BOTTOM], [LEFT, BOTTOM], [TOP, RIGHT], [TOP, LEFT]][corner];
        pairs.contains(&edge)
    });
    joined[usize::from(triangle.diagonal)] = true;
    link(rows, &cell, &joined, band);
}
