//! Triangle meshes, as plain data, and the files they are read from: PLY, STL, OBJ.
//!
//! None of these formats has a length unit: coordinates are in whatever unit the caller knows.

mod obj;
mod stl;
#[cfg(test)]
mod tests;

use crate::error::read_bytes;
use crate::{Place, ReadError, ply};
use std::path::Path;
use transect_geometry::Point3;

/// A triangle mesh: corners counter-clockwise seen from outside, when it has an outside.
///
/// Unit and frame: the file's. Guaranteed for every mesh this crate reads: finite vertices, face
/// indices inside `vertices`. Not checked: closedness, orientation, unused or repeated vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions.
    pub vertices: Vec<Point3>,
    /// Three indices into `vertices` per triangle.
    pub faces: Vec<[u32; 3]>,
}

/// A mesh from a file, and what the reader passed over.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// Vertices and triangles; polygons are split into fans around their first corner.
    pub mesh: TriangleMesh,
    /// What the reader passed over or found odd.
    pub notes: Vec<String>,
}

/// Reads a mesh from `.ply`, `.stl` (text or binary) or `.obj`.
///
/// Triangles of an STL file share vertices where their coordinates are equal.
///
/// # Errors
/// [`ReadError`] if the extension is none of these, the file is truncated or has no faces, a vertex
/// is not finite, or a face names a vertex that is not there; with the line or the element.
pub fn read_mesh(path: &Path) -> Result<MeshFile, ReadError> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let read = match extension.as_deref() {
        Some("ply") => ply::mesh,
        Some("stl") => stl::mesh,
        Some("obj") => obj::mesh,
        _ => {
            let problem = "meshes are read from .ply, .stl and .obj";
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
    };
    read(path, &read_bytes(path)?)
}

/// The triangles of a polygon, around its first corner; none for fewer than three corners.
pub(crate) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let split = corners.split_first();
    split.into_iter().flat_map(|(&first, rest)| {
        rest.iter().zip(rest.iter().skip(1)).map(move |(&b, &c)| [first, b, c])
    })
}

/// A note about faces that are none.
pub(crate) fn note_dropped(count: usize, what: &str) -> Option<String> {
    (count > 0).then(|| format!("{count} {what} dropped"))
}

fn element(kind: &str, number: usize, line: Option<usize>) -> Place {
    Place::Element { kind: kind.to_owned(), number, line }
}
