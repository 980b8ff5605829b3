//! What is wrong with a scan is said with its place and its reason; nothing panics, nothing is
//! left.
//!
//! Each table begins with a sound scan and spoils one thing at a time. The sound one is tested
//! first, so that no row fails for another reason.

use super::common::{Folder, Run, conjugate, fixture};
use serde_json::{Value, json};
use transect_device::ImageSize;
use transect_exchange::write_npy_image;

/// Rows and columns of the images made here.
pub const SIDE: usize = 12;

/// Depths of a wall that leads away from the camera, from 1 m on the left to 2.1 m on the right.
fn depths() -> Vec<f32> {
    (0..SIDE * SIDE).map(|k| 1.0 + 0.1 * (k % SIDE) as f32).collect()
}

pub fn npy(values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let size = ImageSize { rows: SIDE, cols: values.len() / SIDE };
    write_npy_image(size, values, &mut bytes).unwrap();
    bytes
}

/// An image in counts of a millimetre.
pub fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIDE as u32, SIDE as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let counts = depths().into_iter().map(|d| (1000.0 * d).round() as u16);
    let samples: Vec<u8> = counts.flat_map(u16::to_be_bytes).collect();
    encoder.write_header().unwrap().write_image_data(&samples).unwrap();
    bytes
}

/// A camera's manifest with planes across its optical axis.
pub fn manifest() -> Value {
    json!({
        "unit": "m",
        "planes": { "normal": [0, 0, 1], "offset": 0.05, "interval": 0.2 },
        "views": [ {
            "file": "wall.npy", "sensor": "pinhole",
            "fx": 12.0, "fy": 12.0, "cx": 5.5, "cy": 5.5,
            "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        } ]
    })
}

/// A folder with the images and a manifest.
pub fn scan_of(manifest: &Value) -> Folder {
    let folder = Folder::empty();
    folder.write("wall.npy", npy(&depths()));
    folder.write("wall.png", png());
    folder.write("scan.json", serde_json::to_vec(manifest).unwrap());
    folder
}

/// Reconstructs a spoiled scan, which must fail with the texts and leave no results.
pub fn refused(folder: &Folder, line: &str, texts: &[&str]) {
    let run = folder.reconstruct(line);
    run.failed_with(1, texts);
    assert!(!folder.path("out").exists() && run.stdout.is_empty(), "{line} left results");
}

#[test]
fn sound_scans_are_modelled() {
    let folder = scan_of(&manifest());
    let run = folder.reconstruct("scan.json").succeeded();
    assert_eq!((run.stderr.as_str(), run.number("planes with curves")), ("", 6.0));
    folder.edit_json("scan.json", "png.json", |m| {
        m["views"][0]["file"] = "wall.png".into();
        m["views"][0]["depth_scale"] = 0.001.into();
    });
    assert_eq!(folder.reconstruct("png.json").succeeded().number("planes with curves"), 6.0);
}

/// A change to the manifest and what is said about it.
type Spoiled = (fn(&mut Value), &'static [&'static str]);

const MANIFESTS: &[Spoiled] = &[
    (
        |m| m["unit"] = Value::Null,
        &["scan.json", "no length unit", "add \"unit\": \"m\" or pass --unit"],
    ),
    (|m| m["unit"] = "furlong".into(), &["scan.json", "\"unit\" must be one of", "\"furlong\""]),
    (|m| m["views"] = json!([]), &["scan.json", "no views"]),
    (|m| m["sigma"] = json!(-0.1), &["scan.json", "\"sigma\"", "at least 0"]),
    (
        |m| m["planes"]["interval"] = json!(0),
        &["scan.json", "\"planes\"", "the plane interval must be a positive length, got 0"],
    ),
    (
        |m| m["planes"]["normal"] = json!([0, 0, 0]),
        &["scan.json", "\"planes\"", "normal (0, 0, 0) has no direction"],
    ),
    (
        |m| m["views"][0]["sensor"] = "sonar".into(),
        &["scan.json, view 0 (wall.npy)", "\"sensor\"", "\"sonar\""],
    ),
    (
        |m| m["views"][0]["fx"] = Value::Null,
        &["scan.json, view 0 (wall.npy)", "missing field `fx`"],
    ),
    (|m| m["views"][0]["fx"] = json!(0), &["view wall.npy", "wall.npy", "fx = 0"]),
    (
        |m| m["views"][0]["pose"][0] = Value::Null,
        &["scan.json, view 0 (wall.npy)", "pose", "not finite"],
    ),
    (
        |m| m["views"][0]["pose"][0] = json!(-1),
        &["scan.json, view 0 (wall.npy)", "pose is a reflection"],
    ),
    (
        |m| m["views"][0]["pose"][0] = json!(1.5),
        &["scan.json, view 0 (wall.npy)", "pose is no rotation"],
    ),
    (
        |m| m["views"][0]["file"] = "gone.npy".into(),
        &["scan.json: none of its 1 views has a file", "gone.npy", "put the images there"],
    ),
    (
        |m| m["views"][0]["file"] = "scan.json".into(),
        &["view scan.json", "images are read from .npy, .png, .pgm and .tif"],
    ),
    (
        |m| m["views"][0]["rows"] = json!(13),
        &["wall.npy", "12 rows × 12 columns", "the camera file states 13 rows × 12 columns"],
    ),
    (
        |m| m["views"][0]["cols"] = json!(1_000_000_000_000_u64),
        &["wall.npy", "the camera file states 12 rows × 1000000000000 columns"],
    ),
    (
        |m| m["views"][0]["file"] = "wall.png".into(),
        &["view wall.png", "wall.png", "add \"scale\": length units per count"],
    ),
];

#[test]
fn spoiled_manifests_are_refused_with_file_view_and_key() {
    for (spoil, texts) in MANIFESTS {
        let mut manifest = manifest();
        spoil(&mut manifest);
        refused(&scan_of(&manifest), "scan.json", texts);
    }
}

#[test]
fn a_pose_that_is_no_number_is_named_though_json_has_no_such_number() {
    for bad in ["NaN", "Infinity", "-Infinity"] {
        let folder = scan_of(&manifest());
        let text = folder.text("scan.json").replacen("\"pose\":[1", &format!("\"pose\":[{bad}"), 1);
        assert!(text.contains(bad));
        folder.write("scan.json", text);
        refused(&folder, "scan.json", &["scan.json, view 0 (wall.npy)", "pose", "not finite"]);
    }
}

#[test]
fn a_manifest_that_is_no_json_is_told_with_its_line() {
    let folder = scan_of(&manifest());
    folder.write("scan.json", "{ \"unit\": \"m\",\n  \"views\": [ { \"file\" } ] }");
    refused(&folder, "scan.json", &["scan.json", "not valid JSON", "line 2"]);
}

#[test]
fn a_unit_that_contradicts_the_scan_is_refused() {
    let folder = scan_of(&manifest());
    refused(&folder, "scan.json --unit mm", &["scan.json", "the unit is m, but mm was asked for"]);
    folder.edit_json("scan.json", "bare.json", |m| m["unit"] = Value::Null);
    let run = folder.reconstruct("bare.json --unit mm").succeeded();
    assert_eq!(folder.json("out/contours.json")["unit"], "mm", "{}", run.stdout);
}

/// The header of a `.npy` of 32-bit numbers.
pub fn npy_header(shape: &str) -> Vec<u8> {
    let text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = u16::try_from(text.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes()].concat()
}

#[test]
fn spoiled_images_are_refused_with_file_and_reason() {
    let sound = npy(&depths());
    let with_header = |shape| [npy_header(shape), vec![0; 64]].concat();
    let png = png();
    for (file, bytes, texts) in [
        ("wall.npy", npy(&[0.0; SIDE * SIDE]), ["every pixel is missing", "out with --views"]),
        ("wall.npy", npy(&[f32::NAN; SIDE * SIDE]), ["not usable", "every pixel is missing"]),
        ("wall.npy", npy(&[-1.0; SIDE * SIDE]), ["not usable", "every pixel is missing"]),
        ("wall.npy", sound[..sound.len() - 1].to_vec(), ["truncated", "[12, 12]"]),
        ("wall.npy", sound[..20].to_vec(), ["truncated", "header"]),
        ("wall.npy", Vec::new(), ["not a .npy file", "wall.npy"]),
        ("wall.npy", with_header("(4000000000, 4000000000)"), ["truncated", "4000000000"]),
        // The product of these is 0 in 64 bits.
        ("wall.npy", with_header("(4294967296, 4294967296)"), ["truncated", "4294967296"]),
        ("wall.npy", with_header("(0, 12)"), ["0 rows × 12 columns", "empty"]),
        ("wall.npy", with_header("(16,)"), ["shape is [16]", "rows × columns"]),
        ("wall.npy", with_header("(-4, 4)"), ["shape", "whole numbers"]),
        ("wall.png", png[..png.len() / 2].to_vec(), ["wall.png", "cannot be decoded"]),
        ("wall.png", sound.clone(), ["wall.png", "cannot be decoded"]),
    ] {
        let mut manifest = manifest();
        manifest["views"][0]["file"] = file.into();
        manifest["views"][0]["depth_scale"] = 0.001.into();
        let folder = scan_of(&manifest);
        folder.write(file, bytes);
        refused(&folder, "scan.json", &[&format!("view {file}")]);
        refused(&folder, "scan.json", &texts);
    }
}

/// A range grid of 3 rows × 4 columns on a slope, as text.
const GRID: &str = "ply\nformat ascii 1.0\nobj_info num_cols 4\nobj_info num_rows 3\n\
    element vertex 12\nproperty float x\nproperty float y\nproperty float z\n\
    element range_grid 12\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0.1\n2 0 0.2\n3 0 0.3\n0 1 0\n1 1 0.1\n2 1 0.2\n3 1 0.3\n\
    0 2 0\n1 2 0.1\n2 2 0.2\n3 2 0.3\n\
    1 0\n1 1\n1 2\n1 3\n1 4\n1 5\n1 6\n1 7\n1 8\n1 9\n1 10\n1 11\n";

fn grid_scan(grid: &str, pose: &str) -> Folder {
    let folder = Folder::empty();
    folder.write("slope.ply", grid);
    folder.write("slope.conf", format!("camera 0 0 0 0 0 0 1\nbmesh slope.ply {pose}\n"));
    folder
}

const AT_ORIGIN: &str = "0 0 0 0 0 0 1";

#[test]
fn spoiled_range_grids_are_refused_with_file_and_place() {
    // Its pixels are a metre apart.
    let planes = "slope.conf --interval 0.5 --offset 0.25 --normal 1,0,0 --accept extent";
    // So small a grid has no curve that is long enough to keep.
    grid_scan(GRID, AT_ORIGIN).run("inspect slope.conf").succeeded();
    refused(&grid_scan(GRID, AT_ORIGIN), planes, &["the model is empty", "18 nodes of 1 views"]);
    let cut = &GRID[..GRID.len() - 12];
    for (grid, texts) in [
        (cut.to_owned(), ["truncated", "range_grid"]),
        (GRID.replace("num_cols 4", "num_cols 5"), ["num_rows 3 × num_cols 5", "12"]),
        (GRID.replace("num_cols 4", "colour 4"), ["no size", "num_cols"]),
        (GRID.replace("vertex 12", "vertex 1000000000000"), ["truncated", "1000000000000"]),
        (GRID.replace("num_rows 3", "num_rows 4611686018427387905"), ["grid of", "absurd"]),
        (
            GRID.replace("num_rows 3", "num_rows 90000000").replace("grid 12", "grid 360000000"),
            ["truncated", "360000000"],
        ),
        (GRID.replace("\n1 6\n", "\n1 99\n"), ["row 1, column 2", "vertex 99 does not exist"]),
        (GRID.replace("\n1 6\n", "\n1 x\n"), ["line 30", "range_grid 6"]),
        (GRID.replace("2 1 0.2", "2 1 zero"), ["line 18", "vertex 6"]),
        (
            GRID.replace("property list uchar int", "property float"),
            ["range_grid", "vertex_indices"],
        ),
        ("solid slope".to_owned(), ["line 1", "not a PLY file"]),
    ] {
        let folder = grid_scan(&grid, AT_ORIGIN);
        refused(&folder, planes, &["view slope.ply", "slope.ply"]);
        refused(&folder, planes, &texts);
    }
}

#[test]
fn spoiled_configurations_are_refused_with_line_and_view() {
    for (pose, reason) in [
        ("0 0 0 0 0 0 0", "quaternion has length 0"),
        ("0 0 NaN 0 0 0 1", "not finite"),
        ("0 0 0 0 0 0", "7 numbers"),
        ("0 0 0 0 0 0 one", "7 numbers"),
    ] {
        let texts = ["slope.conf, line 2, view slope.ply", reason];
        refused(&grid_scan(GRID, pose), "slope.conf --interval 0.5", &texts);
    }
    let empty = Folder::empty();
    empty.write("empty.conf", "camera 0 0 0 0 0 0 1\n");
    refused(&empty, "empty.conf --interval 1", &["empty.conf", "bmesh"]);
}

#[test]
fn paths_that_are_no_scan_are_told_what_would_be() {
    let folder = Folder::empty();
    folder.write("notes.txt", "no scan");
    std::fs::create_dir(folder.path("bare")).unwrap();
    std::fs::create_dir(folder.path("pump")).unwrap();
    folder.write("pump/pump.ptx", "");
    refused(&folder, "pump", &["a folder that holds scans; pass one, such as ", "pump.ptx"]);
    folder.write("pump/model.transect", "");
    for path in ["pump", "pump/model.transect"] {
        refused(&folder, path, &["a model and no scan; pass the scan", "report.json"]);
    }
    for path in ["notes.txt", "bare"] {
        refused(&folder, path, &[path, "not a scan", "scan.json", ".conf"]);
    }
}

/// `inspect` proposes a command only if the command can succeed.
#[test]
fn a_scan_with_a_damaged_view_is_inspected_without_a_command_for_it() {
    let mut manifest = manifest();
    let inspect = |manifest: &Value| {
        let folder = scan_of(manifest);
        folder.write("cut.npy", &npy(&depths())[..200]);
        folder.run("inspect scan.json")
    };
    assert!(inspect(&manifest).succeeded().stdout.contains("reconstruct it: "));
    let mut cut = manifest["views"][0].clone();
    cut["file"] = "cut.npy".into();
    manifest["views"].as_array_mut().unwrap().push(cut);
    let run = inspect(&manifest);
    run.failed_with(1, &["view cut.npy", "cut.npy: truncated"]);
    assert!(run.stdout.contains("| wall.npy "), "{}", run.stdout);
    assert!(!run.stdout.contains("reconstruct it"), "{}", run.stdout);
}

#[test]
fn unknown_keys_are_told_with_file_view_and_key() {
    let mut manifest = manifest();
    manifest["views"][0]["gain"] = json!(3);
    manifest["colour"] = "red".into();
    let folder = scan_of(&manifest);
    let run = folder.reconstruct("scan.json").succeeded();
    let notes = run.told("note: ");
    assert_eq!(notes.len(), 2, "{}", run.stderr);
    assert!(notes[0].contains("scan.json: unknown key \"colour\" ignored"), "{notes:?}");
    assert!(notes[1].contains("scan.json, view 0 (wall.npy): unknown key \"gain\""), "{notes:?}");
    let noted = folder.json("out/report.json")["reader_notes"].clone();
    assert_eq!(noted.as_array().map(Vec::len), Some(2), "{noted}");
}

/// A misspelt key is told even if the run then fails, most of all if it fails because of it.
#[test]
fn unknown_keys_are_told_when_the_run_fails_too() {
    let mut manifest = manifest();
    manifest["views"][0]["file"] = "wall.png".into();
    manifest["views"][0]["depthscale"] = json!(0.001);
    let run = scan_of(&manifest).reconstruct("scan.json");
    run.failed_with(1, &["add \"scale\": length units per count", "unknown key \"depthscale\""]);
}

#[test]
fn planes_that_miss_everything_are_told_with_the_stations_seen() {
    let mut manifest = manifest();
    manifest["views"][0]["file"] = "wall.png".into();
    // Counts of a micrometre instead of a millimetre: the wall is 1 mm to 2.1 mm away.
    manifest["views"][0]["depth_scale"] = json!(1e-6);
    let folder = scan_of(&manifest);
    refused(
        &folder,
        "scan.json",
        &["no section plane crosses", "they lie somewhere within the stations"],
    );
    let said = folder.reconstruct("scan.json").stderr;
    let (_, stations) = said.split_once("within the stations ").unwrap();
    let words: Vec<&str> = stations.split_whitespace().take(4).collect();
    let [low, "to", high, "m;"] = words[..] else { panic!("{said}") };
    let [low, high] = [low, high].map(|n| n.parse::<f64>().unwrap());
    assert!((low - 0.001).abs() < 1e-6 && (high - 0.0021).abs() < 1e-6, "{said}");
}

#[test]
fn an_interval_in_a_wrong_unit_is_told_with_the_view() {
    let folder = Folder::simulated("objects.scene.toml");
    for interval in ["1e-12", "1e-9m", "0.001um"] {
        let run = folder.reconstruct(&format!("scan --interval {interval}"));
        run.failed_with(1, &["view range_00", "planes", "is the interval in the right unit?"]);
        assert!(!folder.path("out").exists());
    }
}

/// Planes so dense that their curves fill the memory, though a view can count them.
///
/// Runs with 4 GB of address space, so that nothing but this run suffers.
#[test]
#[cfg(unix)]
fn an_interval_that_would_fill_the_memory_is_refused() {
    let folder = Folder::simulated("objects.scene.toml");
    let line = "ulimit -v 4000000; exec \"$0\" reconstruct scan --interval 1um --out out --quiet";
    let output = std::process::Command::new("sh")
        .args(["-c", line, env!("CARGO_BIN_EXE_transect")])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("is the interval in the right unit?"), "{stderr}");
}

