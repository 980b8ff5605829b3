//! The dissertation's own methods and their settings, from end to end.

use super::common::Folder;
use serde_json::json;

const METHODS: &str = "--method dissertation --fusion pairwise";

#[test]
fn every_setting_of_the_dissertation_reaches_the_report() {
    let folder = Folder::simulated("objects.scene.toml");
    let settings = "--subpixel four_point --gap 2 --thickness 3 --jump 500mm --direction codes \
                    --threshold 4mm";
    let run = folder.reconstruct(&format!("scan {METHODS} {settings}")).succeeded();
    assert!(run.number("planes with curves") >= 10.0, "{}", run.stdout);
    let report = folder.json("out/report.json");
    let partial = &report["settings"]["partial"];
    assert_eq!(partial["subpixel"], "four_point", "{partial}");
    assert_eq!((&partial["gap"], &partial["thickness"]), (&json!(2), &json!(3)));
    assert_eq!(partial["direction"], "codes");
    assert_eq!(partial["jump"], json!({ "printed": { "threshold": 0.5 } }));
    let tolerance = &report["settings"]["fusion"]["tolerance"];
    assert_eq!(tolerance["distance"], json!(0.004), "{tolerance}");
    assert!((run.number("overlap threshold") - 0.004).abs() < 1e-9, "{}", run.stdout);
    // The four solutions differ by less than a pixel, and do differ.
    let nodes = |solution: &str| {
        let options = format!("scan --method dissertation --subpixel {solution}");
        folder.reconstruct(&options).succeeded();
        folder.bytes("out/contours.json")
    };
    let solutions = ["cartesian", "device_plane", "device_curves", "four_point"].map(nodes);
    for (k, solution) in solutions.iter().enumerate() {
        assert!(!solutions[..k].contains(solution), "solution {k} is one of those before it");
    }
}

#[test]
fn settings_of_another_method_and_unusable_values_are_refused() {
    let folder = Folder::simulated("objects.scene.toml");
    for setting in ["subpixel cartesian", "gap 2", "thickness 2", "jump 5cm", "direction codes"] {
        let option = format!("--{setting}");
        let name = option.split(' ').next().unwrap();
        folder.reconstruct(&format!("scan {option}")).failed_with(
            2,
            &[name, "belongs to --method dissertation", "this run uses one_pass", "leave out"],
        );
    }
    folder.reconstruct("scan --threshold 2mm --method dissertation").failed_with(
        2,
        &["--threshold", "belongs to --fusion pairwise", "this run uses consensus", "leave out"],
    );
    for (option, found) in [
        ("--gap 65", "65 pixels; at most 64"),
        ("--thickness 1000", "1000 pixels; at most 64"),
        ("--jump 0", "positive length"),
        ("--jump near", "near"),
        ("--threshold 0mm", "positive length"),
        ("--subpixel best", "four_point"),
        ("--direction up", "codes"),
    ] {
        folder.reconstruct(&format!("scan {METHODS} {option}")).failed_with(2, &[found]);
    }
}
