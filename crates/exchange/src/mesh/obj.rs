//! OBJ (Wavefront): the statements `v` and `f`. The others do not concern the shape.
//!
//! ```text
//! v x y z                 further numbers (a weight, a colour) are ignored
//! f 1 2 3 4               corners count from 1, or from the last vertex backwards: -1
//! f 1/5 2//7 3/5/7        texture and normal after a slash are ignored
//! f 1 2 \                 a line that continues
//!   3
//! ```
//!
//! Several objects in one file are read as one mesh. Faces may name vertices that follow.

use super::element;
use crate::error::Problem;
use crate::input::without_mark;
use crate::triangle_mesh::{MeshFile, TriangleMesh, fan, note_dropped};
use crate::{Place, ReadError};
use std::borrow::Cow;
use std::path::Path;
use transect_geometry::Point3;

pub(super) fn mesh(path: &Path, bytes: &[u8]) -> Result<MeshFile, ReadError> {
    let text = String::from_utf8_lossy(without_mark(bytes));
    let mut reader = Reader::default();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let line = joined(line, &mut lines);
        reader.statement(number + 1, &line).map_err(|p| p.in_file(path))?;
    }
    reader.finish(path)
}

/// A line with its continuation lines.
fn joined<'a>(line: &'a str, rest: &mut impl Iterator<Item = (usize, &'a str)>) -> Cow<'a, str> {
    if !line.trim_end().ends_with('\\') {
        return Cow::Borrowed(line);
    }
    let mut whole = String::new();
    let mut part = line;
    while let Some(open) = part.trim_end().strip_suffix('\\') {
        whole.push_str(open);
        whole.push(' ');
        part = rest.next().map_or("", |(_, next)| next);
    }
    whole.push_str(part);
    Cow::Owned(whole)
}

#[derive(Default)]
struct Reader {
    mesh: TriangleMesh,
    /// Faces so far, of any number of corners.
    faces: usize,
    degenerate: usize,
    /// The corner with the largest index.
    largest: Option<Corner>,
}

/// A corner of a face: the vertex it names, the face's number, and its line.
#[derive(Clone, Copy)]
struct Corner {
    vertex: u32,
    face: usize,
    line: usize,
}

impl Reader {
    fn statement(&mut self, line: usize, text: &str) -> Result<(), Problem> {
        let text = text.split('#').next().unwrap_or_default();
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let number = self.mesh.vertices.len();
                let at = || element("vertex", number, Some(line));
                let vertex = vertex(words).map_err(|text| Problem::at(at(), text))?;
                self.mesh.vertices.push(vertex);
            }
            Some("f") => {
                let number = self.faces;
                let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<u32>, _>>();
                let at = || element("face", number, Some(line));
                let corners = corners.map_err(|text| Problem::at(at(), text))?;
                self.face(&corners, line);
            }
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, corners: &[u32], line: usize) {
        if let Some(&largest) = corners.iter().max()
            && self.largest.is_none_or(|corner| corner.vertex < largest)
        {
            self.largest = Some(Corner { vertex: largest, face: self.faces, line });
        }
        self.faces += 1;
        self.degenerate += usize::from(corners.len() < 3);
        self.mesh.faces.extend(fan(corners));
    }

    /// The index from 0 of the vertex that a corner such as `3/5/7` or `-1` names.
    fn corner(&self, word: &str) -> Result<u32, String> {
        let known = self.mesh.vertices.len();
        let name = word.split('/').next().unwrap_or_default();
        let index = name.parse::<i64>().ok().and_then(|index| match index {
            0 => None,
            1.. => Some(index - 1),
            // Backwards, -1 is the last vertex so far.
            _ => i64::try_from(known).ok()?.checked_add(index),
        });
        let index = index.and_then(|index| u32::try_from(index).ok());
        let start: String = word.chars().take(20).collect();
        index.ok_or_else(|| format!("{start:?} names no vertex; there are {known} so far"))
    }

    fn finish(self, path: &Path) -> Result<MeshFile, ReadError> {
        let known = self.mesh.vertices.len();
        let missing = self.largest.filter(|corner| corner.vertex as usize >= known);
        if let Some(Corner { vertex, face, line }) = missing {
            let index = u64::from(vertex) + 1;
            let problem = format!("vertex {index} does not exist; there are {known}");
            return Err(ReadError::damaged(path, element("face", face, Some(line)), problem));
        }
        if self.mesh.faces.is_empty() {
            return Err(ReadError::damaged(path, Place::Whole, "there are no faces"));
        }
        let dropped = note_dropped(self.degenerate, "faces with fewer than 3 corners");
        Ok(MeshFile { mesh: self.mesh, notes: dropped.into_iter().collect() })
    }
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<Point3, String> {
    let mut coordinates = [0.0_f64; 3];
    for coordinate in &mut coordinates {
        let word = words.next().ok_or("a vertex must have three numbers")?;
        let start = || word.chars().take(20).collect::<String>();
        *coordinate = word.parse().map_err(|_| format!("{:?} is not a number", start()))?;
        if !coordinate.is_finite() {
            return Err("a coordinate is not finite".to_owned());
        }
    }
    Ok(Point3::from(coordinates))
}
