//! From pieces to whole lines, in their final order and place.

use super::band::{NONE, capacity_bytes};
use super::part::Part;
use super::trace::Piece;
use super::vertex::Vertex;
use rayon::prelude::*;
use std::ops::Range;
use transect_device::{Handedness, View};

/// One line of the result.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub level: i32,
    pub closed: bool,
    start: u32,
    len: u32,
}

impl Line {
    pub fn range(&self) -> Range<usize> {
        self.start as usize..self.start as usize + self.len as usize
    }
}

/// A line as a row of pieces.
#[derive(Debug, Clone, Copy)]
struct Chain {
    level: i32,
    closed: bool,
    first: u32,
    /// Vertices of the first piece that come last: where a closed line begins.
    offset: u32,
    len: u32,
    /// The pair it begins with.
    edge: u32,
}

/// Memory that is kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    chains: Vec<Chain>,
    sorted: Vec<Chain>,
    counts: Vec<u32>,
}

impl Scratch {
    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        capacity_bytes(&self.chains) + capacity_bytes(&self.sorted) + capacity_bytes(&self.counts)
    }
}

/// Makes lines of pieces.
///
/// Pieces are in the order of their parts, bands and heads, and a head's number grows with its
/// pair. So open chains come out in the order of the pairs they begin with, wherever the image was
/// cut. Closed ones are made to begin with their smallest pair, for the same reason.
pub(super) fn assemble(
    pieces: &mut [Piece],
    parts: &[Part],
    view: &View,
    scratch: &mut Scratch,
    lines: &mut Vec<Line>,
    vertices: &mut Vec<Vertex>,
) {
    scratch.chains.clear();
    // At most one chain begins in each.
    scratch.chains.reserve(pieces.iter().filter(|piece| !piece.follows).count());
    for first in 0..pieces.len() {
        if !pieces[first].follows {
            scratch.chains.extend(open_chain(pieces, first));
        }
    }
    let open = scratch.chains.len();
    for first in 0..pieces.len() {
        if !pieces[first].taken {
            scratch.chains.push(closed_chain(pieces, parts, first));
        }
    }
    scratch.chains[open..].sort_unstable_by_key(|c| c.edge);
    sort_by_level(scratch);
    lines.clear();
    let mut start = 0;
    for chain in &scratch.sorted {
        let &Chain { level, closed, len, .. } = chain;
        lines.push(Line { level, closed, start, len });
        start += len;
    }
    let reverse = view.frame().handedness() == Handedness::ColumnsLeft;
    let place = Place { pieces, parts, reverse };
    place.all(&scratch.sorted, start as usize, vertices);
}

/// Walks an open chain from its first piece.
fn open_chain(pieces: &mut [Piece], first: usize) -> Option<Chain> {
    let (level, mut len) = (pieces[first].level, 0);
    let mut at = first as u32;
    while at != NONE {
        let piece = &mut pieces[at as usize];
        piece.taken = true;
        len += piece.len;
        at = piece.next;
    }
    (len > 0).then_some(Chain {
        level,
        closed: false,
        first: first as u32,
        offset: 0,
        len,
        edge: 0,
    })
}

/// Walks a closed chain and finds its smallest pair.
fn closed_chain(pieces: &mut [Piece], parts: &[Part], first: usize) -> Chain {
    let level = pieces[first].level;
    let mut chain =
        Chain { level, closed: true, first: first as u32, offset: 0, len: 0, edge: u32::MAX };
    let mut at = first;
    while !pieces[at].taken {
        let piece = &mut pieces[at];
        piece.taken = true;
        for (offset, vertex) in (0..).zip(vertices_of(piece, parts)) {
            if vertex.edge < chain.edge {
                let (first, level) = (at as u32, piece.level);
                chain = Chain { first, level, offset, edge: vertex.edge, ..chain };
            }
        }
        chain.len += piece.len;
        at = piece.next as usize;
    }
    chain
}

fn vertices_of<'a>(piece: &Piece, parts: &'a [Part]) -> &'a [Vertex] {
    let (start, len) = (piece.start as usize, piece.len as usize);
    let part = parts.get(piece.part as usize).map_or(&[][..], |part| &part.vertices);
    part.get(start..start + len).unwrap_or(&[])
}

/// Sorts by level and keeps the order within a level.
fn sort_by_level(scratch: &mut Scratch) {
    let Scratch { chains, sorted, counts } = scratch;
    sorted.clear();
    let levels = || chains.iter().map(|c| c.level);
    let (Some(low), Some(high)) = (levels().min(), levels().max()) else { return };
    let span = high.abs_diff(low) as usize + 1;
    if span > 8 * chains.len() + 1024 {
        sorted.extend_from_slice(chains);
        sorted.sort_by_key(|c| c.level);
        return;
    }
    counts.clear();
    counts.resize(span + 1, 0);
    for level in levels() {
        counts[level.abs_diff(low) as usize + 1] += 1;
    }
    for k in 1..counts.len() {
        counts[k] += counts[k - 1];
    }
    sorted.resize(chains.len(), chains[0]);
    for chain in chains.iter() {
        let place = &mut counts[chain.level.abs_diff(low) as usize];
        sorted[*place as usize] = *chain;
        *place += 1;
    }
}

/// Copies chains to their places.
#[derive(Clone, Copy)]
struct Place<'a> {
    pieces: &'a [Piece],
    parts: &'a [Part],
    /// Whether lines run against their links: seen from a mirrored grid, high is on the right.
    reverse: bool,
}

/// Vertices that one task places.
const TASK: usize = 1 << 16;

impl Place<'_> {
    fn all(self, chains: &[Chain], total: usize, vertices: &mut Vec<Vertex>) {
        vertices.clear();
        if self.parts.len() < 2 {
            vertices.reserve_exact(total);
            for chain in chains {
                let start = vertices.len();
                self.slices(chain, |part| vertices.extend_from_slice(part));
                if self.reverse {
                    vertices[start..].reverse();
                }
            }
            return;
        }
        vertices.resize(total, Vertex::default());
        let mut tasks: Vec<(&[Chain], &mut [Vertex])> = Vec::new();
        let (mut rest, mut chains) = (vertices.as_mut_slice(), chains);
        while !chains.is_empty() {
            let (mut count, mut len) = (0, 0);
            while count < chains.len() && len < TASK {
                len += chains[count].len as usize;
                count += 1;
            }
            let (some, others) = chains.split_at(count);
            let (places, left) = rest.split_at_mut(len);
            tasks.push((some, places));
            (chains, rest) = (others, left);
        }
        tasks.into_par_iter().for_each(|(chains, places)| self.some(chains, places));
    }

    fn some(self, chains: &[Chain], places: &mut [Vertex]) {
        let mut at = 0;
        for chain in chains {
            let start = at;
            self.slices(chain, |part| {
                places[at..at + part.len()].copy_from_slice(part);
                at += part.len();
            });
            if self.reverse {
                places[start..at].reverse();
            }
        }
    }

    /// The slices that make a chain, in order.
    #[inline(always)]
    fn slices(self, chain: &Chain, mut act: impl FnMut(&[Vertex])) {
        let first = &self.pieces[chain.first as usize];
        let (last, begin) = vertices_of(first, self.parts).split_at(chain.offset as usize);
        act(begin);
        let mut at = first.next;
        while at != NONE && at != chain.first {
            let piece = &self.pieces[at as usize];
            act(vertices_of(piece, self.parts));
            at = piece.next;
        }
        act(last);
    }
}