/// The views that a run warns of.
fn warned(run: &Run) -> Vec<String> {
    let name = |line: &&str| line.split_whitespace().nth(2).unwrap().to_owned();
    let warnings = run.told("warning: ");
    assert!(warnings.iter().all(|w| w.contains("contradicts the others")), "{warnings:?}");
    assert!(warnings.iter().all(|w| w.contains("heck its pose")), "{warnings:?}");
    warnings.iter().map(name).collect()
}

#[test]
fn right_poses_are_not_warned_of() {
    for scene in ["cell.scene.toml", "objects.scene.toml"] {
        let folder = Folder::simulated(scene);
        let run = folder.reconstruct("scan").succeeded();
        assert_eq!(run.stderr, "", "{scene}");
    }
}

#[test]
fn a_wrong_pose_among_several_is_named_and_no_other() {
    let folder = Folder::simulated("cell.scene.toml");
    for wrong in 0..4 {
        folder.edit_json("scan/scan.json", "scan/wrong.json", |m| conjugate(m, wrong));
        let run = folder.reconstruct("scan/wrong.json").succeeded();
        assert_eq!(warned(&run), [format!("range_{wrong:03}.npy")], "of four views");
        let warnings = folder.json("out/report.json")["warnings"].clone();
        assert_eq!(warnings.as_array().map(Vec::len), Some(1), "{warnings}");
        // Three views are the fewest among which one can be told from the others.
        folder.edit_json("scan/wrong.json", "scan/three.json", |m| {
            m["views"].as_array_mut().unwrap().remove((wrong + 1) % 4);
        });
        let run = folder.reconstruct("scan/three.json").succeeded();
        assert_eq!(warned(&run), [format!("range_{wrong:03}.npy")], "of three views");
    }
}

