//! Reading a store from lines of JSON; see `lines` for the form.

use super::copy;
use super::error::{StoreError, StoreProblem};
use super::lines::{
    CopyLine, CurveText, EndLine, FORMAT, FusedLine, LINES_VERSION, Line, OLDEST_LINES,
    PartialLine, StoreLine,
};
use super::medium::Medium;
use super::tables::{FUSED, PARTIALS, VIEWS, encode_curves, encode_fused};
use super::view::{StoreHeader, StoredView, ViewDescription};
use super::view_id::ViewId;
use super::{Store, build};
use crate::codec::values::hash_piece;
use crate::codec::{HASH_OF_NOTHING, fnv1a_from};
use redb::WriteTransaction;
use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;
use transect_geometry::{Curve, PlaneIndex};

impl Store {
    /// Creates a store from the lines of an export, in a file that must not exist yet.
    ///
    /// The fused curves are taken as they are;
    /// [`Snapshot::stale_planes`](super::Snapshot::stale_planes) compares them with the result of
    /// fusing again.
    ///
    /// # Errors
    /// [`StoreProblem::Import`] with the wrong line; no file remains.
    pub fn import(path: impl AsRef<Path>, lines: impl BufRead) -> Result<Self, StoreError> {
        let path = path.as_ref();
        build(path, |file| Self::import_in(path, file, lines)).map_err(|problem| problem.at(path))
    }

    pub(crate) fn import_in(
        path: &Path,
        medium: impl Medium,
        lines: impl BufRead,
    ) -> Result<Self, StoreProblem> {
        let mut lines = Lines { input: lines, number: 0, hash: HASH_OF_NOTHING, text: Vec::new() };
        let header = read_header(&mut lines)?;
        let store = Self::create_in(path, medium, &header)?;
        let transaction = store.write()?;
        read_contents(&mut lines, &transaction)?;
        transaction.commit()?;
        Ok(store)
    }
}

/// The lines of an export, one in memory at a time.
struct Lines<R> {
    input: R,
    /// Number of the line read last, from 1.
    number: usize,
    /// Hash of all lines before that one.
    hash: u64,
    text: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    fn next(&mut self) -> Result<Line, StoreProblem> {
        self.hash = fnv1a_from(self.hash, &self.text);
        self.text.clear();
        self.number += 1;
        let size = self.input.read_until(b'\n', &mut self.text);
        if size.map_err(|e| self.problem(e))? == 0 {
            return Err(self.problem("the end is missing"));
        }
        self.drop_what_editors_add();
        // The text is one line, which has a number of its own.
        let in_line = |e: serde_json::Error| e.to_string().replace(" at line 1 ", " at ");
        serde_json::from_slice(&self.text).map_err(|e| self.problem(in_line(e)))
    }

    /// Some editors put a byte order mark before the first line, and a carriage return after each.
    fn drop_what_editors_add(&mut self) {
        if self.number == 1 && self.text.starts_with("\u{feff}".as_bytes()) {
            self.text.drain(.."\u{feff}".len());
        }
        if self.text.ends_with(b"\r\n") {
            self.text.truncate(self.text.len() - 2);
            self.text.push(b'\n');
        }
    }

    fn problem(&self, problem: impl std::fmt::Display) -> StoreProblem {
        StoreProblem::Import { line: self.number, problem: problem.to_string() }
    }
}

fn read_header(lines: &mut Lines<impl BufRead>) -> Result<StoreHeader, StoreProblem> {
    let line = match lines.next()? {
        Line::Store(line) if line.format == FORMAT => line,
        _ => return Err(lines.problem("an export begins with a line of its store")),
    };
    let StoreLine { version, .. } = line;
    if !(OLDEST_LINES..=LINES_VERSION).contains(&version) {
        let problem = format!(
            "the export has version {version}; this program reads versions {OLDEST_LINES} to \
             {LINES_VERSION}. Export the store again with a program that writes one of them"
        );
        return Err(lines.problem(problem));
    }
    Ok(line.into())
}

/// The contents that were read so far.
#[derive(Default)]
struct Contents {
    /// Number of the line being read, from 1.
    line: usize,
    views: BTreeMap<ViewId, StoredView>,
    planes: u64,
    last_plane: Option<i64>,
    open: Option<OpenPlane>,
}

/// The plane whose partial curves are being read.
struct OpenPlane {
    plane: i64,
    /// The view whose curves came last.
    last: ViewId,
    /// Hash of the curves so far.
    hash: u64,
}

