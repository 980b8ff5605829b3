//! Outputs on disk: what they never replace, and that they are whole or the old ones.
#![cfg(unix)]

use super::common::{Folder, fixture};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A scan, its results `out`, and its store `s.transect`.
fn stored() -> Folder {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan --store s.transect").succeeded();
    folder
}

/// The content of every file below a folder.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            let below = contents(&entry.path());
            files.extend(below.into_iter().map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            files.insert(name, fs::read(entry.path()).unwrap());
        }
    }
    files
}

#[test]
fn results_never_replace_a_store_or_an_input() {
    let folder = stored();
    let place = |name: &str, from: &str| {
        fs::create_dir_all(folder.path(name).parent().unwrap()).unwrap();
        fs::copy(folder.path(from), folder.path(name)).unwrap();
    };
    place("a/model.transect", "s.transect");
    place("b/planes/plane_+0001.svg", "s.transect");
    fs::create_dir(folder.path("c")).unwrap();
    fs::hard_link(folder.path("s.transect"), folder.path("c/report.json")).unwrap();
    fs::create_dir(folder.path("d")).unwrap();
    std::os::unix::fs::symlink("../axis.csv", folder.path("d/model.dxf")).unwrap();
    folder.write("axis.csv", "x,y,z\n0,0,-1\n0,0,0\n0,0,3\n");
    folder.edit_json("scan/scan.json", "scan/contours.json", |_| ());
    let before = contents(&folder.path("."));
    let store = "would replace a model store";
    let input = "would replace the input";
    for (line, file, reason) in [
        ("reconstruct scan --store a/model.transect --out a", "a/model.transect", input),
        ("reconstruct scan --out a", "a/model.transect", store),
        ("reconstruct scan --out b", "b/planes/plane_+0001.svg", store),
        ("reconstruct scan --out c", "c/report.json", store),
        ("reconstruct scan --store new/contours.json --out ./new", "new/contours.json", input),
        ("reconstruct scan --guide axis.csv --out d", "d/model.dxf", input),
        ("reconstruct scan/contours.json --out scan", "scan/contours.json", input),
        ("export a --out a", "a/model.transect", input),
        ("export a/model.transect --out a", "a/model.transect", input),
        ("export out --out a", "a/model.transect", store),
        ("export s.transect --lines s.transect", "s.transect", input),
        ("export s.transect --lines c/report.json", "c/report.json", input),
        ("export s.transect --lines a/model.transect", "a/model.transect", store),
        ("export s.transect --lines scan/scan.json", "scan/scan.json", "did not write it"),
        ("export s.transect --lines scan/range_001.npy", "range_001.npy", "did not write it"),
    ] {
        folder.run(line).failed_with(1, &[file, reason, "choose another place"]);
        assert!(contents(&folder.path(".")) == before, "{line} changed files");
    }
}

