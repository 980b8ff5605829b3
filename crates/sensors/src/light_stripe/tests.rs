//! Numbers worked out by hand and by following the light, and parameters that make no sensor.

use super::*;
use crate::SensorError;
use transect_device::{LinearForm, RangeImage};

/// A sensor with easy numbers: f = 1, cells of 0.1, a sheet that turns about (-2, 0, 0).
fn simple(radians: Vec<f64>) -> LightStripeParameters {
    LightStripeParameters {
        camera_rows: 11,
        camera_cols: 20,
        focal_length: 1.0,
        cell_width: 0.1,
        cell_height: 0.05,
        x_center: 10.0,
        y_center: 5.0,
        baseline: 2.0,
        mirror_axis: 0.0,
        mirror_face: 0.0,
        fan_angle: 2.0,
        farthest: f64::INFINITY,
        theta_laser: LaserAngles::from_radians(radians),
    }
}

fn message(change: impl FnOnce(&mut LightStripeParameters)) -> String {
    let mut parameters = LightStripeParameters::smart_eye();
    change(&mut parameters);
    LightStripe::new(parameters).unwrap_err().to_string()
}

fn near(a: &Point3, b: [f64; 3], tolerance: f64) -> bool {
    (a - Point3::from(b)).norm() < tolerance
}

/// By hand. At 90° the sheet is x = -2. The image point x_plane = 0.5 is d3 = 5. Its line of sight
/// through F = (0, 0, 1) falls off by 0.5 in x per unit of z, so it meets the sheet at z = 5.
#[test]
fn an_upright_sheet_by_hand() {
    let frame = LightStripe::new(simple(vec![std::f64::consts::FRAC_PI_2])).unwrap();
    let middle = frame.point(Pixel::new(5, 0), 5.0).unwrap();
    assert!(near(&middle, [-2.0, 0.0, 5.0], 1e-12), "{middle}");
    // Two rows up: y_plane = 0.1, and the image is upside down.
    let above = frame.point(Pixel::new(3, 0), 5.0).unwrap();
    assert!(near(&above, [-2.0, -0.4, 5.0], 1e-12), "{above}");
    let ray = frame.ray(Pixel::new(3, 0)).unwrap();
    assert!(near(&ray.start, [-2.0, 0.0, 1.0], 1e-12), "P0 = (f/tan θ - B_b, 0, f)");
    assert_eq!(frame.second_viewpoint(Pixel::new(3, 0)), Some(Point3::new(0.0, 0.0, 1.0)));
    assert_eq!(frame.second_viewpoint(Pixel::new(11, 0)), None);
    // The plane z = 9 is met at x = -2, seen at x_plane = 2/8: d3 = 10 - 2.5.
    let plane = SensorPlane { normal: Vector3::z(), offset: 9.0 };
    let value = frame.plane_value(Pixel::new(5, 0), &plane).unwrap();
    assert!((value - 7.5).abs() < 1e-12, "{value}");
}

/// By hand. At 45° the sheet is z = x + 2 and P0 = (-1, 0, 1); x_plane = 0 looks along Z.
#[test]
fn a_leaning_sheet_by_hand() {
    let frame = LightStripe::new(simple(vec![std::f64::consts::FRAC_PI_4])).unwrap();
    let p = frame.point(Pixel::new(5, 0), 10.0).unwrap();
    assert!(near(&p, [0.0, 0.0, 2.0], 1e-12), "{p}");
    // Line of sight through x_plane = -0.5: x = (z - 1)/2 = z - 2, so z = 3.
    let p = frame.point(Pixel::new(5, 0), 15.0).unwrap();
    assert!(near(&p, [1.0, 0.0, 3.0], 1e-12), "{p}");
    // x_plane = -1 is parallel to the sheet: nothing beyond.
    assert_eq!(frame.point(Pixel::new(5, 0), 20.001), None);
    assert_eq!(frame.point(Pixel::new(5, 0), 20.5), None);
}

