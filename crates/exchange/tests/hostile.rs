//! Files from outside may hold anything: every reader answers with a value or an error that names
//! the file, never with a panic or an allocation the file does not justify.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail loudly")]

use proptest::prelude::*;
use std::path::Path;
use transect_exchange::{
    Scan, TriangleMesh, read_contours, read_mesh, read_range_grid, read_truth, write_file,
    write_npy_image, write_truth,
};

const GRID: &str = "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n\
    element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element range_grid 4\nproperty list uchar int vertex_indices\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 1\n1 0 1\n0 1 1\n1 1 1\n1 0\n1 1\n1 2\n1 3\n3 0 1 2\n";

const MANIFEST: &str = r#"{"unit":"m","sigma":0.1,"planes":{"normal":[0,0,1],"offset":0,"interval":1},
    "views":[{"file":"a.npy","sensor":"pinhole","fx":2,"fy":2,"cx":0,"cy":0,"rows":2,"cols":2,
    "pose":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"#;

const CONTOURS: &str = r#"{"unit":"m","planes":[{"index":3,"station":0.2,"origin":[0,0,0.2],
    "normal":[0,0,1],"x_axis":[1,0,0],"polylines":[{"closed":true,
    "points":[[0,0,0.2],[1,0,0.2],[0,1,0.2]],"sigma":[0,0,0],"views":[1,1,1]}]}]}"#;

const CONF: &str = "camera 0 0 0\nbmesh a.ply 0 0 0 0 0 0 1\n";

/// One change to a file: another byte, a cut, or a piece twice.
#[derive(Debug, Clone)]
enum Damage {
    Byte(prop::sample::Index, u8),
    Cut(prop::sample::Index),
    Repeat(prop::sample::Index, prop::sample::Index),
}

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    let one = prop_oneof![
        4 => (any::<prop::sample::Index>(), any::<u8>()).prop_map(|(i, b)| Damage::Byte(i, b)),
        4 => (any::<prop::sample::Index>(), prop::sample::select(b"0123456789-.eE, \n".as_slice()))
            .prop_map(|(i, b)| Damage::Byte(i, b)),
        1 => any::<prop::sample::Index>().prop_map(Damage::Cut),
        1 => (any::<prop::sample::Index>(), any::<prop::sample::Index>())
            .prop_map(|(i, j)| Damage::Repeat(i, j)),
    ];
    prop::collection::vec(one, 1..6)
}

fn damaged(sound: &[u8], damages: &[Damage]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for damage in damages {
        let length = bytes.len().max(1);
        match damage {
            Damage::Byte(at, value) => {
                if let Some(byte) = bytes.get_mut(at.index(length)) {
                    *byte = *value;
                }
            }
            Damage::Cut(at) => bytes.truncate(at.index(length)),
            Damage::Repeat(from, to) => {
                let (from, to) = (from.index(length), to.index(length));
                bytes.extend_from_within(
                    from.min(to).min(bytes.len())..from.max(to).min(bytes.len()),
                );
            }
        }
    }
    bytes
}

fn npy() -> Vec<u8> {
    let mut bytes = Vec::new();
    let size = transect_device::ImageSize { rows: 2, cols: 2 };
    write_npy_image(size, &[1.0, 2.0, 3.0, 4.0], &mut bytes).unwrap();
    bytes
}

fn truth() -> Vec<u8> {
    let mut bytes = Vec::new();
    let corner = |x, y| transect_geometry::Point3::new(x, y, 0.0);
    let vertices = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
    write_truth(&TriangleMesh { vertices, faces: vec![[0, 1, 2]] }, &mut bytes).unwrap();
    bytes
}

/// An error must name the file it is about.
fn names_its_file<T>(result: Result<T, transect_exchange::ReadError>, folder: &Path) {
    if let Err(error) = result {
        let text = error.to_string();
        assert!(text.contains(&folder.display().to_string()), "{text}");
    }
}

fn with_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path, &Path)) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, folder.path());
}

fn open_and_load(folder: &Path) {
    match Scan::open(folder) {
        Ok(scan) => scan.views.iter().for_each(|v| names_its_file(v.load(), folder)),
        Err(error) => names_its_file::<()>(Err(error), folder),
    }
}

proptest! {
    #[test]
    fn damaged_ply_files_are_survived(damages in damages()) {
        with_file("a.ply", &damaged(GRID.as_bytes(), &damages), |path, folder| {
            names_its_file(read_range_grid(path), folder);
            names_its_file(read_mesh(path), folder);
        });
    }

    #[test]
    fn damaged_truth_is_survived(damages in damages()) {
        with_file("truth.npz", &damaged(&truth(), &damages), |path, folder| {
            names_its_file(read_truth(path), folder);
        });
    }

    #[test]
    fn damaged_contours_are_survived(damages in damages()) {
        with_file("c.json", &damaged(CONTOURS.as_bytes(), &damages), |path, folder| {
            names_its_file(read_contours(path), folder);
        });
    }

    #[test]
    fn damaged_configurations_are_survived(damages in damages()) {
        with_file("a.conf", &damaged(CONF.as_bytes(), &damages), |path, folder| {
            names_its_file(Scan::open(path), folder);
        });
    }

    #[test]
    fn damaged_manifests_and_images_are_survived(damages in damages(), image: bool) {
        let (manifest, npy) = (MANIFEST.as_bytes().to_vec(), npy());
        let (manifest, npy) = if image {
            (manifest, damaged(&npy, &damages))
        } else {
            (damaged(&manifest, &damages), npy)
        };
        with_file("scan.json", &manifest, |_, folder| {
            write_file(&folder.join("a.npy"), |out| out.write_all(&npy)).unwrap();
            open_and_load(folder);
        });
    }
}
