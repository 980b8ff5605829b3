//! Whole views: from the files of every sensor to points.

mod entries;
mod light_stripe;
mod lookup_table;
mod pinhole;

use super::*;
use crate::Scan;
use crate::test_data::{scan_folder, with_causes, write_npy};
use transect_device::{ImageSize, Note, Pixel, View};

fn load(folder: &Path) -> Result<(View, Vec<Note>), ReadError> {
    Scan::open(folder)?.views[0].load()
}

fn error(folder: &Path) -> String {
    with_causes(&load(folder).unwrap_err())
}

fn replace(folder: &Path, from: &str, to: &str) {
    let path = folder.join("scan.json");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(path, text.replace(from, to)).unwrap();
}

/// What a scan with one thing changed in its manifest says.
fn error_with(keys: &str, from: &str, to: &str, files: impl Fn(&Path)) -> String {
    let folder = scan_folder(&[keys]);
    replace(folder.path(), from, to);
    files(folder.path());
    error(folder.path())
}

#[test]
fn angles_are_radians() {
    let folder = scan_folder(&[
        r#""file": "r.npy", "sensor": "spherical", "theta0": 0, "dtheta": 1.5707963267948966,
        "phi0": 0, "dphi": 0.1"#,
    ]);
    write_npy(&folder.path().join("r.npy"), &[2, 2], &[3.0; 4]);
    let (view, _) = load(folder.path()).unwrap();
    let point = view.point_in_sensor(Pixel::new(0, 1)).unwrap();
    assert!((point - Point3::new(0.0, 3.0, 0.0)).norm() < 1e-12, "{point}");
}
