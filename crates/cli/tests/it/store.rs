//! Model stores on the command line: growing, changing, asking, and what is refused.

use super::common::Folder;
use transect_model::store::Store;

/// A scan, its reconstruction `out` in one run, and the store `s.transect`.
fn stored() -> Folder {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan").succeeded();
    grow(&folder, "scan").succeeded();
    folder
}

fn grow(folder: &Folder, scan_and_options: &str) -> super::common::Run {
    folder.run(&format!("reconstruct {scan_and_options} --store s.transect --out grown --quiet"))
}

/// The contours of what the store has now.
fn exported(folder: &Folder) -> Vec<u8> {
    folder.run("export s.transect --out exported").succeeded();
    folder.bytes("exported/contours.json")
}

/// The contours of one run over the manifest's views that are left by an edit.
fn at_once(folder: &Folder, edit: impl FnOnce(&mut serde_json::Value)) -> Vec<u8> {
    folder.edit_json("scan/scan.json", "scan/edited.json", edit);
    folder.run("reconstruct scan/edited.json --out once --quiet").succeeded();
    folder.bytes("once/contours.json")
}

#[test]
fn a_grown_store_gives_the_files_of_one_run() {
    let folder = stored();
    for file in ["contours.json", "model.dxf", "overview.svg", "planes/plane_+0004.svg"] {
        assert!(
            folder.bytes(&format!("grown/{file}")) == folder.bytes(&format!("out/{file}")),
            "{file}"
        );
    }
    let again = grow(&folder, "scan").succeeded();
    assert_eq!((again.number("views added"), again.number("views there already")), (0.0, 4.0));
    assert_eq!(again.number("planes fused"), 0.0);
    assert_eq!(folder.bytes("grown/contours.json"), folder.bytes("out/contours.json"));
    let verified = folder.run("verify s.transect --fusion").succeeded();
    assert_eq!((verified.value("sound"), verified.number("views")), ("yes".to_owned(), 4.0));
    let plain = folder.run("verify out/model.transect").succeeded();
    assert_eq!(plain.number("nodes"), verified.number("nodes"));
    let listed = folder.run("list-views s.transect").succeeded().stdout;
    assert!(listed.contains("| range_003.npy | Pinhole"), "{listed}");
}

#[test]
fn views_leave_and_move_as_if_they_had_never_been_there() {
    let folder = stored();
    let removed = folder.run("remove-view s.transect range_002.npy").succeeded();
    assert_eq!(removed.number("views left"), 3.0);
    let without = at_once(&folder, |m| _ = m["views"].as_array_mut().unwrap().remove(2));
    assert!(exported(&folder) == without);

    let pose = |m: &serde_json::Value| -> Vec<f64> {
        serde_json::from_value(m["views"][0]["pose"].clone()).unwrap()
    };
    let mut moved = pose(&folder.json("scan/scan.json"));
    (moved[3], moved[7]) = (moved[3] + 0.015, moved[7] - 0.01);
    let numbers: Vec<String> = moved.iter().map(f64::to_string).collect();
    let line = format!("replace-view s.transect range_000.npy --pose {}", numbers.join(","));
    folder.run(&line).succeeded();
    let with_pose = at_once(&folder, |m| {
        m["views"].as_array_mut().unwrap().remove(2);
        m["views"][0]["pose"] = serde_json::to_value(&moved).unwrap();
    });
    assert!(exported(&folder) == with_pose);
    // Its own pose again, and the removed view.
    folder.run("replace-view s.transect range_000.npy scan").succeeded();
    grow(&folder, "scan").succeeded();
    assert!(exported(&folder) == folder.bytes("out/contours.json"));
    let compacted = folder.run("compact s.transect").succeeded();
    assert!(compacted.number("after") <= compacted.number("before"));
    folder.run("verify s.transect --fusion").succeeded();
}

