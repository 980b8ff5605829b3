//! Real files of other programs, and files that are written here.

use super::*;
use crate::test_data::{shared, with_causes, write_to_folder};
use std::fmt::Write;
use transect_device::{Pixel, View};
use transect_geometry::LengthUnit;

const IDENTITY: &str = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1";

/// A scan of a wall at x = 3, two columns and three rows; the text ends without a line feed.
fn wall(matrix: &str, tail: &str) -> String {
    let mut text = format!("2\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{matrix}");
    for col in 0..2 {
        for row in 0..3 {
            write!(text, "\n3.5 {} {} 0.5{tail}", 1 - col, row - 1).unwrap();
        }
    }
    text
}

fn opened(text: &str) -> Result<Scan, String> {
    let (_folder, path) = write_to_folder("site.ptx", text.as_bytes());
    Scan::open(&path).map_err(|error| with_causes(&error))
}

/// The views of a file.
fn loaded(text: &str) -> Result<Vec<View>, String> {
    let (_folder, path) = write_to_folder("site.ptx", text.as_bytes());
    let views = Scan::open(&path).and_then(|scan| {
        let views: Result<Vec<_>, _> = scan.views.iter().map(ScanView::load).collect();
        Ok(views?.into_iter().map(|(view, _)| view).collect())
    });
    views.map_err(|error| with_causes(&error))
}

#[test]
fn scans_follow_each_other_column_by_column() {
    let first = wall(IDENTITY, "").replacen("\n3.5 1 1 0.5", "\n0 0 0 0.5", 1);
    let text = format!("\u{feff}{first}\r\n\n{}", wall(IDENTITY, " 10 20 30"));
    let views = loaded(&text).unwrap();
    assert_eq!(views.len(), 2);
    assert_eq!(views[0].image().size(), ImageSize { rows: 3, cols: 2 });
    assert_eq!((views[0].image().valid_count(), views[1].image().valid_count()), (5, 6));
    let point = |row, col| views[0].point_in_sensor(Pixel::new(row, col));
    assert_eq!(point(2, 0), None, "0 0 0 is no return");
    assert_eq!(point(0, 1), Some(Point3::new(3.5, 0.0, -1.0)));
    let scan = opened(&text).unwrap();
    assert_eq!((scan.name.as_str(), scan.unit, scan.inputs.len()), ("site", LengthUnit::Metre, 1));
    assert_eq!(scan.notes.len(), 1, "{:?}", scan.notes);
    assert_eq!((scan.views[0].name(), scan.views[1].name()), ("scan 0", "scan 1"));
}

#[test]
fn a_wrong_count_is_named_at_the_scan_that_has_it() {
    for (counts, points) in [("2\n2", 4), ("3\n3", 9), ("2\n4", 8)] {
        let text =
            format!("{}\n{}", wall(IDENTITY, "").replacen("2\n3", counts, 1), wall(IDENTITY, ""));
        let error = opened(&text).unwrap_err();
        let wanted = format!("which are {points} points, but 6 lines of points follow");
        assert!(error.contains("site.ptx, line 1: the scan announces"), "{error}");
        assert!(error.contains(&wanted), "{error}");
    }
    let second = wall(IDENTITY, "").replacen("2\n3", "2\nthree", 1);
    let error = opened(&format!("{}\n{second}", wall(IDENTITY, ""))).unwrap_err();
    assert!(error.contains("line 18: view 1 (scan 1): found \"three\""), "{error}");
}

