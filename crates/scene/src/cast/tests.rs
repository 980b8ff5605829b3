use super::*;
use crate::test_frames::SheetOfLight;
use crate::{DepthCamera, PoseNoise, Shape, Solid};
use transect_device::Vector3;
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

const SIZE: ImageSize = ImageSize { rows: 40, cols: 60 };

fn radar() -> ImagingRadar {
    let theta = AngularScan::from_degrees(-30.0, 1.0);
    ImagingRadar::new(SIZE, theta, AngularScan::from_degrees(20.0, -1.0)).unwrap()
}

fn camera() -> Pinhole {
    Pinhole::new(SIZE, Intrinsics { fx: 60.0, fy: 55.0, cx: 29.5, cy: 19.5 }).unwrap()
}

fn wall_at(x: f64) -> Scene {
    let wall = Shape::cuboid(Vector3::new(1.0, 50.0, 50.0)).unwrap();
    Scene::new(vec![Solid::new(wall, Isometry3::translation(x + 0.5, 0.0, 0.0)).unwrap()])
}

/// A camera that looks along the world's x axis.
fn along_x() -> Isometry3 {
    Isometry3::face_towards(&Point3::origin(), &Point3::new(1.0, 0.0, 0.0), &-Vector3::z())
}

#[test]
fn every_value_gives_its_surface_point_back() {
    let scene = wall_at(4.0);
    let frames: [(&dyn DeviceFrame, Isometry3); 2] =
        [(&radar(), Isometry3::identity()), (&camera(), along_x())];
    for (frame, world_from_sensor) in frames {
        let image = scene.cast(frame, &world_from_sensor).unwrap();
        assert_eq!(image.valid_count(), SIZE.pixels());
        for pixel in [Pixel::new(0, 0), Pixel::new(39, 59), Pixel::new(17, 31)] {
            let d3 = f64::from(image.get(pixel).unwrap());
            let point = world_from_sensor * frame.point(pixel, d3).unwrap();
            // Values are stored as f32.
            assert!((point.x - 4.0).abs() < 1e-6, "{point}");
        }
    }
}

#[test]
fn depth_of_a_frontal_wall_is_constant() {
    let image = wall_at(4.0).cast(&camera(), &along_x()).unwrap();
    assert_eq!(image.extremes(), Some((4.0, 4.0)));
}

#[test]
fn inside_of_a_room_every_ray_meets_a_wall() {
    let slab = |x: f64, y: f64, z: f64| {
        let size = Vector3::new(10.0, 10.0, 10.0);
        Solid::new(Shape::cuboid(size).unwrap(), Isometry3::translation(x, y, z)).unwrap()
    };
    let scene = Scene::new(vec![
        slab(8.0, 0.0, 0.0),
        slab(-8.0, 0.0, 0.0),
        slab(0.0, 8.0, 0.0),
        slab(0.0, -8.0, 0.0),
        slab(0.0, 0.0, 8.0),
        slab(0.0, 0.0, -8.0),
    ]);
    let size = ImageSize { rows: 90, cols: 180 };
    let around = AngularScan::from_degrees(-179.0, 2.0);
    let frame = ImagingRadar::new(size, around, AngularScan::from_degrees(89.0, -2.0)).unwrap();
    let image = scene.cast(&frame, &Isometry3::translation(1.0, -0.5, 0.2)).unwrap();
    assert_eq!(image.valid_count(), size.pixels());
    for row in 0..90 {
        for col in 0..180 {
            let pixel = Pixel::new(row, col);
            let p = frame.point(pixel, f64::from(image.get(pixel).unwrap())).unwrap()
                + Vector3::new(1.0, -0.5, 0.2);
            assert!((p.coords.amax() - 3.0).abs() < 1e-5, "{p}");
        }
    }
}

#[test]
fn a_sensor_inside_a_solid_sees_nothing() {
    let scene = wall_at(-0.5);
    assert_eq!(scene.cast(&radar(), &Isometry3::identity()).unwrap().valid_count(), 0);
    let view = scene.view("blind", Arc::new(radar()), Isometry3::identity(), &Noise::NONE, 0);
    assert_eq!(view.unwrap_err(), CastError::View(ViewError::NoValidPixel));
}