/// The equations as printed, with the errata, term by term.
fn printed_equations(p: &LightStripeParameters, row: f64, theta: f64, x_frame: f64) -> [f64; 3] {
    let x_plane = (p.x_center - x_frame) * p.cell_width;
    let y_plane = (p.y_center - row) * p.cell_height;
    let (f, g, r, m) = (p.focal_length, p.mirror_axis, p.mirror_face, theta / 2.0);
    let b = (g * m.sin().powi(2) - g + r * m.cos()) / (m.sin() * m.cos());
    let phi = f.atan2(x_plane);
    let s = (p.baseline + b + x_plane) * theta.sin() / (theta + phi).sin();
    let t = s / x_plane.hypot(f);
    [(1.0 - t) * x_plane, (1.0 - t) * y_plane, t * f]
}

/// Follows the light: along X onto the mirror, reflected, then met by the camera's line of sight.
fn follow_the_light(p: &LightStripeParameters, row: f64, theta: f64, x_frame: f64) -> [f64; 3] {
    let (axis_x, axis_z) = (-p.baseline, -p.mirror_axis);
    // The mirror's normal halves the turn from (1, 0) to (cos θ, sin θ).
    let normal = (-(theta / 2.0).sin(), (theta / 2.0).cos());
    let incoming = (1.0, 0.0);
    // Where the beam z = 0 lies `mirror_face` in front of the mirror's axis.
    let spot = axis_x + (p.mirror_face + axis_z * normal.1) / normal.0;
    let turn = 2.0 * (incoming.0 * normal.0 + incoming.1 * normal.1);
    let out = (incoming.0 - turn * normal.0, incoming.1 - turn * normal.1);
    // Image point + t (F - image point) = spot + u out, in X and Z.
    let image = (p.x_center - x_frame) * p.cell_width;
    let sight = (-image, p.focal_length);
    let determinant = sight.0 * -out.1 + out.0 * sight.1;
    let t = ((spot - image) * -out.1) / determinant;
    let y = (p.y_center - row) * p.cell_height;
    [image + t * sight.0, y - t * y, t * sight.1]
}

#[test]
fn points_are_where_printed_equations_and_light_paths_put_them() {
    let frame = LightStripe::smart_eye().unwrap();
    let p = frame.parameters();
    for (row, col, x_frame) in
        [(0, 0, 5.0), (246, 60, 100.25), (300, 120, 500.0), (493, 199, 700.5)]
    {
        let theta = p.theta_laser.as_radians()[col];
        let point = frame.point(Pixel::new(row, col), x_frame);
        let printed = printed_equations(p, row as f64, theta, x_frame);
        let followed = follow_the_light(p, row as f64, theta, x_frame);
        let Some(point) = point else {
            assert!(printed[2] > p.farthest, "{printed:?}");
            continue;
        };
        assert!(near(&point, printed, 1e-8), "{point} {printed:?}");
        assert!(near(&point, followed, 1e-8), "{point} {followed:?}");
        // Residuals of Eq. 4.15 and 4.16.
        let laser = theta.tan() * (point.x + p.base_line(theta)) - point.z;
        let y_row = (p.y_center - row as f64) * p.cell_height;
        let sight = p.focal_length * point.y + y_row * point.z - y_row * p.focal_length;
        assert!(laser.abs() < 1e-8 && sight.abs() < 1e-8, "{laser} {sight}");
    }
}

#[test]
fn both_forms_of_the_mirror_offset_agree() {
    let p = LightStripeParameters::smart_eye();
    for theta in [0.4_f64, 1.1, 2.6] {
        let (m, g, r) = (theta / 2.0, p.mirror_axis, p.mirror_face);
        let b = (g * m.sin().powi(2) - g + r * m.cos()) / (m.sin() * m.cos());
        assert!((p.base_line(theta) - p.baseline - b).abs() < 1e-12);
    }
}

