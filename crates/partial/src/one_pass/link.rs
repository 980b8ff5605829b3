//! Linking: in every cell of four pixels, what enters leads to what leaves.

use super::band::{Band, FOLLOWS, capacity_bytes};
use super::cell::{self, LINKS, SADDLE_TL_BR, SADDLE_TR_BL, Shapes};
use super::contours::{Kind, edge_code};
use super::emit::{Samples, cross_one};
use super::part::apart;
use super::rows::{PAD, Row, columns};
use super::source::{Places, Source};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x4};

/// Four neighbouring pixels: corners TL, TR, BL, BR; edges in the order of [`cell`].
#[derive(Clone, Copy)]
struct Cell {
    ceilings: [i32; 4],
    bases: [u32; 4],
}

/// What cells need of two rows, by the column of their lower right corner. All slices are of one
/// length, so that one test of an index is enough.
struct Rows<'a> {
    /// Of the columns before, and of the columns themselves.
    above: [&'a [i32]; 2],
    row: [&'a [i32]; 2],
    /// Numbers of top, left, right and bottom pairs.
    bases: [&'a [u32]; 4],
    /// As `above` and `row`.
    levels: [&'a [f32]; 4],
}

impl<'a> Rows<'a> {
    #[inline(always)]
    fn new(above: &'a Row, row: &'a Row) -> Option<Self> {
        fn shifted<T>(list: &[T], before: usize, len: usize) -> Option<&[T]> {
            list.get(PAD - before..PAD - before + len)
        }
        let n = row.ceilings.len() - PAD;
        let ceilings =
            |row: &'a Row| Some([shifted(&row.ceilings, 1, n)?, shifted(&row.ceilings, 0, n)?]);
        let levels =
            |row: &'a Row| Some([shifted(&row.levels, 1, n)?, shifted(&row.levels, 0, n)?]);
        let ([a, b], [c, d]) = (levels(above)?, levels(row)?);
        let up = &row.up.bases;
        Some(Self {
            above: ceilings(above)?,
            row: ceilings(row)?,
            bases: [
                shifted(&above.left.bases, 0, n)?,
                shifted(up, 1, n)?,
                shifted(up, 0, n)?,
                shifted(&row.left.bases, 0, n)?,
            ],
            levels: [a, b, c, d],
        })
    }

    /// The cell whose lower right corner is in column `j`.
    #[inline(always)]
    fn cell(&self, j: usize) -> Option<Cell> {
        let ([a, b], [c, d], [top, left, right, bottom]) = (self.above, self.row, self.bases);
        Some(Cell {
            ceilings: [*a.get(j)?, *b.get(j)?, *c.get(j)?, *d.get(j)?],
            bases: [*top.get(j)?, *left.get(j)?, *right.get(j)?, *bottom.get(j)?],
        })
    }

    /// Whether the mean of a cell's four levels exceeds a plane (saddles only, which are rare).
    #[cold]
    #[inline(never)]
    fn middle_exceeds(&self, j: usize, level: i32) -> bool {
        let sum = self.levels.iter().filter_map(|levels| levels.get(j)).copied().map(f64::from);
        sum.sum::<f64>() > 4.0 * f64::from(level)
    }
}

/// Work space: which cells of a row carry crossings, and their columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells {
    /// All four pairs joined.
    whole: Vec<u64>,
    columns: Vec<u32>,
}

impl Cells {
    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        capacity_bytes(&self.whole) + capacity_bytes(&self.columns)
    }
}

/// Links the crossings of the cells between row `i` and the one above.
#[inline(always)]
pub(super) fn link_row<S: Simd>(
    simd: S,
    source: &Source<'_>,
    i: usize,
    (above, row): (&Row, &Row),
    band: &mut Band,
    cells: &mut Cells,
) {
    let Some(rows) = Rows::new(above, row) else { return };
    let mut corners = None;
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
        let triangles = shapes.without.iter().fold(0, |all, mask| all | mask) & crossed;
        if shapes.open & crossed | triangles != 0 {
            each(shapes.open & crossed, word, |j| {
                if let Some(cell) = rows.cell(j) {
                    let joined = joined.map(|mask| mask >> (j % 64) & 1 == 1);
                    link(&rows, (j, &cell), &joined, band);
                }
            });
            each(triangles, word, |j| {
                let corner = shapes.without.iter().position(|mask| mask >> (j % 64) & 1 == 1);
                let corners = corners.get_or_insert_with(|| Corners::new(source, i, above, row));
                if let Some(corners) = corners {
                    link_triangle(corners, &rows, (j, corner.unwrap_or(0)), band);
                }
            });
        }
    }
    let whole = columns(cells.whole.iter().copied(), &mut cells.columns);
    apart(
        simd,
        #[inline(always)]
        || link_whole(simd, &rows, whole, band),
    );
}

