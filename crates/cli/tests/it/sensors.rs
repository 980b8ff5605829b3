//! Every sensor from its simulation through its scan folder to a scored model.

use super::common::{Folder, Run, fixture};

/// Simulates the objects, a block and a ball a metre apart, without noise, and models them.
fn modelled(options: &str) -> (Folder, Run) {
    let folder = Folder::empty();
    let scene = fixture("objects.scene.toml");
    let line = format!("simulate {} --noise-free --out scan {options}", scene.display());
    folder.run(&line).succeeded();
    let run = folder.reconstruct("scan").succeeded();
    assert_eq!(run.stderr, "", "{options}: no note, no warning");
    (folder, run)
}

#[test]
fn every_sensor_gives_a_scan_that_comes_back_as_the_scene() {
    for sensor in ["spherical", "pinhole", "light_stripe", "lookup_table"] {
        let (folder, run) = modelled(&format!("--sensor {sensor} --density 0.5"));
        assert_eq!(run.number("views"), 4.0, "{sensor}");
        // Pixels of one to two centimetres on a ball of half a metre: chords err by 0.1 mm.
        let median = run.number("median distance from truth");
        assert!(median < 2e-4, "{sensor}: {median}");
        assert!(run.number("95 % of distances below") < 0.01, "{sensor}");
        assert!(run.number("completeness of that") > 90.0, "{sensor}");
        assert!(run.number("oriented like the truth") > 99.9, "{sensor}");
        let view = &folder.json("scan/scan.json")["views"][0];
        assert_eq!(view["sensor"], sensor);
    }
}

#[test]
fn scanners_of_true_size_give_sections_on_the_truth() {
    // Unit, spacing of the samples and radius of the nearest bend, in millimetres.
    for (scene, options, in_millimetres, spacing, radius) in
        [("smart_eye_jug", "", 10.0, 1.4, 6.0), ("hyscan_mask", "--views 2", 1.0, 0.55, 9.0)]
    {
        let folder = Folder::empty();
        folder.run(&format!("simulate {scene} --noise-free --out scan {options}")).succeeded();
        let run = folder.reconstruct("scan --interval 8mm").succeeded();
        assert_eq!(run.stderr, "", "{scene}: no note, no warning");
        // A chord between two samples errs by the sagitta where the surface bends most.
        let sagitta = spacing * spacing / (8.0 * radius) / in_millimetres;
        let median = run.number("median distance from truth");
        assert!(median < sagitta, "{scene}: {median} against {sagitta}");
        let p95 = run.number("95 % of distances below");
        assert!(p95 < spacing / 2.0 / in_millimetres, "{scene}: {p95}");
        assert!(run.number("completeness of that") > 97.0, "{scene}: {}", run.stdout);
        assert!(run.number("oriented like the truth") > 99.5, "{scene}: {}", run.stdout);
        // The scanner is not scaled to the scene.
        let view = &folder.json("scan/scan.json")["views"][0];
        match view["sensor"].as_str().unwrap() {
            "light_stripe" => assert_eq!(view["baseline"], 30.0),
            _ => assert_eq!(view["projector"], serde_json::json!([-30.0, 0.0])),
        }
    }
}

#[test]
fn light_becomes_curves() {
    let (folder, run) = modelled("--sensor light_stripe --density 0.2 --views 2 --stripe-images");
    // The stripe is found to a tenth of a cell, and a cell is worth some 4 mm of depth here.
    assert!(run.number("median distance from truth") < 0.001, "{}", run.stdout);
    assert!(run.number("oriented like the truth") > 99.0, "{}", run.stdout);
    assert_eq!(folder.json("scan/scan.json")["views"][1]["file"], "stripes_001.npy");
}

#[test]
fn views_beyond_the_stations_look_elsewhere() {
    let (folder, run) = modelled("--views 6");
    assert_eq!(run.number("views"), 6.0);
    let scan = folder.json("scan/scan.json");
    assert_ne!(scan["views"][4]["pose"], scan["views"][0]["pose"]);
    assert_eq!(scan["views"][4]["theta0"], scan["views"][0]["theta0"]);
}

#[test]
fn a_noisy_pose_is_stated_beside_the_true_one() {
    let folder = Folder::empty();
    let scene = std::fs::read_to_string(fixture("objects.scene.toml")).unwrap();
    let noisy = scene.replace("[noise]", "[noise]\npose = { degrees = 0.1, shift = 0.001 }");
    assert_ne!(noisy, scene);
    folder.write("noisy.toml", noisy);
    folder.run("simulate noisy.toml --out scan").succeeded();
    let view = &folder.json("scan/scan.json")["views"][0];
    assert!(view["pose_true"].is_array() && view["pose_true"] != view["pose"]);
    let exact = Folder::simulated("objects.scene.toml");
    assert!(exact.json("scan/scan.json")["views"][0]["pose_true"].is_null());
}

#[test]
fn wrong_sensor_options_are_told() {
    let folder = Folder::empty();
    folder.run("simulate room --sensor sonar").failed_with(2, &["sonar", "light_stripe"]);
    folder.run("simulate room --density 2").failed_with(2, &["--sensor"]);
    folder.run("simulate room --sensor pinhole --density 0").failed_with(2, &["--density"]);
    folder.run("simulate room --views 0").failed_with(2, &["--views"]);
}

#[test]
fn a_depth_camera_as_real_ones_gives_a_model_that_is_scored_only_if_wanted() {
    let folder = Folder::empty();
    folder.run("simulate kitchen --out scan").succeeded();
    let scan = folder.json("scan/scan.json");
    assert!(scan["sigma"].is_null() && scan["views"][0]["pose_true"].is_array());
    let run = folder.reconstruct("scan --no-score").succeeded();
    assert_eq!(run.number("views"), 16.0);
    assert!(run.number("planes with curves") >= 44.0, "{}", run.stdout);
    // Where neighbouring pixels share most of their noise, every other row and column is read.
    let halved = run.number("views at half their resolution");
    let report = folder.json("out/report.json");
    let views = report["views"].as_array().unwrap();
    let share = |view: &serde_json::Value| {
        let [read, valid] = ["read_pixels", "valid_pixels"].map(|key| view[key].as_f64().unwrap());
        read / valid
    };
    let shares: Vec<f64> = views.iter().map(share).filter(|share| *share < 1.0).collect();
    assert!(halved > 4.0 && shares.len() as f64 == halved, "{halved}: {shares:?}");
    assert!(shares.iter().all(|share| (0.24..0.26).contains(share)), "{shares:?}");
    // Poses err by 4 mm, and scale and lens by 0.4 % of two to three metres.
    assert!(run.number("spread between views") > 0.004, "{}", run.stdout);
    assert!(
        !run.stdout.contains("from truth") && !run.stdout.contains("scoring"),
        "{}",
        run.stdout
    );
    let score = folder.run("evaluate out").succeeded();
    assert!(score.number("median distance from truth") < 0.03, "{}", score.stdout);
}