/// The errata's example: x_plane = -4 and θ = 1.4 give a point behind the sensor as printed.
#[test]
fn diverging_rays_are_missing_in_every_way_of_asking() {
    let mut p = simple(vec![1.4]);
    (p.cell_width, p.x_center, p.baseline) = (1.0, 10.0, 6.0);
    assert!(printed_equations(&p, 5.0, 1.4, 14.0)[2] < 0.0);
    let frame = LightStripe::new(p).unwrap();
    assert_eq!(frame.point(Pixel::new(5, 0), 14.0), None);
    let image = RangeImage::from_values(frame.size(), vec![14.0; 11]).unwrap();
    let mut out = [0.0_f32];
    frame.form_row(&image, 5, &LinearForm { gradient: Vector3::z(), constant: 0.0 }, &mut out);
    assert!(out[0].is_nan());
}

#[test]
fn the_dissertations_hardware_sees_a_face_at_working_depth() {
    let frame = LightStripe::smart_eye().unwrap();
    assert_eq!(frame.size(), ImageSize { rows: 494, cols: 200 });
    let mut seen = 0;
    for x in [-100.0, -30.0, 60.0, 120.0] {
        for y in [-90.0, 0.0, 90.0] {
            let p = Point3::new(x, y, 700.0);
            let d = frame.device_point(&p).unwrap();
            assert!(d.row > 0.0 && d.row < 493.0 && d.col > 0.0 && d.col < 199.0, "{d:?}");
            assert!(d.d3 > 0.0 && d.d3 < 768.0, "{d:?}");
            seen += 1;
        }
    }
    assert_eq!(seen, 12);
    // Beside the array, behind the camera, beyond the light, outside the scan: not seen.
    for hidden in [
        [-150.0, 0.0, 700.0],
        [0.0, 0.0, 10.0],
        [0.0, 0.0, 2001.0],
        [250.0, 0.0, 700.0],
        [0.0, f64::NAN, 700.0],
    ] {
        assert_eq!(frame.device_point(&Point3::from(hidden)), None, "{hidden:?}");
    }
}

/// One cell at the working depth is 0.8 mm, as the parameters' page says.
#[test]
fn a_cell_is_worth_as_much_depth_as_documented() {
    let frame = LightStripe::smart_eye().unwrap();
    let d = frame.device_point(&Point3::new(0.0, 0.0, 700.0)).unwrap();
    let pixel = Pixel::new(d.row as usize, d.col as usize);
    let here = frame.point(pixel, d.d3).unwrap();
    let next = frame.point(pixel, d.d3 + 1.0).unwrap();
    assert!((next.z - here.z - 0.8).abs() < 0.1, "{}", next.z - here.z);
}

#[test]
fn light_ends_at_the_farthest_depth_and_at_the_edge_of_the_fan() {
    let mut p = simple(vec![std::f64::consts::FRAC_PI_2]);
    p.farthest = 6.0;
    let frame = LightStripe::new(p.clone()).unwrap();
    assert!(frame.point(Pixel::new(5, 0), 5.99).is_some(), "z = 5.99");
    assert_eq!(frame.point(Pixel::new(5, 0), 6.1), None);
    let plane = SensorPlane { normal: Vector3::z(), offset: 6.5 };
    assert_eq!(frame.plane_value(Pixel::new(5, 0), &plane), None);
    assert_eq!(frame.device_point(&Point3::new(-2.0, 0.0, 6.5)), None);
    assert!(frame.device_point(&Point3::new(-2.0, 0.0, 5.5)).is_some());
    // The fan of 2 · atan(0.2): row 0 (y_plane = 0.25) is lit up to z = 5, where y = 1 = 0.2 z.
    p.farthest = f64::INFINITY;
    p.fan_angle = 2.0 * 0.2_f64.atan();
    let frame = LightStripe::new(p).unwrap();
    let value = |z: f64| {
        let plane = SensorPlane { normal: Vector3::z(), offset: z };
        frame.plane_value(Pixel::new(0, 0), &plane)
    };
    assert!(value(4.99).is_some() && value(5.01).is_none());
    assert!(frame.device_point(&Point3::new(-2.0, 0.99, 4.99)).is_some());
    assert_eq!(frame.device_point(&Point3::new(-2.0, 1.01, 5.01)), None);
}

