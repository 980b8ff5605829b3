//! Errors of depth cameras, found together with the poses.

use super::common::{coarse, simulated, simulated_with_noise};
use super::refining::{apart, given, shaken};
use std::collections::BTreeMap;
use std::sync::Arc;
use transect_device::{DepthOffsets, Pixel, RangeImage, Vector3, View};
use transect_register::{CoarseView, RefineOptions, refine};
use transect_sensors::{Intrinsics, Pinhole};

/// What is left of offsets over an image after the best `a + b row + c col`, as a root mean square.
/// Such offsets turn planes into other planes, so the views hardly tell them.
fn waves(offsets: &[(f64, f64, f64)]) -> f64 {
    let terms = |row: f64, col: f64| Vector3::new(1.0, row, col);
    let (mut matrix, mut right) = (nalgebra::Matrix3::zeros(), Vector3::zeros());
    for (row, col, offset) in offsets {
        matrix += terms(*row, *col) * terms(*row, *col).transpose();
        right += terms(*row, *col) * *offset;
    }
    let plane = matrix.try_inverse().unwrap() * right;
    let left = offsets.iter().map(|(row, col, offset)| offset - plane.dot(&terms(*row, *col)));
    (left.map(|d| d * d).sum::<f64>() / offsets.len() as f64).sqrt()
}

#[test]
fn the_error_of_a_depth_camera_is_found_with_the_poses() {
    let wave = |k: usize| 0.003 * (2.1 * (k % 9) as f64).sin() * (1.3 * (k / 9) as f64).cos();
    let error = DepthOffsets::new(7, 9, (0..63).map(wave).collect()).unwrap();
    let sound = simulated_with_noise("kitchen", |noise| noise.depth_camera.distortion = 0.0);
    let distorted = sound.iter().map(|view| {
        let image = error.correct(view.frame(), view.image()).unwrap();
        view.with_image(image).unwrap()
    });
    let views: Vec<View> = distorted.collect();
    let refinement = refine(&coarse(&shaken(&views, 0.2, 0.004)), &RefineOptions::default());
    let found = refinement.poses[0].depth_offsets.as_ref().unwrap();
    assert!(refinement.poses.iter().all(|pose| pose.depth_offsets.as_ref() == Some(found)));
    let size = views[0].image().size();
    let places = || size.all_pixels().filter(|p| p.row % 16 == 8 && p.col % 16 == 8);
    let left = |with: f64| -> f64 {
        let offset =
            |p: Pixel| (p.row as f64, p.col as f64, error.at(size, p) + with * found.at(size, p));
        waves(&places().map(offset).collect::<Vec<_>>())
    };
    let (before, after) = (left(0.0), left(1.0));
    println!("offsets of {before}, {after} of them not found");
    assert!(after < 0.4 * before, "{after} of {before} are left");
}

/// Views whose depths are this many times what they were.
fn with_depths_times(views: &[View], factor: f32) -> Vec<View> {
    let scaled = |view: &View| {
        let values = view.image().values().iter().map(|value| factor * value).collect();
        let image = RangeImage::from_values(view.image().size(), values).unwrap();
        view.with_image(image).unwrap()
    };
    views.iter().map(scaled).collect()
}

#[test]
fn the_scale_of_a_depth_camera_is_found_with_the_poses() {
    let sound = simulated("machined_part", "");
    for (factor, degrees, length) in [(1.006, 0.0, 0.0), (1.035, 0.0, 0.0), (1.006, 0.2, 0.1)] {
        let views = with_depths_times(&sound, factor);
        let wrong = shaken(&views, degrees, length);
        let refinement = refine(&coarse(&wrong), &RefineOptions::default());
        let found = refinement.poses[0].depth_offsets.as_ref().unwrap();
        let poses: Vec<_> = refinement.poses.iter().map(|p| p.world_from_sensor).collect();
        let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &poses));
        println!("scale {}, {before} to {after} mm", found.scale());
        let left = f64::from(factor) * found.scale() - 1.0;
        assert!(left.abs() < 1e-3, "scale {} of {factor}", found.scale());
        // Without the scale, right poses move by several millimetres.
        assert!(after < 0.2 * before.max(1.0), "{before} to {after}");
        assert!(refinement.poses.iter().all(|pose| pose.depth_offsets.as_ref() == Some(found)));
    }
}