/// Links whole cells: every crossing that enters one leaves it again.
#[inline(always)]
fn link_whole<S: Simd>(simd: S, rows: &Rows<'_>, columns: &[u32], band: &mut Band) {
    let count = band.count;
    let (Some(next), Some(marks)) = (band.next.get_mut(..count), band.marks.get_mut(..count))
    else {
        return;
    };
    let mut connect = |bases: &[u32; 4], level: i32, [from, to]: [u8; 2]| {
        let number = |edge: u8| bases[usize::from(edge & 3)].wrapping_add(level as u32);
        let (from, to) = (number(from), number(to));
        if let (Some(next), Some(mark)) = (next.get_mut(from as usize), marks.get_mut(to as usize))
        {
            *next = to;
            *mark = FOLLOWS;
        }
    };
    for &j in columns {
        let j = j as usize;
        let Some(Cell { ceilings, bases }) = rows.cell(j) else { break };
        let [a, b, c, d] = ceilings;
        let corners = i32x4::simd_from(simd, ceilings);
        for level in a.min(b).min(c.min(d))..a.max(b).max(c.max(d)) {
            let code = corners.simd_gt(level).to_bitmask() as usize & 15;
            let [from, to] = LINKS[code];
            if from == to {
                for pair in cell::saddle(code, rows.middle_exceeds(j, level)) {
                    connect(&bases, level, pair);
                }
            } else {
                connect(&bases, level, [from, to]);
            }
        }
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

/// Links what enters a cell to what leaves it, as far as both pairs are joined.
fn link(rows: &Rows<'_>, (j, cell): (usize, &Cell), joined: &[bool; 4], band: &mut Band) {
    let [a, b, c, d] = cell.ceilings;
    for level in a.min(b).min(c.min(d))..a.max(b).max(c.max(d)) {
        let [a, b, c, d] = [a > level, b > level, c > level, d > level].map(usize::from);
        let code = a | b << 1 | c << 2 | d << 3;
        if code == SADDLE_TL_BR || code == SADDLE_TR_BL {
            // Of which the mean of the corners decides, as in most contouring programs.
            for pair in cell::saddle(code, rows.middle_exceeds(j, level)) {
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

/// The samples at a cell's corners, for those that become triangles.
struct Corners<'a> {
    /// Of the row above and of the row, each of the columns before and of the columns themselves.
    samples: [[Samples<'a, Places<'a>>; 2]; 2],
    /// The cells' diagonals are numbered from here on.
    edge: usize,
}

impl<'a> Corners<'a> {
    #[inline(always)]
    fn new(source: &'a Source<'_>, i: usize, above: &'a Row, row: &'a Row) -> Option<Self> {
        let samples = |i: usize, row: &'a Row| {
            let len = source.padded_cols();
            let of = |before| Samples::new(row, before, len, source.places(i, row, before, len)?);
            Some([of(1)?, of(0)?])
        };
        let edge = edge_code(i, Kind::Rising, 0, source.cols) as usize;
        Some(Self { samples: [samples(i.checked_sub(1)?, above)?, samples(i, row)?], edge })
    }
}

/// Links three corners of a cell; a crossing of the diagonal ends or begins a curve.
fn link_triangle(
    corners: &Corners<'_>,
    rows: &Rows<'_>,
    (j, corner): (usize, usize),
    band: &mut Band,
) {
    let triangle = &cell::TRIANGLES[corner];
    let Some(mut cell) = rows.cell(j) else { return };
    cell.ceilings[triangle.missing] = cell.ceilings[triangle.onto];
    let [above, row] = &corners.samples;
    let (from, to) = if triangle.falls { (&above[0], &row[1]) } else { (&above[1], &row[0]) };
    let (Some(a), Some(b)) = (from.at(j), to.at(j)) else { return };
    let edge = corners.edge + 2 * j + usize::from(triangle.falls);
    cell.bases[usize::from(triangle.diagonal)] = cross_one(band, edge as u32, a, b);
    if band.full {
        // The diagonal has no crossings to link; the sweep ends after this row.
        return;
    }
    link(rows, (j, &cell), &triangle.joined, band);
}
