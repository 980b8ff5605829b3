//! `transect evaluate`: what is scored, and against what.

use super::command_line::reconstructed;
use super::common::Folder;

#[test]
fn evaluation_finds_the_truth_that_simulation_left() {
    let (folder, _) = reconstructed();
    let run = folder.run("evaluate out --tolerance 15mm").succeeded();
    // One millimetre of noise, seen by up to three views, and pixels of three centimetres.
    assert!(run.number("median distance from truth") < 0.001);
    assert!(run.number("95 % of distances below") < 0.005);
    assert!(run.number("oriented like the truth") > 99.9);
    assert!(run.number("length off the truth") < 0.5);
    assert_eq!(run.number("duplicated length"), 0.0);
    assert_eq!(run.number("planes with truth"), 12.0);
    // The station leaves planes out, and the tolerance is what counts as off.
    let upper = folder.run("evaluate out --from 0.5 --tolerance 15mm").succeeded();
    assert_eq!(upper.number("planes with truth"), 5.0);
    let strict = folder.run("evaluate out --tolerance 0.5mm").succeeded();
    assert!(strict.number("length off the truth") > 5.0);
    folder.run("evaluate out --from 100").failed_with(2, &["--from: no plane is at 100 m", "last"]);
}

#[test]
fn a_store_is_counted_as_a_plain_model_is() {
    let (folder, _) = reconstructed();
    folder.run("reconstruct scan --quiet --store s.transect --out grown").succeeded();
    let run = folder.run("evaluate s.transect").succeeded();
    assert!(run.stdout.contains("\ncurves "), "{}", run.stdout);
    let reason = run.told("note:")[0];
    assert!(reason.contains("no report.json beside the model names its scan"), "{reason}");
}

#[test]
fn a_model_of_a_part_of_a_scan_is_not_scored_against_the_whole() {
    let (folder, _) = reconstructed();
    for (out, options, scored) in [("some", "--views 0", false), ("all", "", true)] {
        folder.run(&format!("reconstruct scan --quiet --out {out} {options}")).succeeded();
        let run = folder.run(&format!("evaluate {out}")).succeeded();
        assert_eq!(run.stderr.contains("only duplicated length"), !scored, "{out}: {}", run.stderr);
    }
    let run = folder.run("reconstruct scan --quiet --skip-missing --out rest");
    assert!(!run.succeeded().stdout.contains("median distance from truth"));
}

#[test]
fn a_truth_that_was_simulated_anew_is_refused() {
    let (folder, _) = reconstructed();
    folder.edit_json("scan/scan.json", "scan/scan.json", |m| m["comment"] = "mine".into());
    let changed = folder.run("evaluate out").succeeded();
    assert!(changed.told("warning:")[0].contains("scan.json: the file has changed"));
    assert!(changed.stdout.contains("median distance from truth"), "{}", changed.stdout);
    folder.run("simulate face_mask --out scan --force").succeeded();
    let refused = ["scan/truth.npz: the file has changed", "out/report.json", "--reference"];
    folder.run("evaluate out").failed_with(1, &refused);
    folder.run("reconstruct scan --quiet --no-score --out unscored").succeeded();
    let unknown = folder.run("evaluate unscored").succeeded();
    assert!(unknown.told("warning:")[0].contains("truth.npz: unscored/report.json does not state"));
}

/// The box of the mesh lies inside that of the model, and between two of its planes.
#[test]
fn a_reference_that_no_plane_cuts_is_refused() {
    let (folder, _) = reconstructed();
    let corners = "v 0 0 0.02\nv 0.001 0 0.02\nv 0 0.001 0.02\nv 0 0 0.021\n";
    folder.write("small.obj", format!("{corners}f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"));
    let file = "small.obj: the mesh does not fit the model\n  because: the reference spans";
    let refused = [file, "no plane of the model cuts", "unit"];
    folder.run("evaluate out --reference small.obj").failed_with(1, &refused);
}

