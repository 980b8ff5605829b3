//! Linking: in every cell of four pixels, each entering crossing leads to a leaving one.

use super::apart::apart;
use super::band::{Band, FOLLOWS, capacity_bytes};
use super::cell::{self, LINKS, SADDLE_TL_BR, SADDLE_TR_BL, Shapes};
use super::emit::{Sample, cross_one, sample};
use super::rows::{PAD, Pairs, Row, WORDS, columns};
use super::source::Source;
use super::vertex::{Kind, edge_code};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x4};

/// Four neighbouring pixels: corners TL, TR, BL, BR; edges in the order of [`cell`].
#[derive(Clone, Copy)]
struct Cell {
    ceilings: [i32; 4],
    bases: [u32; 4],
}

/// The numbers of two rows for cells, by the column of the cell's lower right corner. All slices
/// are of one length, so that one test of an index is enough.
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
    /// Some pairs broken, but still with curves.
    broken: Vec<u64>,
    columns: Vec<u32>,
}

impl Cells {
    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        capacity_bytes(&self.whole) + capacity_bytes(&self.broken) + capacity_bytes(&self.columns)
    }
}

/// The masks of the four pairs of each cell.
struct Masks<'a> {
    above: &'a Pairs,
    up: &'a Pairs,
    left: &'a Pairs,
    /// Whether the upward pair to the left of column 0 is joined, and whether it is crossed.
    before_first: [u64; 2],
}

impl<'a> Masks<'a> {
    #[inline(always)]
    fn new(source: &Source<'_>, above: &'a Row, row: &'a Row) -> Self {
        let last = source.cols - 1;
        let bit = |mask: &[u64]| if source.wraps { mask[last / 64] >> (last % 64) & 1 } else { 0 };
        let before_first = [bit(&row.up.joined), bit(&row.up.crossed)];
        Self { above: &above.left, up: &row.up, left: &row.left, before_first }
    }

    /// Marks the cells that carry crossings; returns whether any of them has broken pairs.
    #[inline(always)]
    fn mark(&self, cells: &mut Cells) -> bool {
        let words = self.up.joined.len();
        cells.whole.resize(words, 0);
        cells.broken.resize(words, 0);
        let joined = blocks(&self.above.joined).zip(blocks(&self.up.joined));
        let joined = joined.zip(blocks(&self.left.joined));
        let crossed = blocks(&self.above.crossed).zip(blocks(&self.up.crossed));
        let crossed = crossed.zip(blocks(&self.left.crossed));
        let (whole, _) = cells.whole.as_chunks_mut::<WORDS>();
        let (broken, _) = cells.broken.as_chunks_mut::<WORDS>();
        let [mut joined_before, mut crossed_before] = self.before_first;
        let mut any = [0; WORDS];
        for ((joined, crossed), (whole, broken)) in
            joined.zip(crossed).zip(whole.iter_mut().zip(broken))
        {
            let ((top, right), bottom) = joined;
            let left = beside(right, &mut joined_before);
            let ((crossed_top, crossed_right), crossed_bottom) = crossed;
            let crossed_left = beside(crossed_right, &mut crossed_before);
            for k in 0..WORDS {
                let crossed =
                    crossed_top[k] | crossed_left[k] | crossed_right[k] | crossed_bottom[k];
                let shapes = Shapes::of([top[k], left[k], right[k], bottom[k]]);
                whole[k] = shapes.whole & crossed;
                broken[k] = (shapes.open | shapes.triangles()) & crossed;
                any[k] |= broken[k];
            }
        }
        any != [0; WORDS]
    }

    /// Which pairs of a cell are joined: top, left, right, bottom.
    fn joined(&self, j: usize) -> [bool; 4] {
        let bit = |mask: &[u64], j: usize| mask[j / 64] >> (j % 64) & 1 == 1;
        let left = match j.checked_sub(1) {
            Some(before) => bit(&self.up.joined, before),
            None => self.before_first[0] == 1,
        };
        let Self { above, up, left: bottom, .. } = self;
        [bit(&above.joined, j), left, bit(&up.joined, j), bit(&bottom.joined, j)]
    }
}

