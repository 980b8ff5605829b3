//! Folders of clouds with their poses.

use super::*;
use crate::pose::row_major;
use transect_geometry::Vector3;

/// A folder of three clouds in firings, with other files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let cloud = ply_text("", &points(&sweep(30, 0.0)), None);
    for name in ["a.ply", "b.ply", "c.ply"] {
        std::fs::write(folder.path().join(name), &cloud).unwrap();
    }
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The x of every view's place.
fn places(scan: &Scan) -> Vec<f64> {
    scan.views.iter().map(|v| v.world_from_sensor().translation.x).collect()
}

fn open(files: &[(&str, &str)]) -> Result<Vec<f64>, String> {
    let folder = folder(files);
    let scan = Scan::open(folder.path()).map_err(|e| e.to_string())?;
    scan.views.iter().for_each(|view| drop(view.load().unwrap()));
    Ok(places(&scan))
}

/// 4 × 4 numbers of a shift along x.
fn shift(x: f64) -> String {
    format!("1 0 0 {x}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")
}

const KITTI: &str = "1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n1 0 0 3 0 1 0 0 0 0 1 0\n";

#[test]
fn poses_come_from_a_trajectory_from_files_or_from_pairs() {
    assert_eq!(open(&[("poses.txt", KITTI)]), Ok(vec![1.0, 2.0, 3.0]));
    let blocks = format!("# three poses\n{}\n{}\n{}", shift(4.0), shift(5.0), shift(6.0));
    assert_eq!(open(&[("poses.txt", &blocks)]), Ok(vec![4.0, 5.0, 6.0]));
    let log = format!("0 0 1\n{}1 1 2\n{}2 2 3\n{}", shift(4.0), shift(5.0), shift(6.0));
    assert_eq!(open(&[("poses.txt", &log)]), Ok(vec![4.0, 5.0, 6.0]));
    let (a, b, c) = (shift(7.0), shift(8.0), shift(9.0));
    let beside = [("a.pose.txt", &*a), ("b.pose.txt", &*b), ("c.pose.txt", &*c)];
    assert_eq!(open(&beside), Ok(vec![7.0, 8.0, 9.0]));
    assert_eq!(open(&[("T_b_a.txt", &a), ("T_b_c.txt", &c)]), Ok(vec![7.0, 0.0, 9.0]));
    // Files of other clouds state nothing.
    let others = [("T_a_d.txt", "no pose"), ("T_b_a.txt", &*a), ("T_b_c.txt", &*c)];
    assert_eq!(open(&others), Ok(vec![7.0, 0.0, 9.0]));
}

#[test]
fn a_named_trajectory_comes_first() {
    let elsewhere = tempfile::tempdir().unwrap();
    let path = elsewhere.path().join("traj.txt");
    std::fs::write(&path, KITTI).unwrap();
    let options = OpenOptions { poses: Some(path.clone()), ..OpenOptions::default() };
    let folder = folder(&[("poses.txt", "no poses")]);
    let scan = Scan::open_with(folder.path(), &options).unwrap();
    assert_eq!(places(&scan), [1.0, 2.0, 3.0]);
    assert_eq!((scan.inputs.len(), &scan.inputs[0]), (4, &path));
}

#[test]
fn poses_that_do_not_fit_are_refused_by_file_and_line() {
    let none = open(&[]).unwrap_err();
    assert!(none.contains("3 clouds without poses; pass the setting `poses`, a file"), "{none}");
    let few = open(&[("poses.txt", &KITTI[..24])]).unwrap_err();
    assert!(few.contains("poses.txt: the file has 1 poses; expected one for each of the 3"));
    let word = open(&[("poses.txt", &KITTI.replacen('2', "two", 1))]).unwrap_err();
    assert!(word.ends_with("poses.txt, line 2: \"two\" is no number"), "{word}");
    let short = open(&[("poses.txt", "1 2 3 4 5 6 7\n")]).unwrap_err();
    assert!(short.contains("line 1: the line has 7 words; a trajectory begins with"), "{short}");
    let timed = open(&[("poses.txt", "10.5 0 0 0 0 0 0 1\n")]).unwrap_err();
    assert!(timed.contains("poses.txt: the poses have times, but the clouds have none"), "{timed}");
    let shear = open(&[("poses.txt", &KITTI.replacen("1 0 0 1", "2 0 0 1", 1))]).unwrap_err();
    assert!(shear.contains("line 1: the pose is no rotation"), "{shear}");
    let missing = open(&[("a.pose.txt", &shift(1.0))]).unwrap_err();
    assert!(missing.contains("b.pose.txt: 2 of 3 clouds have no file NAME.pose.txt"), "{missing}");
    let mixed = open(&[("poses.txt", KITTI), ("d.pcd", "")]).unwrap_err();
    assert!(mixed.contains("the folder has 1 *.pcd, 3 *.ply and 0 *.bin"), "{mixed}");
}

