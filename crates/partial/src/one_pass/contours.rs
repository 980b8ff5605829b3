//! Linked level lines of a view, for all planes of a family at once.

use super::band::capacity_bytes;
use super::chains::{Line, assemble};
use super::part::Part;
use super::source::Source;
use super::trace::{Border, Piece, stitch};
use super::vertex::{Kind, Vertex, decode};
use crate::{MAX_CROSSINGS, PartialError, SectionAxes};
use rayon::prelude::*;
use transect_device::{Pixel, View};
use transect_geometry::PlaneIndex;
use transect_image::BreakRule;
use transect_image::Instructions;

/// Crossings per band: with 17 bytes for each, a band fits a processor's second cache level.
const BAND_SIZE: usize = 1 << 14;

/// How the work is done; nothing here changes the curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Instructions of the inner loops.
    pub instructions: Instructions,
    /// Parts into which the rows are cut, to be swept in parallel; at least 1.
    pub parts: usize,
    /// Crossings that are linked and followed at a time.
    pub band_size: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self { instructions: Instructions::Best, parts: 1, band_size: BAND_SIZE }
    }
}

/// Memory that is kept from view to view.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    parts: Vec<Part>,
    pieces: Vec<Piece>,
    chains: super::chains::Scratch,
    lines: Vec<Line>,
    vertices: Vec<Vertex>,
}

impl Workspace {
    /// Memory it holds, in bytes: all that was needed beyond the image, with the lines themselves.
    pub fn bytes(&self) -> usize {
        self.parts.iter().map(Part::bytes).sum::<usize>()
            + capacity_bytes(&self.pieces)
            + self.chains.bytes()
            + capacity_bytes(&self.lines)
            + capacity_bytes(&self.vertices)
    }
}

/// The level lines of a view on all planes.
#[derive(Debug, Clone, Copy)]
pub struct Contours<'a> {
    axes: &'a SectionAxes,
    cols: usize,
    lines: &'a [Line],
    vertices: &'a [Vertex],
    jumps: usize,
}

/// One level line: its vertices in order, solid on the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polyline<'a> {
    /// The plane.
    pub plane: PlaneIndex,
    /// Level of the plane, counted from the base of the view's axes.
    pub level: i32,
    /// Whether the last vertex is followed by the first.
    pub closed: bool,
    /// The vertices, at least one; a closed line does not repeat its first.
    pub vertices: &'a [Vertex],
}

impl<'a> Contours<'a> {
    /// All lines, by plane, open ones before closed ones, each by the pair they begin with.
    pub fn polylines(&self) -> impl ExactSizeIterator<Item = Polyline<'a>> + 'a {
        let (axes, vertices) = (self.axes, self.vertices);
        self.lines.iter().map(move |line| Polyline {
            plane: axes.plane(line.level),
            level: line.level,
            closed: line.closed,
            vertices: vertices.get(line.range()).unwrap_or(&[]),
        })
    }

    /// Number of vertices of all lines.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Pairs of valid neighbours that do not belong to one surface.
    pub fn jumps(&self) -> usize {
        self.jumps
    }

    /// Kind and samples of a vertex's pair, in the order in which [`Vertex::t`] counts.
    pub fn pair(&self, vertex: &Vertex) -> (Kind, [Pixel; 2]) {
        let (kind, here) = decode(vertex.edge, self.cols);
        let Pixel { row, col } = here;
        let up = row.saturating_sub(1);
        let before = if col == 0 { self.cols - 1 } else { col - 1 };
        let pair = match kind {
            Kind::Up => [Pixel::new(up, col), here],
            Kind::Left => [Pixel::new(row, before), here],
            Kind::Rising => [Pixel::new(up, col), Pixel::new(row, before)],
            Kind::Falling => [Pixel::new(up, before), here],
        };
        (kind, pair)
    }

    /// The pixel that a vertex's pair is numbered by: the lower right one of its cell.
    pub(super) fn pixel(&self, vertex: &Vertex) -> Pixel {
        decode(vertex.edge, self.cols).1
    }
}

/// The level lines of a view.
///
/// # Errors
/// [`PartialError::TooManyCrossings`] beyond [`MAX_CROSSINGS`] of them.
pub fn contours<'a>(
    view: &View,
    axes: &'a SectionAxes,
    rule: &BreakRule,
    effort: &Effort,
    work: &'a mut Workspace,
) -> Result<Contours<'a>, PartialError> {
    let source = Source::new(view, axes, rule);
    let count = effort.parts.clamp(1, source.rows);
    work.parts.resize_with(count, Part::default);
    let cuts = |k: usize| k * source.rows / count;
    let sweep = |(k, part): (usize, &mut Part)| {
        part.sweep(&source, cuts(k)..cuts(k + 1), effort.instructions, effort.band_size)
    };
    if let [part] = work.parts.as_mut_slice() {
        sweep((0, part))?;
    } else {
        work.parts.par_iter_mut().enumerate().try_for_each(sweep)?;
    }
    let found: usize = work.parts.iter().map(|p| p.used).sum();
    if found > MAX_CROSSINGS {
        return Err(PartialError::TooManyCrossings { interval: axes.interval() });
    }
    join(&mut work.parts, &mut work.pieces);
    assemble(
        &mut work.pieces,
        &work.parts,
        view,
        &mut work.chains,
        &mut work.lines,
        &mut work.vertices,
    );
    Ok(Contours {
        axes,
        cols: source.cols,
        lines: &work.lines,
        vertices: &work.vertices,
        jumps: work.parts.iter().map(|p| p.jumps).sum(),
    })
}

/// Puts the pieces of all parts into one list and joins them at the parts' borders.
fn join(parts: &mut [Part], pieces: &mut Vec<Piece>) {
    pieces.clear();
    if let [part] = parts {
        std::mem::swap(&mut part.pieces, pieces);
        return;
    }
    let mut above = Border::default();
    for (k, part) in parts.iter_mut().enumerate() {
        let offset = pieces.len() as u32;
        pieces.extend(part.pieces.iter().map(|piece| Piece {
            next: if piece.next == super::band::NONE { piece.next } else { piece.next + offset },
            part: k as u32,
            ..*piece
        }));
        part.top.shift(offset);
        part.bottom.shift(offset);
        if k > 0 {
            stitch(pieces, &above, &part.top);
        }
        above.clone_from(&part.bottom);
    }
}