#[test]
fn lines_of_json_make_the_same_store() {
    let folder = stored();
    folder.run("export s.transect --lines lines.json").succeeded();
    folder.run("import lines.json t.transect").succeeded();
    folder.run("export t.transect --lines again.json --out exported").succeeded();
    assert!(folder.bytes("lines.json") == folder.bytes("again.json"));
    assert!(folder.bytes("exported/contours.json") == folder.bytes("out/contours.json"));
    let hash =
        |file| folder.run(&format!("verify {file}")).succeeded().value("hash of the contents");
    assert_eq!(hash("s.transect"), hash("t.transect"));
    folder.run("import lines.json t.transect").failed_with(1, &["t.transect", "exists"]);
    let text = folder.text("lines.json").replacen("\"closed\":true", "\"closed\":1", 1);
    folder.write("spoiled.json", text);
    folder.run("import spoiled.json u.transect").failed_with(1, &["spoiled.json: line "]);
    assert!(!folder.path("u.transect").exists());
}

#[test]
fn models_and_stores_answer_alike() {
    let folder = stored();
    for question in ["query FILE 0.1,-0.5,0.4 2,2,0.5 -0.2,0.6,-9", "measure FILE"] {
        let ask = |file| folder.run(&question.replace("FILE", file)).succeeded().stdout;
        assert_eq!(ask("s.transect"), ask("out/model.transect"));
    }
    let answers = folder.run("query s.transect 0.1,-0.5,0.4 2,2,0.5 -0.2,0.6,-9").stdout;
    let words: Vec<&str> =
        answers.lines().skip(2).map(|l| l.split('|').nth(2).unwrap().trim()).collect();
    assert_eq!(words, ["inside", "outside", "unknown"]);
    let sums = folder.run("measure s.transect --sums --close-gaps 1m").succeeded();
    // Ball and block: 4/3 π 0.45³ + 0.9 · 0.6 · 0.8; below the ball's middle nobody saw all of it.
    let volume = sums.number("solid volume, gaps closed");
    assert!((volume - 0.75).abs() < 0.1, "{volume}");
    assert_eq!(sums.number("directions that contradict nesting"), 0.0);
    for file in ["s.transect", "out/model.transect"] {
        let inspected = folder.run(&format!("inspect {file}")).succeeded();
        assert_eq!((inspected.number("views"), inspected.number("closed curves")), (4.0, 18.0));
    }
}

/// A point behind the post, past which the other two cameras look, and one in the post.
#[test]
fn a_store_knows_what_its_views_looked_through() {
    let folder = Folder::simulated("post.scene.toml");
    let ask = |options: &str| {
        grow(&folder, &format!("scan {options}")).succeeded();
        let run = folder.run("query s.transect --csv 0,0.9,0.113 0,-0.1,0.113").succeeded();
        let words = run.stdout.lines().skip(1).map(|l| l.split(',').nth(3).unwrap_or_default());
        (words.collect::<Vec<_>>().join(" "), run.told("note").len())
    };
    assert_eq!(ask("--views 0"), ("inside inside".to_owned(), 0));
    assert_eq!(ask("--views 1"), ("unknown inside".to_owned(), 1));
    assert_eq!(ask("--views 2"), ("outside inside".to_owned(), 1));
    std::fs::remove_file(folder.path("s.transect")).unwrap();
    assert_eq!(ask("--keep-seen-through"), ("inside inside".to_owned(), 0));
}

/// Options that a command would ignore are refused, and advice names the option that helps.
#[test]
fn options_of_a_store_are_told() {
    let folder = stored();
    for model in ["s.transect", "out"] {
        let refused = ["a model is inspected as it is", "leave out the options"];
        folder.run(&format!("inspect {model} --views 0")).failed_with(2, &refused);
    }
    let gaps = folder.run("gaps s.transect --incidence 0").succeeded();
    assert!(gaps.stdout.contains("at an incidence of 0° or less"), "{}", gaps.stdout);
    assert!(gaps.stdout.contains("pass a larger --incidence"), "{}", gaps.stdout);
    folder.edit_json("scan/scan.json", "scan/other.json", |m| {
        m["views"][0]["pose"][3] = serde_json::json!(0.1);
    });
    let refused = ["view range_000.npy", "with another pose", "--prefix", "--views"];
    grow(&folder, "scan/other.json").failed_with(1, &refused);
}

