//! Triangle meshes as plain data, and the check that a mesh bounds a solid.

use transect_geometry::{Isometry3, Point3};

/// Largest coordinate, size or distance of a scene, in its length unit. Chosen by hand: UTM
/// coordinates in micrometres (5.4e12) fit, and no product of a few lengths overflows. Doubled,
/// nothing changes.
pub const LARGEST: f64 = 1e13;

/// A triangle mesh.
///
/// Winding: seen from outside the solid, a face's vertices run counter-clockwise. Coordinates are
/// in the model's length unit. The type guarantees nothing; [`Mesh::check_closed`] checks whether
/// the mesh bounds a solid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Positions.
    pub vertices: Vec<Point3>,
    /// Triangles as indices into `vertices`.
    pub faces: Vec<[u32; 3]>,
}

/// Why triangles make no mesh, or a mesh bounds no solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is no face at all.
    #[error("the mesh has no faces")]
    Empty,
    /// A coordinate is no number, or beyond [`LARGEST`].
    #[error("vertex {vertex} has a coordinate that is not finite, or beyond {LARGEST:e}")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index}, but there are {vertices} vertices")]
    BadIndex {
        /// Index of the face.
        face: usize,
        /// The vertex it names.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A face names one vertex twice.
    #[error("face {face} uses vertex {index} twice")]
    Degenerate {
        /// Index of the face.
        face: usize,
        /// The vertex it repeats.
        index: u32,
    },
    /// An edge has a face on one side only.
    #[error("edge {from}-{to} of face {face} has no face on its other side")]
    OpenEdge {
        /// First vertex, in the face's winding.
        from: u32,
        /// Second vertex.
        to: u32,
        /// The face that has it.
        face: usize,
    },
    /// Two faces run along an edge in the same direction.
    #[error(
        "faces {face} and {other} both run along edge {from}-{to}: \
         more than two faces meet there, or their windings disagree"
    )]
    EdgeUsedTwice {
        /// First vertex, in the faces' winding.
        from: u32,
        /// Second vertex.
        to: u32,
        /// One of the faces.
        face: usize,
        /// The other face.
        other: usize,
    },
    /// The winding makes normals point into the solid.
    #[error("the faces wind inwards: the mesh encloses the volume {volume}")]
    InsideOut {
        /// The enclosed volume, which is not positive.
        volume: f64,
    },
    /// The planes lie so densely that their sections would not fit into memory.
    #[error("the mesh would cross {planes} section planes; at most {most} are accepted")]
    TooManyPlanes {
        /// Number of planes it crosses.
        planes: f64,
        /// Largest accepted number.
        most: usize,
    },
}