/// A store keeps its images: poses that hide their wrong scale suit them.
#[test]
fn no_scale_is_found_where_images_stay() {
    let views = with_depths_times(&simulated("machined_part", ""), 1.006);
    let options = RefineOptions { images_stay: true, ..RefineOptions::default() };
    let refinement = refine(&coarse(&views), &options);
    let scales = refinement.poses.iter().filter_map(|pose| pose.depth_offsets.as_ref());
    assert!(scales.into_iter().all(|offsets| offsets.scale() == 1.0));
}

/// The views of cameras whose focal lengths are stated as these many times the true ones.
fn with_focal_lengths_times(views: &[View], [x, y]: [f64; 2]) -> Vec<View> {
    let misread = |view: &View| {
        let size = view.image().size();
        let place = |row, col| {
            let direction = view.frame().ray(Pixel::new(row, col)).unwrap().direction;
            direction / direction.z
        };
        let (first, last) = (place(0, 0), place(size.rows - 1, size.cols - 1));
        let fx = (size.cols - 1) as f64 / (last.x - first.x);
        let fy = (size.rows - 1) as f64 / (last.y - first.y);
        let (cx, cy) = (-first.x * fx, -first.y * fy);
        let frame = Pinhole::new(size, Intrinsics { fx: x * fx, fy: y * fy, cx, cy }).unwrap();
        let (pose, sigma) = (*view.world_from_sensor(), view.sigma());
        View::new(view.name(), view.image().clone(), Arc::new(frame), pose, sigma).unwrap()
    };
    views.iter().map(misread).collect()
}

/// Offsets, a scale and poses would bend to a wrong focal length.
#[test]
fn wrong_focal_lengths_of_a_depth_camera_are_told_and_nothing_moves() {
    let sets = [simulated("machined_part", ""), simulated("kitchen", "")];
    for (sound, degrees, length) in [(&sets[0], 0.0, 0.0), (&sets[1], 0.2, 0.004)] {
        for (factors, images_stay) in [([0.98, 0.98], false), ([1.02, 1.0], true)] {
            let views = shaken(&with_focal_lengths_times(sound, factors), degrees, length);
            let options = RefineOptions { images_stay, ..RefineOptions::default() };
            let refinement = refine(&coarse(&views), &options);
            let found = refinement.focal_over_true.unwrap();
            println!("{found:?} of {factors:?}");
            let off = found.iter().zip(&factors).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 2e-3, "{found:?} of {factors:?}");
            assert!(refinement.poses.iter().all(|pose| pose.depth_offsets.is_none()));
            let poses: Vec<_> = refinement.poses.iter().map(|p| p.world_from_sensor).collect();
            assert_eq!(poses, given(&views));
        }
    }
}

#[test]
fn a_sound_camera_has_no_offsets() {
    let refinement = refine(&coarse(&simulated("machined_part", "")), &RefineOptions::default());
    assert!(refinement.poses.iter().all(|pose| pose.depth_offsets.is_none()));
}

/// A copy is corrected in place of being made anew from the corrected image.
#[test]
fn a_corrected_copy_is_that_of_the_corrected_image() {
    let views = simulated("kitchen", "");
    let (rows, cols) = (3, 4);
    let values = (0..rows * cols).map(|k| 0.01 * (1.3 * k as f64).sin()).collect();
    let offsets = DepthOffsets::new(rows, cols, values).unwrap().after_scale(0.98).unwrap();
    let view = &views[0];
    let image = offsets.correct(view.frame(), view.image()).unwrap();
    let [given, corrected] = [view, &view.with_image(image).unwrap()].map(CoarseView::new);
    let quick = given.clone().corrected(&offsets);
    let largest_off = |copy: &CoarseView| {
        let of_cell: BTreeMap<_, _> = copy.patches().collect();
        let off = corrected
            .patches()
            .filter_map(|(cell, patch)| Some((of_cell.get(&cell)?.point() - patch.point()).norm()));
        let off: Vec<f64> = off.collect();
        assert!(off.len() > 1000, "{} patches", off.len());
        off.into_iter().fold(0.0, f64::max)
    };
    let (before, after) = (largest_off(&given), largest_off(&quick));
    println!("largest distance: {before} without a correction, {after} with it");
    assert!(before > 0.02 && after < 0.1 * before, "{before}, {after}");
}