#[test]
fn reading_commands_leave_the_store_as_it_is() {
    let folder = stored();
    let before = folder.bytes("s.transect");
    let reader = Store::open_read_only(folder.path("s.transect")).unwrap();
    for command in [
        "query s.transect 0.1,-0.5,0.4",
        "export s.transect --lines lines.json --out exported",
        "inspect s.transect",
        "list-views s.transect",
        "verify s.transect --fusion",
        "measure s.transect --close-gaps 0.1",
        "gaps s.transect",
    ] {
        folder.run(command).succeeded();
        assert!(folder.bytes("s.transect") == before, "{command}");
    }
    let refused = ["s.transect", "being read by another process"];
    folder.run("compact s.transect").failed_with(1, &refused);
    folder.run("remove-view s.transect range_000.npy").failed_with(1, &refused);
    drop(reader);
    // A program that another test starts just now holds the file open until its own code runs.
    let opened = || {
        std::thread::sleep(std::time::Duration::from_millis(10));
        Store::open(folder.path("s.transect")).ok()
    };
    let writer = (0..500).find_map(|_| opened()).unwrap();
    let refused = ["s.transect", "is open for changes already"];
    folder.run("list-views s.transect").failed_with(1, &refused);
    drop(writer);
}

#[test]
fn what_is_refused_says_why_and_changes_nothing() {
    let folder = stored();
    let before = exported(&folder);
    let near = ["s.transect", "no view \"range_1.npy\"", "range_001.npy"];
    folder.run("remove-view s.transect range_1.npy").failed_with(1, &near);
    folder.run("replace-view s.transect range_1.npy scan").failed_with(1, &near);
    let other = "replace-view s.transect range_000.npy scan --view attic";
    folder.run(other).failed_with(1, &["attic", "range_003.npy"]);
    let pose = "replace-view s.transect range_000.npy --pose 1,2,3";
    folder.run(pose).failed_with(2, &["--pose", "16 numbers"]);
    let flat = ["0"; 16].join(",");
    folder.run(&format!("{} {flat}", pose.replace(" 1,2,3", ""))).failed_with(2, &["--pose"]);
    grow(&folder, "scan --interval 0.1")
        .failed_with(1, &["s.transect", "interval", "0.08 m", "0.1 m"]);
    grow(&folder, "scan --fusion pairwise").failed_with(
        1,
        &[
            "s.transect",
            "fusion: the store has consensus, this run pairwise",
            "Leave these options",
        ],
    );
    folder.edit_json("scan/scan.json", "scan/mm.json", |m| m["unit"] = "mm".into());
    let units = ["s.transect", "the store is in m and the scan in mm", "make another store"];
    grow(&folder, "scan/mm.json").failed_with(1, &units);
    let replaced = folder.run("replace-view s.transect range_000.npy scan/mm.json");
    replaced.failed_with(1, &["mm.json: its views cannot be taken", units[1], units[2]]);
    folder
        .edit_json("scan/scan.json", "scan/moved.json", |m| m["views"][1]["pose"][3] = 9.0.into());
    grow(&folder, "scan/moved.json").failed_with(1, &["range_001.npy", "another pose"]);
    let far = |options: &str| {
        let run = folder.run(&format!("query s.transect {options} 2,2,0.4")).succeeded();
        run.stdout.lines().last().unwrap().split('|').nth(2).unwrap().trim().to_owned()
    };
    let answers = ["", "--within 10m", "--within 1mm"].map(far);
    assert!(answers[0] != "unknown" && answers[0] == answers[1], "{answers:?}");
    assert_eq!(answers[2], "unknown");
    folder.run("query s.transect 1,2").failed_with(2, &["1,2", "three numbers"]);
    let late = folder.run("query s.transect 2,2,0.4 --within 1mm");
    late.failed_with(2, &["--within", "stands before the points"]);
    assert!(exported(&folder) == before);
}

