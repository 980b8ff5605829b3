//! Paths that are no regular files, and files with byte order marks.

use std::path::Path;
use transect_exchange::{
    Scan, read_calibration, read_guide, read_mesh, read_range_grid, read_text, read_truth,
};
use transect_geometry::{GuideKind, LengthUnit};

/// What every reader says about a file of one name.
fn errors(folder: &Path, name: &str) -> Vec<String> {
    let path = |extension: &str| folder.join(format!("{name}.{extension}"));
    let text = |error: transect_exchange::ReadError| {
        let source = std::error::Error::source(&error).map(ToString::to_string);
        format!("{error}: {}", source.unwrap_or_default())
    };
    [
        Scan::open(&path("conf")).map(drop),
        Scan::open(&path("json")).map(drop),
        read_mesh(&path("ply")).map(drop),
        read_mesh(&path("stl")).map(drop),
        read_mesh(&path("obj")).map(drop),
        read_range_grid(&path("ply")).map(drop),
        read_guide(&path("csv"), GuideKind::Spline, LengthUnit::Metre).map(drop),
        read_calibration(&path("csv")).map(drop),
        read_truth(&path("npz")).map(drop),
        read_text(&path("txt")).map(drop),
    ]
    .into_iter()
    .map(|read| text(read.unwrap_err()))
    .collect()
}

const EXTENSIONS: [&str; 8] = ["conf", "json", "ply", "stl", "obj", "csv", "npz", "txt"];

/// Without the check, the pipe would block for ever and the device fill the memory.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_before_they_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    for extension in EXTENSIONS {
        let pipe = folder.path().join(format!("pipe.{extension}"));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let device = folder.path().join(format!("zero.{extension}"));
        std::os::unix::fs::symlink("/dev/zero", device).unwrap();
    }
    for name in ["pipe", "zero"] {
        for error in errors(folder.path(), name) {
            assert!(error.contains(": a pipe, socket or device, where a regular file"), "{error}");
        }
    }
}

#[test]
fn folders_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("a.ply")).unwrap();
    let error = read_mesh(&folder.path().join("a.ply")).unwrap_err();
    let cause = std::error::Error::source(&error).unwrap().to_string();
    assert!(cause.starts_with("a folder, where a regular file was expected"), "{cause}");
}

#[test]
fn byte_order_marks_are_skipped_in_every_text() {
    let folder = tempfile::tempdir().unwrap();
    let with_mark = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
        path
    };
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
               vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, text) in [("a.stl", stl), ("a.ply", ply), ("a.obj", obj)] {
        let mesh = read_mesh(&with_mark(name, text)).unwrap().mesh;
        assert_eq!((mesh.vertices.len(), mesh.faces.len()), (3, 1), "{name}");
    }
    let guide = with_mark("guide.csv", "0 0 0\n1 0 0\n2 0.1 0\n3 0 0\n");
    let (guide, _) = read_guide(&guide, GuideKind::Spline, LengthUnit::Metre).unwrap();
    assert_eq!(guide.points().len(), 4, "the first point is no header");
    let table = "sweep,theta,p,u,v\n0,0,1,2,3\n1,0,4,5,6\n";
    assert!(read_calibration(&with_mark("table.csv", table)).is_ok());
}