#[test]
fn simulations_and_manifests_replace_their_own_files_only() {
    let folder = stored();
    let scene = fixture("objects.scene.toml");
    let simulate = |options: &str| folder.run(&format!("simulate {} {options}", scene.display()));
    simulate("--out scan").succeeded();
    let refused = ["no simulation wrote", "--force"];
    simulate("--out out").failed_with(1, &["out: ", refused[0], refused[1]]);
    folder.edit_json("scan/scan.json", "scan/scan.json", |m| m["tool"] = "scanner".into());
    simulate("--out scan").failed_with(1, &["scan: ", refused[0], refused[1]]);
    simulate("--out scan --force").succeeded();
    // As builds wrote it that did not name the command.
    folder.edit_json("scan/scan.json", "scan/scan.json", |m| m["tool"] = "transect 0.1.0".into());
    simulate("--out scan").succeeded();
    fs::copy(folder.path("s.transect"), folder.path("scan/truth.npz")).unwrap();
    simulate("--out scan --force").failed_with(1, &["truth.npz", "model store"]);

    fs::create_dir(folder.path("depth")).unwrap();
    folder.write("depth/camera-intrinsics.txt", "585 0 320\n0 585 240\n0 0 1\n");
    folder.write("depth/a.depth.png", "not read");
    folder.write("depth/a.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    let manifest = |options: &str| folder.run(&format!("manifest depth --out {options}"));
    manifest("m.json").succeeded();
    manifest("m.json").succeeded();
    let simulated = ["scan/scan.json", "transect simulate wrote it", "--force"];
    manifest("scan/scan.json").failed_with(1, &simulated);
    fs::create_dir(folder.path("other")).unwrap();
    for file in ["camera-intrinsics.txt", "a.depth.png", "a.pose.txt"] {
        fs::copy(folder.path("depth").join(file), folder.path("other").join(file)).unwrap();
    }
    let other = ["m.json", "manifest wrote it for another scan", "--force"];
    folder.run("manifest other --out m.json").failed_with(1, &other);
    folder.run("manifest other --out m.json --force").succeeded();
    manifest("m.json --force").succeeded();
    folder.write("notes.txt", "mine");
    manifest("notes.txt").failed_with(1, &["notes.txt", "the file exists", "--force"]);
    manifest("s.transect --force").failed_with(1, &["s.transect", "model store"]);
    manifest("n.json --camera 9,8,3,2 --depth-scale 0.0002").succeeded();
    let view = &folder.json("n.json")["views"][0];
    assert_eq!((view["fy"].as_f64(), view["scale"].as_f64()), (Some(8.0), Some(0.0002)));
    // The commands of a store would read the images without the option.
    let store =
        "reconstruct depth --depth-scale 0.0002 --normal 0,0,1 --interval 1m --store d.transect";
    let advice = ["without --depth-scale", "transect manifest SCAN --depth-scale"];
    folder.run(store).failed_with(2, &advice);
    assert!(!folder.path("d.transect").exists());
    manifest("depth/a.depth.png --force").failed_with(1, &["a.depth.png", "input"]);
    assert_eq!(folder.text("notes.txt"), "mine");
    manifest("notes.txt --force").succeeded();
}

#[test]
fn files_of_other_programs_are_not_replaced() {
    let folder = Folder::simulated("objects.scene.toml");
    let run = || folder.run("reconstruct scan --out project --quiet --no-score");
    fs::create_dir_all(folder.path("project/planes")).unwrap();
    folder.write("project/notes.txt", "mine");
    for name in ["model.dxf", "splines.dxf", "report.json", "planes/plane_+0012.svg"] {
        folder.write(&format!("project/{name}"), "mine");
        run().failed_with(1, &[name, "the file exists", "choose another folder"]);
        assert_eq!(folder.text(&format!("project/{name}")), "mine");
        fs::remove_file(folder.path(&format!("project/{name}"))).unwrap();
    }
    run().succeeded();
    run().succeeded();
    assert_eq!(folder.text("project/notes.txt"), "mine");
}

#[test]
fn a_run_that_fails_midway_leaves_the_old_results() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan --interval 16cm --splines 1mm").succeeded();
    folder.write("out/notes.txt", "mine");
    folder.write("out/planes/plane_plan.svg", "mine");
    let before = contents(&folder.path("out"));
    // A quota in blocks of 512 bytes, between the sizes of the first and the second file.
    folder.run("reconstruct scan --out whole --quiet").succeeded();
    let size = |name: &str| folder.bytes(&format!("whole/{name}")).len();
    assert!(size("model.transect") + 9000 < size("contours.json"), "the quota has no room");
    let blocks = size("model.transect") / 512 + 8;
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let output = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_transect")])
        .args("reconstruct scan --out out --quiet".split_whitespace())
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("contours.json") && said.contains("File too large"), "{said}");
    assert!(contents(&folder.path("out")) == before);
    // A killed process leaves its stage, which the next run removes with the old sheets.
    fs::create_dir(folder.path("out/.transect.part")).unwrap();
    folder.write("out/.transect.part/model.dxf", "half");
    folder.write("out/.model.dxf.4294967295.part", "half, by an older version");
    folder.reconstruct("scan --interval 32cm").succeeded();
    let after = contents(&folder.path("out"));
    let gone: Vec<_> = before.keys().filter(|name| !after.contains_key(*name)).collect();
    let is_old = |name: &str| name.starts_with("planes/plane_+") || name.starts_with("splines.");
    assert!(gone.len() >= 4 && gone.iter().all(|name| is_old(name)), "{gone:?}");
    assert!(after.keys().all(|name| before.contains_key(name)), "{:?}", after.keys());
    assert_eq!(after["notes.txt"], b"mine");
    assert!(after.contains_key("planes/plane_plan.svg"), "a drawing of another program");
    // A file that cannot be replaced is found before the work.
    fs::remove_file(folder.path("out/model.dxf")).unwrap();
    fs::create_dir(folder.path("out/model.dxf")).unwrap();
    folder.reconstruct("scan").failed_with(1, &["out/model.dxf", "is a folder"]);
    folder.write("file", "");
    folder.run("reconstruct scan --out file").failed_with(1, &["file: is a file", "folder"]);
}

#[test]
fn the_table_of_the_readme_is_what_the_first_command_prints() {
    let readme = include_str!("../../../../README.md");
    let (_, block) = readme.split_once("```text\nmetric").unwrap();
    let (block, _) = block.split_once("```").unwrap();
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let run = Folder::empty().run("reconstruct --quiet").succeeded();
    let printed: Vec<_> = run.stdout.lines().map(words).collect();
    let shown: Vec<_> = block.lines().skip(1).map(words).collect();
    assert!(shown.len() >= 5, "{block}");
    for line in shown {
        assert!(
            printed.contains(&line),
            "README.md has {line:?}, and the command prints:\n{run:?}"
        );
    }
}

/// JSON holds no bytes that are not Unicode: reports name the scan all the same, and files that
/// name it for other commands are refused.
#[cfg(target_os = "linux")]
#[test]
fn a_scan_may_lie_in_a_folder_whose_name_is_not_unicode() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::simulated("objects.scene.toml");
    let odd = std::ffi::OsStr::from_bytes(b"a\xff b");
    fs::rename(folder.path("scan"), folder.path(".").join(odd)).unwrap();
    let run = |command: &str| {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_transect"));
        program.arg(command).arg(odd).args(["--out", command]).current_dir(folder.path("."));
        let output = program.output().unwrap();
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (succeeded, said) = run("reconstruct");
    assert!(succeeded, "{said}");
    let scan = folder.json("reconstruct/report.json")["scan"].clone();
    assert!(scan.as_str().unwrap().contains("a\u{fffd} b"), "{scan}");
    let (succeeded, said) = run("register");
    assert!(!succeeded && said.contains("not Unicode") && said.contains("rename"), "{said}");
    assert!(!folder.path("register/scan.json").exists());
}