/// A mask, some words at a time.
#[inline(always)]
fn blocks(mask: &[u64]) -> impl Iterator<Item = &[u64; WORDS]> {
    mask.as_chunks().0.iter()
}

/// The bits one column to the left; `before` is the bit before the first, and then that before the
/// next block.
#[inline(always)]
fn beside(mask: &[u64; WORDS], before: &mut u64) -> [u64; WORDS] {
    let mut carry = mask.map(|word| word >> 63);
    carry.rotate_right(1);
    let next = std::mem::replace(&mut carry[0], *before);
    *before = next;
    std::array::from_fn(|k| mask[k] << 1 | carry[k])
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
    let masks = Masks::new(source, above, row);
    let (broken, count) = apart(
        simd,
        #[inline(always)]
        || {
            let broken = masks.mark(cells);
            (broken, columns(&cells.whole, &mut cells.columns).len())
        },
    );
    let whole = cells.columns.get(..count).unwrap_or(&[]);
    apart(
        simd,
        #[inline(always)]
        || link_whole(simd, &rows, whole, band),
    );
    if broken {
        let edge = edge_code(i, Kind::Rising, 0, source.cols) as usize;
        let corners = Corners { above, row, rows: &rows, edge };
        link_broken(&corners, &masks, band, cells);
    }
}

/// Links the cells that have broken pairs.
#[inline(never)]
fn link_broken(corners: &Corners<'_>, masks: &Masks<'_>, band: &mut Band, cells: &Cells) {
    for (word, broken) in cells.broken.iter().enumerate() {
        each(*broken, word, |j| {
            let joined = masks.joined(j);
            let shapes = Shapes::of(joined.map(u64::from));
            if shapes.open & 1 == 1 {
                if let Some(cell) = corners.rows.cell(j) {
                    link(corners.rows, (j, &cell), &joined, band);
                }
            } else {
                let corner = shapes.without.iter().position(|mask| mask & 1 == 1);
                link_triangle(corners, (j, corner.unwrap_or(0)), band);
            }
        });
    }
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

#[inline(always)]
fn each(mut bits: u64, word: usize, mut act: impl FnMut(usize)) {
    while bits != 0 {
        act(64 * word + bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// Links entering crossings of a cell to leaving ones, where both pairs are joined.
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

/// The samples at the corners of cells, for those that become triangles.
struct Corners<'a> {
    above: &'a Row,
    row: &'a Row,
    rows: &'a Rows<'a>,
    /// The cells' diagonals are numbered from here on.
    edge: usize,
}

impl Corners<'_> {
    /// The sample of the row above, in column `j` or some columns before.
    fn above(&self, j: usize, before: usize) -> Option<Sample> {
        sample(self.above, (j, before))
    }

    /// That of the row.
    fn row(&self, j: usize, before: usize) -> Option<Sample> {
        sample(self.row, (j, before))
    }
}

/// Links three corners of a cell; a crossing of the diagonal ends or begins a curve.
fn link_triangle(corners: &Corners<'_>, (j, corner): (usize, usize), band: &mut Band) {
    let triangle = &cell::TRIANGLES[corner];
    let Some(mut cell) = corners.rows.cell(j) else { return };
    cell.ceilings[triangle.missing] = cell.ceilings[triangle.onto];
    let (from, to) = if triangle.falls { (1, 0) } else { (0, 1) };
    let (Some(a), Some(b)) = (corners.above(j, from), corners.row(j, to)) else { return };
    let edge = corners.edge + 2 * j + usize::from(triangle.falls);
    cell.bases[usize::from(triangle.diagonal)] = cross_one(band, edge as u32, a, b);
    if band.full {
        // The diagonal has no crossings to link; the sweep ends after this row.
        return;
    }
    link(corners.rows, (j, &cell), &triangle.joined, band);
}
