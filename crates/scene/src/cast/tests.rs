use super::*;
use crate::test_frames::SheetOfLight;
use crate::{PoseNoise, Shape, Solid};
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

/// A step on a wall at z = 10, before a laser at x = 0 and a camera at x = 4: a box from x = 1 to 3
/// whose face is at z = 8.
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
    let caster = Caster::new(&scene, &frame, &pose, &Noise::NONE);
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
