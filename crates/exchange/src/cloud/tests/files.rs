//! The readers of single files.

use super::*;
use crate::{ReadError, pose};
use transect_device::{Pixel, Vector3};

/// A table of 2 × 3 points with a field between the axes, and a missing point.
const ROWS: [[f32; 4]; 6] = [
    [0.0, 9.0, 0.0, 2.0],
    [1.0, 9.0, 0.0, 2.0],
    [2.0, 9.0, 0.0, 2.5],
    [f32::NAN, 9.0, f32::NAN, f32::NAN],
    [1.0, 9.0, 1.0, 2.0],
    [2.0, 9.0, 1.0, 2.5],
];

fn header(data: &str) -> String {
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x intensity y z\n\
         SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 2\n\
         VIEWPOINT 1 2 3 0 0 0 1\nPOINTS 6\nDATA {data}\n"
    )
}

fn text_file() -> String {
    let line = |row: &[f32; 4]| row.map(|v| v.to_string()).join(" ");
    header("ascii") + &ROWS.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn bytes_of(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}

fn binary_file() -> Vec<u8> {
    [header("binary").into_bytes(), bytes_of(ROWS.into_iter().flatten())].concat()
}

/// LZF of literals, 32 bytes at a time.
fn compressed_file() -> Vec<u8> {
    let columns = bytes_of((0..4).flat_map(|col| ROWS.map(|row| row[col])));
    let packed: Vec<u8> =
        columns.chunks(32).flat_map(|c| [&[c.len() as u8 - 1], c].concat()).collect();
    let lengths = [packed.len() as u32, columns.len() as u32].map(u32::to_le_bytes).concat();
    [header("binary_compressed").into_bytes(), lengths, packed].concat()
}

fn load(name: &str, bytes: &[u8], options: &OpenOptions) -> Result<String, String> {
    let (_folder, path) = write_to_folder(name, bytes);
    let text = |error: ReadError| crate::test_data::with_causes(&error);
    let scan = Scan::open_with(&path, options).map_err(text)?;
    let (view, notes) = scan.views[0].load().map_err(text)?;
    let image = view.image();
    let valid = image.valid_count();
    Ok(format!("{}, {valid} valid, {:?}", image.size(), image.get(Pixel::new(1, 2)))
        + &notes.iter().map(|note| format!("; {note}")).collect::<String>())
}

fn error(name: &str, text: &str) -> String {
    load(name, text.as_bytes(), &OpenOptions::default()).unwrap_err()
}

#[test]
fn all_encodings_of_pcd_give_the_same_grid() {
    let wanted = "2 rows × 3 columns, 5 valid, Some(3.354102)";
    for bytes in [text_file().into_bytes(), binary_file(), compressed_file()] {
        assert_eq!(load("a.pcd", &bytes, &OpenOptions::default()).unwrap(), wanted);
        let cut = load("a.pcd", &bytes[..bytes.len() - 3], &OpenOptions::default());
        assert!(cut.is_err() || bytes == text_file().into_bytes(), "{cut:?}");
    }
}

#[test]
fn a_note_tells_of_what_follows_the_last_point() {
    let notes = |bytes: &[u8]| {
        let (_folder, path) = write_to_folder("a.pcd", bytes);
        Scan::open(&path).unwrap().views[0].load().unwrap().1
    };
    let text = notes((text_file() + "\n1 2 3\n").as_bytes());
    assert!(
        text.last().unwrap().text.ends_with("1 lines after the last point ignored"),
        "{text:?}"
    );
    for bytes in [binary_file(), compressed_file()] {
        let before = notes(&bytes).len();
        let found = notes(&[bytes, vec![0; 3]].concat());
        let end = "3 bytes after the last point ignored";
        assert!(found.iter().any(|note| note.text.ends_with(end)), "{found:?}");
        assert_eq!(found.len(), before + 1);
    }
}

#[test]
fn the_viewpoint_is_the_pose() {
    let (_folder, path) = write_to_folder("a.pcd", text_file().as_bytes());
    let scan = Scan::open(&path).unwrap();
    // Half a turn about z.
    let wanted = [-1.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 2.0, 0.0, 0.0, 1.0, 3.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(pose::row_major(scan.views[0].world_from_sensor()), wanted);
    assert!(scan.notes[1].text.contains("1 poses from VIEWPOINT lines"), "{:?}", scan.notes);
}

/// Grids of a room in the frame of the sensor, and in the world with the same `VIEWPOINT`.
#[test]
fn points_in_the_world_beside_a_viewpoint_are_refused() {
    let cloud = |moved: f64| {
        let point = |k: usize| {
            let (theta, phi) = (0.07 * (k % 90) as f64, -1.0 + 0.03 * (k / 90) as f64);
            let d = Vector3::new(phi.cos() * theta.cos(), phi.cos() * theta.sin(), phi.sin());
            let reach = Vector3::new(5.0, 4.0, 1.5).zip_map(&d, |half, d| half / d.abs()).min();
            let p = d * reach + Vector3::new(2.0, 1.0, 1.4) * moved;
            format!("{:.6} {:.6} {:.6}\n", p.x, p.y, p.z)
        };
        let points: String = (0..60 * 90).map(point).collect();
        let text = format!(
            "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 90\nHEIGHT 60\n\
             VIEWPOINT 2 1 1.4 1 0 0 0\nPOINTS 5400\nDATA ascii\n{points}"
        );
        let (_folder, path) = write_to_folder("a.pcd", text.as_bytes());
        Scan::open(&path).unwrap().views[0].load().map(drop).map_err(|e| e.to_string())
    };
    assert_eq!(cloud(0.0), Ok(()));
    let error = cloud(1.0).unwrap_err();
    assert!(error.contains("a.pcd: the points are seen from (2.000, 1.000, 1.400)"), "{error}");
    assert!(error.contains("Pass the setting `poses`"), "{error}");
}

#[test]
fn a_cloud_without_the_viewpoint_that_others_have_is_refused() {
    let (folder, _) = write_to_folder("a.pcd", text_file().as_bytes());
    let without = text_file().replace("VIEWPOINT 1 2 3 0 0 0 1\n", "");
    std::fs::write(folder.path().join("b.pcd"), without).unwrap();
    let error = Scan::open(folder.path()).unwrap_err().to_string();
    assert!(error.contains("b.pcd: no VIEWPOINT line, which 1 of 2 clouds of the"), "{error}");
}

#[test]
fn damaged_pcd_files_name_the_place() {
    let text = text_file();
    let with = |from: &str, to: &str| error("a.pcd", &text.replacen(from, to, 1));
    assert!(with("DATA ascii", "DATA xml").contains("line 11: DATA is \"xml\"; expected ascii"));
    assert!(with("DATA ascii", "").contains("no line DATA within the first 100 lines"));
    assert!(with("y z", "y w").contains("FIELDS has no z"));
    assert!(with("SIZE 4 4 4 4", "SIZE 4 4 4").contains("line 3: FIELDS has 4 names, SIZE 3,"));
    assert!(with("SIZE 4 4", "SIZE 4 3").contains("field intensity has TYPE F, SIZE 3, COUNT 1"));
    let none = with("COUNT 1 1 1 1", "COUNT 0 1 1 1");
    assert!(none.contains("field x has COUNT 0; expected 1 number for each point"), "{none}");
    assert!(with("WIDTH 3", "WIDTH x").contains("line 7: WIDTH: \"x\" is no number"));
    assert!(with("POINTS 6", "POINTS 7").contains("POINTS is 7, but WIDTH 3 × HEIGHT 2 is 6"));
    let huge = with("WIDTH 3", "WIDTH 4000000000");
    assert!(huge.contains("WIDTH 4000000000 × HEIGHT 2 is empty or absurd"), "{huge}");
    assert!(with("0 0 0 1", "0 0 0 2").contains("line 9: VIEWPOINT is no pose"));
    assert!(with("1 9 0 2", "1 9 zero 2").contains("line 13, point 1: field y: \"zero\" is no"));
    assert!(with("1 9 0 2", "1 9 0").contains("line 13: the line has 3 numbers; FIELDS"));
    assert!(
        with("1 9 0 2\n", "").contains("truncated: the header announces 6 points, the file has 5")
    );
}

#[test]
fn vertices_row_by_row_need_a_stated_grid() {
    let points =
        [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|k: f64| Point3::new(k % 3.0, (k / 3.0).floor(), 2.0));
    let stated = ply_text("obj_info num_rows 2\nobj_info num_cols 3\n", &points, None);
    let wanted = "2 rows × 3 columns, 6 valid, Some(3.0)";
    assert_eq!(load("a.ply", stated.as_bytes(), &OpenOptions::default()).unwrap(), wanted);
    let bare = ply_text("", &points, None);
    let grid =
        |rows, cols| OpenOptions { grid: Some(ImageSize { rows, cols }), ..OpenOptions::default() };
    assert_eq!(load("a.ply", bare.as_bytes(), &grid(2, 3)).unwrap(), wanted);
    let other = load("a.ply", bare.as_bytes(), &grid(2, 4)).unwrap_err();
    assert!(other.contains("the file has 6 points, 2 rows × 4 columns need 8"), "{other}");
    let other = load("a.ply", stated.as_bytes(), &grid(3, 2)).unwrap_err();
    assert!(
        other.contains(
            "the header states 2 rows × 3 columns, the setting `grid` 3 rows × 2 columns"
        )
    );
    let unorganised = error("a.ply", &bare);
    assert!(unorganised.contains("a.ply: the 6 points have no rows and columns"), "{unorganised}");
    assert!(
        unorganised.contains("pass the setting `rings`") && unorganised.contains("as E57, PTX")
    );
}

#[test]
fn a_mesh_is_no_scan() {
    let mesh = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement face 1\n\
                property list uchar int vertex_indices\nend_header\n0\n3 0 0 0\n";
    assert!(error("a.ply", mesh).contains("a.ply: a triangle mesh, which has no rows"));
}

#[test]
fn raw_lidar_files_have_four_or_five_floats() {
    let returns = sweep(30, 0.0);
    let floats = |has_ring: bool| {
        let numbers = returns.iter().flat_map(|r| {
            let p = r.point.map(|c| c as f32);
            let ring = has_ring.then_some(f32::from(r.laser));
            [p.x, p.y, p.z, 0.5].into_iter().chain(ring)
        });
        bytes_of(numbers)
    };
    for (name, bytes) in [("0.bin", floats(false)), ("0.pcd.bin", floats(true))] {
        let loaded = load(name, &bytes, &OpenOptions::default()).unwrap();
        assert!(loaded.starts_with("8 rows × 30 columns, 240 valid"), "{name}: {loaded}");
    }
    let cut = load("0.bin", &floats(true), &OpenOptions::default()).unwrap_err();
    assert!(!cut.is_empty());
    let cut = load("0.bin", &floats(false)[..33], &OpenOptions::default()).unwrap_err();
    assert!(cut.contains("the file has 33 bytes; expected a multiple of 16: 4 32-bit floats"));
    let mut odd = floats(true);
    odd[36..40].copy_from_slice(&0.5_f32.to_le_bytes());
    let odd = load("0.pcd.bin", &odd, &OpenOptions::default()).unwrap_err();
    assert!(odd.contains("point 1: the ring is 0.5; expected a whole number"), "{odd}");
}