impl Mesh {
    /// Whether coordinates are finite and every face names three vertices that exist.
    ///
    /// # Errors
    /// [`MeshError`] naming the first vertex or face that is wrong.
    pub fn check(&self) -> Result<(), MeshError> {
        // Comparisons with NaN are false.
        let usable = |p: &Point3| p.coords.iter().all(|c| c.abs() <= LARGEST);
        if let Some(vertex) = self.vertices.iter().position(|p| !usable(p)) {
            return Err(MeshError::NotFinite { vertex });
        }
        let vertices = self.vertices.len();
        for (face, corners) in self.faces.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices) {
                return Err(MeshError::BadIndex { face, index, vertices });
            }
        }
        Ok(())
    }

    /// Whether the mesh is the closed, outward-wound surface of a solid: every edge belongs to
    /// exactly two faces that run along it in opposite directions.
    ///
    /// Self-intersections are not detected.
    ///
    /// # Errors
    /// [`MeshError`] naming the first vertex, face or edge that is wrong.
    pub fn check_closed(&self) -> Result<(), MeshError> {
        self.check()?;
        if self.faces.is_empty() {
            return Err(MeshError::Empty);
        }
        for (face, &[a, b, c]) in self.faces.iter().enumerate() {
            let repeated = [(a, b), (c, a), (b, c)].into_iter().find(|(p, q)| p == q);
            if let Some((index, _)) = repeated {
                return Err(MeshError::Degenerate { face, index });
            }
        }
        self.check_edges()?;
        let volume = self.signed_volume();
        if volume > 0.0 { Ok(()) } else { Err(MeshError::InsideOut { volume }) }
    }

    fn check_edges(&self) -> Result<(), MeshError> {
        let numbered = self.faces.iter().enumerate();
        let mut edges: Vec<_> = numbered
            .flat_map(|(face, &[a, b, c])| [(a, b, face), (b, c, face), (c, a, face)])
            .collect();
        edges.sort_unstable();
        for pair in edges.windows(2) {
            if let [(from, to, face), (f, t, other)] = *pair
                && (from, to) == (f, t)
            {
                return Err(MeshError::EdgeUsedTwice { from, to, face, other });
            }
        }
        let has = |from, to| edges.binary_search_by_key(&(from, to), |e| (e.0, e.1)).is_ok();
        match edges.iter().find(|&&(from, to, _)| !has(to, from)) {
            Some(&(from, to, face)) => Err(MeshError::OpenEdge { from, to, face }),
            None => Ok(()),
        }
    }

    /// Volume enclosed by a closed mesh, negative if it is wound inwards.
    ///
    /// Faces that name missing vertices are ignored.
    ///
    /// # Units
    /// The cube of the model's length unit.
    pub fn signed_volume(&self) -> f64 {
        // From a vertex of the mesh, so that world-sized coordinates keep their precision.
        let Some(anchor) = self.vertices.first() else { return 0.0 };
        let sextuple = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|i| self.vertices.get(i as usize).map(|p| p - anchor));
            Some(a?.dot(&b?.cross(&c?)))
        };
        self.faces.iter().filter_map(sextuple).sum::<f64>() / 6.0
    }

    /// Adds another mesh's faces, moved from its frame into this one's.
    pub(crate) fn append(&mut self, other: &Self, target_from_source: &Isometry3) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(other.vertices.iter().map(|p| target_from_source * p));
        self.faces.extend(other.faces.iter().map(|face| face.map(|i| i + base)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let vertices = vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(0.0, 0.0, 1.0),
        ];
        Mesh { vertices, faces: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] }
    }

    #[test]
    fn a_closed_mesh_has_its_volume() {
        let mesh = tetrahedron();
        assert_eq!(mesh.check_closed(), Ok(()));
        assert!((mesh.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn the_first_bad_edge_is_named() {
        let mut open = tetrahedron();
        open.faces.pop();
        let text = open.check_closed().unwrap_err().to_string();
        assert_eq!(text, "edge 0-2 of face 0 has no face on its other side");

        let mut turned = tetrahedron();
        turned.faces[3] = [0, 2, 3];
        let error = turned.check_closed().unwrap_err();
        assert!(matches!(error, MeshError::EdgeUsedTwice { from: 0, to: 2, .. }), "{error}");
    }

    #[test]
    fn bad_parts_and_inside_out_meshes_are_refused() {
        let mut mesh = tetrahedron();
        mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
        assert!(
            matches!(mesh.check_closed(), Err(MeshError::InsideOut { volume }) if volume < 0.0)
        );
        mesh.faces[2] = [1, 1, 3];
        assert_eq!(mesh.check_closed(), Err(MeshError::Degenerate { face: 2, index: 1 }));
        mesh.faces[1] = [0, 1, 9];
        assert_eq!(mesh.check(), Err(MeshError::BadIndex { face: 1, index: 9, vertices: 4 }));
        mesh.vertices[2].y = f64::NAN;
        assert_eq!(mesh.check(), Err(MeshError::NotFinite { vertex: 2 }));
        assert_eq!(Mesh::default().check_closed(), Err(MeshError::Empty));
    }
}
