//! Triangle meshes, for reference surfaces.

use super::{Element, Ply};
use crate::triangle_mesh::{MeshFile, TriangleMesh, fan, note_dropped};
use crate::{Place, ReadError};
use std::path::Path;

/// Reads the elements `vertex` and `face`. Both must be there.
pub(crate) fn mesh(path: &Path, bytes: &[u8]) -> Result<MeshFile, ReadError> {
    let mut ply = Ply::open(path, bytes)?;
    let elements = ply.header.elements.clone();
    let count = |name| elements.iter().find(|e| e.name == name).map(|e| e.count);
    let Some((vertex_count, _)) = count("vertex").zip(count("face")) else {
        let problem = "no mesh: the elements vertex and face are needed";
        return Err(ReadError::damaged(path, Place::Whole, problem));
    };
    let mut mesh = TriangleMesh::default();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => mesh.vertices = ply.points(element)?,
            "face" => mesh.faces = read_faces(&mut ply, element, vertex_count)?,
            _ => ply.skip(element)?,
        }
    }
    ply.note_leftovers();
    if let Some(bad) = mesh.vertices.iter().position(|v| !v.coords.iter().all(|c| c.is_finite())) {
        let at = Place::Element { kind: "vertex".to_owned(), number: bad, line: None };
        return Err(ReadError::damaged(path, at, "a coordinate is not finite"));
    }
    Ok(MeshFile { mesh, notes: ply.header.notes })
}

fn read_faces(
    ply: &mut Ply<'_>,
    element: &Element,
    vertices: usize,
) -> Result<Vec<[u32; 3]>, ReadError> {
    let (mut faces, mut degenerate) = (Vec::new(), 0);
    ply.vertex_lists(element, |indices| {
        let corners = indices.iter().map(|&index| known_vertex(index, vertices));
        let corners: Vec<u32> = corners.collect::<Result<_, _>>()?;
        degenerate += usize::from(corners.len() < 3);
        faces.extend(fan(&corners));
        Ok(())
    })?;
    ply.header.notes.extend(note_dropped(degenerate, "faces with fewer than 3 corners"));
    Ok(faces)
}

fn known_vertex(index: i64, vertices: usize) -> Result<u32, String> {
    let known = u32::try_from(index).ok().filter(|&i| (i as usize) < vertices);
    known.ok_or_else(|| format!("vertex {index} does not exist; there are {vertices}"))
}
