//! STL: triangles without shared vertices, as text or binary.
//!
//! ```text
//! solid NAME                               80 bytes, ignored
//!   facet normal nx ny nz                  u32 number of triangles, little-endian
//!     outer loop                           per triangle:
//!       vertex x y z       (three)           12 × f32: normal, three corners
//!     endloop                                u16, ignored
//!   endfacet
//! endsolid NAME
//! ```
//!
//! Binary files may begin with `solid` too. A file is binary if its length is what its number of
//! triangles requires, or if it does not begin with `solid`, or if its beginning is not text.
//! Normals are ignored: some programs write zeros or NaN, and the order of the corners gives them.
//!
//! Corners of equal coordinates become one vertex, in the order in which they first occur.

use super::element;
use crate::input::without_mark;
use crate::triangle_mesh::{MeshFile, TriangleMesh, note_dropped};
use crate::{Place, ReadError};
use std::collections::HashMap;
use std::path::Path;
use transect_geometry::Point3;

/// Bytes before the number of triangles, and before the triangles.
const TITLE: usize = 80;
const HEADER: usize = TITLE + 4;
/// Bytes of a triangle, and of the normal at its start.
const TRIANGLE: usize = 50;
const NORMAL: usize = 12;
/// Bytes that are examined to decide whether a file is text. Chosen by hand. Doubled, the decision
/// takes twice as long.
const BEGINNING: usize = 1024;

pub(super) fn mesh(path: &Path, bytes: &[u8]) -> Result<MeshFile, ReadError> {
    let mut welder = Welder::default();
    let mut notes = Vec::new();
    if is_binary(bytes) {
        binary(path, bytes, &mut welder, &mut notes)?;
    } else {
        text(path, bytes, &mut welder)?;
    }
    if welder.mesh.faces.is_empty() {
        return Err(ReadError::damaged(path, Place::Whole, "there are no triangles"));
    }
    notes.extend(note_dropped(welder.degenerate, "triangles with two equal corners"));
    Ok(MeshFile { mesh: welder.mesh, notes })
}

fn is_binary(bytes: &[u8]) -> bool {
    let as_announced = announced(bytes).and_then(|n| n.checked_mul(TRIANGLE));
    if as_announced.and_then(|n| n.checked_add(HEADER)) == Some(bytes.len()) {
        return true;
    }
    let beginning = bytes.get(..BEGINNING).unwrap_or(bytes);
    let start = without_mark(beginning).trim_ascii_start();
    let solid = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // Names in any encoding are text; control characters are not.
    let is_text = |b: &u8| *b >= b' ' || b.is_ascii_whitespace();
    !(solid && beginning.iter().all(is_text))
}

fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(TITLE..)?.first_chunk().copied()?;
    usize::try_from(u32::from_le_bytes(count)).ok()
}

fn binary(
    path: &Path,
    bytes: &[u8],
    welder: &mut Welder,
    notes: &mut Vec<String>,
) -> Result<(), ReadError> {
    let damaged = |problem: String| ReadError::damaged(path, Place::Whole, problem);
    let count = announced(bytes);
    let count = count.ok_or_else(|| damaged("truncated inside the header".to_owned()))?;
    let body = bytes.get(HEADER..).unwrap_or_default();
    let (triangles, _) = body.as_chunks::<TRIANGLE>();
    let Some(triangles) = triangles.get(..count) else {
        let found = triangles.len();
        return Err(damaged(format!(
            "truncated: the header announces {count} triangles, {found} follow"
        )));
    };
    for (number, triangle) in triangles.iter().enumerate() {
        let (numbers, _) = triangle.get(NORMAL..).unwrap_or_default().as_chunks::<4>();
        let numbers: Vec<f64> = numbers.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect();
        let (corners, _) = numbers.as_chunks::<3>();
        if let &[a, b, c] = corners {
            let added = welder.add([a, b, c]);
            added.map_err(|e| ReadError::damaged(path, element("triangle", number, None), e))?;
        }
    }
    let left = body.len() - count * TRIANGLE;
    if left > 0 {
        notes.push(format!("{left} bytes after the last triangle ignored"));
    }
    Ok(())
}