#[test]
fn sigma_is_an_error_along_the_ray() {
    let scene = wall_at(4.0);
    let noise = Noise { sigma: 0.01, seed: 3, ..Noise::NONE };
    let frames: [(&dyn DeviceFrame, Isometry3); 2] =
        [(&radar(), Isometry3::identity()), (&camera(), along_x())];
    for (frame, world_from_sensor) in frames {
        let clean = scene.cast(frame, &world_from_sensor).unwrap();
        let noisy = scene.scan(frame, &world_from_sensor, &noise, 0).unwrap();
        let point = |image: &RangeImage, pixel| {
            frame.point(pixel, f64::from(image.get(pixel).unwrap())).unwrap().coords.norm()
        };
        let pixels = (0..SIZE.pixels()).map(|k| Pixel::new(k / SIZE.cols, k % SIZE.cols));
        let squares = pixels.map(|p| (point(&noisy, p) - point(&clean, p)).powi(2));
        let sigma = (squares.sum::<f64>() / SIZE.pixels() as f64).sqrt();
        // Four standard errors of 2400 samples.
        assert!((sigma / 0.01 - 1.0).abs() < 4.0 / (2.0 * 2400f64).sqrt(), "{sigma}");
    }
}

#[test]
fn oblique_surfaces_drop_out() {
    let noise = Noise { max_incidence: 25f64.to_radians(), ..Noise::NONE };
    let image = wall_at(4.0).scan(&radar(), &Isometry3::identity(), &noise, 0).unwrap();
    for (row, col) in [(20, 30), (20, 8), (0, 30), (20, 2), (0, 10)] {
        let ray = radar().ray(Pixel::new(row, col)).unwrap();
        let returns = ray.direction.x.acos() <= 25f64.to_radians();
        assert_eq!(image.get(Pixel::new(row, col)).is_some(), returns, "{row} {col}");
    }
}

fn bytes(image: &RangeImage) -> Vec<u32> {
    (0..SIZE.rows).flat_map(|r| image.row(r).iter().map(|v| v.to_bits())).collect()
}

#[test]
fn same_seed_same_bytes_whatever_the_order_of_views() {
    let near = Solid::new(Shape::ball(1.0).unwrap(), Isometry3::translation(3.0, 0.3, 0.2));
    let scene = Scene::new(vec![wall_at(4.0).solids()[0].clone(), near.unwrap()]);
    let (frame, pose) = (radar(), Isometry3::identity());
    let some = Noise { sigma: 0.01, sigma_growth: 0.001, dropout: 0.1, ..Noise::NONE };
    let noise = Noise { full_return: 0.9, mixed: 0.5, quantum: 0.001, seed: 11, ..some };
    let scan = |view| bytes(&scene.scan(&frame, &pose, &noise, view).unwrap());
    let forward: Vec<_> = (0..3).map(scan).collect();
    let backward: Vec<_> = (0..3).rev().map(scan).collect();
    assert!(forward.iter().eq(backward.iter().rev()));
    assert_ne!(forward[0], forward[1]);
    let other = Noise { seed: 12, ..noise };
    assert_ne!(bytes(&scene.scan(&frame, &pose, &other, 0).unwrap()), forward[0]);
}

/// A step on a wall at z = 10, before a laser at x = 0 and a camera at x = 4. The step is a box
/// from x = 1 to 3 whose face is at z = 8.
fn step() -> Scene {
    let slab = |size: [f64; 3], at: [f64; 3]| {
        Solid::new(Shape::cuboid(size.into()).unwrap(), Isometry3::translation(at[0], at[1], at[2]))
    };
    let wall = slab([40.0, 20.0, 1.0], [0.0, 0.0, 10.5]).unwrap();
    Scene::new(vec![wall, slab([2.0, 20.0, 3.0], [2.0, 0.0, 9.5]).unwrap()])
}

