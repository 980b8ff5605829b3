//! Emission: every plane between the two samples of a joined pair is a crossing with a vertex.
//!
//! Crossings of one pair have consecutive numbers, so one number per pair stands for all of them.

use super::band::Band;
use super::contours::{Kind, Vertex, edge_code};
use super::rows::{PAD, Row, columns};
use super::source::{PlaceAt, Places, Source};

/// Vertices that are made together, whether they are all wanted or not: most pairs have fewer, and a
/// loop that stops after one or two is guessed wrong more often than not.
const AT_ONCE: usize = 2;

/// One sample of a pair.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub level: f32,
    pub ceiling: i32,
    pub place: [f32; 2],
}

/// The crossings of the pairs of row `i` with the row above it.
#[inline(always)]
pub(super) fn emit_up(
    source: &Source<'_>,
    i: usize,
    (above, row): (&Row, &mut Row),
    band: &mut Band,
    list: &mut Vec<u32>,
) {
    let mut bases = std::mem::take(&mut row.up.bases);
    let pairs = columns(row.up.crossed.iter().copied(), list);
    let edge = edge_code(i, Kind::Up, 0, source.cols);
    match (source.places(i.wrapping_sub(1), above), source.places(i, row)) {
        (Places::Tables(over), Places::Tables(here)) => {
            emit_pairs(pairs, edge, (above, over), (row, here), &mut bases, band);
        }
        (over, here) => emit_pairs(pairs, edge, (above, over), (row, here), &mut bases, band),
    }
    bases[PAD - 1] = bases[PAD + source.cols - 1];
    row.up.bases = bases;
}

/// The crossings of pairs of one column each.
#[inline(always)]
fn emit_pairs<P: PlaceAt>(
    pairs: &[u32],
    edge: u32,
    (above, over): (&Row, P),
    (row, here): (&Row, P),
    bases: &mut [u32],
    band: &mut Band,
) {
    let mut at = band.count;
    for &j in pairs {
        let (a, b) = (sample(above, &over, j as usize, 0), sample(row, &here, j as usize, 0));
        bases[PAD + j as usize] = cross(band, &mut at, edge.wrapping_add(j), a, b);
    }
    band.add(at);
}

/// The crossings of the pairs of row `i` with their left neighbours.
#[inline(always)]
pub(super) fn emit_left(
    source: &Source<'_>,
    i: usize,
    row: &mut Row,
    band: &mut Band,
    list: &mut Vec<u32>,
) {
    let mut bases = std::mem::take(&mut row.left.bases);
    let pairs = columns(row.left.crossed.iter().copied(), list);
    let edge = edge_code(i, Kind::Left, 0, source.cols);
    let first = band.count;
    let mut at = first;
    // The pair across the seam, whose first sample is in the last column.
    let (seam, others) = pairs.split_at(usize::from(pairs.first() == Some(&0)));
    let places = source.places(i, row);
    if !seam.is_empty() {
        let last = source.cols - 1;
        let (a, b) = (sample(row, &places, last, 0), sample(row, &places, 0, 0));
        bases[PAD] = cross(band, &mut at, edge, a, b);
    }
    match places {
        Places::Tables(places) => {
            emit_beside(others, edge, row, places, (&mut at, &mut bases), band)
        }
        places => emit_beside(others, edge, row, places, (&mut at, &mut bases), band),
    }
    row.left.bases = bases;
    band.last_row = first..at;
    band.add(at);
}

/// The crossings of pairs of two columns each.
#[inline(always)]
fn emit_beside<P: PlaceAt>(
    pairs: &[u32],
    edge: u32,
    row: &Row,
    places: P,
    (at, bases): (&mut usize, &mut [u32]),
    band: &mut Band,
) {
    for &j in pairs {
        let (a, b) = (sample(row, &places, j as usize, 1), sample(row, &places, j as usize, 0));
        bases[PAD + j as usize] = cross(band, at, edge.wrapping_add(j), a, b);
    }
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

/// The sample a number of columns before column `j`.
#[inline(always)]
pub(super) fn sample<P: PlaceAt>(row: &Row, places: &P, j: usize, before: usize) -> Sample {
    let at = PAD + j - before;
    let (levels, ceilings) = (row.levels.as_slice(), row.ceilings.as_slice());
    Sample { level: levels[at], ceiling: ceilings[at], place: places.at(j - before) }
}

/// Emits the crossings of one pair; returns its number at level 0.
///
/// `t = (level_a − k) / (level_a − level_b)`: the linear subpixel solution (3.6, errata).
#[inline(always)]
pub(super) fn cross(band: &mut Band, at: &mut usize, edge: u32, a: Sample, b: Sample) -> u32 {
    let (low, high) = (a.ceiling.min(b.ceiling), a.ceiling.max(b.ceiling));
    let first = *at;
    let end = first + high.abs_diff(low) as usize;
    if !band.reach(end + AT_ONCE) {
        return 0;
    }
    *at = end;
    let per_level = 1.0 / (a.level - b.level);
    let [dx, dy] = [b.place[0] - a.place[0], b.place[1] - a.place[1]];
    let mut level = low;
    let mut next = first;
    while let (Some(vertices), Some(levels)) =
        (band.vertices.get_mut(next..next + AT_ONCE), band.levels.get_mut(next..next + AT_ONCE))
    {
        for (k, (vertex, place)) in (level..).zip(vertices.iter_mut().zip(levels)) {
            let t = ((a.level - k as f32) * per_level).min(1.0);
            *vertex = Vertex { edge, t, x: a.place[0] + t * dx, y: a.place[1] + t * dy };
            *place = k;
        }
        level += AT_ONCE as i32;
        next += AT_ONCE;
        if level >= high {
            break;
        }
    }
    (first as u32).wrapping_sub(low as u32)
}
