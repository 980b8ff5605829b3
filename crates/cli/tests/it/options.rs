//! Options that a command cannot follow are refused.

use super::command_line::reconstructed;
use super::common::Folder;

#[test]
fn arguments_that_make_no_sense_end_with_2() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.write("axis.csv", "x,y,z\n0,0,0\n0,0,1\n0,0.2,2\n");
    for (arguments, reason) in [
        ("--interval 0", "interval must be a positive length, got 0"),
        ("--interval -1", "interval must be a positive length, got -1"),
        ("--interval NaN", "--interval: \"NaN\" is not a length"),
        ("--interval inf", "--interval: \"inf\" is not a length"),
        ("--interval abc", "--interval: \"abc\" is not a length"),
        ("--interval 1furlong", "unknown length unit \"furlong\""),
        ("--offset x", "--offset: \"x\" is not a length"),
        ("--normal 0,0,0", "normal (0, 0, 0) has no direction"),
        ("--normal 1,2", "--normal 1,2: write three numbers"),
        ("--normal nan,0,1", "has no direction"),
        ("--guide axis.csv --guide-reach 0", "the reach must be a positive length, got 0"),
        ("--method guess", "invalid value 'guess' for '--method"),
        ("--threads many", "invalid value 'many' for '--threads"),
        ("--unit furlong", "unknown length unit \"furlong\""),
        ("--frobnicate", "unexpected argument '--frobnicate'"),
    ] {
        folder.reconstruct(&format!("scan {arguments}")).failed_with(2, &["error: ", reason]);
        assert!(!folder.path("out").exists(), "{arguments} left results");
    }
    folder.run("frobnicate").failed_with(2, &["unrecognized subcommand 'frobnicate'"]);
    folder.run("").failed_with(2, &["Usage"]);
}

/// The parser of options forgets that one option needs another where a third one excludes that.
#[test]
fn options_that_would_be_ignored_are_refused() {
    let (folder, _) = reconstructed();
    for (line, code, texts) in [
        ("reconstruct scan --store q.transect --prior 89,1mm", 2, ["--store", "--prior"]),
        ("reconstruct scan --refine-poses --prefix a", 2, ["--refine-poses", "--prefix"]),
        ("reconstruct scan --refine 1mm --prefix a", 2, ["--refine", "--prefix"]),
        ("reconstruct scan --normal 0,0,1 --guide-kind polyline", 2, ["--normal", "--guide-kind"]),
        ("reconstruct scan --normal 0,0,1 --guide-radius 3", 2, ["--normal", "--guide-radius"]),
        ("explain scan --normal 0,0,1 --guide-reach 5", 2, ["--normal", "--guide-reach"]),
        ("simulate room --stripe-images --out s", 2, ["--stripe-images", "--sensor light_stripe"]),
        (
            "simulate room --stripe-images --sensor pinhole --out s",
            2,
            ["--stripe-images", "pinhole"],
        ),
        ("export out --lines lines --dxf plane", 2, ["--dxf", "--out DIR"]),
        ("verify out --fusion", 1, ["out: --fusion", "reconstruct SCAN --store FILE"]),
    ] {
        folder.run(line).failed_with(code, &texts);
    }
    assert!(!folder.path("s").exists() && !folder.path("lines").exists());
}

#[test]
fn more_threads_than_the_machine_can_use_are_refused() {
    let texts = ["--threads 100000: this machine has", "at most", "64 per core", "0"];
    Folder::empty().run("reconstruct nowhere --threads 100000").failed_with(2, &texts);
}

#[test]
fn more_threads_in_the_environment_than_the_machine_can_use_are_refused() {
    let folder = Folder::empty();
    let variable = [("RAYON_NUM_THREADS", "100000")];
    let texts = ["RAYON_NUM_THREADS=100000: this machine has", "64 per core", "Unset"];
    for command in ["reconstruct nowhere", "inspect nowhere", "explain nowhere", "measure nowhere"]
    {
        folder.run_with(&variable, command).failed_with(2, &texts);
    }
    // The option counts where it is given.
    folder.run_with(&variable, "reconstruct nowhere --threads 2").failed_with(1, &["nowhere"]);
}

#[test]
fn a_camera_with_impossible_numbers_is_refused() {
    let folder = Folder::empty();
    for (numbers, found) in [
        ("nan,585,320,240", "fx is NaN"),
        ("0,585,320,240", "fx is 0"),
        ("-585,585,320,240", "fx is -585"),
        ("585,0,320,240", "fy is 0"),
        ("585,585,inf,240", "cx is inf"),
    ] {
        let line = format!("manifest . --out m.json --camera={numbers}");
        folder.run(&line).failed_with(2, &["--camera", found, "expected"]);
    }
    folder.write("camera.txt", "585 585 320 inf\n");
    folder.write("a.depth.png", "not read");
    folder.write("a.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    let line = "manifest . --out m.json --camera";
    folder.run(&format!("{line} camera.txt")).failed_with(1, &["camera.txt: cy is inf"]);
    folder.run(&format!("{line} 481,-480,320,240")).succeeded();
}