#[test]
fn a_triangulation_sensor_has_shadows_on_both_sides_of_a_step() {
    let frame = SheetOfLight { size: ImageSize { rows: 3, cols: 2000 }, base_line: 4.0 };
    let image = step().cast(&frame, &Isometry3::identity()).unwrap();
    let mut seen = Vec::new();
    for col in 0..2000 {
        let pixel = Pixel::new(1, col);
        let slope = frame.angle(col).tan();
        // Where the laser's ray crosses the planes of the face and of the wall.
        let (on_face, on_wall) = (8.0 * slope, 10.0 * slope);
        let meets_face = (1.0..3.0).contains(&on_face);
        let meets_side = on_face < 1.0 && on_wall > 1.0;
        // The camera's line over the face's left edge reaches the wall at x = 1 - 3 · 2/8.
        let hidden = meets_side || (0.25..1.0).contains(&on_wall);
        assert_eq!(image.get(pixel).is_none(), hidden, "column {col}");
        if let Some(d3) = image.get(pixel) {
            let point = frame.point(pixel, f64::from(d3)).unwrap();
            let (x, z) = if meets_face { (on_face, 8.0) } else { (on_wall, 10.0) };
            assert!((point - Point3::new(x, frame.row(1), z)).norm() < 1e-4, "{point}");
            seen.push(point);
        }
    }
    let on_wall =
        |low: f64, high: f64| seen.iter().filter(|p| p.z > 9.9 && low < p.x && p.x < high).count();
    assert_eq!(on_wall(0.25, 1.0), 0, "shadow of the camera");
    assert_eq!(on_wall(3.0, 3.75), 0, "shadow of the laser");
    assert!(on_wall(0.0, 0.25) > 10 && on_wall(3.75, 4.0) > 10);
}

#[test]
fn a_camera_at_the_laser_sees_all_that_is_lit() {
    let frame = SheetOfLight { size: ImageSize { rows: 3, cols: 2000 }, base_line: 0.0 };
    assert_eq!(frame.second_viewpoint(Pixel::new(0, 0)), Some(frame.start(0)));
    let (scene, pose) = (step(), Isometry3::identity());
    let caster = Caster::new(&scene, &frame, &pose, (&Noise::NONE, 0));
    for (col, echo) in caster.row(1).iter().enumerate() {
        let lit = scene.hit(&frame.ray(Pixel::new(1, col)).unwrap());
        assert_eq!(echo.map(|e| e.distance), lit.map(|h| h.distance), "column {col}");
    }
}

#[test]
fn dark_and_oblique_surfaces_return_in_proportion_to_their_light() {
    let noise = Noise { full_return: 0.5, seed: 2, ..Noise::NONE };
    let wall = wall_at(4.0).solids()[0].clone().with_reflectivity(0.2).unwrap();
    let scene = Scene::new(vec![wall]);
    let views = 40;
    let mut found = vec![0; SIZE.cols];
    for view in 0..views {
        let image = scene.scan(&radar(), &Isometry3::identity(), &noise, view).unwrap();
        for (col, count) in found.iter_mut().enumerate() {
            *count += (0..SIZE.rows).filter(|&r| image.get(Pixel::new(r, col)).is_some()).count();
        }
    }
    for (col, &count) in found.iter().enumerate() {
        let rays = (0..SIZE.rows).map(|row| radar().ray(Pixel::new(row, col)).unwrap());
        let shares: Vec<f64> = rays.map(|ray| 0.2 * ray.direction.x / 0.5).collect();
        let mean = shares.iter().sum::<f64>() * views as f64;
        let sigma = (shares.iter().map(|p| p * (1.0 - p)).sum::<f64>() * views as f64).sqrt();
        // Five sigmas, since there are 60 columns.
        assert!((count as f64 - mean).abs() < 5.0 * sigma, "{col}: {count} against {mean}");
    }
}

#[test]
fn mixed_pixels_lie_between_the_two_surfaces_of_a_jump() {
    let near = Shape::cuboid(Vector3::new(1.0, 50.0, 50.0)).unwrap();
    let near = Solid::new(near, Isometry3::translation(4.5, 25.01, 0.0)).unwrap();
    let scene = Scene::new(vec![near, wall_at(8.0).solids()[0].clone()]);
    let noise = Noise { mixed: 0.3, seed: 6, ..Noise::NONE };
    let (frame, pose) = (radar(), Isometry3::identity());
    let clean = scene.cast(&frame, &pose).unwrap();
    // Column 30 looks along the x axis, past the near wall's edge; column 31 meets the wall.
    let ranges = |row: usize| {
        let x = |col: usize| frame.ray(Pixel::new(row, col)).unwrap().direction.x;
        [(30, 8.0 / x(30), 4.0 / x(30)), (31, 4.0 / x(31), 8.0 / x(31))]
    };
    let (mut mixed, mut all, mut shares) = (0, 0, Vec::new());
    for view in 0..40 {
        let image = scene.scan(&frame, &pose, &noise, view).unwrap();
        for row in 0..SIZE.rows {
            for col in (0..SIZE.cols).filter(|col| ![30, 31].contains(col)) {
                assert_eq!(image.get(Pixel::new(row, col)), clean.get(Pixel::new(row, col)));
            }
            for (col, own, other) in ranges(row) {
                let found = f64::from(image.get(Pixel::new(row, col)).unwrap());
                let share = (found - own) / (other - own);
                all += 1;
                if share.abs() > 1e-6 {
                    mixed += 1;
                    shares.push(share);
                }
            }
        }
    }
    let n = f64::from(all);
    assert!((f64::from(mixed) / n - 0.3).abs() < 4.0 * (0.21 / n).sqrt(), "{mixed} of {all}");
    // Along its own ray a pixel is drawn to where its neighbour's surface is, one degree away.
    assert!(shares.iter().all(|s| (0.0..1.02).contains(s)));
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!((mean - 0.5).abs() < 4.0 / (12.0 * shares.len() as f64).sqrt() + 0.01, "{mean}");
    let square = shares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / shares.len() as f64;
    assert!((square.sqrt() - 1.0 / 12f64.sqrt()).abs() < 0.03, "{}", square.sqrt());
}

