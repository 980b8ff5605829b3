//! What the tests of whole scenes share.

use transect_device::View;
use transect_geometry::{Curve, Point2};
use transect_scene::{Description, Noise};

/// The views of all stations.
pub fn views(description: &Description, noise: &Noise) -> Vec<View> {
    let scene = description.scene();
    let stations = description.stations.iter().enumerate();
    stations
        .map(|(k, s)| {
            scene.view(&s.name, s.frame().unwrap(), s.world_from_sensor, noise, k as u64).unwrap()
        })
        .collect()
}

/// Winding number of the curves around a point, from crossings of the ray to the right.
pub fn winding(curves: &[Curve], p: Point2) -> i32 {
    let crossings = curves.iter().flat_map(Curve::units).map(|u| {
        let (up, down) = (u.start.y <= p.y && p.y < u.end.y, u.end.y <= p.y && p.y < u.start.y);
        let left_of_unit = u.line_value(&p) < 0.0;
        i32::from(up && left_of_unit) - i32::from(down && !left_of_unit)
    });
    crossings.sum()
}
