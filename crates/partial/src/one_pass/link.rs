//! Linking: in every cell of four pixels, what enters leads to what leaves.

use super::band::{Band, FOLLOWS};
use super::cell::{self, BOTTOM, LEFT, LINKS, RIGHT, SADDLE_TL_BR, SADDLE_TR_BL, Shapes, TOP};
use super::contours::{Kind, edge_code};
use super::emit::{cross, sample};
use super::rows::{PAD, Row};
use super::source::Source;

/// Four neighbouring pixels: corners TL, TR, BL, BR; edges in the order of [`cell`].
struct Cell {
    levels: [f32; 4],
    ceilings: [i32; 4],
    bases: [u32; 4],
}

/// Links the crossings of the cells between row `i` and the one above.
pub(super) fn link_row(source: &Source<'_>, i: usize, above: &Row, row: &Row, band: &mut Band) {
    let (mut joined_before, mut crossed_before) = before_first(source, row);
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
        if crossed == 0 {
            continue;
        }
        let shapes = Shapes::of(joined);
        each(shapes.whole & crossed, word, |j| link(&gather(above, row, j), &[true; 4], band));
        each(shapes.open & crossed, word, |j| {
            let joined = joined.map(|mask| mask >> (j % 64) & 1 == 1);
            link(&gather(above, row, j), &joined, band);
        });
        let triangles = shapes.without.iter().fold(0, |all, mask| all | mask);
        each(triangles & crossed, word, |j| {
            let corner = shapes.without.iter().position(|mask| mask >> (j % 64) & 1 == 1);
            link_triangle(source, i, (above, row), (j, corner.unwrap_or(0)), band);
        });
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

/// The cell whose lower right corner is in column `j`.
#[inline(always)]
fn gather(above: &Row, row: &Row, j: usize) -> Cell {
    let (right, left) = (PAD + j, PAD + j - 1);
    Cell {
        levels: [above.levels[left], above.levels[right], row.levels[left], row.levels[right]],
        ceilings: [
            above.ceilings[left],
            above.ceilings[right],
            row.ceilings[left],
            row.ceilings[right],
        ],
        bases: [
            above.left.bases[right],
            row.up.bases[left],
            row.up.bases[right],
            row.left.bases[right],
        ],
    }
}

#[inline(always)]
fn link(cell: &Cell, joined: &[bool; 4], band: &mut Band) {
    let [a, b, c, d] = cell.ceilings;
    for level in a.min(b).min(c.min(d))..a.max(b).max(c.max(d)) {
        let code = cell.ceilings.iter().enumerate();
        let code: usize = code.map(|(k, ceiling)| usize::from(*ceiling > level) << k).sum();
        if code == SADDLE_TL_BR || code == SADDLE_TR_BL {
            // Of which the mean of the corners decides, as in most contouring programs.
            let sum = cell.levels.iter().map(|l| f64::from(*l)).sum::<f64>();
            for pair in cell::saddle(code, sum > 4.0 * f64::from(level)) {
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
    (above, row): (&Row, &Row),
    (j, corner): (usize, usize),
    band: &mut Band,
) {
    let triangle = cell::TRIANGLES[corner];
    let mut cell = gather(above, row, j);
    cell.ceilings[triangle.missing] = cell.ceilings[triangle.onto];
    let before = if j == 0 { source.cols - 1 } else { j - 1 };
    let (over, here) = (source.places(i - 1, above), source.places(i, row));
    let (left, right) = ((j.wrapping_sub(1), before), (j, j));
    let (kind, (from, from_col), (to, to_col)) =
        if triangle.falls { (Kind::Falling, left, right) } else { (Kind::Rising, right, left) };
    let (a, b) = (sample(above, &over, from, from_col), sample(row, &here, to, to_col));
    let mut at = band.count;
    let edge = edge_code(i, kind, j, source.cols);
    cell.bases[usize::from(triangle.diagonal)] = cross(band, &mut at, edge, a, b);
    band.add(at);
    let mut joined = [TOP, LEFT, RIGHT, BOTTOM].map(|edge| {
        // The two pairs of the corner opposite the missing one, and the diagonal.
        let pairs = [[RIGHT, BOTTOM], [LEFT, BOTTOM], [TOP, RIGHT], [TOP, LEFT]][corner];
        pairs.contains(&edge)
    });
    joined[usize::from(triangle.diagonal)] = true;
    link(&cell, &joined, band);
}
