//! Real scans from end to end, where they are: `../shared/data` beside the workspace.

use super::common::{Folder, Run};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A data set; tells that the test is skipped where there is none.
fn data(name: &str) -> Option<PathBuf> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = shared.join(name);
    if folder.exists() {
        return Some(folder.canonicalize().unwrap());
    }
    // Written past the capture of passing tests' output: a skipped test must not look like a run
    // one.
    let reason = format!("skipped: ../shared/data is absent ({} is not there)", folder.display());
    let mut stderr = std::io::stderr();
    writeln!(stderr, "{reason}").unwrap();
    None
}

/// Ten range images of Stanford's bunny on planes 2 mm apart.
fn bunny(configuration: &Path, folder: &Folder) -> Run {
    let planes = "--normal 0,1,0 --interval 2mm";
    folder.reconstruct(&format!("{} {planes}", configuration.display())).succeeded()
}

#[test]
fn the_bunny_agrees_with_its_published_surface() {
    let Some(data) = data("stanford_bunny") else { return };
    let folder = Folder::empty();
    let run = bunny(&data.join("bun.conf"), &folder);
    assert_eq!(run.told("warning: "), [""; 0]);
    assert!(run.stderr.contains("taken as metres by its convention"), "{}", run.stderr);
    assert_eq!(run.number("views"), 10.0);
    // The scans do not show the bunny's base, and the reference closes it: from 6 cm on.
    let reference = data.join("reference/bun_zipper.ply");
    let options = "--from 0.06 --tolerance 0.5mm";
    let line = format!("evaluate out --reference {} {options}", reference.display());
    let score = folder.run(&line).succeeded();
    assert!(score.number("median distance from truth") < 0.06e-3, "{}", score.stdout);
    assert!(score.number("95 % of distances below") < 0.25e-3, "{}", score.stdout);
    assert!(score.number("completeness") > 99.0, "{}", score.stdout);
    assert!(score.number("duplicated length") < 1.0, "{}", score.stdout);
    assert!(score.number("oriented like the truth") > 99.9, "{}", score.stdout);
    assert!(score.number("planes with truth") > 60.0, "{}", score.stdout);
}

/// A configuration with every quaternion conjugated and every file by its absolute path.
fn conjugated(data: &Path) -> String {
    let text = std::fs::read_to_string(data.join("bun.conf")).unwrap();
    let scans = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>());
    let lines = scans.filter(|w| w.first() == Some(&"bmesh")).map(|words| {
        let [_, file, tx, ty, tz, qx, qy, qz, qw] = words[..] else { panic!("{words:?}") };
        let [x, y, z] = [qx, qy, qz].map(|q| -q.parse::<f64>().unwrap());
        format!("bmesh {} {tx} {ty} {tz} {x} {y} {z} {qw}\n", data.join(file).display())
    });
    lines.collect()
}

#[test]
fn the_bunny_with_conjugated_quaternions_is_warned_of() {
    let Some(data) = data("stanford_bunny") else { return };
    let folder = Folder::empty();
    folder.write("conjugated.conf", conjugated(&data));
    let run = bunny(Path::new("conjugated.conf"), &folder);
    let warnings = run.told("warning: ");
    assert!(warnings.len() == 1, "{}", run.stderr);
    assert!(warnings[0].ends_with("Pass --pose-convention conjugate"), "{}", run.stderr);
}

/// The turntable's axis is y. The first camera of the kitchen is inclined by 27°, and with it the
/// world: the floor's normal there is (-0.02, -0.88, -0.47), found with another program.
#[test]
fn real_scans_are_modelled_on_planes_that_fit_them() {
    let normal_of = |name: &str, planes: std::ops::RangeInclusive<f64>| {
        let folder = Folder::empty();
        let run = folder.reconstruct(&format!("{}", data(name)?.display())).succeeded();
        assert!(run.stderr.contains("suggested planes are used: --normal"), "{}", run.stderr);
        assert!(planes.contains(&run.number("planes with curves")), "{}", run.stdout);
        let normal = folder.json("out/report.json")["settings"]["normal"].clone();
        Some(<[f64; 3]>::try_from(serde_json::from_value::<Vec<f64>>(normal).unwrap()).unwrap())
    };
    if let Some(normal) = normal_of("stanford_bunny/bun.conf", 70.0..=80.0) {
        assert_eq!(normal, [0.0, 1.0, 0.0]);
    }
    if let Some([x, y, z]) = normal_of("rgbd_redkitchen", 60.0..=110.0) {
        let cosine = -0.017 * x - 0.882 * y - 0.471 * z;
        assert!(cosine > 0.998, "{x} {y} {z}");
    }
}

#[test]
fn the_red_kitchen_is_read_from_its_folder() {
    let Some(data) = data("rgbd_redkitchen") else { return };
    let folder = Folder::empty();
    let options = "--normal 0,-1,0 --interval 0.5m";
    let run = folder.reconstruct(&format!("{} {options}", data.display())).succeeded();
    let repaired = "50 of 50 poses replaced by the nearest rotation";
    assert!(run.stderr.contains(repaired), "{}", run.stderr);
    assert!(run.stderr.contains("0.001 m per count"), "{}", run.stderr);
    assert_eq!(run.told("warning: "), [""; 0]);
    assert_eq!(run.number("views"), 50.0);
    // A room some three metres high has six planes of half a metre; the sensor errs by centimetres.
    assert!((4.0..=9.0).contains(&run.number("planes with curves")), "{}", run.stdout);
    assert!((0.002..0.05).contains(&run.number("spread between views")), "{}", run.stdout);
    let notes = folder.json("out/report.json")["reader_notes"].to_string();
    assert!(notes.contains(repaired), "{notes}");
}

/// The bunny's views are grids of points, which have no inverse mapping.
#[test]
fn the_dissertation_models_grids_of_points() {
    let Some(data) = data("stanford_bunny") else { return };
    let folder = Folder::empty();
    let planes = "--normal 0,1,0 --interval 10mm --method dissertation --fusion pairwise";
    let run = folder.reconstruct(&format!("{} {planes}", data.join("bun.conf").display()));
    assert!(run.succeeded().number("planes with curves") >= 15.0);
    let reference = data.join("reference/bun_zipper.ply");
    let options = "--from 0.06 --tolerance 0.5mm";
    let line = format!("evaluate out --reference {} {options}", reference.display());
    let score = folder.run(&line).succeeded();
    assert!(score.number("median distance from truth") < 0.2e-3, "{}", score.stdout);
    assert!(score.number("oriented like the truth") > 99.0, "{}", score.stdout);
    assert!(score.number("completeness") > 90.0, "{}", score.stdout);
}
