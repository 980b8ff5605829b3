//! Folders in the layouts of several programs, and what is wrong with some of them.

use super::*;
use crate::test_data::{IDENTITY_POSE, in_unit, lines, shared, write_png};
use crate::{ScanView, write_npy_image};
use std::fs;
use tempfile::TempDir;
use transect_device::{ImageSize, Pixel};
use transect_sensors::PinholeScale;

const MATRIX: &str = "2 0 0.5\n0 2 0.5\n0 0 1\n";

/// A folder with files; those that end with `.png` are images of 2 × 2 equal counts.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        match content.parse() {
            Ok(count) if name.ends_with(".png") => write_png(&path, 2, &[count; 4]),
            _ => fs::write(path, content).unwrap(),
        }
    }
    folder
}

/// A pose without rotation, whose sensor is at x.
fn pose_at(x: f64) -> String {
    IDENTITY_POSE.replacen("0 0 0\n", &format!("0 0 {x}\n"), 1)
}

/// The names of the views with the x of their sensor and the depth of their first pixel.
fn views(scan: &Scan) -> Vec<(&str, f64, f32)> {
    let of_view = |view: &'_ ScanView| {
        let (loaded, _) = view.load().unwrap();
        (view.world_from_sensor().translation.x, loaded.image().extremes().unwrap().0)
    };
    let found = scan.views.iter().map(|view| (view.name(), of_view(view)));
    found.map(|(name, (x, depth))| (name, x, depth)).collect()
}

fn error(folder: &TempDir, options: &OpenOptions) -> String {
    Scan::open_with(folder.path(), options).unwrap_err().to_string()
}

fn with_poses(folder: &TempDir, name: &str) -> OpenOptions {
    OpenOptions { poses: Some(folder.path().join(name)), ..OpenOptions::default() }
}

fn seven_scenes(pose: &str, counts: &[u16]) -> TempDir {
    let folder =
        folder(&[("camera-intrinsics.txt", MATRIX), ("a.pose.txt", pose), ("b.pose.txt", pose)]);
    for name in ["b", "a"] {
        write_png(&folder.path().join(format!("{name}.depth.png")), 2, counts);
    }
    folder
}

#[test]
fn a_folder_is_a_scan_in_metres_sorted_by_name() {
    let folder = seven_scenes(IDENTITY_POSE, &[1500, 0, 65535, 2500]);
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(scan.unit, LengthUnit::Metre);
    let names: Vec<_> = scan.views.iter().map(|v| v.name()).collect();
    assert_eq!(names, ["a.depth.png", "b.depth.png"]);
    assert_eq!(scan.inputs.len(), 5, "intrinsics, poses and images: {:?}", scan.inputs);
    let (view, notes) = scan.views[0].load().unwrap();
    assert_eq!(view.image().valid_count(), 2);
    assert_eq!(view.image().extremes(), Some((1.5, 2.5)));
    assert!(notes[0].text.ends_with("1 pixels at the largest count, 65535, taken as missing"));
    let other = Scan::open_with(folder.path(), &in_unit(LengthUnit::Millimetre)).unwrap_err();
    assert!(matches!(other, ReadError::UnitConflict { .. }), "{other}");
}

#[test]
fn its_manifest_can_be_written_and_opened_elsewhere() {
    let (images, elsewhere) = (seven_scenes(IDENTITY_POSE, &[9; 4]), tempfile::tempdir().unwrap());
    let absolute = FileNames::Absolute;
    let (manifest, _) =
        depth_sequence_manifest(images.path(), absolute, &OpenOptions::default()).unwrap();
    let path = elsewhere.path().join("scan.json");
    crate::write_file(&path, |out| manifest::write_manifest(&manifest, "manifest", out)).unwrap();
    let scan = Scan::open(elsewhere.path()).unwrap();
    assert_eq!(scan.notes, []);
    assert!(scan.views[1].load().is_ok());
}

