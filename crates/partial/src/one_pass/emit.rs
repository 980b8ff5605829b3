//! Emission: every plane between the two samples of a joined pair is a crossing with a vertex.
//!
//! Crossings of one pair have consecutive numbers, so one number per pair stands for all of them.

use super::apart::apart;
use super::band::Band;
use super::rows::{PAD, Row};
use super::source::Source;
use super::vertex::{Kind, Vertex, edge_code};
use fearless_simd::Simd;

/// Vertices that are made together, whether they are all wanted or not. Most pairs have fewer, and
/// a loop that stops after one or two is guessed wrong more often than not.
const AT_ONCE: usize = 2;

/// One sample of a pair.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub level: f32,
    pub ceiling: i32,
}

/// The samples of a row by column. Both slices are of one length, so that the processor tests an
/// index once and not for each of them.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a> {
    levels: &'a [f32],
    ceilings: &'a [i32],
}

impl<'a> Samples<'a> {
    /// The samples of a row, or those one column before.
    #[inline(always)]
    pub fn new(row: &'a Row, before: usize, len: usize) -> Option<Self> {
        let first = PAD - before;
        let levels = row.levels.get(first..first + len)?;
        Some(Self { levels, ceilings: row.ceilings.get(first..first + len)? })
    }

    #[inline(always)]
    pub fn at(&self, col: usize) -> Option<Sample> {
        Some(Sample { level: *self.levels.get(col)?, ceiling: *self.ceilings.get(col)? })
    }
}

/// The sample of a row in column `j`, or some columns before, none or one.
pub(super) fn sample(row: &Row, (j, before): (usize, usize)) -> Option<Sample> {
    let at = PAD - before + j;
    Some(Sample { level: *row.levels.get(at)?, ceiling: *row.ceilings.get(at)? })
}

/// The crossings of row `i`: of the pairs with the row above it, then of those with left
/// neighbours, in the columns of two lists.
#[inline(always)]
pub(super) fn emit_row<S: Simd>(
    simd: S,
    source: &Source<'_>,
    i: usize,
    (above, row): (&Row, &mut Row),
    band: &mut Band,
    pairs: [&[u32]; 2],
) {
    let edges = [Kind::Up, Kind::Left].map(|kind| edge_code(i, kind, 0, source.cols));
    let len = source.padded_cols();
    let mut lists = [std::mem::take(&mut row.up.bases), std::mem::take(&mut row.left.bases)];
    if let [Some(up), Some(left)] = lists.each_mut().map(|bases| bases.get_mut(PAD..PAD + len)) {
        Emission { rows: (above, row), pairs, edges, bases: [up, left], band }.all(simd);
    }
    let [up, left] = &mut lists;
    up[PAD - 1] = up[PAD + source.cols - 1];
    std::mem::swap(&mut row.up.bases, up);
    std::mem::swap(&mut row.left.bases, left);
}

/// The output of a row; of two, the pairs with the row above and with left neighbours.
struct Emission<'a> {
    /// The row above and the row.
    rows: (&'a Row, &'a Row),
    pairs: [&'a [u32]; 2],
    /// The numbers of the pairs of column 0.
    edges: [u32; 2],
    bases: [&'a mut [u32]; 2],
    band: &'a mut Band,
}

impl Emission<'_> {
    #[inline(always)]
    fn all<S: Simd>(self, simd: S) {
        let Self { rows: (above, row), pairs, edges, bases: [up, left], band } = self;
        let len = up.len();
        let b = Samples::new(row, 0, len);
        apart(
            simd,
            #[inline(always)]
            || {
                let a = Samples::new(above, 0, len);
                emit_pairs(pairs[0], edges[0], a.zip(b), up, band);
                let first = band.count;
                let a = Samples::new(row, 1, len);
                emit_pairs(pairs[1], edges[1], a.zip(b), left, band);
                band.last_row = first..band.count;
            },
        );
    }
}

#[inline(always)]
fn emit_pairs(
    pairs: &[u32],
    edge: u32,
    samples: Option<(Samples<'_>, Samples<'_>)>,
    bases: &mut [u32],
    band: &mut Band,
) {
    let Some((a, b)) = samples else { return };
    let mut rest = pairs;
    // Room is made between runs of pairs, so that lists stay in place during one.
    while !rest.is_empty() && band.reach(band.count + AT_ONCE) {
        let done = emit_run(rest, edge, (&a, &b), bases, band);
        rest = rest.get(done..).unwrap_or(&[]);
        if done == 0 {
            let wanted = rest.first().and_then(|j| a.at(*j as usize).zip(b.at(*j as usize)));
            let wanted = wanted.map_or(0, |(a, b)| a.ceiling.abs_diff(b.ceiling) as usize);
            if wanted == 0 || !band.reach(band.count + wanted + AT_ONCE) {
                return;
            }
        }
    }
}

