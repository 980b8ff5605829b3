//! `truth.npz`: the exact surface a simulated scan was cast against.
//!
//! Arrays `vertices` (n × 3, float64, world frame and model unit) and `faces` (m × 3, int64 or
//! int32). Written by this workspace's simulator and by the peer benchmark's generator.

use crate::error::Problem;
use crate::input::read_bytes;
use crate::npy::{self, Npy};
use crate::{Place, ReadError, TriangleMesh, npz};
use std::io::{self, Write};
use std::path::Path;
use transect_geometry::Point3;

/// The name of the truth in the folder of a simulated scan.
pub const TRUTH_FILE: &str = "truth.npz";

/// Reads a mesh from an `.npz` archive.
///
/// # Errors
/// [`ReadError`] if the file is missing, damaged or compressed, an array has another shape or bytes
/// after its last number, or a face names a missing vertex.
pub fn read_truth(path: &Path) -> Result<TriangleMesh, ReadError> {
    let bytes = read_bytes(path)?;
    let vertices = triples(path, &bytes, "vertices", false)?;
    let faces = triples(path, &bytes, "faces", true)?;
    let at = |kind: &str, number| Place::Element { kind: kind.to_owned(), number, line: None };
    let vertices: Vec<_> = vertices.into_iter().map(Point3::from).collect();
    if let Some(bad) = vertices.iter().position(|v| !v.coords.iter().all(|c| c.is_finite())) {
        return Err(ReadError::damaged(path, at("vertex", bad), "not a finite point"));
    }
    // Indices below 2³² are exact in f64.
    let index = |i: f64| (i >= 0.0 && i < vertices.len() as f64).then_some(i as u32);
    let face = |(number, [a, b, c]): (usize, [f64; 3])| match (index(a), index(b), index(c)) {
        (Some(a), Some(b), Some(c)) => Ok([a, b, c]),
        _ => {
            let problem = format!("[{a}, {b}, {c}] names none of the {} vertices", vertices.len());
            Err(ReadError::damaged(path, at("face", number), problem))
        }
    };
    let faces = faces.into_iter().enumerate().map(face).collect::<Result<_, _>>()?;
    Ok(TriangleMesh { vertices, faces })
}

/// The rows of an n × 3 array of the archive.
fn triples(
    path: &Path,
    archive: &[u8],
    array: &str,
    integers: bool,
) -> Result<Vec<[f64; 3]>, ReadError> {
    let parsed = || {
        let member = npz::member(archive, &format!("{array}.npy"))?;
        let parsed = Npy::parse(member.ok_or_else(|| Problem::damaged("not in the archive"))?)?;
        if !matches!(parsed.shape(), [_, 3]) {
            let problem = format!("its shape is {:?}, not n × 3", parsed.shape());
            return Err(Problem::damaged(problem));
        }
        // Scores have no notes, which could tell that they are ignored.
        if parsed.leftovers().is_some() {
            let problem = "bytes follow its last number; save the archive again";
            return Err(Problem::damaged(problem));
        }
        if integers && !parsed.is_integer() {
            let problem = "the array holds floating-point numbers, not integers";
            return Err(Problem::unsupported(problem));
        }
        Ok(parsed.triples().collect())
    };
    parsed().map_err(|p| p.of(&format!("array {array}")).in_file(path))
}

/// Writes a mesh as an `.npz` archive that [`read_truth`] and `numpy.load` read.
///
/// # Errors
/// An error of `out`, or an archive of more than 4 GiB.
pub fn write_truth(mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
    let mut vertices = Vec::new();
    npy::write_header(&mut vertices, "<f8", &[mesh.vertices.len(), 3])?;
    let coordinates = mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]);
    vertices.extend(coordinates.flat_map(f64::to_le_bytes));
    let mut faces = Vec::new();
    npy::write_header(&mut faces, "<i8", &[mesh.faces.len(), 3])?;
    let corners = mesh.faces.iter().flatten().map(|&i| i64::from(i));
    faces.extend(corners.flat_map(i64::to_le_bytes));
    npz::write(out, &[("vertices.npy", vertices), ("faces.npy", faces)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn round_trip(mesh: &TriangleMesh) -> Result<TriangleMesh, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.npz");
        crate::write_file(&path, |out| write_truth(mesh, out)).unwrap();
        read_truth(&path)
    }

    fn tetrahedron() -> TriangleMesh {
        let vertices = [[0.1, 0.0, 5.4e6], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        TriangleMesh {
            vertices: vertices.map(Point3::from).to_vec(),
            faces: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        }
    }

    proptest! {
        #[test]
        fn writing_and_reading_returns_the_mesh(
            points in proptest::collection::vec(prop::array::uniform3(-1e7..1e7), 3..40),
        ) {
            let faces = (0..points.len() as u32 - 2).map(|i| [i, i + 1, i + 2]).collect();
            let vertices = points.into_iter().map(Point3::from).collect();
            let mesh = TriangleMesh { vertices, faces };
            prop_assert_eq!(round_trip(&mesh).unwrap(), mesh);
        }
    }

    #[test]
    fn a_face_without_its_vertex_is_named() {
        let mut mesh = tetrahedron();
        mesh.faces[2] = [0, 3, 4];
        let error = round_trip(&mesh).unwrap_err().to_string();
        assert!(error.ends_with("truth.npz, face 2: [0, 3, 4] names none of the 4 vertices"));
    }

    #[test]
    fn a_missing_array_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.npz");
        crate::write_file(&path, |out| npz::write(out, &[])).unwrap();
        let error = read_truth(&path).unwrap_err().to_string();
        assert!(error.ends_with("truth.npz: array vertices: not in the archive"), "{error}");
    }

    #[test]
    fn bytes_after_an_array_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.npz");
        let mut vertices = Vec::new();
        npy::write_header(&mut vertices, "<f8", &[1, 3]).unwrap();
        vertices.extend([0; 25]);
        let members = [("vertices.npy", vertices)];
        crate::write_file(&path, |out| npz::write(out, &members)).unwrap();
        let error = read_truth(&path).unwrap_err().to_string();
        assert!(error.contains("truth.npz: array vertices: bytes follow its last"), "{error}");
    }

    #[test]
    fn numpy_reads_what_is_written_and_the_other_way_round() {
        let Some(python) = crate::test_data::python_with("numpy") else { return };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.npz");
        crate::write_file(&path, |out| write_truth(&tetrahedron(), out)).unwrap();
        let script = "import sys, numpy as np\n\
            z = np.load(sys.argv[1])\n\
            v, f = z['vertices'], z['faces']\n\
            assert v.shape == (4, 3) and v[0, 2] == 5.4e6 and f.dtype == np.int64\n\
            np.savez(sys.argv[1], vertices=v, faces=f.astype(np.int32))\n\
            np.savez_compressed(sys.argv[2], vertices=v, faces=f)\n";
        let packed = folder.path().join("packed.npz");
        let mut run = std::process::Command::new(&python);
        let run = run.args(["-c", script]).arg(&path).arg(&packed).output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        assert_eq!(read_truth(&path).unwrap(), tetrahedron());
        let error = read_truth(&packed).unwrap_err().to_string();
        let end =
            "vertices.npy is compressed; write it with numpy.savez instead of savez_compressed";
        assert!(error.ends_with(end), "{error}");
    }
}