#[test]
fn images_without_a_usable_pose_are_counted_and_refused_if_none_is_left() {
    let bad = seven_scenes(&IDENTITY_POSE.replacen('1', "-inf", 1), &[9; 4]);
    let all = error(&bad, &OpenOptions::default());
    assert!(all.contains("no image has a pose: 2 of 2 images are left out"), "{all}");
    assert!(all.ends_with("a.pose.txt: the pose has a number that is not finite"), "{all}");
    fs::write(bad.path().join("b.pose.txt"), IDENTITY_POSE).unwrap();
    let scan = Scan::open(bad.path()).unwrap();
    assert_eq!(scan.views.len(), 1);
    let note = &scan.notes[1];
    assert!(note.text.contains("1 of 2 images are left out, without a usable pose"), "{note}");
    let short = error(&seven_scenes("1 0 0", &[9; 4]), &OpenOptions::default());
    assert!(
        short.ends_with("a.pose.txt: 3 numbers; a pose has 12 (3 × 4) or 16 (4 × 4), row by row"),
        "{short}"
    );
    fs::remove_file(bad.path().join("a.pose.txt")).unwrap();
    let scan = Scan::open(bad.path()).unwrap();
    assert!(scan.notes[1].text.contains("left out, without a pose file in "), "{}", scan.notes[1]);
}

/// A turn of 90° around z and a way of 1 m between the times 10 and 11.
const TUM: &str = "# time tx ty tz qx qy qz qw\n10 0 0 0 0 0 0 1\n\
    11 1 0 0 0 0 0.70710678 0.70710678\nbroken\n40 4 0 0 0 0 0 1\n";

#[test]
fn tum_images_get_the_pose_at_their_time_and_no_other() {
    let folder = folder(&[
        (
            "depth.txt",
            "# time file\n10.5 depth/a.png\n9.9 depth/b.png\n20 depth/c.png\n40 depth/d.png\n",
        ),
        ("groundtruth.txt", TUM),
        ("calibration.txt", "2 2 0.5 0.5\n"),
        ("depth/a.png", "5000"),
        ("depth/b.png", "5000"),
        ("depth/c.png", "5000"),
        ("depth/d.png", "10000"),
    ]);
    for wrong in [-0.1, f64::NAN, f64::INFINITY] {
        let options = OpenOptions { max_time_difference: Some(wrong), ..OpenOptions::default() };
        let error = error(&folder, &options);
        assert!(
            error.contains(&format!("the setting `max_time_difference` is {wrong}; expected")),
            "{error}"
        );
    }
    let options = OpenOptions { max_time_difference: Some(0.5), ..OpenOptions::default() };
    let scan = Scan::open_with(folder.path(), &options).unwrap();
    assert_eq!(views(&scan), [("depth/a.png", 0.5, 1.0), ("depth/d.png", 4.0, 2.0)]);
    let turn = scan.views[0].world_from_sensor().rotation.angle().to_degrees();
    assert!((turn - 45.0).abs() < 1e-6, "{turn}");
    let notes = lines(&scan.notes);
    for text in [
        "metres, 0.0002 m per count, the convention of this layout; depths 1.000 to 2.000 m, med",
        "groundtruth.txt: lines without a pose: 1; the first: line 4: \"broken\" is no number; expected 8",
        "1 of 4 images are left out, before the first pose or after the last; the first: \
         depth/b.png at 9.9; ",
        "has poses from 10 to 40",
        "1 of 4 images are left out, without a pose within 0.5 s; the first: depth/c.png at 20",
    ] {
        assert!(notes.contains(text), "no {text:?} in\n{notes}");
    }
    let zero = TUM.replace(" 0.70710678 0.70710678", " 0 0").replace("0 0 0 1\n", "0 0 0 0\n");
    fs::write(folder.path().join("groundtruth.txt"), zero).unwrap();
    let none = error(&folder, &options);
    let line = "no image has a pose: lines without a pose: 4; the first: line 2: the quaternion has \
                length 0, which is no rotation; 4 of 4 images";
    assert!(none.contains(line), "{none}");
    fs::write(folder.path().join("groundtruth.txt"), TUM).unwrap();
    // The usual tolerance leaves the image of the time of a pose.
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(views(&scan), [("depth/d.png", 4.0, 2.0)]);
    let contradicts =
        |scan: &Scan| scan.notes.iter().any(|note| note.text.contains("that differ: 1"));
    assert!(!contradicts(&scan));
    for (again, told) in [("40 4 0 0 0 0 0 1\n", false), ("40 5 0 0 0 0 0 1\n", true)] {
        fs::write(folder.path().join("groundtruth.txt"), format!("{TUM}{again}")).unwrap();
        let scan = Scan::open(folder.path()).unwrap();
        assert_eq!(views(&scan), [("depth/d.png", 4.0, 2.0)]);
        assert_eq!(contradicts(&scan), told, "{:?}", scan.notes);
    }
}