/// Every method and kind of planes: a store is continued, changed and verified without its options.
#[test]
fn the_name_of_its_method_keeps_the_options_of_a_store() {
    let folder = Folder::simulated("objects.scene.toml");
    let options = "--interval 0.1 --method dissertation --gap 2 --fusion pairwise --threshold 5mm";
    grow(&folder, &format!("scan {options}")).succeeded();
    grow(&folder, "scan --method dissertation --fusion pairwise").succeeded();
    let other = "scan --method dissertation --gap 3";
    grow(&folder, other).failed_with(1, &["gap", "the store has 2, this run 3"]);
}

#[test]
fn stores_of_any_options_can_be_continued_and_changed() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.write("axis.csv", "x,y,z\n-1,-1,-1\n-0.3,-0.2,0\n0,0.1,3\n");
    let planes = [
        ("", "--interval 0.1", "interval"),
        ("--normal 1,2,3 --interval 4in --offset 1mm", "--normal 0,0,1", "guide"),
        ("--guide axis.csv --interval 0.1", "--offset 0.02", "offset"),
        ("--guide axis.csv --guide-kind polyline --interval 0.07", "--guide axis.csv", "guide"),
    ];
    for (method, fusion) in [
        ("one_pass", "consensus"),
        ("one_pass", "pairwise"),
        ("dissertation", "consensus"),
        ("dissertation", "pairwise"),
    ] {
        for (planes, other, name) in planes {
            let own = format!("scan {planes} --method {method} --fusion {fusion}");
            let made = grow(&folder, &own);
            if planes.contains("guide") && method == "dissertation" {
                made.failed_with(1, &["straight guide", "one_pass"]);
                assert!(!folder.path("s.transect").exists(), "an empty store is in the way");
                continue;
            }
            made.succeeded();
            let whole = folder.bytes("grown/contours.json");
            folder.run("replace-view s.transect range_000.npy").succeeded();
            folder.run("remove-view s.transect range_001.npy").succeeded();
            let verified = folder.run("verify s.transect --fusion").succeeded();
            assert_eq!(verified.value("fused again"), "the same", "{own}");
            for again in ["scan", &own] {
                let run = grow(&folder, again).succeeded();
                assert_eq!(run.number("views"), 4.0, "{again}");
                assert!(folder.bytes("grown/contours.json") == whole, "{own}: {again}");
            }
            let differs = ["s.transect", &format!("{name}: the store has"), "this run"];
            grow(&folder, &format!("scan {other}")).failed_with(1, &differs);
            std::fs::remove_file(folder.path("s.transect")).unwrap();
        }
    }
}

#[test]
fn a_store_keeps_its_planes_where_the_scan_states_others() {
    let folder = Folder::simulated("objects.scene.toml");
    grow(&folder, "scan --interval 4in").succeeded();
    let run = grow(&folder, "scan --prefix b-").succeeded();
    let notes = run.told("note: the scan states other planes than the store");
    assert_eq!(notes.len(), 1, "{}", run.stderr);
    assert_eq!(grow(&folder, "scan --interval 10.16cm").succeeded().number("views added"), 0.0);
}

#[test]
fn what_a_killed_process_left_of_a_new_store_is_removed() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.write("s.transect.4294967295-0.part", "half");
    grow(&folder, "scan --views 0").succeeded();
    assert!(!folder.path("s.transect.4294967295-0.part").exists());
}