#[test]
fn values_are_whole_steps_of_d3() {
    let noise = Noise { sigma: 0.03, quantum: 0.0625, seed: 1, ..Noise::NONE };
    let image = wall_at(4.0).scan(&radar(), &Isometry3::identity(), &noise, 0).unwrap();
    for row in 0..SIZE.rows {
        assert!(image.row(row).iter().all(|v| (v / 0.0625).fract() == 0.0));
    }
}

#[test]
fn a_view_states_the_noisy_pose_and_measures_from_the_true_one() {
    let (scene, truth) = (wall_at(4.0), Isometry3::translation(0.5, 0.0, 0.0));
    let pose = PoseNoise { degrees: 0.5, shift: 0.02 };
    let noise = Noise { sigma: 0.01, sigma_growth: 0.005, pose, seed: 3, ..Noise::NONE };
    let view = scene.view("off", Arc::new(radar()), truth, &noise, 2).unwrap();
    let stated = noise.stated_pose(&truth, 2);
    assert_eq!(view.world_from_sensor(), &stated);
    assert_ne!(stated, truth);
    let clean = scene.scan(&radar(), &truth, &Noise { pose: PoseNoise::default(), ..noise }, 2);
    assert_eq!(bytes(view.image()), bytes(&clean.unwrap()));
    // Ranges run from 3.5 to 3.5 / cos² 30°, about.
    let sigma = view.sigma().unwrap();
    assert!((0.01 + 0.005 * 3.5..0.01 + 0.005 * 4.4).contains(&sigma), "{sigma}");
}

/// A depth camera of 120 × 160 pixels with a focal length of 150 pixels.
fn depth_camera() -> Pinhole {
    let size = ImageSize { rows: 120, cols: 160 };
    Pinhole::new(size, Intrinsics { fx: 150.0, fy: 150.0, cx: 79.5, cy: 59.5 }).unwrap()
}

/// Depths of a scene before a camera at the origin that looks along z, row by row.
fn depths(scene: &Scene, noise: &Noise, view: u64) -> Vec<Option<f64>> {
    let frame = depth_camera();
    let image = scene.scan(&frame, &Isometry3::identity(), noise, view).unwrap();
    let pixels = (0..frame.size().pixels()).map(|k| Pixel::new(k / 160, k % 160));
    pixels.map(|pixel| image.get(pixel).map(f64::from)).collect()
}

/// A wall through (0, 0, 4) that falls back to the right: depth = 4 + slope · x.
fn slanted_wall(slope: f64) -> Scene {
    let wall = Shape::cuboid(Vector3::new(80.0, 80.0, 2.0)).unwrap();
    let turned = Isometry3::rotation(Vector3::y() * -slope.atan());
    let pose =
        Isometry3::translation(0.0, 0.0, 4.0) * turned * Isometry3::translation(0.0, 0.0, 1.0);
    Scene::new(vec![Solid::new(wall, pose).unwrap()])
}

fn with_camera(depth_camera: DepthCamera) -> Noise {
    Noise { depth_camera, seed: 17, ..Noise::NONE }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(n, sum), v| (n + 1.0, sum + v * v));
    f64::sqrt(sum / count)
}

