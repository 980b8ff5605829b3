//! Two cameras look into the corner of a room, and the pose of the second one is wrong by 2 cm.
//!
//! `cargo run --release -p transect-register --example refine_poses`
#![allow(clippy::print_stdout, reason = "an example prints what it found")]

use std::error::Error;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageSize, Isometry3, Point3, RangeImage, SensorPlane, Vector3, View,
};
use transect_register::{CoarseView, RefineOptions, judge, refine};
use transect_sensors::{Intrinsics, Pinhole};

/// The image of the corner at the origin, whose walls are x = 0, y = 0 and z = 0.
fn view(name: &str, eye: Point3) -> Result<View, Box<dyn Error>> {
    let size = ImageSize { rows: 240, cols: 320 };
    let camera = Pinhole::new(size, Intrinsics { fx: 300.0, fy: 300.0, cx: 159.5, cy: 119.5 })?;
    let target = Point3::new(0.2, 0.2, 0.2);
    // Sensor axes: x to the right, y down, z ahead.
    let pose = Isometry3::face_towards(&eye, &target, &-Vector3::z());
    let wall = |axis: usize| {
        let normal = pose.inverse_transform_vector(&Vector3::ith(axis, 1.0));
        SensorPlane { normal, offset: -eye[axis] }
    };
    let walls = [wall(0), wall(1), wall(2)];
    let depth = |pixel| {
        let seen = walls.iter().filter_map(|wall| camera.plane_value(pixel, wall));
        seen.fold(f64::INFINITY, f64::min) as f32
    };
    let image = RangeImage::from_values(size, size.all_pixels().map(depth).collect())?;
    Ok(View::new(name, image, Arc::new(camera), pose, Some(0.001))?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let first = view("first", Point3::new(2.0, 1.5, 1.2))?;
    let second = view("second", Point3::new(1.4, 2.1, 1.0))?;
    let error = Isometry3::translation(0.02, 0.0, 0.0);
    let wrong = second.with_pose(error * second.world_from_sensor())?;

    let copies = [CoarseView::new(&first), CoarseView::new(&wrong)];
    println!("{} findings at the given poses", judge(&copies).findings.len());
    let refinement = refine(&copies, &RefineOptions::default())?;
    for pose in &refinement.poses {
        let millimetres = 1000.0 * pose.translation;
        println!("{}: {:?}, moved by {millimetres:.1} mm", pose.view, pose.outcome);
    }
    let relative = |a: &Isometry3, b: &Isometry3| a.inverse() * b;
    let [a, b] = [0, 1].map(|k: usize| refinement.poses[k].world_from_sensor);
    let truth = relative(first.world_from_sensor(), second.world_from_sensor());
    let left = (relative(&a, &b).translation.vector - truth.translation.vector).norm();
    assert!(left < 0.001, "{left}");
    println!("{:.2} mm of the error of 20 mm are left", 1000.0 * left);
    Ok(())
}