/// Planes of a model around the origin cut a mesh in every unit.
#[test]
fn a_reference_in_another_unit_that_planes_cut_is_refused() {
    let folder = Folder::empty();
    let station = |name: &str, at: [f64; 3]| {
        format!(
            "[[station]]\nname = \"{name}\"\nsensor = \"pinhole\"\nrows = 90\ncols = 120\n\
             field_of_view = 40\nat = {at:?}\nlook_at = [0, 0, 0]\n"
        )
    };
    let scene = "name = \"cube\"\nunit = \"m\"\n[planes]\nnormal = [0, 0, 1]\noffset = 0.013\n\
                 interval = 0.1\n[noise]\nsigma = 0.001\nseed = 7\n[[solid]]\nshape = \"box\"\n\
                 size = [1, 1, 1]\nat = [0, 0, 0]\n";
    let stations = station("east", [3.0, 0.4, 0.2]) + &station("north", [0.4, 3.0, 0.2]);
    folder.write("cube.scene.toml", format!("{scene}{stations}"));
    folder.run("simulate cube.scene.toml --out scan").succeeded();
    folder.reconstruct("scan").succeeded();
    for (unit, metres) in [("ft", 0.3048), ("in", 0.0254), ("m", 1.0)] {
        let half = 0.5 / metres;
        let corner = |k: usize| {
            let side = |bit: usize| if k >> bit & 1 == 1 { half } else { -half };
            format!("v {} {} {}\n", side(0), side(1), side(2))
        };
        let corners: String = (0..8).map(corner).collect();
        let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        folder.write(&format!("{unit}.obj"), format!("{corners}{faces}"));
        let run = folder.run(&format!("evaluate out --reference {unit}.obj"));
        if unit == "m" {
            assert!(run.succeeded().number("length off the truth") < 5.0);
        } else {
            let texts = [&*format!("multiplied by {metres}. Convert"), "the reference spans"];
            run.failed_with(1, &texts);
        }
    }
}

#[test]
fn distances_below_zero_are_refused() {
    let (folder, _) = reconstructed();
    for (line, option) in [
        ("measure out --close-gaps=-1", "--close-gaps: -1"),
        ("query --within=-1mm out 0,0,0", "--within: -1mm"),
    ] {
        folder.run(line).failed_with(2, &[option, "is below 0", "0 or more"]);
    }
}

/// The cells of comma separated values; heads may hold commas in quotes.
fn cells(line: &str) -> Vec<String> {
    let parts = line.split('"').enumerate();
    let kept = parts.map(|(k, part)| if k % 2 == 1 { part.replace(',', ";") } else { part.into() });
    kept.collect::<String>().split(',').map(str::to_owned).collect()
}

#[test]
fn spreadsheets_get_numbers_in_all_their_digits() {
    let (folder, _) = reconstructed();
    let table = |command: &str| -> Vec<Vec<String>> {
        folder.run(command).succeeded().stdout.lines().map(cells).collect()
    };
    let planes = table("measure out --csv --close-gaps 1m");
    assert_eq!((planes.len(), planes[0].len()), (13, 16));
    assert_eq!(
        planes[0][..4],
        ["plane", "station; m", "least solid area; m²", "most solid area; m²"]
    );
    for line in &planes[1..] {
        let number = |k: usize| line[k].parse::<f64>().unwrap();
        assert!(
            line.len() == 16 && number(2) <= number(14) && number(6) + number(10) > 0.0,
            "{line:?}"
        );
    }
    let sums = table("measure out --csv --sums");
    assert_eq!(
        (sums[0].join(" "), sums[1].join(" ")),
        ("metric value unit".to_owned(), "planes with curves 12 ".to_owned())
    );
    for line in &sums[1..] {
        assert!(line[1].is_empty() || line[1].parse::<f64>().is_ok(), "{line:?}");
    }
    let unit = |name: &str| sums.iter().find(|line| line[0] == name).unwrap()[2].clone();
    assert_eq!((unit("least solid volume"), unit("most clear volume")), ("m³".into(), "m³".into()));
    assert!(
        planes.iter().flatten().all(|cell| cell.len() < 20 || cell.contains(' ')),
        "{planes:?}"
    );
    let answers = table("query out --csv --output-unit mm 0.1,-0.5,0.4 2,2,0.5");
    assert_eq!(answers[0][4], "nearest curve; mm");
    assert_eq!(
        (answers[1][..4].join(" "), answers[2][3].as_str()),
        ("100 -500 400 inside".to_owned(), "outside")
    );
    assert!(answers[1][4].parse::<f64>().unwrap() > 0.0);
    let scores = table("evaluate out --csv");
    assert!(scores.iter().all(|line| line.len() == 3) && scores.len() > 8, "{scores:?}");
}
