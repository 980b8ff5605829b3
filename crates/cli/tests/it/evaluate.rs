//! `transect evaluate`: what is scored, and against what.

use super::command_line::reconstructed;

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