/// The crossings of pairs for which there is room; returns how many pairs these are.
#[inline(always)]
fn emit_run(
    pairs: &[u32],
    edge: u32,
    (a, b): (&Samples<'_>, &Samples<'_>),
    bases: &mut [u32],
    band: &mut Band,
) -> usize {
    let mut at = band.count;
    let room = band.vertices.len();
    let Some(levels) = band.levels.get_mut(..room) else { return 0 };
    let out = &mut Out { vertices: &mut band.vertices, levels };
    let mut done = 0;
    for &j in pairs {
        let column = j as usize;
        // One after the other, since together they would be kept as flags.
        let Some(a) = a.at(column) else { break };
        let Some(b) = b.at(column) else { break };
        let Some(base) = bases.get_mut(column) else { break };
        let Some(number) = cross(out, &mut at, edge.wrapping_add(j), a, b) else { break };
        *base = number;
        done += 1;
    }
    band.count = at;
    done
}

/// Where crossings go; lists of one length.
struct Out<'a> {
    vertices: &'a mut [Vertex],
    levels: &'a mut [i32],
}

/// Emits the crossings of one pair, if there is room; returns its number at level 0.
///
/// `t = (level_a − k) / (level_a − level_b)`: the linear subpixel solution (3.6, errata).
#[inline(always)]
fn cross(out: &mut Out<'_>, at: &mut usize, edge: u32, a: Sample, b: Sample) -> Option<u32> {
    let (low, high) = (a.ceiling.min(b.ceiling), a.ceiling.max(b.ceiling));
    let first = *at;
    let end = first + high.abs_diff(low) as usize;
    if end + AT_ONCE > out.vertices.len() {
        return None;
    }
    *at = end;
    let per_level = 1.0 / (a.level - b.level);
    let mut level = low;
    let mut next = first;
    while let (Some(vertices), Some(levels)) =
        (out.vertices.get_mut(next..next + AT_ONCE), out.levels.get_mut(next..next + AT_ONCE))
    {
        for (k, (vertex, place)) in (level..).zip(vertices.iter_mut().zip(levels)) {
            let t = ((a.level - k as f32) * per_level).min(1.0);
            *vertex = Vertex { edge, t };
            *place = k;
        }
        level += AT_ONCE as i32;
        next += AT_ONCE;
        if level >= high {
            break;
        }
    }
    Some((first as u32).wrapping_sub(low as u32))
}

/// Emits the crossings of a single pair; returns its number at level 0.
pub(super) fn cross_one(band: &mut Band, edge: u32, a: Sample, b: Sample) -> u32 {
    let wanted = a.ceiling.abs_diff(b.ceiling) as usize + AT_ONCE;
    if !band.reach(band.count + wanted) {
        return 0;
    }
    let room = band.vertices.len();
    let Some(levels) = band.levels.get_mut(..room) else { return 0 };
    let out = &mut Out { vertices: &mut band.vertices, levels };
    cross(out, &mut band.count, edge, a, b).unwrap_or_default()
}

/// Numbers the crossings of a row's left pairs without making vertices: the guests of a band.
/// Returns how many there are.
pub(super) fn number_guests(row: &mut Row) -> usize {
    let mut at = 0_u32;
    let Row { left, ceilings, .. } = row;
    for j in crossed(&left.crossed) {
        let (a, b) = (ceilings[j - 1], ceilings[j]);
        left.bases[j] = at.wrapping_sub(a.min(b) as u32);
        at += a.abs_diff(b);
    }
    at as usize
}

/// Whether each crossing of a row's left pairs runs up, in the order of their numbers.
pub(super) fn runs_up(row: &Row, out: &mut Vec<bool>) {
    out.clear();
    for j in crossed(&row.left.crossed) {
        let (a, b) = (row.ceilings[j - 1], row.ceilings[j]);
        out.resize(out.len() + a.abs_diff(b) as usize, a > b);
    }
}

/// The places of a row whose bits are set in a mask.
fn crossed(mask: &[u64]) -> impl Iterator<Item = usize> {
    let bits =
        |word: u64| std::iter::successors(Some(word), |bits| Some(bits & bits.wrapping_sub(1)));
    let columns = move |(k, word): (usize, &u64)| {
        let rest = bits(*word).take_while(|bits| *bits != 0);
        rest.map(move |bits| PAD + 64 * k + bits.trailing_zeros() as usize)
    };
    mask.iter().enumerate().flat_map(columns)
}
