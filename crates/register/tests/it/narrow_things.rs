//! Things that are narrower than a cell of a coarse copy: trunks of trees, frames of windows.

use super::common::{coarse, described};
use super::refining::{apart, given, shaken};
use std::sync::Arc;
use transect_device::{Point3, View};
use transect_register::{RefineOptions, refine};
use transect_sensors::{PointGrid, RayStarts};

/// Forty trunks on level ground, and five scanners that turn around among them.
fn forest() -> String {
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
    let views = described(&forest());
    let wrong = shaken(&views, 0.05, 0.02);
    let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
    let poses: Vec<_> = refinement.poses.iter().map(|pose| pose.world_from_sensor).collect();
    let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &poses));
    assert!(after < 0.004, "{before} m before and {after} m after: {refinement:?}");
}

/// A wall with 36 boxes of a size over a street, from three scanners that turn around.
pub fn street([thick, wide, high]: [f64; 3]) -> String {
    let mut text = "name = \"street\"\nunit = \"m\"\n\
        [planes]\nnormal = [0, 0, 1]\noffset = 1.3\ninterval = 0.5\n\
        [noise]\nsigma = 0.003\nseed = 5\n\
        [[solid]]\nname = \"street\"\nshape = \"box\"\nsize = [30, 40, 0.5]\nat = [10, 15, -0.25]\n\
        [[solid]]\nname = \"wall\"\nshape = \"box\"\nsize = [0.5, 36, 12]\nat = [-0.25, 15, 6]\n"
        .to_owned();
    for k in 0..36 {
        let (y, z) = (2.5 * f64::from(k % 12) + 1.2, 3.0 * f64::from(k / 12) + 2.0);
        text += &format!(
            "[[solid]]\nname = \"box\"\nshape = \"box\"\nsize = [{thick}, {wide}, {high}]\n\
             at = [{}, {y}, {z}]\n",
            0.5 * thick
        );
    }
    for (k, [x, y]) in [[10.0, 4.0], [14.0, 15.0], [9.0, 26.0]].iter().enumerate() {
        text += &format!(
            "[[station]]\nname = \"{k}\"\nsensor = \"spherical\"\nrows = 600\ncols = 1200\n\
             theta = [180, -179.7]\nphi = [60, -60]\nat = [{x}, {y}, 1.7]\nlook_at = [0, {y}, 1.7]\n"
        );
    }
    text
}

/// The view as most programs export it: a point for each pixel.
fn as_points(view: &View) -> View {
    let size = view.image().size();
    let missing = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let point = |pixel| view.point_in_sensor(pixel).unwrap_or(missing);
    let points = size.all_pixels().map(point).collect();
    let starts = RayStarts::Viewpoint(Point3::origin());
    let (frame, image) = PointGrid::new(size, points, starts).unwrap();
    let pose = *view.world_from_sensor();
    View::new(view.name(), image, Arc::new(frame), pose, view.sigma()).unwrap()
}

/// No patch tells where a scanner is along the wall: the sides of frames are one or two pixels
/// wide.
#[test]
fn frames_hold_scanners_along_a_wall() {
    let views = described(&street([0.2, 0.3, 2.5]));
    let points: Vec<View> = views.iter().map(as_points).collect();
    for views in [views, points] {
        let wrong = shaken(&views, 0.03, 0.02);
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
        let poses: Vec<_> = refinement.poses.iter().map(|pose| pose.world_from_sensor).collect();
        let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &poses));
        eprintln!("{before} m off before, {after} m after refinement");
        assert!(after < 0.01, "{before} m before and {after} m after: {refinement:?}");
    }
}