#[test]
fn a_store_without_views_replaces_no_results() {
    let folder = stored();
    let before = exported(&folder);
    for k in 0..4 {
        folder.run(&format!("remove-view s.transect range_00{k}.npy")).succeeded();
    }
    for command in ["export s.transect --out exported", "measure s.transect --sums"] {
        folder.run(command).failed_with(1, &["s.transect", "no curves"]);
    }
    assert!(folder.bytes("exported/contours.json") == before);
}

#[test]
fn a_single_plane_tells_no_volume() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan --interval 100m --offset 300mm").succeeded();
    let sums = folder.run("measure out --sums").succeeded().stdout;
    assert!(sums.contains("too few planes"), "{sums}");
    let whole = folder.reconstruct("scan --interval 20mm").succeeded();
    assert!(whole.number("planes with curves") > 1.0);
    let sums = folder.run("measure out --sums").succeeded().stdout;
    assert!(!sums.contains("too few planes"), "{sums}");
}

/// The unit vector along 1, 1, 0 has a length that rounding makes unequal to 1.
#[test]
fn a_store_grows_along_any_normal() {
    let folder = Folder::simulated("objects.scene.toml");
    let first = grow(&folder, "scan --views 0 --normal 1,1,0 --interval 100mm");
    assert_eq!(first.succeeded().number("views added"), 1.0);
    assert_eq!(grow(&folder, "scan --views 1").succeeded().number("views added"), 1.0);
}

#[test]
fn replacing_a_view_tells_the_notes_of_its_scan() {
    let folder = stored();
    folder.edit_json("scan/scan.json", "scan/noted.json", |m| m["colour"] = "red".into());
    let replaced = folder.run("replace-view s.transect range_000.npy scan/noted.json").succeeded();
    assert!(replaced.stderr.contains("colour"), "{}", replaced.stderr);
}

#[test]
fn a_replaced_pose_is_checked_as_in_a_run() {
    let folder = stored();
    let pose = |edit: fn(&mut [f64])| {
        let views = folder.json("scan/scan.json")["views"].clone();
        let mut pose: Vec<f64> = serde_json::from_value(views[0]["pose"].clone()).unwrap();
        edit(&mut pose);
        let numbers: Vec<String> = pose.iter().map(f64::to_string).collect();
        folder.run(&format!("replace-view s.transect range_000.npy --pose {}", numbers.join(",")))
    };
    let before = exported(&folder);
    for (edit, reason) in [
        ((|p| p[0] *= 1.2) as fn(&mut [f64]), "no rotation"),
        (|p| p.iter_mut().take(3).for_each(|n| *n = -*n), "reflection"),
        (|p| p[3] = f64::NAN, "not finite"),
        (|p| p[12] = 1.0, "last row"),
    ] {
        pose(edit).failed_with(2, &["--pose", reason]);
    }
    assert!(exported(&folder) == before);
    let rounded = pose(|p| p[0] += 1e-4).succeeded();
    assert!(rounded.stderr.contains("nearest rotation is used"), "{}", rounded.stderr);
    let far = pose(|p| p[3] += 40.0).succeeded();
    let told = "range_000.npy meets no surface of another view";
    assert!(far.stderr.contains(told), "{}", far.stderr);
    assert!(far.stderr.contains("transect remove-view"), "{}", far.stderr);
    let right = pose(|_| ()).succeeded();
    assert_eq!(right.stderr, "");
}

#[test]
fn what_is_no_store_is_told_what_it_is() {
    let folder = stored();
    folder.write("notes.txt", "not a model at all");
    for command in ["list-views", "verify", "measure", "compact"] {
        folder
            .run(&format!("{command} notes.txt"))
            .failed_with(1, &["notes.txt", "not a Transect"]);
        folder.run(&format!("{command} nowhere")).failed_with(1, &["nowhere"]);
    }
    let plain = "remove-view out/model.transect range_000.npy";
    folder.run(plain).failed_with(1, &["plain model file", "reconstruct --store"]);
    let mut bytes = folder.bytes("s.transect");
    let middle = bytes.len() / 2;
    bytes.truncate(middle);
    folder.write("half.transect", &bytes);
    folder.run("verify half.transect").failed_with(1, &["half.transect", "truncated"]);
    let held = Store::open(folder.path("s.transect")).unwrap();
    grow(&folder, "scan").failed_with(1, &["s.transect", "is open for changes already"]);
    drop(held);
    let nothing = "reconstruct scan --store new.transect --offset 500 --interval 1 --out o --quiet";
    folder.run(nothing).failed_with(1, &["no section plane crosses"]);
    // A store of planes that nothing crosses would stand in the way of the next attempt.
    assert!(!folder.path("new.transect").exists());
}

