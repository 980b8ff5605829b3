//! Writing a store as lines of JSON; see `lines` for the form.

use super::Store;
use super::error::{StoreError, StoreProblem};
use super::lines::{CopyLine, CurveText, EndLine, FusedLine, Line, PartialLine, StoreLine};
use super::snapshot::Snapshot;
use super::tables::{decode_fused, read_partials, read_views};
use crate::codec::{HASH_OF_NOTHING, fnv1a_from};
use redb::ReadableTable;
use std::io::Write;
use transect_geometry::{Curve, PlaneIndex};

impl Store {
    /// Writes everything in the store as lines of JSON; equal contents give equal bytes.
    ///
    /// # Errors
    /// If the store is damaged, or `out` cannot be written.
    pub fn export(&self, out: impl Write) -> Result<(), StoreError> {
        self.read()?.export(out)
    }
}

impl Snapshot {
    /// Writes everything in the snapshot as lines of JSON, one plane in memory at a time.
    ///
    /// # Errors
    /// If the store is damaged, or `out` cannot be written.
    pub fn export(&self, out: impl Write) -> Result<(), StoreError> {
        self.write_lines(out).map_err(|problem| self.error(problem))
    }

    fn write_lines(&self, out: impl Write) -> Result<(), StoreProblem> {
        self.check_fused()?;
        let mut out = Lines { out, hash: HASH_OF_NOTHING };
        out.write(&Line::Store(StoreLine::from(self.header())))?;
        let views = read_views(&self.views)?;
        let mut end = EndLine { views: views.len() as u64, planes: 0, hash: String::new() };
        for view in views {
            let copy = self.read_copy(&view.entry)?;
            let copy = copy.map(|copy| CopyLine::new(view.entry.id.clone(), &copy));
            out.write(&Line::View(view.entry))?;
            if let Some(copy) = copy {
                out.write(&Line::Copy(copy))?;
            }
        }
        for entry in ReadableTable::iter(&self.fused)? {
            let (plane, value) = entry?;
            let plane = PlaneIndex(plane.value());
            for (view, curves) in read_partials(&self.partials, plane)?.by_view {
                let curves = texts(&curves);
                out.write(&Line::Partial(PartialLine { plane: plane.0, view, curves }))?;
            }
            let (_, curves) = decode_fused(plane, value.value())?;
            out.write(&Line::Fused(FusedLine { plane: plane.0, curves: texts(&curves) }))?;
            end.planes += 1;
        }
        end.hash = format!("{:016x}", out.hash);
        out.write(&Line::End(end))?;
        out.out.flush().map_err(StoreProblem::Export)
    }
}

fn texts(curves: &[Curve]) -> Vec<CurveText> {
    curves.iter().map(CurveText::from).collect()
}

/// The output, with the hash of all lines written so far.
struct Lines<W> {
    out: W,
    hash: u64,
}

impl<W: Write> Lines<W> {
    fn write(&mut self, line: &Line) -> Result<(), StoreProblem> {
        let mut text = serde_json::to_vec(line).map_err(|e| StoreProblem::Export(e.into()))?;
        text.push(b'\n');
        self.hash = fnv1a_from(self.hash, &text);
        self.out.write_all(&text).map_err(StoreProblem::Export)
    }
}