#[test]
fn errors_of_neighbours_correlate_over_the_stated_length() {
    let scene = slanted_wall(0.0);
    let (sigma_square, length) = (0.001, 4.0);
    let noise = Noise { sigma_square, correlation: length, seed: 5, ..Noise::NONE };
    let clean = depths(&scene, &Noise::NONE, 0);
    let ray =
        |k: usize| ((k % 160) as f64 - 79.5).hypot((k / 160) as f64 - 59.5).hypot(150.0) / 150.0;
    let errors: Vec<Vec<f64>> = (0..30)
        .map(|view| {
            let found = depths(&scene, &noise, view);
            let pairs = found.iter().zip(&clean).enumerate();
            // In standard deviations: along the ray, with the square of the range.
            let error = |(k, (a, b)): (usize, (&Option<f64>, &Option<f64>))| {
                let (range, off) = (b.unwrap() * ray(k), (a.unwrap() - b.unwrap()) * ray(k));
                off / (sigma_square * range * range)
            };
            pairs.map(error).collect()
        })
        .collect();
    // 30 views of about 120 · 160 / (π · 4² · 2) independent patches: one standard error is 1 %.
    assert!((rms(errors.iter().flatten().copied()) - 1.0).abs() < 0.03);
    for distance in [1, 2, 4, 6, 12] {
        for (step, cols, rows) in
            [(distance, 160 - distance, 120), (160 * distance, 160, 120 - distance)]
        {
            let inside = (0..rows * cols).map(|k| k / cols * 160 + k % cols);
            let products =
                |view: &Vec<f64>| inside.clone().map(|k| view[k] * view[k + step]).sum::<f64>();
            let sum: f64 = errors.iter().map(products).sum();
            let found = sum / (30 * rows * cols) as f64;
            let expected = (-(distance as f64 / length).powi(2)).exp();
            assert!((found - expected).abs() < 0.04, "{distance}, {step}: {found} for {expected}");
        }
    }
    assert_ne!(errors[0], errors[1]);
}

#[test]
fn disparities_are_whole_steps() {
    let noise =
        with_camera(DepthCamera { base_line: 0.1, disparity_step: 0.25, ..DepthCamera::default() });
    let scene = slanted_wall(0.3);
    let disparity = |depth: f64| 0.1 * 150.0 / depth;
    let (mut levels, mut lit) = (std::collections::BTreeSet::new(), 0);
    for (found, true_depth) in depths(&scene, &noise, 0).iter().zip(depths(&scene, &Noise::NONE, 0))
    {
        let (Some(found), Some(true_depth)) = (found, true_depth) else { continue };
        let steps = disparity(*found) / 0.25;
        assert!((steps - steps.round()).abs() < 1e-5, "{found} is at {steps} steps");
        // Values are stored as f32.
        assert!((disparity(*found) - disparity(true_depth)).abs() < 0.125 + 1e-5);
        levels.insert(steps.round() as i32);
        lit += 1;
    }
    // Depths run from 3.4 to 4.8: disparities from 4.4 to 3.1 pixels, in steps of a quarter.
    assert_eq!(levels.into_iter().collect::<Vec<_>>(), (13..=17).collect::<Vec<_>>());
    assert_eq!(lit, 120 * 160, "the projector lights all of a wall");
}

#[test]
fn shuffled_pixels_measure_places_beside_their_own() {
    let (slope, shuffle) = (0.5, 0.6);
    let scene = slanted_wall(slope);
    let noise = with_camera(DepthCamera { shuffle, ..DepthCamera::default() });
    let (found, clean) = (depths(&scene, &noise, 0), depths(&scene, &Noise::NONE, 0));
    // On depth = 4 / (1 - slope · u) a place beside by δ pixels is deeper by slope · depth² / 4 ·
    // δ/f.
    let pairs = found.iter().zip(&clean).map(|(a, b)| (a.unwrap(), b.unwrap()));
    let pixels = pairs.map(|(a, b)| (a - b) * 150.0 * 4.0 / (slope * a * b));
    let spread = rms(pixels);
    // Four standard errors of 19 200 pixels.
    assert!((spread / shuffle - 1.0).abs() < 4.0 / (2.0 * 19_200f64).sqrt(), "{spread}");
    let frontal = slanted_wall(0.0);
    assert_eq!(depths(&frontal, &noise, 0), depths(&frontal, &Noise::NONE, 0));
}