/// world-from-camera · camera-from-lidar is world-from-lidar.
#[test]
fn kittis_calibration_turns_poses_of_the_camera_into_those_of_the_lidar() {
    let calib = "P0: 1 2 3\nTr: 0 -1 0 0.5 0 0 -1 0 1 0 0 0\n";
    let folder = folder(&[("poses.txt", KITTI), ("calib.txt", calib)]);
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(places(&scan), [1.5, 2.5, 3.5]);
    let ahead = scan.views[0].world_from_sensor() * Vector3::x();
    assert!((ahead - Vector3::z()).norm() < 1e-12, "the lidar's x is the camera's z: {ahead}");
    assert!(scan.notes[1].to_string().contains("calib.txt: \"Tr:\" turns"), "{:?}", scan.notes);
    std::fs::write(folder.path().join("calib.txt"), calib.replace("0 -1 0 0.5", "0 -1.001 0 0.5"))
        .unwrap();
    let scan = Scan::open(folder.path()).unwrap();
    let note = "calib.txt: 1 of 1 poses replaced by the nearest rotation";
    assert!(scan.notes.iter().any(|found| found.to_string().contains(note)), "{:?}", scan.notes);
}

#[test]
fn the_real_pair_opens_without_arguments_and_lies_on_itself() {
    let Some(folder) = crate::test_data::shared("lidar_pair_hdl32") else { return };
    let scan = Scan::open(&folder).unwrap();
    let names: Vec<_> = scan.views.iter().map(ScanView::name).collect();
    assert_eq!(names, ["source.ply", "target.ply"]);
    assert_eq!(row_major(scan.views[1].world_from_sensor())[3], 0.0, "target is the world");
    let grids: Vec<_> = scan.views.iter().map(|v| v.load().unwrap()).collect();
    for ((view, notes), firings) in grids.iter().zip([2181, 2159]) {
        assert_eq!((view.image().size().rows, view.image().size().cols), (32, firings));
        assert!(view.frame().columns_wrap(), "a full turn");
        assert!(
            notes[0].text.contains(&format!("{firings} firings of 32 lasers found")),
            "{notes:?}"
        );
        assert!(notes[1].text.contains("from 10.67° down to -30.67°"), "{notes:?}");
    }
    let seen = |number: usize, pose: &Isometry3| -> Vec<Point3> {
        let (view, _) = &grids[number];
        let pixels = view.image().size().all_pixels();
        let points = pixels.filter_map(|p| view.frame().point(p, view.image().get(p)?.into()));
        points.map(|p| pose * p).collect()
    };
    let target = seen(1, &Isometry3::identity());
    let median = |pose: &Isometry3| {
        let source = seen(0, pose);
        let nearest = |p: &Point3| {
            target.iter().map(|q| (p - q).norm_squared()).fold(f64::INFINITY, f64::min).sqrt()
        };
        transect_device::median(source.iter().step_by(50).map(nearest)).unwrap()
    };
    // The data's own page states 0.047 m, 0.068 m without the pose and 0.162 m with its inverse.
    let (placed, unmoved) =
        (median(scan.views[0].world_from_sensor()), median(&Isometry3::identity()));
    assert!(placed < 0.05 && unmoved > 0.06, "{placed} m, without the pose {unmoved} m");
}