#[test]
fn planes_beside_the_field_are_nearer_or_farther_than_every_sample() {
    let frame = LightStripe::new(simple(vec![std::f64::consts::FRAC_PI_2])).unwrap();
    let value = |z: f64| {
        let plane = SensorPlane { normal: Vector3::z(), offset: z };
        frame.plane_value(Pixel::new(5, 0), &plane)
    };
    // The array's left edge, x_plane = 1, sees the sheet at z = 3.
    assert!(value(2.5).unwrap() < 0.0 && value(3.5).unwrap() > 0.0);
    assert_eq!(value(0.5), None, "behind the ray's start");
    let leaning = LightStripe::new(simple(vec![1.2])).unwrap();
    // Its stripe leaves the array on the right at x_plane = -f/tan 1.2 = -0.389 for z → ∞.
    let image_of = |z: f64| {
        let plane = SensorPlane { normal: Vector3::z(), offset: z };
        leaning.plane_value(Pixel::new(5, 0), &plane).unwrap()
    };
    assert!((image_of(1e9) - (10.0 + 3.8877)).abs() < 1e-3, "{}", image_of(1e9));
}

#[test]
fn the_extent_is_finite_as_soon_as_light_ends() {
    let mut p = simple(vec![1.4, 1.5]);
    let endless = LightStripe::new(p.clone()).unwrap();
    assert_eq!(endless.extent(&Vector3::z(), 1.0, 19.0).1, f64::INFINITY);
    p.farthest = 50.0;
    let (low, high) = LightStripe::new(p).unwrap().extent(&Vector3::z(), 1.0, 19.0);
    assert!(low > 1.0 && (high - 50.0).abs() < 1e-12, "{low} {high}");
}

/// Fast rows against points, and the extent, where light ends early in every possible way.
#[test]
fn rows_and_extent_agree_with_points_also_where_samples_end() {
    let mut p = simple((0..20).map(|k| 0.9 + 0.04 * f64::from(k)).collect());
    (p.farthest, p.fan_angle, p.mirror_axis, p.mirror_face) = (30.0, 0.4, 0.1, 0.3);
    let frame = LightStripe::new(p).unwrap();
    let size = frame.size();
    let direction = Vector3::new(0.5, -0.7, 0.3).normalize();
    let form = LinearForm { gradient: direction, constant: 0.25 };
    let (mut valid, mut invalid) = (0, 0);
    for step in 1..60 {
        let d3 = 0.25 * step as f32;
        let image = RangeImage::from_values(size, vec![d3; size.pixels()]).unwrap();
        let (low, high) = frame.extent(&direction, f64::from(d3), f64::from(d3));
        let mut out = vec![0.0_f32; size.cols];
        for row in 0..size.rows {
            frame.form_row(&image, row, &form, &mut out);
            for (col, fast) in out.iter().enumerate() {
                let Some(point) = frame.point(Pixel::new(row, col), f64::from(d3)) else {
                    assert!(fast.is_nan(), "row {row}, column {col}, {d3}");
                    invalid += 1;
                    continue;
                };
                let along = direction.dot(&point.coords);
                assert!((along + 0.25 - f64::from(*fast)).abs() < 1e-5 * (1.0 + along.abs()));
                assert!(low - 1e-9 < along && along < high + 1e-9, "{low} {along} {high}");
                assert!(frame.device_point(&(point * 0.9999999)).is_some() || d3 < 0.3);
                valid += 1;
            }
        }
    }
    assert!(valid > 2000 && invalid > 2000, "{valid} {invalid}");
}

