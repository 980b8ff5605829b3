//! Trunks of trees: things that are thinner than a cell of a coarse copy.

use super::common::{coarse, described};
use super::refining::{apart, given, shaken};
use transect_register::{RefineOptions, refine};

/// Forty trunks on level ground, and five scanners that turn around among them.
fn scene() -> String {
    let mut text = "name = \"forest\"\nunit = \"m\"\n\
        [planes]\nnormal = [0, 0, 1]\noffset = 1.3\ninterval = 0.5\n\
        [noise]\nsigma = 0.004\nseed = 5\n\
        [[solid]]\nname = \"ground\"\nshape = \"box\"\nsize = [30, 30, 0.5]\nat = [0, 0, -0.25]\n"
        .to_owned();
    // Even steps of the golden ratio never form rows.
    let place = |k: usize, ratio: f64| 26.0 * ((k as f64 * ratio) % 1.0) - 13.0;
    for k in 1..=40 {
        let (x, y, radius) = (place(k, 0.618034), place(k, 0.414214), 0.06 + 0.006 * k as f64);
        text += &format!(
            "[[solid]]\nname = \"trunk\"\nshape = \"cylinder\"\nradius = {radius}\nheight = 6\n\
             at = [{x}, {y}, 3]\n"
        );
    }
    for (k, [x, y]) in
        [[0.3, 0.4], [8.0, 3.0], [-7.0, 5.0], [-6.0, -8.0], [5.0, -7.0]].iter().enumerate()
    {
        text += &format!(
            "[[station]]\nname = \"{k}\"\nsensor = \"spherical\"\nrows = 560\ncols = 1280\n\
             theta = [180, -179.71875]\nphi = [70, -45]\nat = [{x}, {y}, 1.6]\n\
             look_at = [13, {y}, 1.6]\n"
        );
    }
    text
}

#[test]
fn trunks_hold_scanners_over_level_ground() {
    let views = described(&scene());
    let wrong = shaken(&views, 0.05, 0.02);
    let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
    let poses: Vec<_> = refinement.poses.iter().map(|pose| pose.world_from_sensor).collect();
    let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &poses));
    assert!(after < 0.004, "{before} m before and {after} m after: {refinement:?}");
}