#[test]
fn icl_nuim_states_numbers_for_times_and_a_camera_whose_y_points_up() {
    let folder = folder(&[
        ("associations.txt", "1 depth/1.png 1 rgb/1.png\n2 depth/2.png 2 rgb/2.png\n"),
        ("livingRoom.gt.freiburg", "1 7 1 0 0 0 0 1\n2 8 1 0 0.6 0 0 0.8\n"),
        ("depth/1.png", "5000"),
        ("depth/2.png", "5000"),
    ]);
    let none = error(&folder, &OpenOptions::default());
    assert!(
        none.contains("no camera beside the depth images; pass the setting `camera`, a file or"),
        "{none}"
    );
    let camera = "481.2,-480,0.5,0.5".parse().ok();
    let options = OpenOptions { camera, ..OpenOptions::default() };
    let scan = Scan::open_with(folder.path(), &options).unwrap();
    assert_eq!(views(&scan), [("depth/1.png", 7.0, 1.0), ("depth/2.png", 8.0, 1.0)]);
    let notes = lines(&scan.notes);
    assert!(notes.contains("fy is negative, so y points up"), "{notes}");
    // Row 0 is up: with y down, at y below 0 in the sensor, so above -1 in the world.
    let (view, _) = scan.views[0].load().unwrap();
    let corner = view.point_in_sensor(transect_device::Pixel::new(0, 0)).unwrap();
    let y = (view.world_from_sensor() * corner).y;
    assert!((y - (-1.0 - 0.5 / 480.0)).abs() < 1e-6, "{y}");
    let turn = scan.views[1].world_from_sensor().rotation.euler_angles().0;
    assert!((turn + 2.0 * 0.6_f64.asin()).abs() < 1e-6, "a turn around x changes its sign: {turn}");
}

#[test]
fn scannet_has_files_by_number_and_poses_that_are_lost() {
    let intrinsics = "2 0 0.5 0\n0 2 0.5 0\n0 0 1 0\n0 0 0 1\n";
    let lost = "-inf -inf -inf -inf\n".repeat(4);
    let folder = folder(&[
        ("intrinsic/intrinsic_depth.txt", intrinsics),
        ("depth/10.png", "1000"),
        ("depth/9.png", "2000"),
        ("depth/100.png", "3000"),
        ("pose/9.txt", &pose_at(9.0)),
        ("pose/10.txt", &pose_at(10.0)),
        ("pose/100.txt", &lost),
    ]);
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(views(&scan), [("depth/9.png", 9.0, 2.0), ("depth/10.png", 10.0, 1.0)]);
    let note = &scan.notes[1];
    assert!(
        note.text.contains(
            "1 of 3 images are left out, without a usable pose; the first: depth/100.png"
        ),
        "{note}"
    );
}

