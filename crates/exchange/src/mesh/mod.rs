//! Triangle meshes, as plain data.

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