#[test]
fn matrices_multiply_rows_and_may_scale() {
    // A quarter turn that turns x into y, and millimetres into metres.
    let matrix = "0 0.001 0 0\n-0.001 0 0 0\n0 0 0.001 0\n600000.125 5000000.25 30 1";
    let (_folder, path) = write_to_folder("a.ptx", wall(matrix, "").as_bytes());
    let scan = Scan::open(&path).unwrap();
    let wanted = "view 0 (scan 0): the matrix scales x, y and z by 0.001, 0.001 and 0.001; applied";
    assert!(scan.notes[1].to_string().ends_with(wanted), "{:?}", scan.notes);
    let (view, _) = scan.views[0].load().unwrap();
    let point = view.point_in_sensor(Pixel::new(0, 0)).unwrap();
    let off = view.world_from_sensor() * point
        - Point3::new(600_000.125 - 0.001, 5_000_000.25 + 0.0035, 30.0 - 0.001);
    assert!(off.norm() < 1e-9, "{off}");
}

#[test]
fn matrices_that_are_no_pose_are_refused_with_their_numbers() {
    let refused = |matrix: &str| opened(&wall(matrix, "")).unwrap_err();
    let shear = refused("1 0 0 0\n0.5 1 0 0\n0 0 1 0\n0 0 0 1");
    assert!(
        shear.contains("site.ptx, line 10: view 0 (scan 0): the pose is no rotation"),
        "{shear}"
    );
    assert!(shear.contains("the lines of the matrix are 1 0 0, 0.5 1 0, 0 0 1"), "{shear}");
    let mirror = refused("1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1");
    assert!(mirror.contains("the pose is a reflection"), "{mirror}");
    let transposed = refused("1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1");
    let wanted = "the 4th column of the matrix is [5.0, 6.0, 7.0, 1.0]; expected 0 0 0 1";
    assert!(transposed.contains(wanted), "{transposed}");
    assert!(refused("0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 1").contains("the pose is no rotation"));
}

#[test]
fn rotations_of_few_digits_are_noted() {
    let matrix = |cos: f64| format!("{cos} 0.6 0 0\n-0.6 {cos} 0 0\n0 0 1 0\n0 0 0 1");
    let notes = |cos| opened(&wall(&matrix(cos), "")).unwrap().notes.split_off(1);
    assert_eq!(notes(0.800001), [], "six digits");
    assert!(
        notes(0.8002)[0].text.ends_with("replaced by the nearest rotation; it deviated by 3.2e-4")
    );
}

/// A room in the world, seen from (2, 1, 0.5); its points are relative to `origin`.
fn room(position: &str, origin: [f64; 3]) -> String {
    let [x, y, z] = origin;
    let mut text = format!("90\n60\n{position}\n1 0 0\n0 1 0\n0 0 1\n");
    write!(text, "1 0 0 0\n0 1 0 0\n0 0 1 0\n{x} {y} {z} 1").unwrap();
    for k in 0..90 * 60 {
        let (theta, phi) = (-0.07 * f64::from(k / 60), 0.8 - 0.03 * f64::from(k % 60));
        let d = Vector3::new(phi.cos() * theta.cos(), phi.cos() * theta.sin(), phi.sin());
        let reach = Vector3::new(5.0, 4.0, 1.5).zip_map(&d, |half, d| half / d.abs()).min();
        let p = Point3::new(2.0 - x, 1.0 - y, 0.5 - z) + d * reach;
        write!(text, "\n{} {} {} 0.5", p.x, p.y, p.z).unwrap();
    }
    text
}

#[test]
fn a_position_that_contradicts_the_matrix_is_noted() {
    let notes = |position: &str, origin: [f64; 3]| {
        let scan = write_to_folder("site.ptx", room(position, origin).as_bytes());
        let (_, notes) = Scan::open(&scan.1).unwrap().views[0].load().unwrap();
        notes.into_iter().map(|note| note.to_string()).collect::<Vec<_>>()
    };
    let matrix = [2.0, 1.0, 0.5];
    for same in ["2 1 0.5", "2.0004 0.9996 0.5"] {
        assert_eq!(notes(same, matrix), [""; 0], "{same}");
    }
    let other = notes("-7 1 0.5", matrix);
    let wanted = "view 0 (scan 0): the third line of the header states the scanner at (-7.000, \
                  1.000, 0.500), but the matrix places it at (2.000, 1.000, 0.500); the matrix is";
    assert!(other.len() == 1 && other[0].contains(wanted), "{other:?}");
    // Points in the frame of the world, with a matrix that moves nothing.
    let world = notes("2 1 0.5", [0.0; 3]);
    assert!(world.len() == 1 && world[0].contains("but from (2.000, 1.000, 0.5"), "{world:?}");
}