/// An image of one row or one column has the errors of a larger one with its focal lengths.
#[test]
fn images_of_one_row_or_column_have_the_errors_of_depth_cameras() {
    let camera = DepthCamera { base_line: 0.1, disparity_step: 0.25, ..DepthCamera::default() };
    let noise = with_camera(DepthCamera { shuffle: 0.6, ..camera });
    for (rows, cols) in [(1, 400), (400, 1), (1, 1)] {
        let (cx, cy) = (0.5 * cols as f64, 0.5 * rows as f64);
        let lens = Intrinsics { fx: 150.0, fy: 150.0, cx, cy };
        let frame = Pinhole::new(ImageSize { rows, cols }, lens).unwrap();
        let scene = slanted_wall(0.5);
        let image = scene.scan(&frame, &Isometry3::identity(), &noise, 0).unwrap();
        let depths = frame.size().all_pixels().filter_map(|pixel| image.get(pixel));
        let steps: Vec<f64> = depths.map(|depth| 0.1 * 150.0 / f64::from(depth) / 0.25).collect();
        assert_eq!(steps.len(), rows * cols);
        assert!(steps.iter().all(|step| (step - step.round()).abs() < 1e-4), "{steps:?}");
    }
}

#[test]
fn a_projector_throws_shadows_beside_jumps() {
    let noise = with_camera(DepthCamera { base_line: 4.0, ..DepthCamera::default() });
    let (clean, found) = (depths(&step(), &Noise::NONE, 0), depths(&step(), &noise, 0));
    let mut hidden = 0;
    for (k, (clean, found)) in clean.into_iter().zip(found).enumerate() {
        let depth = clean.unwrap();
        let x = ((k % 160) as f64 - 79.5) / 150.0 * depth;
        // The step's side, and the wall behind it as for the laser and the camera of the step.
        let is_side = depth > 8.001 && depth < 9.999;
        let is_hidden = is_side || depth > 9.0 && (0.25..1.0).contains(&x);
        assert_eq!(found, clean.filter(|_| !is_hidden), "pixel {k}");
        hidden += usize::from(is_hidden);
    }
    assert!(hidden > 1000, "{hidden}");
}

#[test]
fn distortion_is_a_share_of_depth_that_all_views_have() {
    let noise = with_camera(DepthCamera { distortion: 0.006, ..DepthCamera::default() });
    let shares = |slope, noise: &Noise, view| -> Vec<f64> {
        let scene = slanted_wall(slope);
        let pairs = depths(&scene, noise, view).into_iter().zip(depths(&scene, &Noise::NONE, 0));
        pairs.map(|(found, clean)| found.unwrap() / clean.unwrap() - 1.0).collect()
    };
    let first = shares(0.0, &noise, 0);
    assert!((rms(first.iter().copied()) / 0.006 - 1.0).abs() < 1e-4);
    for (a, b) in first.iter().zip(shares(0.4, &noise, 3)) {
        // Values are stored as f32.
        assert!((a - b).abs() < 1e-6);
    }
    let rows = first.chunks(160).flat_map(|row| row.windows(2));
    let steps = rows.map(|pair| pair[1] - pair[0]);
    assert!(rms(steps) < 0.1 * 0.006, "the distortion varies smoothly");
    let other = shares(0.0, &Noise { seed: 18, ..noise }, 0);
    assert!(rms(first.iter().zip(other).map(|(a, b)| a - b)) > 0.001);
}

#[test]
fn a_depth_camera_has_the_same_bytes_for_the_same_seed_and_states_no_sigma() {
    let camera =
        DepthCamera { base_line: 0.3, disparity_step: 0.1, shuffle: 0.5, distortion: 0.01 };
    let noise = Noise { sigma_square: 0.001, correlation: 3.0, mixed: 0.5, ..with_camera(camera) };
    let bits = |view| -> Vec<_> {
        depths(&step(), &noise, view).into_iter().map(|d| d.map(f64::to_bits)).collect()
    };
    let forward: Vec<_> = (0..3).map(bits).collect();
    assert!(forward.iter().eq((0..3).rev().map(bits).collect::<Vec<_>>().iter().rev()));
    assert_ne!(forward[0], forward[1]);
    let pose = Isometry3::identity();
    let view = step().view("camera", Arc::new(depth_camera()), pose, &noise, 0).unwrap();
    assert_eq!(view.sigma(), None);
    // A scanner has no projector, no disparities and no lens.
    let radar_only = Noise { depth_camera: camera, ..Noise::NONE };
    let scan = |noise| bytes(&wall_at(4.0).scan(&radar(), &pose, noise, 0).unwrap());
    assert_eq!(scan(&radar_only), scan(&Noise::NONE));
}
