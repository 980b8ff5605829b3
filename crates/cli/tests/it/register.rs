//! Poses on the command line: refined, read by another convention, and what is refused.

use super::common::{Folder, conjugate};
use serde_json::Value;
use transect::nalgebra::{Isometry3, Vector3};
use transect_exchange::{pose_of_row_major, row_major};

fn numbers(view: &Value) -> [f64; 16] {
    serde_json::from_value(view["pose"].clone()).unwrap()
}

fn pose(view: &Value) -> Isometry3<f64> {
    pose_of_row_major(&numbers(view)).unwrap().0
}

/// A scan of the bundled machined part whose second view is off by 0.5° and 1 mm.
fn perturbed() -> Folder {
    let folder = Folder::empty();
    folder.run("simulate machined_part --out scan").succeeded();
    folder.edit_json("scan/scan.json", "scan/off.json", |m| {
        let by = Isometry3::new(Vector3::new(0.6, -0.5, 0.6), Vector3::new(0.006, 0.005, -0.004));
        let moved = pose(&m["views"][1]) * by;
        m["views"][1]["pose"] = serde_json::to_value(row_major(&moved)).unwrap();
    });
    folder
}

#[test]
fn a_registered_scan_is_a_scan_with_the_same_files_and_names() {
    let folder = perturbed();
    let run = folder.run("register scan/off.json --out new --quiet").succeeded();
    assert!(run.stdout.contains("| outcome "), "{}", run.stdout);
    assert!(run.stdout.contains("transect reconstruct new/scan.json"), "{}", run.stdout);
    let (old, new) = (folder.json("scan/off.json"), folder.json("new/scan.json"));
    let views = |m: &Value| m["views"].as_array().unwrap().clone();
    assert_eq!(views(&new).len(), views(&old).len());
    for (old, new) in views(&old).iter().zip(views(&new)) {
        assert_eq!(new["name"], old["file"]);
        assert_eq!(new["file"], format!("../scan/{}", old["file"].as_str().unwrap()));
        assert_eq!((&new["sensor"], &new["rows"]), (&old["sensor"], &old["rows"]));
    }
    assert_eq!((&new["planes"], &new["unit"]), (&old["planes"], &old["unit"]));
    let report = folder.json("new/report.json");
    assert_eq!(report["poses"].as_array().unwrap().len(), views(&old).len());
    assert_eq!(report["poses"][1]["view"], views(&old)[1]["file"]);
    // The scan with refined poses gives the model of one run that refines them.
    let two = folder.run("reconstruct new --out two --quiet").succeeded();
    let one = "reconstruct scan/off.json --refine-poses --no-score --out one --quiet";
    let one = folder.run(one).succeeded();
    // A matrix in a file is rounded, so the poses differ in their last digits.
    assert!((one.number("nodes") / two.number("nodes") - 1.0).abs() < 1e-3);
    for (view, refined) in views(&new).iter().zip(report["poses"].as_array().unwrap()) {
        let refined: Isometry3<f64> =
            serde_json::from_value(refined["world_from_sensor"].clone()).unwrap();
        assert!((pose(view).to_homogeneous() - refined.to_homogeneous()).amax() < 1e-9);
    }
    let moved = pose(&views(&old)[1]).inverse() * pose(&views(&new)[1]);
    assert!(moved.translation.vector.norm() > 0.3, "the view that was off stays there");
    assert_eq!(folder.json("one/report.json")["poses"]["poses"], report["poses"]);
    folder.run("register new --out same --quiet").succeeded();
    for (first, second) in views(&new).iter().zip(views(&folder.json("same/scan.json"))) {
        assert!(first["surface_sigma"].is_number());
        assert_eq!(
            [&first["pose"], &first["surface_sigma"]],
            [&second["pose"], &second["surface_sigma"]]
        );
    }
    let part = folder.run("register scan/off.json --views 1,2 --out part --quiet").succeeded();
    assert_eq!(views(&folder.json("part/scan.json")).len(), 2, "{}", part.stdout);
    // The scan of the same images is replaced, that of other ones is not.
    folder.run("register scan/off.json --views 1,2 --out part --quiet").succeeded();
    let refused = ["part/scan.json", "register wrote it for another scan", "another --out"];
    folder.run("register scan --out part").failed_with(1, &refused);
}

/// Takes the inverse of each pose.
fn invert(manifest: &mut Value) {
    for view in manifest["views"].as_array_mut().unwrap() {
        let inverse = row_major(&pose(view).inverse());
        view["pose"] = serde_json::to_value(inverse).unwrap();
    }
}

