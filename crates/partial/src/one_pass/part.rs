//! A part of the image, swept from top to bottom by one thread.
//!
//! The part is cut into bands by their number of crossings, so that a band's links stay in the
//! processor's cache while they are made and followed. Where the cuts are changes nothing in the
//! result: neither between bands nor between parts.

use super::apart::apart;
use super::band::{Band, capacity_bytes};
use super::emit::{emit_row, number_guests, runs_up};
use super::link::{Cells, link_row};
use super::rows::{Row, columns};
use super::source::Source;
use super::trace::{Border, Piece, Pieces, stitch, trace};
use super::vertex::Vertex;
use crate::{MAX_CROSSINGS, PartialError};
use fearless_simd::{Simd, dispatch};
use std::ops::Range;
use transect_image::Instructions;

/// Work space and result of one part.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    rows: [Row; 2],
    band: Band,
    /// Work space for the columns of crossed pairs: upward, left.
    columns: [Vec<u32>; 2],
    cells: Cells,
    /// Vertices of all pieces; the list is longer than what is used of it.
    pub vertices: Vec<Vertex>,
    pub used: usize,
    pub pieces: Vec<Piece>,
    /// The border with the part above; empty in the first part.
    pub top: Border,
    /// The border with the part below.
    pub bottom: Border,
    /// Borders within the part.
    inner: [Border; 2],
    pub jumps: usize,
}

impl Part {
    /// Sweeps some rows of an image.
    pub fn sweep(
        &mut self,
        source: &Source<'_>,
        rows: Range<usize>,
        instructions: Instructions,
        band_size: usize,
    ) -> Result<(), PartialError> {
        // All of it, since emission and linking gain from newer instructions, too.
        dispatch!(instructions.level(), simd => self.sweep_with(simd, source, rows, band_size))
    }

    #[inline(always)]
    fn sweep_with<S: Simd>(
        &mut self,
        simd: S,
        source: &Source<'_>,
        rows: Range<usize>,
        band_size: usize,
    ) -> Result<(), PartialError> {
        self.used = 0;
        self.pieces.clear();
        self.jumps = 0;
        let [mut above, mut row] = std::mem::take(&mut self.rows);
        above.fit(source.cols);
        row.fit(source.cols);
        self.begin(simd, source, &rows, &mut above, &row);
        let mut found = Ok(());
        let mut first_band = true;
        for i in rows.clone() {
            found = self.sweep_row(simd, source, i, (&mut above, &mut row));
            if found.is_err() {
                break;
            }
            let enough = self.band.count > band_size + self.band.guests;
            if enough || i + 1 == rows.end {
                let share = (i + 1 - rows.start) as f64 / rows.len() as f64;
                self.finish_band(simd, &mut row, first_band, share);
                first_band = false;
            }
            std::mem::swap(&mut above, &mut row);
        }
        self.rows = [above, row];
        found
    }

    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        let borders = [&self.top, &self.bottom].into_iter().chain(&self.inner);
        self.rows.iter().map(Row::bytes).sum::<usize>()
            + self.band.bytes()
            + self.cells.bytes()
            + self.columns.iter().map(capacity_bytes).sum::<usize>()
            + capacity_bytes(&self.vertices)
            + capacity_bytes(&self.pieces)
            + borders.map(Border::bytes).sum::<usize>()
    }

    /// Reads the row before the first one, whose left pairs are the guests.
    #[inline(always)]
    fn begin<S: Simd>(
        &mut self,
        simd: S,
        source: &Source<'_>,
        rows: &Range<usize>,
        above: &mut Row,
        none: &Row,
    ) {
        let mut guests = 0;
        if let Some(before) = rows.start.checked_sub(1) {
            above.read(simd, source, before, none);
            guests = number_guests(above);
        }
        self.band.restart(guests, MAX_CROSSINGS);
    }

    #[inline(always)]
    fn sweep_row<S: Simd>(
        &mut self,
        simd: S,
        source: &Source<'_>,
        i: usize,
        (above, row): (&mut Row, &mut Row),
    ) -> Result<(), PartialError> {
        row.read(simd, source, i, above);
        self.jumps += row.jumps;
        let [ups, lefts] = &mut self.columns;
        let ups = columns(&row.up.crossed, ups);
        let lefts = columns(&row.left.crossed, lefts);
        let crossed = ups.len() + lefts.len();
        let above_crossed = crossed > 0 || !self.band.last_row.is_empty();
        self.band.last_row = self.band.count..self.band.count;
        if crossed > 0 {
            emit_row(simd, source, i, (above, row), &mut self.band, [ups, lefts]);
        }
        // Without their crossings, links would lead nowhere.
        if !self.band.full && i > 0 && above_crossed {
            link_row(simd, source, i, (above, row), &mut self.band, &mut self.cells);
        }
        if self.band.full {
            return Err(PartialError::TooManyCrossings { interval: source.axes.interval() });
        }
        Ok(())
    }

    /// Follows the band's links, joins its pieces to those above and makes `row` the guests of the
    /// next band. `share` of the part's rows are done.
    #[inline(always)]
    fn finish_band<S: Simd>(&mut self, simd: S, row: &mut Row, first: bool, share: f64) {
        /// Factor by which later rows may hold more than those before.
        const MARGIN: f64 = 1.1;
        let expected = ((self.used + self.band.count) as f64 * MARGIN / share) as usize;
        let expected = expected.min(MAX_CROSSINGS + self.band.count);
        let [over, under] = &mut self.inner;
        let mut out = Pieces {
            vertices: &mut self.vertices,
            used: &mut self.used,
            expected,
            pieces: &mut self.pieces,
            top: if first { &mut self.top } else { under },
            bottom: &mut self.bottom,
        };
        apart(
            simd,
            #[inline(always)]
            || trace(&mut self.band, &mut out),
        );
        if !first {
            stitch(&mut self.pieces, over, under);
        }
        runs_up(row, &mut self.bottom.runs_up);
        over.clone_from(&self.bottom);
        let guests = number_guests(row);
        self.band.restart(guests, (MAX_CROSSINGS + guests).saturating_sub(self.used));
    }
}
