//! Emission: every plane between the two samples of a joined pair is a crossing with a vertex.
//!
//! Crossings of one pair have consecutive numbers, so one number per pair stands for all of them.

use super::band::Band;
use super::contours::{Kind, Vertex, edge_code};
use super::rows::{PAD, Row};
use super::source::{Places, Source};

/// One sample of a pair.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub level: f32,
    pub ceiling: i32,
    pub place: [f32; 2],
}

/// The crossings of the pairs of row `i` with the row above it.
pub(super) fn emit_up(source: &Source<'_>, i: usize, above: &Row, row: &mut Row, band: &mut Band) {
    let mut at = band.count;
    let mut bases = std::mem::take(&mut row.up.bases);
    let (over, here) = (source.places(i.wrapping_sub(1), above), source.places(i, row));
    let first = edge_code(i, Kind::Up, 0, source.cols);
    for (word, mask) in row.up.crossed.iter().enumerate() {
        let mut bits = *mask;
        while bits != 0 {
            let j = 64 * word + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let (a, b) = (sample(above, &over, j, j), sample(row, &here, j, j));
            bases[PAD + j] = cross(band, &mut at, first.wrapping_add(j as u32), a, b);
        }
    }
    bases[PAD - 1] = bases[PAD + source.cols - 1];
    row.up.bases = bases;
    band.add(at);
}

/// The crossings of the pairs of row `i` with their left neighbours.
pub(super) fn emit_left(source: &Source<'_>, i: usize, row: &mut Row, band: &mut Band) {
    let mut at = band.count;
    let mut bases = std::mem::take(&mut row.left.bases);
    let here = source.places(i, row);
    let first = edge_code(i, Kind::Left, 0, source.cols);
    for (word, mask) in row.left.crossed.iter().enumerate() {
        let mut bits = *mask;
        while bits != 0 {
            let j = 64 * word + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let before = if j == 0 { source.cols - 1 } else { j - 1 };
            let a = sample(row, &here, j.wrapping_sub(1), before);
            let b = sample(row, &here, j, j);
            bases[PAD + j] = cross(band, &mut at, first.wrapping_add(j as u32), a, b);
        }
    }
    row.left.bases = bases;
    band.last_row = band.count..at;
    band.add(at);
}

/// Numbers the crossings of a row's left pairs without making vertices: the guests of a band. Returns
/// how many there are.
pub(super) fn number_guests(row: &mut Row) -> usize {
    let mut at = 0_u32;
    for (word, mask) in row.left.crossed.iter().enumerate() {
        let mut bits = *mask;
        while bits != 0 {
            let j = PAD + 64 * word + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let (a, b) = (row.ceilings[j - 1], row.ceilings[j]);
            row.left.bases[j] = at.wrapping_sub(a.min(b) as u32);
            at += a.abs_diff(b);
        }
    }
    at as usize
}

/// Whether each crossing of a row's left pairs runs up, in the order of their numbers.
pub(super) fn runs_up(row: &Row, out: &mut Vec<bool>) {
    out.clear();
    for (word, mask) in row.left.crossed.iter().enumerate() {
        let mut bits = *mask;
        while bits != 0 {
            let j = PAD + 64 * word + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let (a, b) = (row.ceilings[j - 1], row.ceilings[j]);
            out.resize(out.len() + a.abs_diff(b) as usize, a > b);
        }
    }
}

/// Column `j` of a row, −1 for the one before the first, whose place is that of column `col`.
#[inline(always)]
pub(super) fn sample(row: &Row, places: &Places<'_>, j: usize, col: usize) -> Sample {
    let at = PAD.wrapping_add(j);
    Sample { level: row.levels[at], ceiling: row.ceilings[at], place: places.at(col) }
}

/// Emits the crossings of one pair; returns its number at level 0.
///
/// `t = (level_a − k) / (level_a − level_b)`: the linear subpixel solution (3.6, errata).
#[inline(always)]
pub(super) fn cross(band: &mut Band, at: &mut usize, edge: u32, a: Sample, b: Sample) -> u32 {
    let (low, high) = (a.ceiling.min(b.ceiling), a.ceiling.max(b.ceiling));
    let first = *at;
    let end = first + high.abs_diff(low) as usize;
    if !band.reach(end) {
        return 0;
    }
    *at = end;
    let per_level = 1.0 / (a.level - b.level);
    let [dx, dy] = [b.place[0] - a.place[0], b.place[1] - a.place[1]];
    let (Some(vertices), Some(levels)) =
        (band.vertices.get_mut(first..end), band.levels.get_mut(first..end))
    else {
        return 0;
    };
    for (k, (vertex, level)) in (low..high).zip(vertices.iter_mut().zip(levels)) {
        let t = ((a.level - k as f32) * per_level).min(1.0);
        *vertex = Vertex { edge, t, x: a.place[0] + t * dx, y: a.place[1] + t * dy };
        *level = k;
    }
    (first as u32).wrapping_sub(low as u32)
}