#[test]
fn damaged_lines_are_named() {
    let text = wall(IDENTITY, "");
    let error = loaded(&text.replacen("3.5 1 1", "3.5 one 1", 1)).unwrap_err();
    let wanted = "line 13: view 0 (scan 0): found \"3.5 one 1 0.5\"; expected a point: x y z";
    assert!(error.contains(wanted), "{error}");
    let error = loaded(&text.replacen("3.5 1 1 0.5", "3.5 1", 1)).unwrap_err();
    assert!(error.contains("line 13: view 0 (scan 0): found \"3.5 1\""), "{error}");
    let cut = &text[..text.len() - 14];
    let error = opened(cut).unwrap_err();
    let wanted = "line 1: the scan announces 3 rows × 2 columns, but 5 lines follow; the file is";
    assert!(error.contains(wanted), "{error}");
    let error = opened(&text.replacen('3', "4000000000", 1)).unwrap_err();
    assert!(error.contains("4000000000 rows × 2 columns, but 73 bytes follow"), "{error}");
    let error = opened(&text.replacen('3', "2.5", 1)).unwrap_err();
    assert!(
        error.contains("line 2: view 0 (scan 0): found 2.5; expected the number of"),
        "{error}"
    );
    let error = opened("2\n3\n0 0 0\n").unwrap_err();
    assert!(
        error.contains("found \"the end of the file\"; expected the scanner's x axis"),
        "{error}"
    );
    assert!(opened("\n \n").unwrap_err().ends_with("site.ptx: the file holds no scan"));
    let line = "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n";
    let error = opened(line).unwrap_err();
    assert!(error.contains("scan 0 (line 1) has 1 rows × 1 columns; a scan needs 2"), "{error}");
    let scan = opened(&format!("{line}{text}")).unwrap();
    assert!(
        scan.notes[1].text.contains("left out: scan 0 (line 1) has 1 rows"),
        "{:?}",
        scan.notes
    );
    assert_eq!((scan.views.len(), scan.views[0].name()), (1, "scan 1"));
}

#[test]
fn samples_of_another_program_are_read() {
    let Some(folder) = shared("ptx_samples") else { return };
    let scan = Scan::open(&folder.join("complex-transform.ptx")).unwrap();
    let view = &scan.views[0];
    let scanner = view.world_from_sensor() * Point3::origin();
    assert_eq!(scanner, Point3::new(-3.028748, -3.819741, -1.384333));
    let error = with_causes(&view.load().unwrap_err());
    assert!(error.ends_with("no three neighbouring points show from which side the grid is seen"));
    // Two clouds of the same four points; the matrix of the first scales z by 2.
    let path = folder.join("multiple-and-transform.ptx");
    let mut lines = Lines::open(&path).unwrap();
    let at = Place::Whole;
    let mut clouds = Vec::new();
    for _ in 0..2 {
        let header = Header::read(&mut lines, &at).unwrap();
        let point = |lines: &mut Lines| read_point(lines, &at, &header.scale).unwrap();
        let points: Vec<_> = (0..4).map(|_| header.world_from_sensor * point(&mut lines)).collect();
        clouds.push(points);
    }
    for (a, b) in clouds[0].iter().zip(&clouds[1]) {
        assert!((a - b).norm() < 1e-6, "{a} and {b}");
    }
    let scan = Scan::open(&path).unwrap();
    assert_eq!(scan.views.len(), 1);
    assert!(scan.notes[2].text.contains("left out: scan 1 (line 15) has 1 rows × 4 columns"));
}
