//! One function per reader of files: what fuzzing and the test of mutated files call.
//!
//! A target puts the bytes into a file of a folder, with the sound files that the reader needs
//! beside it, and reads it. It returns the error's text. Files of the corpus whose names begin with
//! `sound` must be read without an error.

use std::error::Error;
use std::fs;
use std::io::BufReader;
use std::path::Path;
use transect_exchange::{
    Scan, read_calibration, read_guide, read_mesh, read_range_grid, read_truth,
};
use transect_geometry::{GuideKind, LengthUnit};
use transect_model::{Model, store::Store};

/// Reads bytes as one kind of file, in an existing folder.
pub type Target = fn(&Path, &[u8]) -> Result<(), String>;

/// Every reader with the name of its folder in the corpus.
pub const TARGETS: [(&str, Target); 30] = [
    ("calibration", |folder, bytes| read(folder, "a.csv", bytes, read_calibration)),
    ("cloud_poses", |folder, bytes| {
        let clouds = folder.join("clouds");
        fs::create_dir_all(&clouds).unwrap();
        write(&clouds, "a.ply", GRID.as_bytes());
        write(&clouds, "b.ply", GRID.as_bytes());
        write(&clouds, "poses.txt", bytes);
        load(&clouds, &clouds)
    }),
    ("conf", |folder, bytes| {
        write(folder, "a.ply", GRID.as_bytes());
        write(folder, "a.conf", bytes);
        load(folder, &folder.join("a.conf"))
    }),
    ("depth_camera", |folder, bytes| sequence(folder, "camera.json", bytes)),
    ("depth_list", |folder, bytes| sequence(folder, "depth.txt", bytes)),
    ("depth_pgm", |folder, bytes| scan(folder, &DEPTH.replace("a.png", "a.pgm"), "a.pgm", bytes)),
    ("depth_png", |folder, bytes| scan(folder, DEPTH, "a.png", bytes)),
    ("depth_tiff", |folder, bytes| scan(folder, &DEPTH.replace("a.png", "a.tif"), "a.tif", bytes)),
    ("e57", |folder, bytes| {
        write(folder, "a.e57", &pages(bytes));
        load(folder, &folder.join("a.e57"))
    }),
    ("guide_csv", |folder, bytes| read(folder, "a.csv", bytes, spline)),
    ("guide_dxf", |folder, bytes| read(folder, "a.dxf", bytes, spline)),
    ("guide_geojson", |folder, bytes| read(folder, "a.geojson", bytes, spline)),
    ("lidar_bin", |folder, bytes| view(folder, "a.bin", bytes)),
    ("lookup_table", |folder, bytes| {
        write(folder, "a.npy", &npy("<f4", "(2, 2)", &SAMPLES));
        scan(folder, TABLE, "a.csv", bytes)
    }),
    ("manifest", |folder, bytes| {
        write(folder, "a.npy", &npy("<f4", "(2, 2)", &SAMPLES));
        write(folder, "stack.npy", &npy("|u1", "(4, 3, 24)", &[90; 288]));
        write(folder, "a.csv", CALIBRATION.as_bytes());
        read(folder, "scan.json", bytes, Scan::open)?;
        load(folder, &folder.join("scan.json"))
    }),
    ("model", |folder, bytes| read(folder, "a.transect", bytes, |path| Model::load(path))),
    ("npy_grid", |folder, bytes| scan(folder, POINTS, "a.npy", bytes)),
    ("npy_image", |folder, bytes| scan(folder, IMAGE, "a.npy", bytes)),
    ("npy_stack", |folder, bytes| scan(folder, STACK, "a.npy", bytes)),
    ("npz", |folder, bytes| read(folder, "a.npz", bytes, read_truth)),
    ("obj", |folder, bytes| read(folder, "a.obj", bytes, read_mesh)),
    ("pcd", |folder, bytes| view(folder, "a.pcd", bytes)),
    ("ply_cloud", |folder, bytes| view(folder, "a.ply", bytes)),
    ("ply_grid", |folder, bytes| read(folder, "a.ply", bytes, read_range_grid)),
    ("ply_mesh", |folder, bytes| read(folder, "a.ply", bytes, read_mesh)),
    ("pose", |folder, bytes| {
        write(folder, "camera-intrinsics.txt", b"2 0 0.5\n0 2 0.5\n0 0 1\n");
        write(folder, "a.depth.png", b"");
        write(folder, "a.pose.txt", bytes);
        Scan::open(folder).map(drop).map_err(|error| text(folder, &error))
    }),
    ("pose_list", |folder, bytes| {
        write(folder, "a.ply", GRID.as_bytes());
        write(folder, "a.conf", b"bmesh a.ply 0 0 0 0 0 0 1\n");
        write(folder, "scan.json", bytes);
        load(folder, &folder.join("scan.json"))
    }),
    ("ptx", |folder, bytes| {
        write(folder, "a.ptx", bytes);
        load(folder, &folder.join("a.ptx"))
    }),
    ("stl", |folder, bytes| read(folder, "a.stl", bytes, read_mesh)),
    ("trajectory", |folder, bytes| sequence(folder, "trajectory.txt", bytes)),
];

