//! A part of a scan: some of its views, and their points within limits.

use super::common::{Folder, Run};

fn named_views(folder: &Folder) -> Vec<String> {
    let report = folder.json("out/report.json");
    let views = report["views"].as_array().unwrap();
    views.iter().map(|view| view["name"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn views_are_chosen_by_number_range_and_name() {
    let folder = Folder::simulated("objects.scene.toml");
    let all = ["range_000.npy", "range_001.npy", "range_002.npy", "range_003.npy"];
    for (options, numbers) in [
        ("--views 3,0", vec![0, 3]),
        ("--views 1-2,range_003.npy", vec![1, 2, 3]),
        ("--every 2", vec![0, 2]),
        ("--views 1-3 --every 2", vec![1, 3]),
    ] {
        let run = folder.reconstruct(&format!("scan {options}")).succeeded();
        let count = numbers.len();
        let note = format!("note: {count} of 4 views are used, as asked for");
        assert_eq!(run.told("note: ")[0], note, "{options}");
        assert_eq!(named_views(&folder), numbers.iter().map(|&k| all[k]).collect::<Vec<_>>());
        assert_eq!(run.number("views"), count as f64);
    }
    let report = folder.json("out/report.json");
    assert_eq!(report["selection"], serde_json::json!({ "views": "1-3", "every": 2 }));
    for (options, reason) in [
        (
            "--views 4",
            "--views: there is no view \"4\"; write names of views, or numbers from 0 to 3",
        ),
        ("--views 2-9", "there is no view \"2-9\""),
        ("--views 2-1", "there is no view \"2-1\""),
        ("--views nothing.npy", "there is no view \"nothing.npy\""),
        ("--every 0", "--every: 0 selects no view; write 1 or more"),
        ("--crop 1,2", "--crop: \"1,2\" has 2 lengths; write x0,x1,y0,y1,z0,z1"),
        ("--crop 2,1,,,,", "--crop: x runs from 2 m to 1 m; write x0 < x1"),
        ("--crop a,,,,,", "--crop: \"a\" is not a length"),
        ("--max-range 0", "--max-range: \"0\" leaves no pixel; write a length over 0"),
        ("--max-range=-1m", "--max-range: \"-1m\" leaves no pixel; write a length over 0"),
        ("--max-range far", "--max-range: \"far\" is not a length"),
        ("--max-range 20 --store s", "--max-range: a store takes whole views"),
    ] {
        folder.reconstruct(&format!("scan {options}")).failed_with(2, &["error: ", reason]);
    }
    // A store that grows by some views, then by the others, is the store of all.
    folder.reconstruct("scan --store all.transect").succeeded();
    let curves = folder.bytes("out/contours.json");
    folder.reconstruct("scan --views 1-2 --store some.transect").succeeded();
    let rest = folder.reconstruct("scan --store some.transect").succeeded();
    assert_eq!(rest.number("views there already"), 2.0);
    assert!(folder.bytes("out/contours.json") == curves);
}

/// The extent that `inspect` prints for an axis, in the unit that is printed.
fn extent(run: &Run, axis: &str) -> [f64; 2] {
    let text = run.value(&format!("extent, {axis}"));
    let ends: Vec<f64> = text.split(" to ").map(|end| end.parse().unwrap()).collect();
    ends.try_into().unwrap()
}

#[test]
fn a_crop_leaves_points_out_and_makes_no_surface() {
    let folder = Folder::simulated("objects.scene.toml");
    let whole = folder.run("inspect scan --output-unit m").succeeded();
    let [low, high] = extent(&whole, "x");
    let middle = 0.5 * (low + high);
    let crop = format!("--crop {}mm,,,,,", 1000.0 * middle);
    let cropped = folder.run(&format!("inspect scan --output-unit m {crop}")).succeeded();
    assert!(extent(&cropped, "x")[0] >= middle - 1e-3 && extent(&cropped, "x")[1] == high);
    assert!(cropped.stdout.contains(&format!("reconstruct scan --output-unit m {crop}")));
    let full = folder.reconstruct("scan").succeeded();
    let run = folder.reconstruct(&format!("scan {crop}")).succeeded();
    assert!(run.number("curve length") < 0.8 * full.number("curve length"));
    assert!(!run.stdout.contains("distance from truth"), "{}", run.stdout);
    // No curve runs along the cut: every node is a point of the surface, within the box.
    let contours = folder.json("out/contours.json");
    for plane in contours["planes"].as_array().unwrap() {
        for line in plane["polylines"].as_array().unwrap() {
            for node in line["points"].as_array().unwrap() {
                assert!(node[0].as_f64().unwrap() > middle - 1e-2, "{node}");
            }
        }
    }
    assert_eq!(folder.json("out/report.json")["selection"]["crop"], crop[7..]);
}

#[test]
fn a_crop_of_a_few_pixels_is_no_damaged_image() {
    let folder = Folder::simulated("objects.scene.toml");
    // It leaves 3 of 12 000 pixels of a view.
    let crop = "scan --crop 0,0.4,0,0.4,, --no-score";
    folder.reconstruct(crop).succeeded();
    let inspected = folder.run(&format!("inspect {}", crop.trim_end_matches(" --no-score")));
    assert!(!inspected.succeeded().stderr.contains("pixels are valid"));
}

#[test]
fn views_without_a_point_in_range_are_left_out() {
    let folder = Folder::simulated("objects.scene.toml");
    let inspected = folder.run("inspect scan --output-unit m").succeeded();
    let nearest = |number: usize| -> f64 {
        let name = format!("range_00{number}.npy");
        let line = inspected.stdout.lines().find(|line| line.contains(&name)).unwrap();
        line.split('|').nth(6).unwrap().split(',').next().unwrap().trim().parse().unwrap()
    };
    let mut all: Vec<f64> = (0..4).map(nearest).collect();
    all.sort_by(f64::total_cmp);
    let limit = 0.5 * (all[0] + all[3]);
    let empty = (0..4).filter(|&k| nearest(k) > limit).count();
    let run = folder.run(&format!("inspect scan --max-range {limit}")).succeeded();
    assert_eq!(run.number("views"), (4 - empty) as f64);
    assert!(
        run.stderr.contains(&format!("{empty} views left out, without a point")),
        "{}",
        run.stderr
    );
    let none = folder.reconstruct("scan --max-range 1mm");
    none.failed_with(1, &["scan: no view has a point within the limits; inspect shows"]);
}
