//! The figures of `explain` and `explain-growth`.

use super::common::{Folder, Run, fixture};
use serde_json::Value;
use std::collections::BTreeSet;

/// The figures of a page, in the order in which it shows them; each must be a whole SVG file with
/// its number, and the folder must hold nothing else.
fn figures(folder: &Folder, out: &str) -> Vec<String> {
    let page = folder.text(&format!("{out}/index.html"));
    let shown: Vec<String> =
        page.split("src=\"").skip(1).map(|s| s.split('"').next().unwrap().to_owned()).collect();
    let mut there: BTreeSet<String> = std::fs::read_dir(folder.path(out))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    there.remove("index.html");
    assert_eq!(there, shown.iter().cloned().collect());
    for (number, name) in shown.iter().enumerate() {
        let svg = folder.text(&format!("{out}/{name}"));
        assert!(name.starts_with(&format!("{:02}-", number + 1)), "{name}");
        assert!(svg.contains(&format!("<title>{} · ", number + 1)), "{name}");
        // Without the bytes of rasters, which hold any letters.
        let parts = svg.split("base64,").enumerate();
        let text =
            parts.map(|(k, part)| if k == 0 { part } else { part.split_once('"').unwrap().1 });
        let text: String = text.collect();
        assert!(text.ends_with("</svg>\n") && !text.contains("NaN") && !text.contains("inf,"));
        let opened =
            svg.matches('<').count() - svg.matches("</").count() - svg.matches("/>").count();
        assert_eq!(opened, svg.matches("</").count(), "{name}");
    }
    shown
}

fn has_all(shown: &[String], steps: &[&str]) {
    for step in steps {
        assert!(shown.iter().any(|name| name.contains(step)), "no figure {step} among {shown:?}");
    }
}

#[test]
fn every_step_of_the_dissertation_has_its_figure() {
    let folder = Folder::simulated("objects.scene.toml");
    let line = "explain scan --view 1 --method dissertation --fusion pairwise --out a";
    let run = folder.run(line).succeeded();
    let shown = figures(&folder, "a");
    has_all(&shown, &["object-range-image", "plane-range-image", "label-image", "codes"]);
    has_all(&shown, &["thinning", "tracing", "subpixel", "directions"]);
    has_all(&shown, &["envelopes", "overlap", "verification", "averaging", "merged"]);
    assert_eq!(run.number("figures"), shown.len() as f64);
    assert!(run.number("contour pixels") > 20.0, "{}", run.stdout);
    assert!(folder.text("a/10-overlap.svg").contains("valid, pattern ("));
    // The same scan gives the same bytes, for any number of the view's names.
    folder.run(&line.replace("--view 1", "--view range_001.npy").replace("--out a", "--out b"));
    for name in figures(&folder, "b") {
        assert_eq!(
            folder.bytes(&format!("a/{name}")),
            folder.bytes(&format!("b/{name}")),
            "{name}"
        );
    }
}

#[test]
fn every_room_of_the_default_methods_has_its_figure() {
    let folder = Folder::simulated("objects.scene.toml");
    let run = folder.run("explain scan --out a").succeeded();
    let shown = figures(&folder, "a");
    has_all(&shown, &["range-image", "heights", "pairs", "links", "curves"]);
    has_all(&shown, &["observations", "groups", "nodes", "chains", "fused"]);
    assert!(run.number("observations") > run.number("nodes"), "{}", run.stdout);
}

#[test]
fn a_plane_grows_by_cases_and_patterns() {
    let folder = Folder::simulated("objects.scene.toml");
    let run = folder.run("explain-growth scan --out a").succeeded();
    let shown = figures(&folder, "a");
    let cases = |run: &Run| -> f64 {
        let names = ["1 (new plane)", "2 (appended)", "3 (merged)"];
        names.iter().map(|name| run.number(&format!("views of case {name}"))).sum()
    };
    assert_eq!(cases(&run), 4.0, "{}", run.stdout);
    assert_eq!(run.number("views of case 1 (new plane)"), 1.0);
    assert!(run.number("merges of pattern (a) end to beginning") > 0.0, "{}", run.stdout);
    // Open curves have gaps; the longest is a length.
    assert!(run.number("gaps left") > 0.0 && run.value("longest gap").ends_with(" m"));
    // The range image and the plane of each view, and the animation.
    let last = folder.text(&format!("a/{}", shown.last().unwrap()));
    assert_eq!(2 * last.matches("<animate ").count(), shown.len() - 1);
    assert!(folder.text("a/01-image-000.svg").contains("Range image of view"));
    let first = folder.text("a/02-view-000.svg");
    assert!(first.contains("Case 1") && first.contains("Gaps left: "), "{first}");
}