fn read_contents(
    lines: &mut Lines<impl BufRead>,
    transaction: &WriteTransaction,
) -> Result<(), StoreProblem> {
    let mut contents = Contents::default();
    loop {
        let line = lines.next()?;
        contents.line = lines.number;
        match line {
            Line::Store(_) => return contents.refuse("a second store"),
            Line::View(entry) => contents.add_view(entry)?,
            Line::Copy(line) => contents.add_copy(&line, transaction)?,
            Line::Partial(line) => contents.add_partial(line, transaction)?,
            Line::Fused(line) => contents.add_fused(line, transaction)?,
            Line::End(line) => break contents.check_end(&line, lines.hash)?,
        }
    }
    let at_end = lines.input.fill_buf().map(<[u8]>::is_empty);
    if !at_end.map_err(|e| lines.problem(e))? {
        return contents.refuse("there is more behind the end");
    }
    let mut table = transaction.open_table(VIEWS)?;
    for (id, view) in contents.views {
        table.insert(id.0.as_str(), view.encode()?.as_slice())?;
    }
    Ok(())
}

impl Contents {
    fn refuse<T>(&self, problem: impl std::fmt::Display) -> Result<T, StoreProblem> {
        Err(StoreProblem::Import { line: self.line, problem: problem.to_string() })
    }

    fn add_view(&mut self, entry: ViewDescription) -> Result<(), StoreProblem> {
        if self.open.is_some() || self.last_plane.is_some() {
            return self.refuse("views come before planes");
        }
        if self.views.last_key_value().is_some_and(|(last, _)| *last >= entry.id) {
            return self.refuse("views come in order of their ids");
        }
        entry.check().or_else(|error| self.refuse(error))?;
        self.views.insert(entry.id.clone(), StoredView::new(entry));
        Ok(())
    }

    fn add_copy(
        &self,
        line: &CopyLine,
        transaction: &WriteTransaction,
    ) -> Result<(), StoreProblem> {
        let last = self.views.last_key_value().filter(|(id, _)| **id == line.view);
        let Some((_, view)) = last.filter(|_| self.open.is_none() && self.last_plane.is_none())
        else {
            return self.refuse("the copy of a view comes after the view");
        };
        let Some(copy) = line.copy() else {
            return self.refuse("the bytes of a copy are pairs of hexadecimal digits");
        };
        copy::put(transaction, &view.entry, &copy)
    }

    fn add_partial(
        &mut self,
        line: PartialLine,
        transaction: &WriteTransaction,
    ) -> Result<(), StoreProblem> {
        let PartialLine { plane, view: id, curves } = line;
        let hash = match &self.open {
            Some(open) if open.plane != plane => {
                let open = open.plane;
                return self.refuse(format_args!("plane {open} has no line of its fused curves"));
            }
            Some(open) if open.last >= id => {
                return self.refuse("views come in order of their ids");
            }
            Some(open) => open.hash,
            None if self.last_plane.is_some_and(|last| last >= plane) => {
                return self.refuse("planes come in order of station");
            }
            None => HASH_OF_NOTHING,
        };
        let curves = self.curves_of(curves)?;
        if curves.is_empty() {
            return self.refuse("a view without curves on a plane has no line there");
        }
        let value = encode_curves(&curves)?;
        let Some(view) = self.views.get_mut(&id) else {
            return self.refuse(format_args!("there is no view {id}"));
        };
        transaction.open_table(PARTIALS)?.insert((plane, id.0.as_str()), value.as_slice())?;
        view.count(PlaneIndex(plane), &curves);
        let hash = hash_piece(hash_piece(hash, id.0.as_bytes()), &value);
        self.open = Some(OpenPlane { plane, last: id, hash });
        Ok(())
    }

    fn add_fused(
        &mut self,
        line: FusedLine,
        transaction: &WriteTransaction,
    ) -> Result<(), StoreProblem> {
        let hash = match self.open.take() {
            Some(open) if open.plane == line.plane => open.hash,
            _ => {
                return self.refuse(format_args!("plane {} has no lines of its views", line.plane));
            }
        };
        let value = encode_fused(hash, &self.curves_of(line.curves)?)?;
        transaction.open_table(FUSED)?.insert(line.plane, value.as_slice())?;
        self.last_plane = Some(line.plane);
        self.planes += 1;
        Ok(())
    }

    fn check_end(&self, end: &EndLine, hash: u64) -> Result<(), StoreProblem> {
        if self.open.is_some() {
            return self.refuse("the last plane has no line of its fused curves");
        }
        if (end.views, end.planes) != (self.views.len() as u64, self.planes) {
            return self.refuse("lines are missing: the counts do not match");
        }
        if end.hash != format!("{hash:016x}") {
            return self.refuse("the lines do not match their hash");
        }
        Ok(())
    }

    fn curves_of(&self, texts: Vec<CurveText>) -> Result<Vec<Curve>, StoreProblem> {
        let curve = |(number, text): (usize, CurveText)| {
            text.curve().or_else(|error| self.refuse(format_args!("curve {number}: {error}")))
        };
        texts.into_iter().enumerate().map(curve).collect()
    }
}