/// The camera of a file is the one of [`MATRIX`], and the image has the size that it states.
#[test]
fn cameras_are_read_from_open3d_realsense_and_text() {
    let open3d = r#"{ "height": 2, "width": 2,
        "intrinsic_matrix": [2, 0, 0, 0, 2, 0, 0.5, 0.5, 1] }"#;
    let realsense = r#"{ "width": 2, "height": 2, "ppx": 0.5, "ppy": 0.5, "fx": 2, "fy": 2,
        "model": "Brown Conrady", "coeffs": [0.0, 0.0, 0.0, 0.0, 0.0] }"#;
    let view = format!(r#"{{ "parameters": [ {{ "intrinsic": {open3d} }} ] }}"#);
    let camera = |text: &str| {
        let (_folder, path) = crate::test_data::write_to_folder("camera", text.as_bytes());
        Camera::read(&CameraOption::File(path)).map_err(|e| crate::test_data::with_causes(&e))
    };
    for text in [open3d, realsense, &view, MATRIX, "# fx fy cx cy\n2 2 0.5 0.5"] {
        let wanted = camera(MATRIX).unwrap().sensor(PinholeScale::Depth);
        assert_eq!(camera(text).map(|c| c.sensor(PinholeScale::Depth)), Ok(wanted), "{text}");
    }
    assert_eq!(camera(open3d).map(|c| (c.rows, c.cols)), Ok((Some(2), Some(2))));
    let bent = realsense.replace("[0.0,", "[0.1,");
    assert!(camera(&bent).is_ok());
    for (text, problem) in [
        (
            bent.replace("Brown", "Inverse Brown").as_str(),
            "the lens model is \"inverse brown conrady\"",
        ),
        (
            realsense.replace("coeffs", "dist_coeffs").replace("[0.0,", "[0.1,").as_str(),
            "\"dist_coeffs\" is [0.1,0.0,0.0,0.0,0.0], and a lens distortion is not read under this",
        ),
        (r#"{ "fx": 2, "fy": 2, "cx": 0.5, "cy": 0.5, "k1": -0.2 }"#, "\"k1\" is -0.2, and a lens"),
        ("2 2 0.5", "not a camera; expected a matrix of 3 × 3"),
        ("2 1 0.5 0 2 0.5 0 0 1", "not a camera matrix"),
        (r#"{ "fx": 2 }"#, "no camera; expected \"intrinsic_matrix\""),
        (r#"{ "parameters": [] }"#, "\"parameters\" is empty"),
        (r#"{ "fx": "#, "not valid JSON"),
        (
            &format!(r#"{{ "parameters": [{open3d}, {}] }}"#, open3d.replace("0.5", "0.6")),
            "different cameras",
        ),
    ] {
        let error = camera(text).unwrap_err();
        assert!(error.contains(problem), "{error}");
    }
}

/// Two poses in every format of trajectories.
#[test]
fn trajectories_of_all_formats_place_the_same_images() {
    let line = |x: f64| pose_at(x).replace('\n', " ");
    let kitti = |x: f64| format!("1 0 0 {x} 0 1 0 0 0 0 1 0");
    // Open3D: the inverse, column by column.
    let view = |x: f64| format!(r#"{{"extrinsic": [1,0,0,0, 0,1,0,0, 0,0,1,0, {},0,0,1]}}"#, -x);
    let trajectories = [
        ("a.txt", format!("{}\n{}\n", kitti(5.0), kitti(6.0))),
        ("b.txt", format!("{}\n{}\n", line(5.0), line(6.0))),
        ("c.txt", format!("{}\n{}", pose_at(5.0), pose_at(6.0))),
        ("d.log", format!("0 0 1\n{}1 1 2\n{}", pose_at(5.0), pose_at(6.0))),
        ("e.json", format!(r#"{{"parameters": [{}, {}]}}"#, view(5.0), view(6.0))),
        ("f.tum", "0 5 0 0 0 0 0 1\n1 6 0 0 0 0 0 1\n".to_owned()),
        ("g/0.txt", pose_at(5.0)),
        ("g/1.txt", pose_at(6.0)),
    ];
    let files = [("depth/0.png", "1000"), ("depth/1.png", "2000"), ("camera.txt", MATRIX)];
    let files: Vec<_> =
        files.into_iter().chain(trajectories.iter().map(|(n, t)| (*n, t.as_str()))).collect();
    let folder = folder(&files);
    let none = error(&folder, &OpenOptions::default());
    assert!(
        none.contains("no poses beside the depth images; pass the setting `poses`, a file"),
        "{none}"
    );
    for name in ["a.txt", "b.txt", "c.txt", "d.log", "e.json", "f.tum", "g"] {
        let scan = Scan::open_with(folder.path(), &with_poses(&folder, name)).unwrap();
        assert_eq!(views(&scan), [("depth/0.png", 5.0, 1.0), ("depth/1.png", 6.0, 2.0)], "{name}");
        assert!(!scan.notes.iter().any(|note| note.text.contains("nearest rotation")), "{name}");
    }
    let rounded =
        fs::read_to_string(folder.path().join("e.json")).unwrap().replace("[1,", "[1.001,");
    fs::write(folder.path().join("e.json"), rounded).unwrap();
    let scan = Scan::open_with(folder.path(), &with_poses(&folder, "e.json")).unwrap();
    let note = "2 of 2 poses replaced by the nearest rotation; largest deviation";
    assert!(scan.notes.iter().any(|found| found.text.contains(note)), "{:?}", scan.notes);
}

#[test]
fn a_trajectory_of_more_images_places_them_by_the_numbers_in_their_names() {
    let poses: String = (0..9).map(|x| format!("1 0 0 {x} 0 1 0 0 0 0 1 0\n")).collect();
    let poses = poses.replace("1 0 0 4 ", "1 0 0 nan ");
    let folder = folder(&[
        ("camera.txt", MATRIX),
        ("poses.txt", &poses),
        ("depth/000002.png", "1000"),
        ("depth/000004.png", "1000"),
        ("depth/000008.png", "1000"),
        ("depth/000009.png", "1000"),
    ]);
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(views(&scan), [("depth/000002.png", 2.0, 1.0), ("depth/000008.png", 8.0, 1.0)]);
    let notes = lines(&scan.notes);
    for text in [
        "9 poses for 4 images; pose k (from 0) belongs to the image whose name ends with",
        "without a usable pose; the first: depth/000004.png, ",
        "line 5: the pose has a number that is not finite",
        "with numbers beyond the last pose; the first: depth/000009.png",
    ] {
        assert!(notes.contains(text), "no {text:?} in\n{notes}");
    }
    fs::rename(folder.path().join("depth/000009.png"), folder.path().join("depth/last.png"))
        .unwrap();
    let unnamed = error(&folder, &OpenOptions::default());
    assert!(unnamed.ends_with("expected one pose per image"), "{unnamed}");
}

/// Heads that do not count from 0 in order place poses by the numbers in the images' names.
#[test]
fn the_heads_of_a_log_place_its_poses() {
    let log = |heads: &[usize]| -> String {
        heads.iter().map(|k| format!("{k} {k} {}\n{}", k + 1, pose_at(*k as f64))).collect()
    };
    let folder = folder(&[("camera.txt", MATRIX), ("trajectory.log", &log(&[3, 2, 7]))]);
    let add = |name: &str| write_png(&folder.path().join("depth").join(name), 2, &[1000; 4]);
    fs::create_dir(folder.path().join("depth")).unwrap();
    ["000000.png", "000002.png", "000003.png"].into_iter().for_each(add);
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(views(&scan), [("depth/000002.png", 2.0, 1.0), ("depth/000003.png", 3.0, 1.0)]);
    let notes = lines(&scan.notes);
    for text in [
        "3 poses for 3 images; their heads have numbers from 2 to 7; a pose belongs to the image \
         whose name ends with the number in the head; 1 poses have no image",
        "1 of 3 images are left out, with numbers that no pose has in its head; the first: \
         depth/000000.png",
    ] {
        assert!(notes.contains(text), "no {text:?} in\n{notes}");
    }
    // Heads that repeat a number, or count from 0, state nothing.
    for heads in [[5, 5, 5], [0, 1, 2]] {
        fs::write(folder.path().join("trajectory.log"), log(&heads)).unwrap();
        let scan = Scan::open(folder.path()).unwrap();
        let x = |k: usize| scan.views[k].world_from_sensor().translation.x as usize;
        assert_eq!([x(0), x(1), x(2)], heads);
        assert!(!lines(&scan.notes).contains("heads"), "{:?}", scan.notes);
    }
    fs::write(folder.path().join("trajectory.log"), log(&[5, 6, 7])).unwrap();
    let none = error(&folder, &OpenOptions::default());
    assert!(none.contains("no image has a pose: 3 of 3 images are left out, with num"), "{none}");
    fs::rename(folder.path().join("depth/000003.png"), folder.path().join("depth/last.png"))
        .unwrap();
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(scan.views.len(), 3);
    let text = "the numbers in the heads of the poses are not used, because not all images have";
    assert!(lines(&scan.notes).contains(text), "{:?}", scan.notes);
}

#[test]
fn images_of_floating_point_numbers_hold_metres() {
    let folder = folder(&[("camera.txt", MATRIX), ("poses.txt", &pose_at(0.0))]);
    let size = ImageSize { rows: 2, cols: 2 };
    let image = folder.path().join("depth.npy");
    crate::write_file(&image, |out| write_npy_image(size, &[1.5; 4], out)).unwrap();
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(views(&scan), [("depth.npy", 0.0, 1.5)]);
    assert!(scan.notes[0].text.contains("floating-point numbers; depths 1.500 to 1.500 m"));
    let options = OpenOptions { depth_scale: Some(0.5), ..OpenOptions::default() };
    let scan = Scan::open_with(folder.path(), &options).unwrap();
    assert_eq!(views(&scan), [("depth.npy", 0.0, 0.75)]);
}

#[test]
fn options_that_mean_nothing_are_refused() {
    let folder = seven_scenes(IDENTITY_POSE, &[9; 4]);
    let scale = OpenOptions { depth_scale: Some(1000.0), ..OpenOptions::default() };
    assert!(
        error(&folder, &scale)
            .contains("the setting `depth_scale` is 1000; it is the metres per count")
    );
    let time = OpenOptions { max_time_difference: Some(1.0), ..OpenOptions::default() };
    assert!(
        error(&folder, &time)
            .contains("the poses have no times, so the setting `max_time_difference`")
    );
    let rings = OpenOptions { rings: Some(32), ..OpenOptions::default() };
    assert!(
        error(&folder, &rings)
            .contains("the setting `rings` has no meaning for a scan of this format")
    );
    fs::write(folder.path().join("scan.json"), "{}").unwrap();
    let taken_over = error(&folder, &scale);
    assert!(taken_over.contains("the setting `depth_scale` has no meaning"), "{taken_over}");
    assert!(taken_over.contains("scan.json is read, which states the cameras"), "{taken_over}");
    assert!("585,585".parse::<CameraOption>().unwrap_err().starts_with("2 numbers; expected"));
}

#[test]
fn the_size_of_a_camera_file_must_be_that_of_the_images() {
    let camera = r#"{ "width": 3, "height": 2, "fx": 2, "fy": 2, "cx": 0.5, "cy": 0.5 }"#;
    let folder = folder(&[("a.png", "5"), ("camera.json", camera), ("poses.txt", IDENTITY_POSE)]);
    let scan = Scan::open(folder.path()).unwrap();
    let error = scan.views[0].load().unwrap_err().to_string();
    assert!(error.contains("the image has 2 rows × 2 columns, but"), "{error}");
}

#[test]
fn an_image_of_another_size_than_most_is_refused() {
    let folder = folder(&[
        ("a.png", "5"),
        ("b.png", "5"),
        ("c.png", "5"),
        ("camera.txt", MATRIX),
        ("poses.txt", &IDENTITY_POSE.repeat(3)),
    ]);
    for odd in 0..3 {
        for (number, name) in ["a.png", "b.png", "c.png"].into_iter().enumerate() {
            let side = if number == odd { 3 } else { 2 };
            write_png(&folder.path().join(name), side, &vec![9; side * side]);
        }
        let views = Scan::open(folder.path()).unwrap().views;
        for (number, view) in views.iter().enumerate() {
            let text = "states 2 rows × 2 columns, or most images have them";
            match view.load() {
                Ok(_) => assert_ne!(number, odd),
                Err(error) => {
                    assert!(number == odd && error.to_string().ends_with(text), "{error}")
                }
            }
        }
    }
}

#[test]
fn red_kitchen_opens_with_its_rounded_rotations_repaired() {
    let Some(folder) = shared("rgbd_redkitchen") else { return };
    let scan = Scan::open(&folder).unwrap();
    assert_eq!(scan.views.len(), 50);
    let depths = "0.001 m per count, the convention of this layout; depths 0.";
    assert!(scan.notes[0].text.contains(depths), "{}", scan.notes[0]);
    let repaired = &scan.notes[1];
    assert!(
        repaired.text.contains("50 of 50 poses replaced by the nearest rotation"),
        "{repaired}"
    );
    let (view, _) = scan.views[0].load().unwrap();
    assert_eq!(view.image().size().to_string(), "480 rows × 640 columns");
    let (nearest, farthest) = view.image().extremes().unwrap();
    assert!(nearest > 0.8 && farthest < 4.0, "metres: {nearest} to {farthest}");
}

#[test]
fn lengths_of_rays_are_read_as_such_if_that_is_stated() {
    let files = [
        ("camera-intrinsics.txt", MATRIX),
        ("frame-000000.depth.png", "2000"),
        ("frame-000000.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"),
    ];
    let folder = folder(&files);
    let corner = |pixels_hold| {
        let options = OpenOptions { pixels_hold, ..OpenOptions::default() };
        let scan = Scan::open_with(folder.path(), &options).unwrap();
        let (view, _) = scan.views[0].load().unwrap();
        let point = view.frame().point(Pixel::new(0, 0), 2.0).unwrap();
        (point.z, point.coords.norm(), scan.notes.len())
    };
    let (depth, _, notes) = corner(None);
    assert_eq!(depth, 2.0);
    let (_, length, notes_if_stated) = corner(Some(PinholeScale::RayLength));
    assert!((length - 2.0).abs() < 1e-12, "{length}");
    assert_eq!(notes_if_stated, notes + 1);
}
