//! Triangle meshes as plain data, and the steps that the readers of mesh files share.

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

/// A mesh from a file, and the notes of the reader.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MeshFile {
    /// Vertices and triangles; polygons are split into fans around their first corner.
    pub mesh: TriangleMesh,
    /// Content that the reader ignored or repaired.
    pub notes: Vec<String>,
}

/// The triangles of a polygon, around its first corner; none for fewer than three corners.
pub(crate) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let split = corners.split_first();
    split.into_iter().flat_map(|(&first, rest)| {
        rest.iter().zip(rest.iter().skip(1)).map(move |(&b, &c)| [first, b, c])
    })
}

/// A note about faces that were left out.
pub(crate) fn note_dropped(count: usize, what: &str) -> Option<String> {
    (count > 0).then(|| format!("{count} {what} dropped"))
}