/// The reader of a store's exported lines; each case makes a store, so it runs fewer cases.
pub const STORE_LINES: (&str, Target) = ("store_lines", |folder, bytes| {
    let store = folder.join("a.transect");
    let _ = fs::remove_file(&store);
    let imported = Store::import(&store, BufReader::new(bytes));
    imported.map(drop).map_err(|error| text(folder, &error))
});

fn spline(path: &Path) -> Result<transect_geometry::CurvedGuide, transect_exchange::ReadError> {
    read_guide(path, GuideKind::Spline, LengthUnit::Metre).map(|(guide, _)| guide)
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    fs::write(folder.join(name), bytes).unwrap();
}

/// The text of an error and its causes. An error must name the folder's file.
fn text(folder: &Path, error: &dyn Error) -> String {
    let mut text = error.to_string();
    assert!(text.contains(&folder.display().to_string()), "no file is named: {text}");
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}

fn read<T, E: Error>(
    folder: &Path,
    name: &str,
    bytes: &[u8],
    read: impl Fn(&Path) -> Result<T, E>,
) -> Result<(), String> {
    write(folder, name, bytes);
    read(&folder.join(name)).map(drop).map_err(|error| text(folder, &error))
}

/// Loads all views of a manifest, one of whose files holds the bytes.
fn scan(folder: &Path, view: &str, name: &str, bytes: &[u8]) -> Result<(), String> {
    write(folder, name, bytes);
    let pose = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";
    let manifest = format!(r#"{{"unit": "m", "views": [{{ {view}, "pose": {pose} }}]}}"#);
    write(folder, "scan.json", manifest.as_bytes());
    load(folder, &folder.join("scan.json"))
}

/// Opens a sequence of one depth image, one of whose files holds the bytes.
fn sequence(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), String> {
    fs::create_dir_all(folder.join("depth")).unwrap();
    write(folder, "depth/0.png", b"");
    write(folder, "camera.json", b"2 2 0.5 0.5");
    write(folder, "trajectory.txt", b"0 0 0 0 0 0 0 1");
    write(folder, name, bytes);
    Scan::open(folder).map(drop).map_err(|error| text(folder, &error))
}

/// Loads a file that is a scan of its own.
fn view(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), String> {
    write(folder, name, bytes);
    load(folder, &folder.join(name))
}

fn load(folder: &Path, path: &Path) -> Result<(), String> {
    let scan = Scan::open(path).map_err(|error| text(folder, &error))?;
    let mut views = scan.views.iter();
    views.try_for_each(|v| v.load().map(drop).map_err(|error| text(folder, &error)))
}

/// The pages of an E57 file. The corpus holds their content without the checksums, because a reader
/// gets no farther than a wrong checksum.
fn pages(content: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    for page in content.chunks(1020) {
        let start = file.len();
        file.extend_from_slice(page);
        file.resize(start + 1020, 0);
        let checksum = crc32c(&file[start..]);
        file.extend_from_slice(&checksum.to_be_bytes());
    }
    file
}

/// The checksum of Castagnoli, bit by bit.
fn crc32c(bytes: &[u8]) -> u32 {
    let bit = |sum: u32| (sum >> 1) ^ (0x82f6_3b78 * (sum & 1));
    !bytes.iter().fold(!0, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), |sum, _| bit(sum)))
}

/// A `.npy` of version 1.
fn npy(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00".as_slice(), &length, header.as_bytes(), data].concat()
}

/// The numbers 1, 2, 3 and 4 as `f32`.
const SAMPLES: [u8; 16] = [0, 0, 128, 63, 0, 0, 0, 64, 0, 0, 64, 64, 0, 0, 128, 64];

const DEPTH: &str = r#""file": "a.png", "sensor": "pinhole", "scale": 0.001, "fx": 2, "fy": 2,
    "cx": 0.5, "cy": 0.5, "distortion": [-0.1, 0.02, 0.01, 0.01, 0]"#;
const IMAGE: &str = r#""file": "a.npy", "sensor": "spherical", "scale": 0.5, "theta0": 0,
    "dtheta": 0.1, "phi0": 0, "dphi": 0.1"#;
const POINTS: &str = r#""file": "a.npy", "sensor": "grid", "scale": 0.5, "viewpoint": [0, 0, -9]"#;
const STACK: &str = r#""file": "a.npy", "sensor": "light_stripe", "camera_rows": 3,
    "camera_cols": 24, "focal_length": 16, "cell_width": 0.27, "cell_height": 2, "x_center": 12,
    "y_center": 1, "baseline": 300, "fan_angle": 1, "theta0": 1.1, "dtheta": 0.05,
    "stripe": { "width": 4, "height": 100, "median_rows": 3 }"#;
const TABLE: &str = r#""file": "a.npy", "sensor": "lookup_table", "theta0": 0, "dtheta": 0.1,
    "calibration": "a.csv", "median_window": 1, "y0": 0, "dy": 1, "mounting": "xz""#;
const CALIBRATION: &str = "sweep,theta,p,u,v\n0,0,0.5,0,10\n0,0.1,0.5,1,10\n1,0,2.5,0,20\n\
    1,0.1,2.5,2,20\n2,0,4.5,0,30\n2,0.1,4.5,3,30\n";
const GRID: &str = "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n\
    element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 -1\n1 0 -1\n0 1 -1\n1 1 -1\n1 0\n1 1\n1 2\n1 3\n";