#[test]
fn poses_of_another_convention_are_read_as_asked_for() {
    let folder = Folder::simulated("objects.scene.toml");
    let right = folder.reconstruct("scan --no-score").succeeded();
    folder.edit_json("scan/scan.json", "scan/inverse.json", invert);
    let line = "scan/inverse.json --pose-convention inverse";
    let read = folder.reconstruct(&format!("{line} --no-score")).succeeded();
    // The inverse is rounded.
    let as_right = |run: &super::common::Run| run.number("nodes") / right.number("nodes") - 1.0;
    assert!(as_right(&read).abs() < 1e-2);
    assert!(read.stderr.contains("sensor from world, not world from sensor"), "{}", read.stderr);
    assert_eq!(folder.json("out/report.json")["pose_convention"], "inverse");
    let inspected = folder.run(&format!("inspect {line}")).succeeded().stdout;
    assert!(inspected.contains(&format!("reconstruct {line}")), "{inspected}");
    // Written anew, the poses need no option.
    folder.run(&format!("register {line} --out new --quiet")).succeeded();
    let anew = folder.reconstruct("new --no-score").succeeded();
    assert!(as_right(&anew).abs() < 0.05);
    let refused = ["--store", "transect register SCAN --pose-convention inverse --out"];
    folder.run(&format!("reconstruct {line} --store s.transect")).failed_with(2, &refused);
    // The quaternions of one view rotate the other way round: the option is for all views.
    folder.edit_json("scan/scan.json", "scan/one.json", |m| conjugate(m, 0));
    folder.edit_json("scan/one.json", "scan/all.json", |m| (1..4).for_each(|k| conjugate(m, k)));
    folder.reconstruct("scan/all.json --pose-convention conjugate --no-score").succeeded();
}

/// Refinement turns these views by up to 3.5°, moves them by 0.3 m, and leaves only regions that
/// contradict.
#[test]
fn refinement_does_not_hide_a_convention() {
    let folder = Folder::empty();
    folder.run("simulate kitchen --out scan").succeeded();
    folder.edit_json("scan/scan.json", "scan/y_up.json", |m| {
        for view in m["views"].as_array_mut().unwrap() {
            let mut pose = numbers(view);
            pose.chunks_mut(4).take(3).flat_map(|row| &mut row[1..3]).for_each(|n| *n = -*n);
            view["pose"] = serde_json::to_value(pose).unwrap();
        }
    });
    let refused = ["y_up.json", "Pass --pose-convention camera-y-up"];
    folder.run("register scan/y_up.json --out new --quiet").failed_with(1, &refused);
    assert!(!folder.path("new/scan.json").exists());
    folder.run("register scan --out new --quiet").succeeded();
}