#[test]
fn a_wrong_pose_of_two_is_warned_of() {
    let folder = Folder::simulated("cell.scene.toml");
    for (right, wrong) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        folder.edit_json("scan/scan.json", "scan/two.json", |m| {
            conjugate(m, wrong);
            m["views"] = json!([m["views"][right], m["views"][wrong]]);
        });
        let run = folder.reconstruct("scan/two.json").succeeded();
        let name = format!("range_{wrong:03}.npy");
        let named = run.told("warning: ").iter().any(|w| w.contains(&name));
        assert!(named, "{right} and {wrong}: {}", run.stderr);
    }
}

#[test]
fn absurd_numbers_in_scenes_are_refused_with_their_key() {
    let scene = std::fs::read_to_string(fixture("objects.scene.toml")).unwrap();
    let folder = Folder::empty();
    let absurd = scene.replace("radius = 0.45", "radius = 1e300");
    assert_ne!(absurd, scene);
    folder.write("absurd.toml", absurd);
    let run = folder.run("simulate absurd.toml --out scan");
    run.failed_with(1, &["absurd.toml", "ball", "radius", "1e300"]);
}

#[test]
fn evaluations_that_make_no_sense_end_with_2() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan").succeeded();
    for (arguments, reason) in [
        ("--tolerance 0", "--tolerance: the tolerance must be a positive length, got 0"),
        ("--tolerance=-1mm", "--tolerance: the tolerance must be a positive length"),
        ("--tolerance NaN", "--tolerance: \"NaN\" is not a length"),
        ("--from x", "--from: \"x\" is not a length"),
    ] {
        folder.run(&format!("evaluate out {arguments}")).failed_with(2, &["error: ", reason]);
    }
}
