//! The command line from end to end, on a scan that is simulated within milliseconds.

use super::common::{Folder, Row};
use serde_json::Value;
use sha2::{Digest, Sha256};
use transect_model::Model;

/// Files that depend on nothing but the scan and the planes.
const REPRODUCIBLE: [&str; 4] = ["contours.json", "model.transect", "model.dxf", "overview.svg"];

/// The scan `scan` and its reconstruction `out`.
pub fn reconstructed() -> (Folder, super::common::Run) {
    let folder = Folder::simulated("objects.scene.toml");
    let run = folder.reconstruct("scan --threads 2").succeeded();
    (folder, run)
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("{key} is no list in {value}"))
}

fn numbers(value: &Value, key: &str) -> Vec<f64> {
    list(value, key).iter().map(|n| n.as_f64().unwrap()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn a_run_ends_with_its_table_and_nothing_on_stderr() {
    let (_folder, run) = reconstructed();
    assert_eq!(run.stderr, "");
    assert_eq!((run.value("scan"), run.value("views")), ("objects".to_owned(), "4".to_owned()));
    assert_eq!(run.number("planes with curves"), 12.0);
    assert!(run.number("closed curves") >= 15.0 && run.number("curves") >= 20.0);
    let unit_of = |metric| run.table().into_iter().find(|r| r.metric == metric).map(|r| r.unit);
    assert_eq!(unit_of("curve length").as_deref(), Some("m"));
    assert!(run.stdout.contains("results: out"), "{}", run.stdout);
}

#[test]
fn lengths_are_printed_in_the_unit_that_was_asked_for() {
    let (folder, run) = reconstructed();
    let cell = |run: &super::common::Run, metric| {
        let row = run.table().into_iter().find(|r| r.metric == metric).unwrap();
        format!("{} {}", row.value, row.unit)
    };
    // Without a unit, numbers are readable; files keep the model's unit.
    let (median, length) = ("median distance from truth", "curve length");
    assert!(cell(&run, median).ends_with(" mm") && cell(&run, length).ends_with(" m"));
    let asked = folder.reconstruct("scan --output-unit mm").succeeded();
    assert!(cell(&asked, median).ends_with(" mm") && cell(&asked, length).ends_with(" mm"));
    assert!((asked.number(length) / run.number(length) - 1.0).abs() < 1e-3);
    let rows = folder.json("out/report.json")["result"].clone();
    let row = rows.as_array().unwrap().iter().find(|r| r["metric"] == median).unwrap().clone();
    assert!(row["unit"] == "m" && row["value"].as_str().unwrap().starts_with("0.000"), "{row}");
    for (line, text) in [
        ("inspect out", " mm\n"),
        ("inspect scan", " mm\n"),
        ("gaps out", "| width, mm "),
        ("query out 0,0,0.4", "nearest curve, mm"),
        ("evaluate out", " mm\n"),
    ] {
        let said = folder.run(&format!("--output-unit mm {line}")).succeeded().stdout;
        // The unit of the scan's files stays.
        let said: String =
            said.lines().filter(|l| !l.starts_with("unit ")).map(|l| format!("{l}\n")).collect();
        assert!(said.contains(text) && !said.contains(" m\n"), "{line}: {said}");
    }
    folder.run("inspect out --output-unit furlong").failed_with(2, &["furlong"]);
}

#[test]
fn a_single_view_has_no_spread_between_views() {
    let folder = Folder::simulated("objects.scene.toml");
    assert!(folder.reconstruct("scan").stdout.contains("spread between views"));
    folder.edit_json("scan/scan.json", "scan/one.json", |m| {
        m["views"] = serde_json::json!([m["views"][0]]);
    });
    for options in ["", "--store s.transect"] {
        let run = folder.reconstruct(&format!("scan/one.json {options}")).succeeded();
        assert!(!run.stdout.contains("spread") && !run.stdout.contains("threshold"), "{options}");
        assert!(folder.json("out/report.json")["fusion"]["spread"].is_null(), "{options}");
    }
}

#[test]
#[cfg(unix)]
fn output_that_cannot_be_written_is_an_error() {
    let (folder, _) = reconstructed();
    folder.reconstruct("scan --store s.transect").succeeded();
    let shell = |line: &str| {
        let script = format!("set -o pipefail; {line}");
        let mut bash = std::process::Command::new("bash");
        bash.args(["-c", &script, env!("CARGO_BIN_EXE_transect")]).current_dir(folder.path("."));
        let output = bash.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for command in [
        "list-views s.transect",
        "inspect out",
        "measure out",
        "gaps out",
        "verify out",
        "query out 0,0,0",
        "evaluate out",
        "export out --out e",
        "--help",
        "--version",
        "reconstruct scan --out out --quiet",
    ] {
        let (code, said) = shell(&format!("\"$0\" {command} > /dev/full"));
        assert_eq!(code, Some(1), "{command}: {said}");
        assert!(said.contains("stdout") && said.contains("No space left"), "{command}: {said}");
        // A reader that has seen enough is no error.
        let (code, said) = shell(&format!("\"$0\" {command} | true"));
        assert_eq!(code, Some(0), "{command}: {said}");
    }
}

#[test]
fn contours_have_the_documented_form() {
    let (folder, _) = reconstructed();
    let contours = folder.json("out/contours.json");
    assert_eq!(contours["unit"], "m");
    let planes = list(&contours, "planes");
    assert_eq!(planes.len(), 12);
    for plane in planes {
        let (index, station) =
            (plane["index"].as_i64().unwrap(), plane["station"].as_f64().unwrap());
        assert!((station - (0.0137 + 0.08 * index as f64)).abs() < 1e-12, "{index}: {station}");
        let [origin, normal, x_axis] = ["origin", "normal", "x_axis"].map(|k| numbers(plane, k));
        assert_eq!((&normal[..], origin.len()), (&[0.0, 0.0, 1.0][..], 3));
        assert!((dot(&origin, &normal) - station).abs() < 1e-12);
        assert!((dot(&x_axis, &x_axis) - 1.0).abs() < 1e-12 && dot(&x_axis, &normal) == 0.0);
        let areas = list(plane, "polylines").iter().map(|p| check_polyline(p, station));
        // Counter-clockwise around solid, seen against the normal: both solids are convex.
        areas.flatten().for_each(|area| assert!(area > 0.0, "plane {index}: area {area}"));
    }
    let indices: Vec<i64> = planes.iter().map(|p| p["index"].as_i64().unwrap()).collect();
    assert!(indices.is_sorted(), "{indices:?}");
}

/// Checks a polyline on a horizontal plane; its signed area if it is closed.
fn check_polyline(polyline: &Value, station: f64) -> Option<f64> {
    let closed = polyline["closed"].as_bool().unwrap();
    let points: Vec<Vec<f64>> =
        serde_json::from_value(polyline["points"].clone()).expect("points are lists of numbers");
    assert!(points.len() >= 2 + usize::from(closed));
    assert!(points.iter().all(|p| p.len() == 3 && (p[2] - station).abs() < 1e-9));
    assert_ne!(points.first(), points.last(), "the first point is repeated");
    let (sigma, views) = (numbers(polyline, "sigma"), numbers(polyline, "views"));
    assert_eq!((sigma.len(), views.len()), (points.len(), points.len()));
    assert!(sigma.iter().all(|s| (0.0..0.1).contains(s)));
    assert!(views.iter().all(|v| (0.0..=4.0).contains(v)));
    assert!(views.iter().any(|v| *v >= 1.0), "seen by nobody");
    let next = points.iter().cycle().skip(1);
    let doubled = points.iter().zip(next).map(|(p, q)| p[0] * q[1] - q[0] * p[1]);
    closed.then(|| 0.5 * doubled.sum::<f64>())
}

#[test]
fn the_report_has_the_settings_and_the_hashes_of_inputs() {
    let folder = Folder::simulated("objects.scene.toml");
    let run = folder.reconstruct("scan --output-unit m").succeeded();
    let report = folder.json("out/report.json");
    assert_eq!((&report["tool"], &report["unit"]), (&"transect".into(), &"m".into()));
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    let settings = &report["settings"];
    assert_eq!((&settings["interval"], &settings["offset"]), (&0.08.into(), &0.0137.into()));
    assert_eq!(numbers(settings, "normal"), [0.0, 0.0, 1.0]);
    assert_eq!(settings["partial"]["method"], "one_pass");
    assert_eq!(settings["fusion"]["method"], "consensus");
    // The scores depend on the truth.
    let (truth, of_scan) = list(&report, "inputs").split_last().unwrap();
    check_input(&folder, "scan/truth.npz", truth);
    check_inputs(&folder, of_scan);
    let names: Vec<&str> =
        list(&report, "views").iter().map(|v| v["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["range_000.npy", "range_001.npy", "range_002.npy", "range_003.npy"]);
    assert_eq!((list(&report, "warnings").len(), list(&report, "reader_notes").len()), (0, 0));
    let stages = list(&report, "stages");
    assert!(stages.len() >= 3 && stages.iter().all(|s| s["seconds"].as_f64().unwrap() >= 0.0));
    assert_same_rows(&run.table(), list(&report, "result"));
}

#[test]
fn the_hash_of_a_guide_is_in_the_report() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.write("axis.csv", "0,0,-1\n0,0,1\n0,0.1,3\n");
    folder.reconstruct("scan --guide axis.csv --interval 0.2 --no-score").succeeded();
    let report = folder.json("out/report.json");
    let inputs = list(&report, "inputs");
    check_input(&folder, "axis.csv", inputs.last().unwrap());
    check_inputs(&folder, &inputs[..inputs.len() - 1]);
}

fn check_inputs(folder: &Folder, inputs: &[Value]) {
    let files = ["scan.json", "range_000.npy", "range_001.npy", "range_002.npy", "range_003.npy"];
    assert_eq!(inputs.len(), files.len());
    for (input, file) in inputs.iter().zip(files) {
        check_input(folder, &format!("scan/{file}"), input);
    }
}

fn check_input(folder: &Folder, file: &str, input: &Value) {
    let bytes = folder.bytes(file);
    let hash: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
    assert!(input["path"].as_str().unwrap().ends_with(file), "{input}");
    assert_eq!(
        (input["bytes"].as_u64(), input["sha256"].as_str()),
        (Some(bytes.len() as u64), Some(hash.as_str()))
    );
}

/// The table in the report may have more rows than the printed one, but no others.
fn assert_same_rows(printed: &[Row], reported: &[Value]) {
    let reported: Vec<Row> = reported
        .iter()
        .map(|r| {
            let [metric, value, unit] =
                ["metric", "value", "unit"].map(|k| r[k].as_str().unwrap().to_owned());
            Row { metric, value, unit }
        })
        .collect();
    for row in printed {
        assert!(reported.contains(row), "{row:?} is not in the report");
    }
}

#[test]
fn every_output_holds_the_same_curves() {
    let (folder, run) = reconstructed();
    let model = Model::load(folder.path("out/model.transect")).unwrap();
    model.check().unwrap();
    let contours = folder.json("out/contours.json");
    let polylines: usize =
        list(&contours, "planes").iter().map(|p| list(p, "polylines").len()).sum();
    assert_eq!((model.curve_count(), model.sections().len()), (polylines, 12));
    assert_eq!(run.number("curves"), polylines as f64);
    assert_eq!(run.number("nodes"), model.node_count() as f64);
    let sheets = std::fs::read_dir(folder.path("out/planes")).unwrap();
    let sheets: Vec<_> = sheets.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(sheets.len(), 12, "{sheets:?}");
    for svg in sheets.iter().map(|s| format!("planes/{s}")).chain(["overview.svg".to_owned()]) {
        let text = folder.text(&format!("out/{svg}"));
        assert!(text.contains("<svg") && text.trim_end().ends_with("</svg>"), "{svg}");
        assert!(!text.contains("NaN") && !text.contains("inf\""), "{svg}");
    }
}

#[test]
fn the_drawing_is_whole_and_in_metres() {
    let (folder, run) = reconstructed();
    let text = folder.text("out/model.dxf");
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    assert!(lines.len().is_multiple_of(2), "a group code without its value");
    let groups: Vec<(&str, &str)> = lines.chunks(2).map(|p| (p[0], p[1])).collect();
    assert_eq!(groups.last(), Some(&("0", "EOF")));
    let unit = groups.iter().position(|g| *g == ("9", "$INSUNITS")).unwrap();
    assert_eq!(groups[unit + 1].1, "6", "6 is metres");
    let polylines = groups.iter().filter(|(code, name)| *code == "0" && *name == "POLYLINE");
    assert_eq!(polylines.count() as f64, run.number("curves"));
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = Folder::simulated("objects.scene.toml");
    for threads in [1, 2, 3] {
        let line = format!("reconstruct scan --out out{threads} --threads {threads} --quiet");
        folder.run(&line).succeeded();
    }
    for file in REPRODUCIBLE {
        let one = folder.bytes(&format!("out1/{file}"));
        for threads in [2, 3] {
            assert!(one == folder.bytes(&format!("out{threads}/{file}")), "{file}, {threads}");
        }
    }
}

#[test]
fn the_order_of_views_does_not_change_the_contours() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan").succeeded();
    let first = folder.bytes("out/contours.json");
    for order in [[3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1]] {
        folder.edit_json("scan/scan.json", "scan/reordered.json", |manifest| {
            let views = order.map(|k: usize| manifest["views"][k].clone());
            manifest["views"] = Value::from(views.to_vec());
        });
        folder.reconstruct("scan/reordered.json").succeeded();
        assert!(folder.bytes("out/contours.json") == first, "{order:?}");
    }
}

#[test]
fn simulation_depends_on_its_seed_alone() {
    let folder = Folder::simulated("objects.scene.toml");
    let scene = super::common::fixture("objects.scene.toml");
    for (out, seed) in [("again", 7), ("other", 8)] {
        folder.run(&format!("simulate {} --out {out} --seed {seed}", scene.display())).succeeded();
    }
    let image = |scan: &str| folder.bytes(&format!("{scan}/range_002.npy"));
    assert!(image("again") == image("scan"), "the scene's own seed is 7");
    assert!(image("other") != image("scan"));
    assert!(folder.bytes("again/truth.npz") == folder.bytes("scan/truth.npz"));
}

#[test]
fn a_model_goes_by_its_folder_or_its_file() {
    let (folder, _) = reconstructed();
    for command in
        ["evaluate MODEL", "inspect MODEL", "verify MODEL", "measure MODEL", "gaps MODEL"]
    {
        let said = |model| folder.run(&command.replace("MODEL", model)).succeeded().stdout;
        assert_eq!(said("out"), said("out/model.transect"), "{command}");
    }
    let none = ["scan", "holds no model.transect", "reconstruct wrote"];
    folder.run("measure scan").failed_with(1, &none);
    folder.run("evaluate scan").failed_with(1, &none);
}

#[test]
fn results_go_beneath_the_current_folder() {
    let folder = Folder::simulated("objects.scene.toml");
    let run = folder.run("reconstruct scan --quiet").succeeded();
    assert!(run.stdout.contains("results: transect-out/objects\n"), "{}", run.stdout);
    folder.run("verify transect-out/objects").succeeded();
}

#[test]
fn inspection_has_a_row_for_every_view() {
    let folder = Folder::simulated("objects.scene.toml");
    let run = folder.run("inspect scan").succeeded();
    assert_eq!((run.value("views"), run.stderr.as_str()), ("4".to_owned(), ""));
    for (number, rows) in [(0, 90), (1, 90), (2, 100), (3, 100)] {
        let name = format!("range_00{number}.npy");
        let line = run.stdout.lines().find(|line| line.contains(&name)).unwrap();
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        assert_eq!((cells[0], cells[3]), (&*number.to_string(), &*format!("{rows} × 120")));
        let numbers = |k: usize| cells[k].split(", ").map(|n| n.parse::<f64>().unwrap());
        assert!(numbers(5).is_sorted() && numbers(5).count() == 3, "{line}");
        assert!(cells[7].ends_with(" mm stated") && cells[6].contains(" × "), "{line}");
        let seen: f64 = cells[8].parse().unwrap();
        assert!((30.0..=100.0).contains(&seen), "{line}");
        assert_eq!((numbers(9).count(), numbers(10).count()), (3, 3), "{line}");
    }
    assert!(run.stdout.ends_with("reconstruct it: transect reconstruct scan\n"), "{}", run.stdout);
}

#[test]
fn a_second_run_leaves_no_sheet_of_the_first() {
    let (folder, _) = reconstructed();
    let sheets = || std::fs::read_dir(folder.path("out/planes")).unwrap().count();
    assert_eq!(sheets(), 12);
    folder.reconstruct("scan --interval 16cm").succeeded();
    assert_eq!(sheets(), 6);
}

/// A name with the code that makes a terminal print in red.
#[test]
fn control_characters_in_names_do_not_reach_the_terminal() {
    let (folder, _) = reconstructed();
    folder.edit_json("scan/scan.json", "scan/red.json", |m| {
        m["name"] = "red\u{1b}[31m".into();
        m["views"][0]["name"] = "wall\u{1b}[31m\n".into();
        m["views"][1]["unknown\u{1b}"] = 1.into();
    });
    for command in ["inspect scan/red.json", "reconstruct scan/red.json --out red --quiet"] {
        let run = folder.run(command).succeeded();
        for text in [&run.stdout, &run.stderr] {
            assert!(!text.contains('\u{1b}') && text.contains("\\u{1b}"), "{command}: {text:?}");
        }
    }
    let run = folder.run("inspect scan/red.json");
    assert!(run.stdout.contains("| wall\\u{1b}[31m\\u{a} |"), "{}", run.stdout);
}

#[test]
fn planes_are_refined_and_the_report_says_where() {
    let folder = Folder::simulated("objects.scene.toml");
    for (refine, reason) in [
        (
            "30mm,0.03",
            "the smallest interval 0.03 is not 0.08 halved 1 to 10 times: 0.04, 0.02, 0.01",
        ),
        ("0", "--refine: the tolerance must be a positive length, got 0 (in m)"),
        ("x", "--refine: \"x\" is not a length"),
        ("30mm --store s.transect", "cannot be used with '--store <FILE>'"),
    ] {
        folder.reconstruct(&format!("scan --refine {refine}")).failed_with(2, &[reason]);
        assert!(!folder.path("out").exists(), "{refine} left results");
    }
    let run = folder.reconstruct("scan --refine 30mm,20mm").succeeded();
    let report = folder.json("out/report.json");
    let count = |key: &str| report["refinement"][key].as_u64().unwrap();
    let inserted = count("planes_inserted");
    assert!(inserted > 4 && count("planes") > inserted);
    for (metric, value) in [
        ("planes inserted", inserted),
        ("intervals still above the tolerance", count("intervals_above_tolerance")),
    ] {
        let row = |line: &str| line.starts_with(metric) && line.ends_with(&format!(" {value}"));
        assert!(run.stdout.lines().any(row), "{metric} {value}: {}", run.stdout);
    }
    let gaps = report["refinement"]["gaps"].as_array().unwrap();
    let with_plane = gaps.iter().filter(|gap| gap["inserted"].is_i64()).count() as u64;
    assert_eq!(with_plane, inserted);
    assert!(gaps.iter().all(|gap| gap["reason"].is_string() && gap["length"].is_number()));
    // The truth counts on planes that were asked for and no others: the planes between lack
    // nothing.
    let evaluated = folder.run("evaluate out --tolerance 16mm").succeeded();
    let completeness = evaluated.stdout.lines().find(|line| line.starts_with("completeness"));
    let mut words = completeness.unwrap().split_whitespace();
    let share: f64 = words.find_map(|word| word.parse().ok()).unwrap();
    assert!(share > 80.0, "{}", evaluated.stdout);
    let inspected = folder.run("inspect out/model.transect").succeeded();
    assert_eq!(inspected.number("planes in use"), run.number("planes in use"));
}

#[test]
fn a_scan_without_planes_gets_suggested_ones_and_says_so() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.edit_json("scan/scan.json", "scan/bare.json", |manifest| {
        manifest.as_object_mut().unwrap().remove("planes");
    });
    let run = folder.reconstruct("scan/bare.json").succeeded();
    let [note] = run.told("note: ")[..] else { panic!("{}", run.stderr) };
    let (_, planes) = note.split_once("suggested planes are used: ").unwrap();
    let (planes, how) = planes.split_once(". ").unwrap();
    assert!(planes.starts_with("--normal 0,0,1 --offset "), "{note}");
    assert!(how.contains("Pass --normal X,Y,Z, --offset LENGTH and --interval LENGTH"), "{note}");
    // The objects are a metre high, and neighbouring rows are some 40 mm apart on them.
    assert!((8.0..=11.0).contains(&run.number("planes with curves")), "{}", run.stdout);
    let report = folder.json("out/report.json");
    assert!(list(&report, "reader_notes").iter().any(|n| note.contains(n.as_str().unwrap())));
    // The suggestion is the command that inspect proposes, and has the same result.
    let curves = folder.bytes("out/contours.json");
    let inspected = folder.run("inspect scan/bare.json").succeeded();
    let (_, command) = inspected.stdout.split_once("reconstruct it: transect ").unwrap();
    assert_eq!(command.trim_end(), format!("reconstruct scan/bare.json {planes}"));
    let asked = folder.run(&format!("{} --out asked --quiet", command.trim_end())).succeeded();
    assert_eq!(asked.stderr, "");
    assert!(folder.bytes("asked/contours.json") == curves);
    // What is given stays, and is completed.
    let given = folder.reconstruct("scan/bare.json --interval 8cm --offset 13.7mm").succeeded();
    assert!(given.stderr.contains("--normal 0,0,1 --offset"), "{}", given.stderr);
    let settings = folder.json("out/report.json")["settings"].clone();
    assert_eq!((&settings["interval"], &settings["offset"]), (&0.08.into(), &0.0137.into()));
}

#[test]
fn failures_end_with_1_and_name_their_file() {
    let (folder, _) = reconstructed();
    folder.write("broken.scene.toml", "name = \"x\"\nunit = 3\n");
    folder.write("no.transect", "nothing");
    folder.write("no.ply", "nothing");
    let facet = "facet\nvertex 1e6 0 0\nvertex 2e6 0 0\nvertex 1e6 3e6 9e6\nendfacet\n";
    folder.write("far.stl", format!("solid a\n{facet}endsolid a\n"));
    for (line, texts) in [
        ("reconstruct nowhere --out o", ["nowhere: cannot be read", "No such file"]),
        ("inspect nowhere", ["nowhere: cannot be read", "No such file"]),
        ("simulate nowhere.toml --out o", ["nowhere.toml", "No such file"]),
        ("simulate broken.scene.toml --out o", ["broken.scene.toml", "unit"]),
        ("evaluate nowhere", ["nowhere", "No such file"]),
        ("evaluate out --reference none.ply", ["none.ply: cannot be read", "No such file"]),
        ("evaluate out --reference no.transect", ["no.transect", "read from .ply, .stl and .obj"]),
        ("evaluate out --reference no.ply", ["no.ply, line 1", "not a PLY file"]),
        ("evaluate out --reference far.stl", ["far.stl: the mesh does not fit", "do not overlap"]),
        ("manifest scan --out m.json", ["scan: no poses beside the depth images", "--poses"]),
        (
            "inspect scan --camera 2,2,0,0",
            ["--camera has no meaning for a scan of this format", ""],
        ),
    ] {
        folder.run(line).failed_with(1, &texts);
    }
    // A file stands where the folder of results should be.
    folder.write("taken", "");
    folder.run("reconstruct scan --out taken --quiet").failed_with(1, &["taken"]);
}
