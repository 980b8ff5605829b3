//! Errors of depth cameras, found together with the poses.

use super::common::{changed, coarse, simulated, simulated_with_noise, turned};
use super::refining::{apart, given, shaken};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;
use transect_device::{
    DepthOffsets, DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, Vector3, View,
};
use transect_register::{CoarseView, PoseOutcome, RefineOptions, refine};
use transect_scene::{Noise, Scene, Shape, Solid};
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
    let refinement =
        refine(&coarse(&shaken(&views, 0.2, 0.004)), &RefineOptions::default()).unwrap();
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
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
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

/// Where a view belongs is looked for among views without that error.
#[test]
fn a_view_far_off_comes_back_where_all_depths_have_a_wrong_scale() {
    let views = with_depths_times(&simulated("machined_part", ""), 1.035);
    let mut wrong = views.clone();
    wrong[2] = turned(&views[2], 0, 3.0);
    let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
    let pose = &refinement.poses[2];
    assert_eq!(pose.outcome, PoseOutcome::BroughtBack, "{refinement:?}");
    let off = pose.world_from_sensor * views[2].world_from_sensor().inverse();
    let degrees = off.rotation.angle().to_degrees();
    println!("{degrees} degrees are left");
    assert!(degrees < 0.2, "{degrees}");
}

/// A store keeps its images: poses that hide their wrong scale suit them.
#[test]
fn no_scale_is_found_where_images_stay() {
    let views = with_depths_times(&simulated("machined_part", ""), 1.006);
    let options = RefineOptions { images_stay: true, ..RefineOptions::default() };
    let refinement = refine(&coarse(&views), &options).unwrap();
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
            let refinement = refine(&coarse(&views), &options).unwrap();
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
    let refinement =
        refine(&coarse(&simulated("machined_part", "")), &RefineOptions::default()).unwrap();
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

/// Views of folded sheet metal, 1.5 mm thick: a base with three walls and a lip, in millimetres.
/// Noise hides the folds and rims of patches that it does not hide in each sample.
fn folded_sheet() -> Vec<View> {
    let sheets = [
        ([300.0, 200.0, 1.5], [0.0, 0.0, 0.75]),
        ([1.5, 200.0, 100.0], [-149.25, 0.0, 50.0]),
        ([1.5, 200.0, 60.0], [149.25, 0.0, 30.0]),
        ([300.0, 1.5, 80.0], [0.0, 99.25, 40.0]),
        ([300.0, 40.0, 1.5], [0.0, 80.0, 79.25]),
    ];
    let k = Intrinsics { fx: 879.0, fy: 879.0, cx: 319.5, cy: 239.5 };
    let camera = Arc::new(Pinhole::new(ImageSize { rows: 480, cols: 640 }, k).unwrap());
    let noise = Noise { sigma: 0.1, max_incidence: 81.0, ..Noise::NONE };
    let middle = Point3::new(0.0, 0.0, 35.0);
    let place = |k: u32| {
        let around = TAU * f64::from(3 * k) / 16.0 + 0.1;
        let up: f64 = [-0.5, 0.3, 0.6, 1.0][k as usize % 4];
        let (sin, cos) = up.sin_cos();
        let away = Vector3::new(around.cos() * cos, around.sin() * cos, sin) * 520.0;
        (middle + away, middle)
    };
    let scene = Scene::new(sheets.iter().map(cuboid).collect());
    seen_by(camera, &scene, (0..16).map(place), &noise)
}

/// A box, given as its size and its middle.
fn cuboid((size, [x, y, z]): &([f64; 3], [f64; 3])) -> Solid {
    let shape = Shape::cuboid(Vector3::from(*size)).unwrap();
    Solid::new(shape, Isometry3::translation(*x, *y, *z)).unwrap()
}

/// What a camera sees of a scene from places towards others.
fn seen_by(
    camera: Arc<dyn DeviceFrame>,
    scene: &Scene,
    places: impl Iterator<Item = (Point3, Point3)>,
    noise: &Noise,
) -> Vec<View> {
    let view = |(k, (at, to)): (usize, (Point3, Point3))| {
        let pose = Isometry3::face_towards(&at, &to, &-Vector3::z());
        scene.view(format!("{k}"), Arc::clone(&camera), pose, noise, k as u64).unwrap()
    };
    places.enumerate().map(view).collect()
}

#[test]
fn folds_that_noise_hides_tell_no_scale() {
    let views = folded_sheet();
    for (degrees, length) in [(0.0, 0.0), (0.05, 0.15), (-0.05, 0.15)] {
        let wrong = shaken(&views, degrees, length);
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
        let poses: Vec<_> = refinement.poses.iter().map(|p| p.world_from_sensor).collect();
        let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &poses));
        println!("{before} to {after} mm");
        assert!(refinement.poses.iter().all(|pose| pose.depth_offsets.is_none()), "{before}");
        // A false scale would move the views by a millimetre.
        assert!(after <= (1.2 * before).max(1e-6), "{before} to {after}");
    }
}

