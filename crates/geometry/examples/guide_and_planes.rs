//! Section planes along a bent axis, and one curve on one of them.
//!
//! Run it with `cargo run --example guide_and_planes`.

use std::f64::consts::{PI, TAU};
use transect_geometry::{Curve, CurvedGuide, Node, PlaneFamily, PlaneIndex, Point2, Point3, Side};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The axis of a tunnel in metres: 100 m east, a bend with a radius of 60 m, 100 m north.
    let axis = [(0.0, 0.0), (160.0, 0.0), (160.0, 160.0)];
    let axis = axis.map(|(east, north)| Point3::new(east, north, 0.0));
    let guide = CurvedGuide::polyline(axis.to_vec(), Some(60.0))?;
    let length = 100.0 + 60.0 * PI / 2.0 + 100.0;
    assert!((guide.length() - length).abs() < 1e-9);
    // Planes across the bend meet at its centre, so only points near the axis can be used.
    assert!((guide.usable_distance() - 0.9 * 60.0).abs() < 0.1);

    // A plane every 5 m along the axis.
    let planes = PlaneFamily::new(guide, 0.0, 5.0)?;
    let (first, last) = planes.ends().ok_or("a curved guide has ends")?;
    assert_eq!((first, last), (PlaneIndex(0), PlaneIndex(58)));
    let frame = planes.frame(PlaneIndex(10));
    assert!((frame.origin() - Point3::new(50.0, 0.0, 0.0)).norm() < 1e-9);

    // The wall of the tunnel, 4 m around the axis. The solid is on the left of a curve, so the
    // wall around a hollow runs clockwise, and its area is negative.
    let at = |k: i32| TAU * f64::from(-k) / 360.0;
    let wall = (0..360).map(|k| Node::at(Point2::new(4.0 * at(k).cos(), 4.0 * at(k).sin())));
    let wall = Curve::new(wall.collect(), true)?;
    let area = wall.signed_area().ok_or("a closed curve has an area")?;
    assert!((area + PI * 16.0).abs() < 0.01);

    // A point of the world 3 m above the axis is in the tunnel: outside of the solid.
    let point = frame.plane_from_world(&Point3::new(50.0, 0.0, 3.0));
    let foot = wall.foot(&point);
    assert!((foot.distance - 1.0).abs() < 1e-3);
    assert_eq!(wall.side_at(&foot, &point), Some(Side::Outside));
    Ok(())
}
