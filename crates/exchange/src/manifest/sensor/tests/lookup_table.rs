//! A wall seen through the calibration of a scanner of known geometry.

use super::*;
use crate::write_calibration;
use transect_sensors::LookupTable;
use transect_sensors::lookup_table::{SynchronizedScanner, ThetaSteps};

const COLUMNS: usize = 16;
const STEP: f64 = 0.02;
const KEYS: &str = r#""sensor": "lookup_table", "theta0": -0.2, "dtheta": 0.02,
    "calibration": "sweeps.csv", "median_window": 1, "y0": 5, "dy": -0.5, "mounting": "xz",
    "tilt": 0.1, "projector": [-30, 0], "receiver": [30, 0]"#;

fn write_sweeps(folder: &Path, depths: usize) {
    let columns = ThetaSteps::from_radians(-0.2, STEP, COLUMNS);
    let scanner = SynchronizedScanner::hyscan();
    let sweep = |k: usize| scanner.sweep(&columns, 110.0 + 10.0 * k as f64, 0.02);
    let sweeps: Vec<_> = (0..depths).map(sweep).collect();
    let path = folder.join("sweeps.csv");
    crate::write_file(&path, |out| write_calibration(&sweeps, out)).unwrap();
}

/// An image of `p` of a wall, as the scanner sees it.
fn write_image(folder: &Path, name: &str, rows: usize) {
    let scanner = SynchronizedScanner::hyscan();
    let p = |n: usize| {
        let column = (n % COLUMNS) as f64;
        scanner.sample(-0.2 + STEP * column, 140.0, 0.0).p as f32
    };
    let values: Vec<f32> = (0..rows * COLUMNS).map(p).collect();
    write_npy(&folder.join(name), &[rows, COLUMNS], &values);
}

fn folder(keys: &str, rows: usize) -> tempfile::TempDir {
    let folder = scan_folder(&[&format!(r#""file": "p.npy", {keys}"#)]);
    write_sweeps(folder.path(), 10);
    write_image(folder.path(), "p.npy", rows);
    folder
}

#[test]
fn the_wall_comes_back_where_it_stood() {
    for rows in [1, 4] {
        let folder = folder(KEYS, rows);
        let (view, notes) = load(folder.path()).unwrap();
        assert_eq!((view.image().valid_count(), notes.len()), (rows * COLUMNS, 0));
        for row in 0..rows {
            let point = view.point_in_sensor(Pixel::new(row, 3)).unwrap();
            // Turned back by the tilt about y, the wall stands at v = 140. Between depths 10 mm
            // apart, linear interpolation errs by some hundredths of a millimetre.
            let v = point.x * 0.1_f64.sin() + point.z * 0.1_f64.cos();
            assert!((v - 140.0).abs() < 0.1, "{v}");
            assert!((point.y - (5.0 - 0.5 * row as f64)).abs() < 1e-12);
        }
        let receiver = view.frame().second_viewpoint(Pixel::new(0, 3)).unwrap();
        assert!((receiver.x - 30.0 * 0.1_f64.cos()).abs() < 1e-12);
    }
}

#[test]
fn the_other_mounting_runs_along_x() {
    let folder = folder(&KEYS.replace("\"xz\"", "\"yz\""), 4);
    let (view, _) = load(folder.path()).unwrap();
    assert_eq!(view.point_in_sensor(Pixel::new(2, 3)).unwrap().x, 4.0);
}

#[test]
fn views_that_say_the_same_share_one_table() {
    let keys = |file: &str, more: &str| format!(r#""file": "{file}", {KEYS}{more}"#);
    let other = keys("a.npy", r#", "pairs": "half_apart""#);
    let folder = scan_folder(&[&keys("a.npy", ""), &keys("b.npy", ""), &other]);
    write_sweeps(folder.path(), 10);
    write_image(folder.path(), "a.npy", 4);
    write_image(folder.path(), "b.npy", 4);
    let scan = Scan::open(folder.path()).unwrap();
    let views: Vec<View> = scan.views.iter().map(|v| v.load().unwrap().0).collect();
    let same = |a: usize, b: usize| std::ptr::addr_eq(views[a].frame(), views[b].frame());
    assert!(same(0, 1), "the calibration is digitised once");
    assert!(!same(0, 2));
    let names = scan.inputs.iter().map(|p| p.file_name().unwrap().to_str().unwrap());
    assert_eq!(names.collect::<Vec<_>>(), ["scan.json", "a.npy", "b.npy", "sweeps.csv"]);
}

#[test]
fn bad_parameters_name_their_key() {
    let keys = format!(r#""file": "p.npy", {KEYS}"#);
    let with = |from: &str, to: &str, depths: usize| {
        error_with(&keys, from, to, |folder| {
            write_sweeps(folder, depths);
            write_image(folder, "p.npy", 4);
        })
    };
    let wrong = |from: &str, to: &str| with(from, to, 10);
    let sensor = "p.npy: the sensor is not usable: ";
    for (error, wanted) in [
        (wrong("\"dy\": -0.5", "\"dy\": 0"), format!("{sensor}dy = 0: a step other than 0")),
        (wrong("\"dtheta\": 0.02", "\"dtheta\": -1"), format!("{sensor}dtheta = -1: a posit")),
        (wrong("window\": 1", "window\": 2"), format!("{sensor}median_window = 2: an odd")),
        (wrong("[-30, 0]", "[-30, 120]"), format!("{sensor}projector = ")),
        (wrong("[30, 0]", "[null, 0]"), "\"receiver\": invalid type: null".to_owned()),
        (
            wrong("\"theta0\": -0.2", "\"theta0\": -0.21"),
            "sweeps.csv: the calibration is not usable: theta = -0.2: an angle of".to_owned(),
        ),
        (with("xz", "xz", 1), "sweeps.csv: 1 sweeps; at least two depths".to_owned()),
        (wrong("sweeps.csv", "none.csv"), "none.csv: cannot be read".to_owned()),
        (
            wrong("\"y0\": 5", "\"y0\": 5, \"cols\": 15"),
            "p.npy: the image has 4 rows × 16 columns, but the manifest or the \
             camera file states"
                .to_owned(),
        ),
    ] {
        assert!(error.contains(&wanted), "{error}");
    }
}

#[test]
fn the_bundled_example_can_be_written_and_read() {
    let columns = LookupTable::hyscan_columns();
    let scanner = SynchronizedScanner::hyscan();
    let sweep = |k: usize| scanner.sweep(&columns, 110.0 + 30.0 * k as f64, 0.0);
    let sweeps: Vec<_> = (0..4).map(sweep).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweeps.csv");
    crate::write_file(&path, |out| write_calibration(&sweeps, out)).unwrap();
    assert_eq!(crate::read_calibration(&path).unwrap(), sweeps);
}