/// Cameras in a room with a pillar, the first two of which face each other, in metres.
fn in_a_room(count: usize) -> Vec<View> {
    let boxes = [
        ([6.0, 5.0, 0.2], [0.0, 0.0, -0.1]),
        ([0.2, 5.0, 3.0], [3.0, 0.0, 1.5]),
        ([0.2, 5.0, 3.0], [-3.0, 0.0, 1.5]),
        ([6.2, 0.2, 3.0], [0.0, 2.5, 1.5]),
        ([6.2, 0.2, 3.0], [0.0, -2.5, 1.5]),
    ];
    let pillar = Shape::cylinder(0.3, 3.0).unwrap();
    let pillar = Solid::new(pillar, Isometry3::translation(1.0, 0.6, 1.5)).unwrap();
    let scene = Scene::new(boxes.iter().map(cuboid).chain([pillar]).collect());
    let k = Intrinsics { fx: 250.0, fy: 250.0, cx: 159.5, cy: 119.5 };
    let camera = Arc::new(Pinhole::new(ImageSize { rows: 240, cols: 320 }, k).unwrap());
    let places = [
        ([-2.0, -1.5, 1.2], [1.0, 0.6, 1.2]),
        ([2.2, -1.6, 1.4], [-1.0, 1.0, 1.2]),
        ([0.5, 2.0, 1.2], [0.2, -1.0, 1.2]),
    ];
    let noise = Noise { sigma: 0.004, ..Noise::NONE };
    let places = places.into_iter().take(count);
    let placed = places.map(|(at, to)| (Point3::from(at), Point3::from(to)));
    seen_by(camera, &scene, placed, &noise)
}

/// Where two cameras face each other, one that stands too far away looks like small depths.
#[test]
fn one_wrong_view_of_few_is_no_wrong_scale() {
    for count in [2, 3] {
        let mut wrong = in_a_room(count);
        let off = Isometry3::translation(0.02, 0.0, 0.0) * wrong[1].world_from_sensor();
        wrong[1] = wrong[1].with_pose(off).unwrap();
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
        let scales = refinement.poses.iter().filter_map(|pose| pose.depth_offsets.as_ref());
        assert!(scales.map(DepthOffsets::scale).all(|scale| scale == 1.0), "{refinement:?}");
    }
}

/// Frames of a hand-held camera that measures the time of flight, in a room whose walls light each
/// other. Depths are too long by up to `most`, the more so the nearer two other walls are.
fn where_walls_light_each_other(most: f64, reach: f64) -> Vec<View> {
    let boxes = [
        ([4.4, 3.6, 0.2], [0.0, 0.0, -0.1]),
        ([4.4, 3.6, 0.2], [0.0, 0.0, 2.7]),
        ([0.2, 3.6, 2.8], [2.2, 0.0, 1.3]),
        ([0.2, 3.6, 2.8], [-2.2, 0.0, 1.3]),
        ([4.4, 0.2, 2.8], [0.0, 1.8, 1.3]),
        ([4.4, 0.2, 2.8], [0.0, -1.8, 1.3]),
        ([1.2, 0.6, 0.9], [1.5, -1.4, 0.45]),
        ([0.6, 1.4, 0.9], [-1.8, 0.5, 0.45]),
        ([0.5, 0.5, 1.8], [1.85, 1.45, 0.9]),
    ];
    let scene = Scene::new(boxes.iter().map(cuboid).collect());
    let k = Intrinsics { fx: 125.0, fy: 125.0, cx: 79.5, cy: 59.5 };
    let camera = Arc::new(Pinhole::new(ImageSize { rows: 120, cols: 160 }, k).unwrap());
    let place = |k: u32| {
        let turn = TAU * f64::from(k) / 24.0;
        let at = Point3::new(0.8 * turn.cos(), 0.6 * turn.sin(), 1.45 + 0.25 * (3.0 * turn).sin());
        let look = turn + 0.9 * (2.0 * turn + 0.4).sin();
        let tilt = -0.22 + 0.2 * (3.0 * turn + 1.0).sin();
        (at, at + Vector3::new(look.cos(), look.sin(), tilt))
    };
    let noise = Noise { sigma: 0.003, ..Noise::NONE };
    let views = seen_by(camera, &scene, (0..24).map(place), &noise);
    let lengthened = |view: &View| {
        changed(view, |row, col, depth| {
            let seen = view.frame().point(Pixel::new(row, col), f64::from(depth));
            let Some(p) = seen.map(|p| view.world_from_sensor() * p) else { return depth };
            let walls = [2.1 - p.x.abs(), 1.7 - p.y.abs(), p.z.min(2.6 - p.z)];
            // The nearest wall is the one that the point is on.
            let light = walls.map(|distance| (-distance.max(0.0) / reach).exp());
            let own = light.into_iter().fold(0.0, f64::max);
            depth + (most * (light.iter().sum::<f64>() - own)) as f32
        })
    };
    views.iter().map(lengthened).collect()
}

/// What walls add to depths looks like other focal lengths, which no pair confirms.
#[test]
fn depths_that_walls_lengthen_tell_no_focal_length() {
    for (most, reach) in [(0.045, 0.5), (0.06, 0.4)] {
        let views = where_walls_light_each_other(most, reach);
        let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
        assert_eq!(refinement.focal_over_true, None, "{most} {reach}");
        assert!(refinement.poses.iter().all(|pose| pose.depth_offsets.is_some()));
    }
}