#[test]
fn inspect_names_a_wrong_view_and_the_convention_that_mends_all() {
    let folder = perturbed();
    let warnings = |scan: &str| {
        let run = folder.run(&format!("inspect {scan}")).succeeded();
        run.told("warning:").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(warnings("scan"), [""; 0], "sound poses");
    let wrong = warnings("scan/off.json");
    assert!(wrong.len() == 1 && wrong[0].contains("view range_001.npy contradicts"), "{wrong:?}");
    let run = folder.run("reconstruct scan/off.json --no-score --out off --quiet").succeeded();
    let told = run.told("warning:");
    assert!(told.len() == 1 && told[0].contains("view range_001.npy contradicts"), "{told:?}");
    assert_eq!(
        folder.json("off/report.json")["poses"]["judgement"]["findings"][0]["kind"],
        "misplaced"
    );
    let run = folder.run("reconstruct scan --no-score --out right --quiet").succeeded();
    assert!(run.told("warning:").is_empty(), "{}", run.stderr);
    assert!(folder.json("right/report.json")["poses"].is_null());
    folder.edit_json("scan/scan.json", "scan/inverse.json", invert);
    let wrong = warnings("scan/inverse.json");
    assert!(wrong.len() == 1 && wrong[0].ends_with("Pass --pose-convention inverse"), "{wrong:?}");
}

/// A convention that the poses do not have is taken back, whichever it is.
#[test]
fn a_wrong_convention_is_taken_back() {
    let folder = perturbed();
    folder.edit_json("scan/scan.json", "scan/inverse.json", invert);
    for (scan, convention, advice) in [
        ("scan", "inverse", "Leave out --pose-convention"),
        ("scan", "radians", "Leave out --pose-convention"),
        ("scan/inverse.json", "conjugate", "Pass --pose-convention inverse"),
    ] {
        let line = format!("{scan} --pose-convention {convention}");
        let run = folder.run(&format!("inspect {line}")).succeeded();
        let wrong = run.told("warning:");
        assert!(wrong.len() == 1 && wrong[0].ends_with(advice), "{line}: {wrong:?}");
        let run = folder.run(&format!("reconstruct {line} --no-score --out wrong --quiet"));
        assert!(run.succeeded().told("warning:")[0].ends_with(advice), "{line}");
    }
}

/// Misread poses are no start for a refinement.
#[test]
fn misread_poses_are_not_refined() {
    let folder = perturbed();
    folder.edit_json("scan/scan.json", "scan/inverse.json", invert);
    let line = "scan/inverse.json --quiet";
    let refused = ["inverse.json", "Pass --pose-convention inverse"];
    folder.run(&format!("register {line} --out new")).failed_with(1, &refused);
    assert!(!folder.path("new/scan.json").exists());
    let line = format!("reconstruct {line} --refine-poses --no-score --out misread");
    assert!(folder.run(&line).succeeded().stderr.contains("Pass --pose-convention inverse"));
    assert!(folder.json("misread/report.json")["poses"]["left_out_pairs"].is_null());
    // A store of them, whose commands name views as the store does.
    let line = "reconstruct scan/inverse.json --no-score --prefix day1/ --store s.transect";
    folder.run(&format!("{line} --out grown --quiet")).succeeded();
    let advice = ["read another way", "registered with --pose-convention inverse"];
    folder.run("register s.transect --quiet").failed_with(1, &advice);
    let line = "reconstruct scan --no-score --prefix day1/ --store right.transect";
    folder.run(&format!("{line} --out grown --quiet")).succeeded();
    let run = folder.run("register right.transect --quiet").succeeded();
    assert!(run.stdout.contains("| day1/range_001.npy | "), "{}", run.stdout);
}

/// The poses are in millimetres, as the scan states, and the images in metres.
#[test]
fn images_in_another_unit_than_the_poses_are_told() {
    let folder = perturbed();
    folder.edit_json("scan/scan.json", "scan/images.json", |m| {
        m["views"].as_array_mut().unwrap().iter_mut().for_each(|view| view["scale"] = 0.001.into());
    });
    let run = folder.run("inspect scan/images.json").succeeded();
    let wrong = run.told("warning:");
    let advice = "correct the images: multiply their \"scale\" in scan.json, or --depth-scale of a \
                  folder of depth images, by 1000; without a scale, state 1000. E57, PTX, PCD and \
                  PLY files have no scale: export them with coordinates that are multiplied by \
                  1000. Or state \"unit\": \"m\" in scan.json, or --unit m for another format, and \
                  pass --pose-convention millimetres";
    assert!(wrong.len() == 2 && wrong[1].ends_with(advice), "{wrong:?}");
    assert!(wrong[0].contains("reconstruct stops: the two nearest"), "{wrong:?}");
}

#[test]
fn images_in_another_order_are_named_and_read_as_asked_for() {
    let folder = Folder::empty();
    folder.run("simulate face_mask --out scan").succeeded();
    let right = folder.reconstruct("scan --no-score").succeeded().number("nodes");
    // Read upside down, images that are right are those of files that are upside down.
    folder.edit_json("scan/scan.json", "scan/wrong.json", |m| {
        let views = m["views"].as_array_mut().unwrap();
        views.iter_mut().for_each(|view| view["image_order"] = "upside-down".into());
    });
    let warnings = |scan: &str| {
        let run = folder.run(&format!("inspect {scan}")).succeeded();
        run.told("warning:").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(!warnings("scan/wrong.json").is_empty());
    for file in ["range_000.npy", "range_001.npy", "range_002.npy", "range_003.npy"] {
        let bytes = std::fs::read(folder.path("scan").join(file)).unwrap();
        let rows = folder.json("scan/scan.json")["views"][0]["rows"].as_u64().unwrap() as usize;
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let row = (bytes.len() - start) / rows;
        let mut turned = bytes[..start].to_vec();
        turned.extend(bytes[start..].chunks(row).rev().flatten());
        std::fs::write(folder.path("scan").join(file), turned).unwrap();
    }
    let wrong = warnings("scan");
    assert!(
        wrong.len() == 1 && wrong[0].contains("Pass --image-order upside-down if"),
        "{wrong:?}"
    );
    let line = "scan --image-order upside-down";
    assert_eq!(
        folder.reconstruct(&format!("{line} --no-score")).succeeded().number("nodes"),
        right
    );
    let refused = ["transect register SCAN --image-order upside-down --out DIR"];
    folder.run(&format!("reconstruct {line} --store s.transect")).failed_with(2, &refused);
    // The images of a store that was made of it are read again, too.
    folder.run("reconstruct scan --store s.transect --no-score --out grown --quiet").succeeded();
    folder
        .run("register s.transect --quiet")
        .failed_with(1, &["registered with --image-order upside-down"]);
    folder.run(&format!("register {line} --out new --quiet")).succeeded();
    assert_eq!(folder.json("new/scan.json")["views"][0]["image_order"], "upside-down");
    let points = folder.run("inspect new").succeeded();
    assert!(points.told("warning:").is_empty(), "{}", points.stderr);
}

#[test]
fn what_cannot_be_registered_is_refused() {
    let folder = Folder::simulated("objects.scene.toml");
    let prior = |prior: &str| format!("register scan --out new --prior {prior}");
    for (text, wanted) in [
        ("-1,2", "--prior: -1,2: the angle is not between 0 and 180 degrees"),
        ("1", "there is no comma"),
        ("1,-2mm", "the length is not positive"),
    ] {
        folder.run(&prior(text)).failed_with(2, &[wanted, "DEGREES,LENGTH"]);
    }
    for command in ["register scan --out new", "reconstruct scan", "inspect scan"] {
        let line = format!("{command} --pose-convention nonsense");
        folder.run(&line).failed_with(2, &["--pose-convention", "inverse", "camera-y-up", "wxyz"]);
    }
    folder.run("register scan").failed_with(2, &["--out DIR"]);
    folder
        .run("register scan --out scan")
        .failed_with(1, &["scan.json", "would replace the input"]);
    folder.reconstruct("scan").succeeded();
    folder.run("register scan --out out").failed_with(1, &["model.transect", "another --out"]);
    folder.run("register out").failed_with(1, &["a plain model file"]);
    std::fs::create_dir(folder.path("taken")).unwrap();
    folder.write("taken/scan.json", "{}");
    folder.run("register scan --out taken").failed_with(1, &["taken/scan.json", "\"tool\""]);
    folder.run("simulate face_mask --out mask").succeeded();
    let before = folder.bytes("mask/scan.json");
    let refused = ["mask/scan.json", "transect simulate wrote it", "Choose another --out"];
    folder.run("register scan --out mask").failed_with(1, &refused);
    assert_eq!(folder.bytes("mask/scan.json"), before);
    folder.run("reconstruct scan --refine-poses --store s.transect").failed_with(2, &["--store"]);
    folder.run("reconstruct scan --prior 1,2").failed_with(2, &["--refine-poses"]);
    folder.run("reconstruct scan --store s.transect --out grown --quiet").succeeded();
    folder.run("register s.transect --out new").failed_with(2, &["leave out --out"]);
    folder.run("register s.transect --views 1").failed_with(2, &["choose a part"]);
    assert!(!folder.path("new").exists());
}

#[test]
fn the_views_of_a_store_are_registered_as_those_of_their_scan() {
    let folder = perturbed();
    folder.run("reconstruct scan/off.json --store s.transect --out grown --quiet").succeeded();
    let run = folder.run("register s.transect --quiet").succeeded();
    assert!(run.stdout.contains(&format!("\nviews moved{:>13}\n", 1)), "{}", run.stdout);
    folder.run("verify s.transect --fusion").succeeded();
    folder.run("export s.transect --out stored").succeeded();
    folder
        .run("reconstruct scan/off.json --refine-poses --no-score --out once --quiet")
        .succeeded();
    assert!(folder.bytes("stored/contours.json") == folder.bytes("once/contours.json"));
    // Refined poses are not refined again.
    let again = folder.run("register s.transect --quiet").succeeded();
    assert!(again.stdout.contains(&format!("\nviews updated{:>11}\n", 0)), "{}", again.stdout);
    let reason = "the store has the refined poses already";
    assert!(again.stderr.contains(reason), "{}", again.stderr);
    // The scan still has the poses that it was added with.
    let added = folder.run("reconstruct scan/off.json --store s.transect --out grown --quiet");
    added.succeeded();
    // An image that is not the store's is refused, and nothing changes.
    let other = folder.bytes("scan/range_000.npy");
    folder.write("scan/range_001.npy", other);
    let refused = ["range_001.npy", "another image", "transect replace-view"];
    folder.run("register s.transect --quiet").failed_with(1, &refused);
    folder.run("export s.transect --out after").succeeded();
    assert!(folder.bytes("stored/contours.json") == folder.bytes("after/contours.json"));
}