#[test]
fn a_scan_can_come_under_other_names() {
    let folder = stored();
    let run = grow(&folder, "scan --prefix again-").succeeded();
    assert_eq!((run.number("views added"), run.number("views")), (4.0, 8.0));
    let listed = folder.run("list-views s.transect").stdout;
    assert!(listed.contains("again-range_000.npy"), "{listed}");
}

/// Views before the one that fails are stored, and the message counts them.
#[test]
fn a_run_that_stops_at_a_view_says_how_many_are_stored() {
    let folder = Folder::simulated("objects.scene.toml");
    let image = folder.bytes("scan/range_002.npy");
    folder.write("scan/range_002.npy", &image[..200]);
    let told = ["2 of 4 views are in the store", "--views", "range_002.npy"];
    grow(&folder, "scan").failed_with(1, &told);
    folder.write("scan/range_002.npy", image);
    grow(&folder, "scan").succeeded();
    assert_eq!(folder.run("verify s.transect").succeeded().number("views"), 4.0);
}

#[test]
fn an_image_that_is_gone_is_told_by_its_path() {
    let folder = stored();
    std::fs::remove_file(folder.path("scan/range_001.npy")).unwrap();
    let missing = ["1 of 4 views have no file", "range_001.npy"];
    folder.run("replace-view s.transect range_001.npy").failed_with(1, &missing);
    let run = folder.run("register s.transect");
    run.failed_with(1, &missing);
    assert!(!run.stderr.contains("--skip-missing"), "{}", run.stderr);
}

#[test]
fn a_scan_that_was_moved_is_told_with_the_way_out() {
    let folder = stored();
    std::fs::rename(folder.path("scan"), folder.path("moved")).unwrap();
    let told = [
        "s.transect: view range_001.npy",
        "transect replace-view s.transect \"range_001.npy\" SCAN",
    ];
    folder.run("replace-view s.transect range_001.npy").failed_with(1, &told);
    let told =
        ["s.transect: view range_000.npy", "/scan,", "replace-view s.transect \"range_000.npy\""];
    folder.run("register s.transect").failed_with(1, &told);
    folder.run("replace-view s.transect range_001.npy moved").succeeded();
    let wrong = folder.run("replace-view s.transect range_001.npy nowhere");
    wrong.failed_with(1, &["nowhere: cannot be read"]);
    assert!(!wrong.stderr.contains("replace-view"), "{}", wrong.stderr);
    let scored = folder.run("evaluate out").succeeded();
    assert!(scored.stderr.contains("scan is not there any more"), "{}", scored.stderr);
}

/// A view far from all others makes free space too coarse to stand in.
#[test]
fn gaps_without_a_place_to_see_them_from_say_so() {
    let folder = stored();
    let places = folder.run("gaps s.transect").succeeded();
    assert!(places.stdout.contains("Next views that would see most"), "{}", places.stdout);
    let away = |m: &mut serde_json::Value| m["views"][1]["pose"][3] = 1000.0.into();
    folder.edit_json("scan/scan.json", "scan/far.json", away);
    let options = "--store far.transect --out far --quiet --accept distance --accept extent";
    folder.run(&format!("reconstruct scan/far.json {options}")).succeeded();
    let places = folder.run("gaps far.transect").succeeded();
    assert!(places.stdout.contains("check its pose, or remove it"), "{}", places.stdout);
}