#[test]
fn a_single_angle_makes_a_profile_sensor() {
    let frame = LightStripe::new(simple(vec![1.2])).unwrap();
    assert_eq!(frame.size().cols, 1);
    let p = frame.point(Pixel::new(2, 0), 8.0).unwrap();
    let d = frame.device_point(&p).unwrap();
    assert!((d.row - 2.0).abs() < 1e-9 && d.col == 0.0 && (d.d3 - 8.0).abs() < 1e-9);
    assert_eq!(frame.device_point(&Point3::new(p.x + 0.1, p.y, p.z)), None, "off the sheet");
}

#[test]
fn bad_parameters_are_named() {
    assert_eq!(message(|p| p.focal_length = 0.0), "focal_length = 0: a positive length");
    assert_eq!(message(|p| p.cell_width = -1.0), "cell_width = -1: a positive length");
    assert!(message(|p| p.cell_height = f64::NAN).starts_with("cell_height = NaN"));
    assert!(message(|p| p.x_center = f64::INFINITY).starts_with("x_center = inf"));
    assert!(message(|p| p.fan_angle = 4.0).starts_with("fan_angle = 4: an angle between"));
    assert!(message(|p| p.mirror_face = -2.0).starts_with("mirror_face = -2: a length"));
    assert!(message(|p| p.camera_rows = 0).starts_with("camera_rows = 0"));
    assert!(message(|p| p.farthest = 3.0).starts_with("farthest = 3: a depth beyond"));
    assert!(message(|p| p.farthest = f64::NAN).starts_with("farthest = NaN"));
    let angles = |list: &[f64]| {
        let list = list.to_vec();
        message(|p| p.theta_laser = LaserAngles::from_radians(list))
    };
    assert_eq!(angles(&[]), "theta_laser = 0: at least one angle");
    assert_eq!(angles(&[1.0, 3.5]), "theta_laser = 3.5: angles between 0 and π, in radians");
    assert_eq!(angles(&[0.0, 1.0]), "theta_laser = 0: angles between 0 and π, in radians");
    assert!(angles(&[1.0, f64::NAN]).starts_with("theta_laser = NaN"));
    let unsorted = "theta_laser = 1.05: angles that all increase or all decrease";
    assert_eq!(angles(&[1.0, 1.1, 1.05, 1.2]), unsorted);
    assert!(angles(&[1.1, 1.1]).contains("all increase or all decrease"));
}

#[test]
fn impossible_geometry_is_refused() {
    // f cos θ exceeds B_b sin θ at flat angles: x_frame would fall with range.
    let flat = message(|p| {
        p.baseline = 2.0;
        p.theta_laser = LaserAngles::from_radians(vec![0.3, 0.5]);
    });
    assert!(flat.starts_with("baseline = "), "{flat}");
    assert!(flat.ends_with("more than f / tan θ at every laser angle"), "{flat}");
    // Sheets that lean away from everything the camera sees.
    let away = message(|p| p.theta_laser = LaserAngles::from_radians(vec![2.5, 2.6]));
    assert_eq!(away, "theta_laser = 2.5: laser sheets that cross the camera's field");
    // A large mirror moves the beam back, and everything it meets beyond the farthest depth.
    let far = message(|p| p.mirror_face = 2000.0);
    assert!(far.ends_with("laser sheets that cross the camera's field"), "{far}");
    // The beam moves back faster than it turns forward: sheets cross at z = 134, seen from 72 on.
    let crossing = message(|p| (p.baseline, p.mirror_face, p.mirror_axis) = (-150.0, 100.0, 0.0));
    assert!(crossing.starts_with("mirror_face = 100: a mirror whose laser sheets"), "{crossing}");
    let error = LightStripe::new(simple(vec![3.2])).unwrap_err();
    assert!(matches!(error, SensorError::BadParameter { key: "theta_laser", .. }));
}
