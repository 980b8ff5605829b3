//! Scans that are valid, but most likely wrong, are stopped with the likely cause.

use super::bad_input::{SIDE, manifest, npy, npy_header, refused, scan_of};
use super::common::Folder;
use serde_json::{Value, json};

/// A single camera's scan of a slope, with one thing spoiled, what is said, and what accepts it.
type Implausible = (fn(&mut Value), &'static str, &'static [&'static str]);

#[test]
fn implausible_scans_are_stopped_before_the_work_and_can_be_accepted() {
    let cases: &[Implausible] = &[
        // A depth image in millimetres that is declared as metres.
        (
            |m| {
                m["views"][0]["file"] = "wall.png".into();
                m["views"][0]["depth_scale"] = json!(1.0);
            },
            "planes --accept extent",
            &["view wall.png", "planes lie between neighbouring pixels", "\"scale\""],
        ),
        // Angles whose range the sensor leaves open; degrees in the place of radians.
        (
            |m| m["views"][0] = turning(-57.0),
            "angles",
            &["view wall.npy", "theta0 = -57 rad", "full circle", "multiply it by π/180"],
        ),
        (
            |m| m["views"][0]["file"] = "holes.npy".into(),
            "valid-pixels",
            &["view holes.npy", "only 4 of 1440 pixels are valid", "at least 1 %"],
        ),
        // Poses in millimetres.
        (
            |m| {
                let mut other = m["views"][0].clone();
                other["pose"][3] = json!(900.0);
                m["views"].as_array_mut().unwrap().push(other);
                m["views"][1]["file"] = "wall.png".into();
                m["views"][1]["depth_scale"] = json!(0.001);
            },
            "distance",
            &[
                "nearest of the 2 sensors are 900.0000 m apart: those of views wall.npy and wall.png",
                "twice. View wall.npy has no pose, it seems",
                "same unit: --pose-convention millimetres",
            ],
        ),
    ];
    for (spoil, check, texts) in cases {
        let mut manifest = manifest();
        spoil(&mut manifest);
        let folder = scan_of(&manifest);
        let mut holes = vec![0.0; 12 * 120];
        [500, 501, 620, 621].iter().for_each(|k| holes[*k] = 1.0 + 0.1 * (k % 2) as f32);
        folder.write("holes.npy", npy(&holes));
        let first = check.split(' ').next().unwrap();
        refused(&folder, "scan.json", &[&format!("pass --accept {first}")]);
        refused(&folder, "scan.json", texts);
        inspection_warns(&folder, "scan.json", texts);
        inspection_warns(&folder, "scan.json", &[&format!("pass --accept {first}")]);
        let accepted = folder.reconstruct(&format!("scan.json --accept {check}"));
        assert!(!accepted.stderr.contains("--accept"), "{check}: {}", accepted.stderr);
    }
    let unknown = scan_of(&manifest()).reconstruct("scan.json --accept everything");
    unknown.failed_with(2, &["--accept", "valid-pixels"]);
}

/// `inspect` warns of what `reconstruct` refuses.
fn inspection_warns(folder: &Folder, scan: &str, texts: &[&str]) {
    let inspected = folder.run(&format!("inspect {scan}")).succeeded();
    let warnings = inspected.told("warning: reconstruct stops").join("\n");
    assert!(texts.iter().all(|text| warnings.contains(text)), "{texts:?}: {}", inspected.stderr);
}

/// Two new views far from each other, on both sides of the store's view.
#[test]
fn views_of_a_store_count_as_neighbours_of_new_ones() {
    let mut manifest = manifest();
    let folder = scan_of(&manifest);
    let add = |scan: &str| folder.reconstruct(&format!("{scan} --store s.transect"));
    let mut other = manifest["views"][0].clone();
    (other["file"], other["depth_scale"]) = (json!("wall.png"), json!(0.001));
    (manifest["views"][0]["pose"][3], other["pose"][3]) = (json!(-9.0), json!(9.0));
    manifest["views"].as_array_mut().unwrap().push(other);
    folder.write("both.json", serde_json::to_vec(&manifest).unwrap());
    let alone = ["18.0000 m apart: those of views wall.npy and wall.png", "twice. Check that"];
    add("both.json --prefix new-").failed_with(1, &alone);
    add("scan.json").succeeded();
    let run = add("both.json --prefix new-").succeeded();
    assert_eq!((run.number("views added"), run.number("views")), (2.0, 3.0));
}

#[test]
fn the_report_names_the_checks_that_were_turned_off() {
    let folder = Folder::simulated("objects.scene.toml");
    let accepted = |options: &str| {
        folder.reconstruct(&format!("scan {options}")).succeeded();
        folder.json("out/report.json")["accepted"].clone()
    };
    assert!(accepted("").is_null());
    assert_eq!(accepted("--accept distance --accept extent"), json!(["distance", "extent"]));
}

/// Images of half the size, beside the camera of the whole ones.
#[test]
fn a_camera_of_larger_images_is_told() {
    let folder = Folder::empty();
    let scene = std::fs::read_to_string(super::common::fixture("objects.scene.toml")).unwrap();
    let (objects, _) = scene.split_once("[[station]]").unwrap();
    let stations = [[-3.0, -0.4, 0.9], [-0.5, -3.0, 0.9]].map(|at| {
        format!(
            "[[station]]\nname = \"at {at:?}\"\nsensor = \"pinhole\"\nrows = 100\ncols = 120\n\
             field_of_view = 55\nat = {at:?}\nlook_at = [0, 0, 0.5]\n"
        )
    });
    folder.write("cameras.scene.toml", format!("{objects}{}", stations.concat()));
    folder.run("simulate cameras.scene.toml --out scan").succeeded();
    folder.run("reconstruct scan --out sound").succeeded();
    let scaled = |name: &str, views: usize, factor: f64| {
        folder.edit_json("scan/scan.json", &format!("scan/{name}.json"), |manifest| {
            for view in manifest["views"].as_array_mut().unwrap().iter_mut().take(views) {
                for key in ["fx", "fy", "cx", "cy"] {
                    view[key] = json!(factor * view[key].as_f64().unwrap());
                }
            }
        });
        format!("scan/{name}.json")
    };
    for (factor, size) in [(2.0, "200 rows × 240 columns"), (0.5, "50 rows × 60 columns")] {
        let scan = scaled("other", 2, factor);
        let texts =
            ["100 rows × 120 columns", size, "Divide fx, fy", "--camera", "--accept camera"];
        refused(&folder, &scan, &texts);
        inspection_warns(&folder, &scan, &texts);
        let accepted = folder.run(&format!("reconstruct {scan} --accept camera --out accepted"));
        assert!(!accepted.stderr.contains("--accept"), "{}", accepted.stderr);
    }
    // One corner of a larger image in one view alone.
    let one = folder.reconstruct(&scaled("one", 1, 2.0));
    assert!(!one.stderr.contains("--accept camera"), "{}", one.stderr);
}

/// Points in a national grid, as 32-bit numbers: their steps are half a metre.
#[test]
fn coordinates_that_their_number_type_does_not_resolve_are_stopped() {
    let folder = Folder::empty();
    let points = |north: f64| -> Vec<f64> {
        let point = |k: usize| {
            let (row, col) = ((k / SIDE) as f64, (k % SIDE) as f64);
            [0.03 * col, north + 0.03 * row, 2.0 + 0.01 * col]
        };
        (0..SIDE * SIDE).flat_map(point).collect()
    };
    let shape = format!("({SIDE}, {SIDE}, 3)");
    let single = |north| points(north).iter().flat_map(|c| (*c as f32).to_le_bytes()).collect();
    let double: Vec<u8> = points(5_400_000.0).iter().flat_map(|c| c.to_le_bytes()).collect();
    let header64 =
        String::from_utf8(npy_header(&shape)[10..].to_vec()).unwrap().replace("f4", "f8");
    let header64 = [&npy_header(&shape)[..10], header64.as_bytes()].concat();
    folder.write("near.npy", [npy_header(&shape), single(0.0)].concat());
    folder.write("far.npy", [npy_header(&shape), single(5_400_000.0)].concat());
    folder.write("double.npy", [header64, double].concat());
    for name in ["near", "far", "double"] {
        let north = if name == "near" { 0.0 } else { 5_400_000.0 };
        let manifest = json!({
            "unit": "m",
            "planes": { "normal": [1, 0, 0], "offset": 0.0, "interval": 0.05 },
            "views": [ {
                "file": format!("{name}.npy"), "sensor": "grid", "viewpoint": [0.2, north, -3],
                "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
            } ]
        });
        folder.write(&format!("{name}.json"), serde_json::to_vec(&manifest).unwrap());
    }
    refused(&folder, "far.json", &["far.npy", "32-bit", "subtract an offset", "resolution"]);
    folder.reconstruct("near.json").succeeded();
    folder.reconstruct("double.json").succeeded();
}

/// A cloud of a room with a pillar, in the world's frame.
#[test]
fn the_viewpoint_of_a_cloud_in_the_world_is_found() {
    let folder = Folder::empty();
    let point = |k: usize| {
        let (theta, phi) = (0.07 * (k % 90) as f64, -1.0 + 0.03 * (k / 90) as f64);
        let d = [phi.cos() * theta.cos(), phi.cos() * theta.sin(), phi.sin()];
        let reach = [5.0, 4.0, 1.5].iter().zip(&d).map(|(half, d)| half / d.abs());
        let reach = reach.fold(f64::INFINITY, f64::min) * if d[0] > 0.9 { 0.4 } else { 1.0 };
        let [x, y, z] = d.map(|d| d * reach);
        format!("{:.9} {:.9} {:.9}\n", 100.0 + x, 50.0 + y, 10.0 + z)
    };
    let points: Vec<String> = (0..60 * 90).map(point).collect();
    let head = "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 90\nHEIGHT 60\n\
                POINTS 5400\nDATA ascii\n";
    folder.write("room.pcd", format!("{head}{}", points.concat()));
    let run =
        folder.reconstruct("room.pcd --normal 0,0,1 --offset 10.1 --interval 0.3").succeeded();
    assert!(run.stderr.contains("but from (100.000, 50.000, 10.000)"), "{}", run.stderr);
    let inside = folder.run("query out 101.5,50,10.1 102.5,50,10.1").succeeded();
    assert!(inside.stdout.contains("outside") && inside.stdout.contains("inside"), "{inside:?}");
}

/// A floor at the height of plane 0.
#[test]
fn planes_in_faces_are_told() {
    let folder = Folder::empty();
    folder.run("simulate room --out scan").succeeded();
    let run = |offset: &str| {
        let options = format!("--normal 0,0,1 --interval 50cm --offset {offset} --no-score");
        folder.reconstruct(&format!("scan {options}")).succeeded().stderr
    };
    let told = run("0");
    assert!(told.contains("plane 0 lies in a face") && told.contains("--offset 0.25"), "{told}");
    assert_eq!(run("0.22"), "");
    // The floor is left out, and with it the face.
    assert_eq!(run("0 --crop ,,,,0.1,"), "");
}

/// The room is 2.8 m high, with its floor at 0.
#[test]
fn advice_to_move_planes_moves_them_within_the_scan() {
    let folder = Folder::empty();
    folder.run("simulate room --out scan").succeeded();
    let run = |offset: &str, interval: &str| {
        let options = format!("--normal 0,0,1 --interval {interval} --offset {offset} --no-score");
        folder.reconstruct(&format!("scan {options}")).succeeded().stderr
    };
    for interval in ["5m", "10m", "100m"] {
        let told = run("0", interval);
        let (_, advice) =
            told.split_once("such as by --offset ").unwrap_or_else(|| panic!("{told}"));
        let told = run(advice.trim(), interval);
        assert!(!told.contains("lies in a face"), "{interval}: {advice}: {told}");
    }
}

/// The room is 2.8 m high.
#[test]
fn a_plane_crosses_the_room_whatever_the_interval() {
    let folder = Folder::empty();
    folder.run("simulate room --out scan").succeeded();
    folder.edit_json("scan/scan.json", "scan/scan.json", |scan| {
        scan.as_object_mut().unwrap().remove("planes");
    });
    for interval in ["5m", "10m", "100m"] {
        let run = folder.reconstruct(&format!("scan --interval {interval} --no-score"));
        assert!(run.succeeded().stderr.contains(&format!("--interval {interval}")));
    }
    let missed = "scan --normal 0,0,1 --offset 10 --interval 20 --no-score";
    let run = folder.reconstruct(missed);
    run.failed_with(1, &["no section plane crosses", "No plane lies between these stations"]);
    let (_, advice) = run.stderr.split_once("; --offset ").unwrap();
    let advice: String = advice.split_whitespace().take(1).collect();
    folder.reconstruct(&missed.replace("--offset 10", &format!("--offset {advice}"))).succeeded();
}

/// A header with its two numbers exchanged makes neighbours of points that are far apart.
#[test]
fn exchanged_rows_and_columns_are_told() {
    let folder = Folder::empty();
    let point = |row: usize, col: usize, turn: f64| {
        let (azimuth, height) = (turn * col as f64 / 50.0, 0.7 - 0.05 * row as f64);
        let range = 3.0 + 0.3 * (3.0 * azimuth).sin();
        format!("{:.4} {:.4} {:.4}", range * azimuth.cos(), range * azimuth.sin(), range * height)
    };
    let scans = [("sector", 1.2), ("circle", std::f64::consts::TAU)];
    for (name, turn) in scans {
        let down: Vec<_> =
            (0..50 * 30).map(|k| format!("{} .5\n", point(k % 30, k / 30, turn))).collect();
        let along: Vec<_> =
            (0..50 * 30).map(|k| format!("{}\n", point(k / 50, k % 50, turn))).collect();
        for (order, rows, cols) in [("right", 30, 50), ("wrong", 50, 30)] {
            let axes = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
            let ptx = format!("{cols}\n{rows}\n{axes}{}", down.concat());
            folder.write(&format!("{name}_{order}.ptx"), ptx);
            let pcd = format!(
                "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {cols}\n\
                 HEIGHT {rows}\nPOINTS 1500\nDATA ascii\n{}",
                along.concat()
            );
            folder.write(&format!("{name}_{order}.pcd"), pcd);
        }
        let texts = ["rows and columns", "30 rows and 50 columns", "pass --accept order"];
        refused(&folder, &format!("{name}_wrong.pcd"), &texts);
        inspection_warns(&folder, &format!("{name}_wrong.pcd"), &texts);
        // Every column of the grid holds two columns of the scanner.
        let right = std::fs::read_to_string(folder.path(&format!("{name}_right.ptx"))).unwrap();
        folder.write(&format!("{name}_double.ptx"), right.replacen("50\n30\n", "25\n60\n", 1));
        for (wrong, stated) in
            [("wrong", "30 columns and 50 rows"), ("double", "25 columns and 60 rows")]
        {
            let expected = "line 1: view 0 (scan 0): the lines state";
            let texts = [expected, stated, "expected 50 columns and 30 rows", "the next one"];
            refused(&folder, &format!("{name}_{wrong}.ptx"), &texts);
        }
    }
    for (name, kind) in scans.iter().flat_map(|(name, _)| ["ptx", "pcd"].map(|kind| (name, kind))) {
        folder.reconstruct(&format!("{name}_right.{kind}")).succeeded();
    }
}

/// A PTX file in millimetres has no key for its unit.
#[test]
fn advice_on_units_names_the_option_of_files_of_points() {
    let folder = Folder::empty();
    let point = |k: usize| {
        let (azimuth, height) = (0.02 * (k / 30) as f64, 0.7 - 0.05 * (k % 30) as f64);
        let [x, y, z] = [azimuth.cos(), azimuth.sin(), height].map(|c| 3000.0 * c);
        format!("{x:.1} {y:.1} {z:.1} .5\n")
    };
    let points: String = (0..50 * 30).map(point).collect();
    let axes = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    folder.write("millimetres.ptx", format!("50\n30\n{axes}{points}"));
    let texts = ["at most 0.5 m", "--unit for PTX", "in scan.json", "pass --accept extent"];
    refused(&folder, "millimetres.ptx", &texts);
    folder.reconstruct("millimetres.ptx --unit mm").succeeded();
}

/// Points of a PTX file may be in the world's frame, with the scanner's place beside them. A pillar
/// in a room shows from where it was seen.
#[test]
fn inspection_states_where_rays_begin() {
    let folder = Folder::empty();
    let point = |k: usize| {
        let (azimuth, height) = (0.07 * (k / 60) as f64, -1.0 + 0.03 * (k % 60) as f64);
        let [x, y, z] = [azimuth.cos(), azimuth.sin(), height.tan()];
        let wall = (5.0 / x.abs()).min(4.0 / y.abs()).min(1.5 / z.abs());
        let range = if x > 0.9 { 0.4 * wall } else { wall };
        let [x, y, z] = [range * x + 10.0, range * y + 20.0, range * z + 1.5];
        format!("{x:.5} {y:.5} {z:.5} .5\n")
    };
    let points: String = (0..90 * 60).map(point).collect();
    let axes = "1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    folder.write("site.ptx", format!("90\n60\n10 20 1.5\n{axes}{points}"));
    let run = folder.run("inspect site.ptx").succeeded();
    assert!(run.stdout.contains("| 10.0000, 20.0000, 1.5000 |"), "{}", run.stdout);
}

/// Parallel rays, as of a scanner that moves along: the grid of a Stanford file.
#[test]
fn exchanged_rows_and_columns_of_parallel_rays_are_told() {
    let folder = Folder::empty();
    let point = |k: usize| {
        let (x, y) = (0.5 * (k % 50) as f64, 0.5 * (k / 50) as f64);
        format!("{x:.4} {y:.4} {:.4}\n", 3.0 * (0.2 * x).sin() + 0.1 * y)
    };
    let points: String = (0..50 * 30).map(point).collect();
    let grid: String = (0..50 * 30).map(|k| format!("1 {k}\n")).collect();
    for (order, rows, cols) in [("right", 30, 50), ("wrong", 50, 30)] {
        let ply = format!(
            "ply\nformat ascii 1.0\nobj_info num_cols {cols}\nobj_info num_rows {rows}\n\
             element vertex 1500\nproperty float x\nproperty float y\nproperty float z\n\
             element range_grid 1500\nproperty list uchar int vertex_indices\nend_header\n\
             {points}{grid}"
        );
        folder.write(&format!("{order}.ply"), ply);
        folder.write(&format!("{order}.conf"), format!("bmesh {order}.ply 0 0 0 0 0 0 1\n"));
    }
    let options = "--unit mm --normal 0,1,0 --interval 2mm";
    let texts = ["rows and columns", "30 rows and 50 columns", "pass --accept order"];
    refused(&folder, &format!("wrong.conf {options}"), &texts);
    folder.reconstruct(&format!("right.conf {options}")).succeeded();
}

/// A turning scanner's view of the wall, whose first column looks along an angle.
fn turning(theta0: f64) -> Value {
    json!({
        "file": "wall.npy", "sensor": "spherical",
        "theta0": theta0, "dtheta": 0.02, "phi0": -0.1, "dphi": 0.02,
        "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    })
}

/// Depths in millimetres that are declared as metres, on planes that fit them.
#[test]
fn pixels_metres_apart_are_told_to_be_in_another_unit() {
    let mut manifest = manifest();
    manifest["views"][0]["file"] = "wall.png".into();
    manifest["views"][0]["depth_scale"] = json!(1.0);
    manifest["planes"]["interval"] = json!(200);
    let folder = scan_of(&manifest);
    let texts =
        ["view wall.png", "pixels are 125.0000 m apart", "at most 0.5 m", "pass --accept extent"];
    refused(&folder, "scan.json", &texts);
    folder.reconstruct("scan.json --accept extent").succeeded();
}

/// One view in millimetres among views in metres. Its few planes make it look sound.
#[test]
fn a_view_of_another_scale_is_named() {
    let mut manifest = manifest();
    for (file, scale) in [("small.png", 1e-6), ("third.png", 0.001)] {
        let mut view = manifest["views"][0].clone();
        view["file"] = file.into();
        view["depth_scale"] = json!(scale);
        manifest["views"].as_array_mut().unwrap().push(view);
    }
    let folder = scan_of(&manifest);
    for file in ["small.png", "third.png"] {
        folder.write(file, super::bad_input::png());
    }
    let texts = ["view small.png", "differ by a factor of 1000", "pass --accept extent"];
    refused(&folder, "scan.json", &texts);
    inspection_warns(&folder, "scan.json", &texts);
    let accepted = folder.reconstruct("scan.json --accept extent");
    assert!(!accepted.stderr.contains("--accept"), "{}", accepted.stderr);
}

/// The tilt of a lookup table in degrees, and the fan of a light stripe, which is limited anyway.
#[test]
fn angles_of_other_sensors_in_degrees_are_told_to_be_radians() {
    for (sensor, key, texts) in [
        ("lookup_table", "tilt", ["tilt = 30 rad", "full circle", "--accept angles"]),
        ("light_stripe", "fan_angle", ["fan_angle = 30", "between 0 and π", "in radians"]),
    ] {
        let folder = Folder::empty();
        let scene = super::common::fixture("thin_sheet.scene.toml");
        let line = format!("simulate {} --sensor {sensor} --views 2 --out scan", scene.display());
        folder.run(&line).succeeded();
        folder.edit_json("scan/scan.json", "scan/degrees.json", |manifest| {
            for view in manifest["views"].as_array_mut().unwrap() {
                assert!(view[key].is_number(), "{view}");
                view[key] = json!(30.0);
            }
        });
        refused(&folder, "scan/degrees.json", &texts);
        if sensor == "lookup_table" {
            let accepted = folder.reconstruct("scan/degrees.json --accept angles");
            assert!(!accepted.stderr.contains("--accept"), "{}", accepted.stderr);
        }
    }
}

/// Degrees in the place of radians.
#[test]
fn angles_in_degrees_are_told_to_be_radians() {
    let mut manifest = manifest();
    manifest["views"][0] = json!({
        "file": "wall.npy", "sensor": "spherical",
        "theta0": -60.0, "dtheta": 10.0, "phi0": -60.0, "dphi": 10.0,
        "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    });
    refused(&scan_of(&manifest), "scan.json", &["wall.npy", "dtheta = 10", "radians"]);
}

#[test]
fn planes_too_far_away_are_told_with_their_number() {
    let folder = scan_of(&manifest());
    let far = ["wall.npy", "from plane 0", "e16", "offset near the view"];
    refused(&folder, "scan.json --offset 3e15", &far);
}

/// A view that is there twice agrees with itself.
#[test]
fn identical_views_overlap() {
    let folder = Folder::simulated("objects.scene.toml");
    std::fs::copy(folder.path("scan/range_000.npy"), folder.path("scan/copy.npy")).unwrap();
    folder.edit_json("scan/scan.json", "scan/twice.json", |m| {
        let mut copy = m["views"][0].clone();
        copy["file"] = "copy.npy".into();
        m["views"] = json!([m["views"][0], copy]);
    });
    assert_eq!(folder.reconstruct("scan/twice.json").succeeded().stderr, "");
    let store = folder.reconstruct("scan/twice.json --store s.transect").succeeded();
    assert_eq!(store.stderr, "");
}

/// The guide's corner is rounded with a radius of 2 m in a tunnel 6 m wide.
#[test]
fn pixels_beyond_the_reach_of_a_guide_are_told() {
    let folder = Folder::empty();
    folder.run("simulate bend_tunnel --out scan").succeeded();
    let told = "of the pixels lie more than 1.800 m from the guide and are left out";
    let sound = folder.reconstruct("scan --no-score").succeeded();
    assert!(!sound.stderr.contains(told) && !sound.stdout.contains("reach"), "{}", sound.stdout);
    folder.edit_json("scan/scan.json", "scan/tight.json", |m| {
        m["planes"]["guide"]["kind"] = json!({ "polyline": 2.0 });
    });
    let tight = folder.reconstruct("scan/tight.json --no-score").succeeded();
    assert!(tight.stderr.contains(told), "{}", tight.stderr);
    assert!(tight.number("too far from the guide, left out") > 50.0);
    let sums = folder.run("measure out --sums").succeeded();
    assert_eq!((sums.value("clear volume").as_str(), sums.told("note").len()), ("unknown", 1));
}

/// A store whose planes miss every view is not left behind, and an empty model is a failure.
#[test]
fn an_empty_model_is_a_failure() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.write("axis.csv", "x,y,z\n30,0,0\n30,0,1\n30.1,0,3\n");
    let line =
        "reconstruct scan --guide axis.csv --interval 0.1 --store s.transect --out o --quiet";
    for _ in 0..2 {
        folder.run(line).failed_with(1, &["no section plane along the guide"]);
        assert!(!folder.path("s.transect").exists() && !folder.path("o").exists());
    }
}