fn text(path: &Path, bytes: &[u8], welder: &mut Welder) -> Result<(), ReadError> {
    let text = String::from_utf8_lossy(without_mark(bytes));
    let mut reader = TextReader { welder, facet: None, open: false };
    for (number, line) in text.lines().enumerate() {
        reader.line(line).map_err(|problem| {
            let place = element("triangle", reader.welder.count, Some(number + 1));
            ReadError::damaged(path, place, problem)
        })?;
    }
    if reader.open {
        let problem = "truncated: there is no endsolid".to_owned();
        return Err(ReadError::damaged(path, Place::Line(text.lines().count()), problem));
    }
    Ok(())
}

/// Reads a text file line by line.
struct TextReader<'a> {
    welder: &'a mut Welder,
    /// Corners of the facet that is being read.
    facet: Option<Vec<[f64; 3]>>,
    /// Whether a solid is being read.
    open: bool,
}

impl TextReader<'_> {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        let Some(first) = words.next() else { return Ok(()) };
        match first.to_ascii_lowercase().as_str() {
            "solid" => self.open = true,
            "endsolid" if self.facet.is_none() => self.open = false,
            "facet" if self.facet.is_none() => self.facet = Some(Vec::new()),
            "outer" | "endloop" if self.facet.is_some() => {}
            "vertex" => {
                let facet = self.facet.as_mut().ok_or("a vertex outside a facet")?;
                facet.push(coordinates(words)?);
                if facet.len() > 3 {
                    return Err("a facet of more than three vertices".to_owned());
                }
            }
            "endfacet" => {
                let facet = self.facet.take().ok_or("an endfacet without its facet")?;
                let &[a, b, c] = facet.as_slice() else {
                    return Err(format!("a facet of {} vertices", facet.len()));
                };
                self.welder.add([a, b, c])?;
            }
            _ => {
                let start: String = first.chars().take(20).collect();
                return Err(format!("{start:?} does not belong here"));
            }
        }
        Ok(())
    }
}

fn coordinates<'a>(words: impl Iterator<Item = &'a str>) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = words.map(|w| w.parse().ok()).collect();
    let three: Option<[f64; 3]> = numbers.and_then(|n| n.try_into().ok());
    finite(three.ok_or("a vertex must have three numbers")?)
}

fn finite(corner: [f64; 3]) -> Result<[f64; 3], String> {
    let finite = corner.iter().all(|c| c.is_finite());
    finite.then_some(corner).ok_or_else(|| "a coordinate is not finite".to_owned())
}

/// Joins corners of equal coordinates.
#[derive(Default)]
struct Welder {
    mesh: TriangleMesh,
    known: HashMap<[u64; 3], u32>,
    /// Triangles taken, kept or not.
    count: usize,
    degenerate: usize,
}

impl Welder {
    fn add(&mut self, corners: [[f64; 3]; 3]) -> Result<(), String> {
        let [a, b, c] = corners.map(|corner| self.vertex(finite(corner)?));
        self.count += 1;
        let face = [a?, b?, c?];
        let [a, b, c] = face;
        if a == b || b == c || c == a {
            self.degenerate += 1;
        } else {
            self.mesh.faces.push(face);
        }
        Ok(())
    }

    fn vertex(&mut self, corner: [f64; 3]) -> Result<u32, String> {
        // Adding 0 turns -0 into 0, which is the same coordinate.
        let key = corner.map(|c| (c + 0.0).to_bits());
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let new = u32::try_from(self.mesh.vertices.len());
        let new = new.map_err(|_| "more vertices than can be numbered".to_owned())?;
        self.known.insert(key, new);
        self.mesh.vertices.push(Point3::from(corner));
        Ok(new)
    }
}