/// A person stands in the room while the first scanner measures; the others look through him.
#[test]
fn the_last_figure_shows_the_curves_of_the_model() {
    let folder = Folder::empty();
    let room = std::fs::read_to_string(fixture("room.scene.toml")).unwrap();
    let person = "\n[[solid]]\nshape = \"cylinder\"\nradius = 0.22\nheight = 1.7\n\
                  at = [1.5, 1.1, 0.85]\nstations = [0]\n";
    let room = room.replace("interval = 0.05", "interval = 0.4") + person;
    folder.write("visited.scene.toml", room);
    folder.run("simulate visited.scene.toml --out scan").succeeded();
    for (command, fusion, step) in [
        ("explain", "consensus", "12-seen-through.svg"),
        ("explain", "pairwise", "12-seen-through.svg"),
        ("explain-growth", "pairwise", "10-seen-through.svg"),
    ] {
        folder.reconstruct(&format!("scan --fusion {fusion} --no-score")).succeeded();
        let model = folder.json("out/contours.json");
        let plane = |plane: &&Value| plane["index"] == 1;
        let plane = model["planes"].as_array().unwrap().iter().find(plane).unwrap().clone();
        let curves = plane["polylines"].as_array().unwrap().len() as f64;
        let line = format!("{command} scan --plane 1 --fusion {fusion} --out {command}-{fusion}");
        let run = folder.run(&line).succeeded();
        assert_eq!(run.number("curves of the plane"), curves, "{}", run.stdout);
        assert!(run.number("nodes seen through, left out") > 20.0, "{}", run.stdout);
        let shown = figures(&folder, &format!("{command}-{fusion}"));
        assert_eq!(shown.last().unwrap(), step);
    }
}

#[test]
fn planes_grow_by_pairwise_alone() {
    let folder = Folder::simulated("objects.scene.toml");
    folder
        .run("explain-growth scan --fusion consensus --out a")
        .failed_with(2, &["--fusion", "all views at once", "transect explain"]);
    assert!(!folder.path("a").exists());
    // The settings of pairwise hold without its name.
    let line = "explain-growth scan --threshold 9mm --out";
    folder.run(&format!("{line} a")).succeeded();
    folder.run(&format!("{line} b --fusion pairwise")).succeeded();
    assert_eq!(folder.bytes("a/02-view-000.svg"), folder.bytes("b/02-view-000.svg"));
}

#[test]
fn the_plane_is_chosen_by_the_method_that_is_explained() {
    let folder = Folder::simulated("objects.scene.toml");
    // Smooth surfaces are range jumps for a printed threshold of a tenth of a millimetre, so the
    // method finds curves on other planes than one_pass.
    let chosen = |options: &str| {
        let run = folder.run(&format!("explain scan {options} --out a")).succeeded();
        run.value("explained")
    };
    let printed = "--method dissertation --jump 0.1mm";
    assert_ne!(chosen(printed), chosen(""));
}

#[test]
fn views_planes_and_guides_that_cannot_be_drawn_are_refused() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.run("explain scan --view 9 --out a").failed_with(2, &["--view", "no view 9", "0 to 3"]);
    folder.run("explain scan --plane 4000 --out a").failed_with(
        2,
        &["--plane", "plane 4000 does not cross", "view range_000.npy saw; planes"],
    );
    folder
        .run("explain-growth scan --plane -4000 --out a")
        .failed_with(2, &["--plane", "no view has a curve"]);
    folder.write("axis.csv", "0,0,0\n0,0,1\n0,0.2,2\n");
    folder
        .run("explain scan --guide axis.csv --out a")
        .failed_with(2, &["--guide: ", "parallel planes", "--normal"]);
    folder.edit_json("scan/scan.json", "scan/bend.json", |m| {
        m["planes"] = serde_json::json!({ "offset": 0, "interval": 0.1,
            "guide": { "kind": "spline", "points": [[0, 0, 0], [0, 0, 1], [0, 0.2, 2]] } });
    });
    folder
        .run("explain scan/bend.json --out a")
        .failed_with(2, &["--normal: ", "the scan's own planes follow a curve"]);
}
