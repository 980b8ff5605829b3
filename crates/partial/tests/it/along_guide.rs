//! Curves along a curved guide whose points are wrong.

use crate::common::{Ball, SIZE, look};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use transect_device::{Isometry3, Note, Point3, Vector3};
use transect_geometry::{CurvedGuide, PlaneFamily};
use transect_partial::PartialModel;
use transect_partial::one_pass::{OnePassOptions, partial_model};
use transect_sensors::{Intrinsics, Pinhole};

/// A ball of 10 cm, seen along x from 40 cm off, on planes along a spline; lengths in centimetres.
fn ball_along(guide: &[[f64; 3]]) -> PartialModel {
    let (cx, cy) = (0.5 * SIZE.cols as f64, 0.5 * SIZE.rows as f64);
    let camera = Pinhole::new(SIZE, Intrinsics { fx: 140.0, fy: 140.0, cx, cy }).unwrap();
    let ball = Ball { centre: Point3::origin(), radius: 5.0 };
    let turned = Isometry3::rotation(Vector3::y() * FRAC_PI_2);
    let pose = turned * Isometry3::translation(0.0, 0.0, -40.0);
    let view = look(Arc::new(camera), pose, &[ball], &[]).unwrap();
    let points = guide.iter().map(|p| Point3::from(*p)).collect();
    let guide = Arc::new(CurvedGuide::spline(points).unwrap());
    let planes = PlaneFamily::new(guide, 0.3, 1.0).unwrap();
    partial_model(&view, &planes, &OnePassOptions::default()).unwrap()
}

fn length(model: &PartialModel) -> f64 {
    model.planes.iter().flat_map(|plane| &plane.curves).map(|c| c.curve.length()).sum()
}

#[test]
fn a_guide_with_one_wrong_coordinate_makes_no_curves_between_its_passes() {
    let guide = |x: f64| [[0.0, 0.0, -60.0], [2.0, 0.0, -20.0], [x, 0.0, 20.0], [0.0, 0.0, 60.0]];
    let (sound, wrong) = (ball_along(&guide(1.0)), ball_along(&guide(1e5)));
    assert!(length(&sound) > 50.0 && sound.notes.is_empty(), "{}", length(&sound));
    assert!(length(&wrong) < 2.0 * length(&sound), "{} of {}", length(&wrong), length(&sound));
    let named = |note: &Note| note.text.contains("point 2 of the guide, (100000, 0, 20)");
    assert!(wrong.notes.iter().any(named), "{:?}", wrong.notes);
}
