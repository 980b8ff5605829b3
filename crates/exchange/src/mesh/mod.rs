//! Mesh files: PLY, STL and OBJ.
//!
//! These formats have no length unit. The caller must know the unit of the coordinates.

mod obj;
mod stl;
#[cfg(test)]
mod tests;

use crate::input::read_bytes;
use crate::triangle_mesh::MeshFile;
use crate::{Place, ReadError, ply};
use std::path::Path;

/// Reads a mesh from `.ply`, `.stl` (text or binary) or `.obj`.
///
/// Triangles of an STL file share vertices where their coordinates are equal.
///
/// # Errors
/// [`ReadError`] if the extension is none of these, or the file is truncated or has no faces. Also,
/// with the line or the element, if a vertex is not finite, or a face names a missing vertex.
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

fn element(kind: &str, number: usize, line: Option<usize>) -> Place {
    Place::Element { kind: kind.to_owned(), number, line }
}
