//! Laws that every device frame keeps, over random sensors, pixels and planes.

use proptest::prelude::*;
use transect_device::{
    DeviceFrame, Handedness, ImageSize, LinearForm, MISSING_POINT, Neighbour, PairGeometry, Pixel,
    Point3, RangeImage, SensorPlane, Vector3,
};
use transect_sensors::{
    AngularScan, ImagingRadar, Intrinsics, LaserAngles, LightStripe, LightStripeParameters,
    Pinhole, PinholeScale, PointGrid, RayStarts, RayTable,
};

pub(super) const SIZE: ImageSize = ImageSize { rows: 12, cols: 17 };

pub(super) fn radars() -> impl Strategy<Value = ImagingRadar> {
    let steps = (0.005..0.1_f64, 0.005..0.1_f64, any::<bool>(), any::<bool>());
    (-4.0..4.0_f64, -0.4..0.4_f64, steps).prop_map(|(theta0, phi0, (dt, dp, flip_t, flip_p))| {
        let sign = |flip: bool| if flip { -1.0 } else { 1.0 };
        let theta = AngularScan::from_radians(theta0, sign(flip_t) * dt);
        let phi = AngularScan::from_radians(phi0, sign(flip_p) * dp);
        ImagingRadar::new(SIZE, theta, phi).unwrap()
    })
}

pub(super) fn cameras() -> impl Strategy<Value = Pinhole> {
    (5.0..60.0, 5.0..60.0, -3.0..20.0, -3.0..20.0)
        .prop_map(|(fx, fy, cx, cy)| Pinhole::new(SIZE, Intrinsics { fx, fy, cx, cy }).unwrap())
}

/// Range finders in focal lengths, with uneven angles either way round and a moving mirror. Every
/// line of sight of the 64 columns meets every sheet, so that all values up to 64 are points.
pub(super) fn stripes() -> impl Strategy<Value = LightStripe> {
    let angles = (0.7..0.8_f64, prop::collection::vec(0.005..0.025_f64, SIZE.cols), any::<bool>());
    let theta_laser = angles.prop_map(|(first, steps, falling)| {
        let next = |theta: &mut f64, step: f64| {
            *theta += step;
            Some(*theta)
        };
        let mut radians: Vec<f64> = steps.into_iter().scan(first, next).collect();
        if falling {
            radians.reverse();
        }
        LaserAngles::from_radians(radians)
    });
    let lengths = (3.0..20.0_f64, 0.0..0.5_f64, 0.0..0.5_f64);
    let camera = (0.003..0.01_f64, 0.01..0.04_f64, 25.0..32.0_f64, -2.0..13.0_f64);
    (theta_laser, lengths, camera).prop_map(|(theta_laser, lengths, camera)| {
        let (baseline, mirror_axis, mirror_face) = lengths;
        let (cell_width, cell_height, x_center, y_center) = camera;
        let parameters = LightStripeParameters {
            camera_rows: SIZE.rows,
            camera_cols: 64,
            focal_length: 1.0,
            cell_width,
            cell_height,
            x_center,
            y_center,
            baseline,
            mirror_axis,
            mirror_face,
            fan_angle: 2.0,
            farthest: f64::INFINITY,
            theta_laser,
        };
        LightStripe::new(parameters).unwrap()
    })
}

fn central_frames() -> impl Strategy<Value = Box<dyn DeviceFrame>> {
    prop_oneof![2 => frames_with_tables(), 1 => frames_without_tables()]
}

/// Frames whose points are separable into rows and columns. Whole images of them take the fast
/// path, so they must have tables.
pub(super) fn frames_with_tables() -> impl Strategy<Value = Box<dyn DeviceFrame>> {
    prop_oneof![
        radars().prop_map(|f| Box::new(f) as Box<dyn DeviceFrame>),
        cameras()
            .prop_map(|f| { Box::new(f.with_scale(PinholeScale::Depth)) as Box<dyn DeviceFrame> }),
    ]
}

/// Frames whose points are not separable: ray lengths of cameras, and rays one by one.
pub(super) fn frames_without_tables() -> impl Strategy<Value = Box<dyn DeviceFrame>> {
    prop_oneof![
        cameras().prop_map(|f| {
            Box::new(f.with_scale(PinholeScale::RayLength)) as Box<dyn DeviceFrame>
        }),
        lenses().prop_map(|f| Box::new(f) as Box<dyn DeviceFrame>),
    ]
}

pub(super) fn scales() -> impl Strategy<Value = PinholeScale> {
    prop_oneof![Just(PinholeScale::Depth), Just(PinholeScale::RayLength)]
}

/// Cameras whose lens pulls rays in or pushes them out, the grid either way round.
pub(super) fn lenses() -> impl Strategy<Value = RayTable> {
    let camera = (20.0..60.0_f64, 4.0..12.0_f64, 2.0..9.0_f64);
    (camera, -0.15..0.15_f64, any::<bool>(), scales()).prop_map(
        |(camera, bend, mirrored, scale)| {
            let (focal, cx, cy) = camera;
            let ray = |(row, col): (usize, usize)| {
                let (x, y) = ((col as f64 - cx) / focal, (row as f64 - cy) / focal);
                let bent = 1.0 + bend * (x * x + y * y);
                Vector3::new(if mirrored { -x * bent } else { x * bent }, y * bent, 1.0)
            };
            let pixels = (0..SIZE.rows).flat_map(|row| (0..SIZE.cols).map(move |col| (row, col)));
            RayTable::new(SIZE, pixels.map(ray).collect(), scale).unwrap()
        },
    )
}

fn frames() -> impl Strategy<Value = Box<dyn DeviceFrame>> {
    prop_oneof![2 => central_frames(), 1 => stripe_frames()]
}

fn stripe_frames() -> impl Strategy<Value = Box<dyn DeviceFrame>> {
    stripes().prop_map(|f| Box::new(f) as Box<dyn DeviceFrame>)
}

fn pixels() -> impl Strategy<Value = Pixel> {
    (0..SIZE.rows, 0..SIZE.cols).prop_map(|(row, col)| Pixel::new(row, col))
}

pub(super) fn directions() -> impl Strategy<Value = Vector3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("has a direction", |v: &Vector3| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

/// Images with values from 1 to 9 and a fifth of the pixels missing.
pub(super) fn images() -> impl Strategy<Value = RangeImage> {
    let value = prop_oneof![4 => 1.0_f32..9.0, 1 => Just(f32::NAN)];
    prop::collection::vec(value, SIZE.pixels())
        .prop_map(|values| RangeImage::from_values(SIZE, values).unwrap())
}

/// The grid of points that another frame sees.
pub(super) fn grid_of(
    frame: &dyn DeviceFrame,
    image: &RangeImage,
) -> Option<(PointGrid, RangeImage)> {
    let all = (0..SIZE.rows).flat_map(|row| (0..SIZE.cols).map(move |col| Pixel::new(row, col)));
    let missing = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let point = |p: Pixel| frame.point(p, f64::from(image.get(p)?));
    let points = all.map(|p| point(p).unwrap_or(missing)).collect();
    PointGrid::new(SIZE, points, RayStarts::Viewpoint(Point3::origin())).ok()
}

/// The obvious per-pixel versions of the row methods, whatever a backend overrides.
#[derive(Debug)]
struct Slow<'a>(&'a dyn DeviceFrame);

impl DeviceFrame for Slow<'_> {
    fn size(&self) -> ImageSize {
        self.0.size()
    }

    fn kind(&self) -> &'static str {
        self.0.kind()
    }
    fn handedness(&self) -> Handedness {
        self.0.handedness()
    }
    fn columns_wrap(&self) -> bool {
        self.0.columns_wrap()
    }
    fn ray(&self, pixel: Pixel) -> Option<transect_device::Ray> {
        self.0.ray(pixel)
    }
    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        self.0.point(pixel, d3)
    }
    fn device_point(&self, p: &Point3) -> Option<transect_device::DevicePoint> {
        self.0.device_point(p)
    }
    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        self.0.plane_value(pixel, plane)
    }
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        self.0.extent(direction, nearest, farthest)
    }
}

fn close(a: f32, b: f32) -> bool {
    (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-5 * (1.0 + a.abs())
}

fn rows_agree(frame: &dyn DeviceFrame, image: &RangeImage, form: &LinearForm) -> bool {
    let slow = Slow(frame);
    let mut forms = [[0.0_f32; SIZE.cols]; 2];
    let mut pairs = [[PairGeometry::MISSING; SIZE.cols]; 2];
    (0..SIZE.rows).all(|row| {
        frame.form_row(image, row, form, &mut forms[0]);
        slow.form_row(image, row, form, &mut forms[1]);
        let same_forms = forms[0].iter().zip(&forms[1]).all(|(a, b)| close(*a, *b));
        let same_pairs = [Neighbour::Up, Neighbour::Left].into_iter().all(|neighbour| {
            frame.pair_row(image, row, neighbour, &mut pairs[0]);
            slow.pair_row(image, row, neighbour, &mut pairs[1]);
            let same = |(a, b): (&PairGeometry, &PairGeometry)| {
                close(a.range_step, b.range_step) && close(a.lateral, b.lateral)
            };
            pairs[0].iter().zip(&pairs[1]).all(same)
        });
        same_forms && same_pairs
    })
}

pub(super) fn valid(image: &RangeImage) -> impl Iterator<Item = (Pixel, f32)> + '_ {
    let pixels = (0..SIZE.rows).flat_map(|row| (0..SIZE.cols).map(move |col| Pixel::new(row, col)));
    pixels.filter_map(|p| Some((p, image.get(p)?)))
}

/// A sensor of one pixel, at a place between those of another: linear between its angles.
fn at_one_pixel(frame: &LightStripe, row: f64, col: f64) -> LightStripe {
    let parameters = frame.parameters().clone();
    let angles = parameters.theta_laser.as_radians();
    let left = (col as usize).min(angles.len() - 2);
    let theta = angles[left] + (col - left as f64) * (angles[left + 1] - angles[left]);
    let one = LightStripeParameters {
        camera_rows: 1,
        y_center: parameters.y_center - row,
        theta_laser: LaserAngles::from_radians(vec![theta]),
        ..parameters
    };
    LightStripe::new(one).unwrap()
}

proptest! {
    #[test]
    fn going_to_the_device_frame_and_back_returns_the_point(
        frame in frames(), pixel in pixels(), d3 in 0.1..50.0,
    ) {
        let p = frame.point(pixel, d3).unwrap();
        let d = frame.device_point(&p).unwrap();
        prop_assert!((d.row - pixel.row as f64).abs() < 1e-7, "{d:?}");
        prop_assert!((d.col - pixel.col as f64).abs() < 1e-7, "{d:?}");
        prop_assert!((d.d3 - d3).abs() < 1e-9 * d3);
        let back = frame.point(pixel, d.d3).unwrap();
        prop_assert!((back - p).norm() < 1e-9 * d3);
    }

    #[test]
    fn places_between_a_range_finders_pixels_are_kept_both_ways(
        frame in stripes(), row in 0.0..11.0, col in 0.0..16.0, d3 in 0.1..50.0,
    ) {
        let p = at_one_pixel(&frame, row, col).point(Pixel::new(0, 0), d3).unwrap();
        let d = frame.device_point(&p).unwrap();
        prop_assert!((d.row - row).abs() < 1e-7 && (d.col - col).abs() < 1e-7, "{d:?}");
        prop_assert!((d.d3 - d3).abs() < 1e-9 * d3);
        let back = at_one_pixel(&frame, d.row, d.col).point(Pixel::new(0, 0), d.d3).unwrap();
        prop_assert!((back - p).norm() < 1e-9 * p.coords.norm(), "{p} {back}");
    }

    #[test]
    fn the_value_of_a_plane_lies_on_the_plane_and_on_the_ray(
        frame in frames(), pixel in pixels(), normal in directions(), offset in -9.0..9.0,
    ) {
        let plane = SensorPlane { normal, offset };
        if let Some(value) = frame.plane_value(pixel, &plane) {
            let p = frame.point(pixel, value).unwrap();
            let ray = frame.ray(pixel).unwrap();
            let along = p - ray.start;
            let scale = 1.0 + along.norm();
            prop_assert!((normal.dot(&p.coords) - offset).abs() < 1e-9 * scale);
            prop_assert!(along.cross(&ray.direction).norm() < 1e-9 * scale);
            prop_assert!(along.dot(&ray.direction) > 0.0);
        }
    }

    #[test]
    fn larger_values_are_farther_along_the_ray(
        frame in frames(), pixel in pixels(), a in 0.1..50.0, b in 0.1..50.0,
    ) {
        let ray = frame.ray(pixel).unwrap();
        let range = |d3: f64| (frame.point(pixel, d3).unwrap() - ray.start).norm();
        prop_assert_eq!(a < b, range(a) < range(b));
    }

    #[test]
    fn no_point_lies_outside_the_extent(
        frame in frames(), image in images(), direction in directions(),
    ) {
        let Some((near, far)) = image.extremes() else { return Ok(()) };
        let (low, high) = frame.extent(&direction, f64::from(near), f64::from(far));
        for row in 0..SIZE.rows {
            for col in 0..SIZE.cols {
                let pixel = Pixel::new(row, col);
                let Some(d3) = image.get(pixel) else { continue };
                let p = frame.point(pixel, f64::from(d3)).unwrap();
                let along = direction.dot(&p.coords);
                prop_assert!(along > low - 1e-9 && along < high + 1e-9, "{low} {along} {high}");
            }
        }
    }

    #[test]
    fn stated_handedness_is_the_one_of_points_on_a_surface_that_faces_the_sensor(
        frame in frames(), pixel in pixels(), d3 in 1.0..9.0,
    ) {
        prop_assume!(pixel.row > 0 && pixel.col > 0);
        let (ray, here) = (frame.ray(pixel).unwrap(), frame.point(pixel, d3).unwrap());
        let facing = SensorPlane { normal: ray.direction, offset: ray.direction.dot(&here.coords) };
        let on_it = |pixel| frame.plane_value(pixel, &facing).and_then(|v| frame.point(pixel, v));
        let left = on_it(Pixel::new(pixel.row, pixel.col - 1));
        let above = on_it(Pixel::new(pixel.row - 1, pixel.col));
        prop_assume!(left.is_some() && above.is_some());
        let turn = (here - left.unwrap()).cross(&(here - above.unwrap())).dot(&ray.direction);
        prop_assert_eq!(turn > 0.0, frame.handedness() == Handedness::ColumnsRight);
    }

    #[test]
    fn fast_rows_equal_slow_rows(
        frame in frames(), image in images(), gradient in directions(), constant in -5.0..5.0,
    ) {
        let form = LinearForm { gradient, constant };
        prop_assert!(rows_agree(frame.as_ref(), &image, &form));
    }

    #[test]
    fn fast_rows_of_tables_equal_slow_rows(
        table in crate::tables::tables(), image in images(), gradient in directions(),
    ) {
        // From within the digitised field to well outside it.
        let values = (0..SIZE.rows).flat_map(|row| image.row(row)).map(|v| 10.0 * v);
        let image = RangeImage::from_values(SIZE, values.collect()).unwrap();
        let form = LinearForm { gradient, constant: 1.0 };
        prop_assert!(rows_agree(&table, &image, &form));
    }

    #[test]
    fn a_grid_of_points_is_the_frame_it_came_from(
        frame in central_frames(), pixel in pixels(), normal in directions(), offset in -9.0..9.0,
    ) {
        let flat = RangeImage::from_values(SIZE, vec![3.0; SIZE.pixels()]).unwrap();
        let Some((grid, image)) = grid_of(frame.as_ref(), &flat) else { return Ok(()) };
        prop_assert_eq!(grid.handedness(), frame.handedness());
        let d3 = f64::from(image.get(pixel).unwrap());
        let there = frame.point(pixel, 3.0).unwrap();
        prop_assert!((grid.point(pixel, d3).unwrap() - there).norm() < 1e-6);
        let plane = SensorPlane { normal, offset };
        let value = grid.plane_value(pixel, &plane);
        prop_assert_eq!(value.is_some(), frame.plane_value(pixel, &plane).is_some());
        if let Some(p) = value.and_then(|v| grid.point(pixel, v)) {
            prop_assert!((normal.dot(&p.coords) - offset).abs() < 1e-6 * (1.0 + p.coords.norm()));
        }
    }

    #[test]
    fn fast_rows_of_point_grids_equal_slow_rows(
        frame in central_frames(), image in images(), gradient in directions(), axis in 0..3_usize,
    ) {
        let Some((grid, given)) = grid_of(frame.as_ref(), &image) else { return Ok(()) };
        let form = LinearForm { gradient, constant: 1.0 };
        // As it was given, and with every other sample moved along its ray.
        let values = (0..SIZE.rows).flat_map(|row| given.row(row)).enumerate();
        let moved = values.map(|(k, v)| if k % 2 == 0 { 1.01 * v } else { *v }).collect();
        for image in [RangeImage::from_values(SIZE, moved).unwrap(), given.clone()] {
            prop_assert!(rows_agree(&grid, &image, &form));
        }
        let points = || valid(&given).map(|(p, d3)| grid.point(p, f64::from(d3)).unwrap());
        for direction in [gradient, Vector3::ith(axis, -2.5)] {
            let (low, high) = grid.extent(&direction, 0.0, 1.0);
            let along = || points().map(|p| direction.dot(&p.coords));
            prop_assert_eq!(low, along().fold(f64::INFINITY, f64::min));
            prop_assert_eq!(high, along().fold(f64::NEG_INFINITY, f64::max));
        }
    }
}

#[test]
fn a_full_circle_joins_its_last_column_to_its_first() {
    let theta = AngularScan::from_degrees(-180.0, 360.0 / SIZE.cols as f64);
    let phi = AngularScan::from_degrees(-10.0, 1.0);
    let circle = ImagingRadar::new(SIZE, theta, phi).unwrap();
    assert!(circle.columns_wrap());
    let seam = circle.neighbour(Pixel::new(3, 0), Neighbour::Left);
    assert_eq!(seam, Some(Pixel::new(3, SIZE.cols - 1)));
    let image = RangeImage::from_values(SIZE, vec![2.0; SIZE.pixels()]).unwrap();
    let form = LinearForm { gradient: Vector3::x(), constant: 0.0 };
    assert!(rows_agree(&circle, &image, &form));
    let half = AngularScan::from_degrees(-90.0, 180.0 / SIZE.cols as f64);
    assert!(!ImagingRadar::new(SIZE, half, phi).unwrap().columns_wrap());
}

#[test]
fn bad_parameters_are_named() {
    let good = AngularScan::from_degrees(0.0, 1.0);
    let message = |theta, phi| ImagingRadar::new(SIZE, theta, phi).unwrap_err().to_string();
    let still = AngularScan::from_degrees(0.0, 0.0);
    assert_eq!(message(still, good), "dtheta = 0: a step other than 0");
    let too_long = AngularScan::from_degrees(0.0, 30.0);
    assert!(message(too_long, good).contains("columns within one full circle"));
    let over_the_top = AngularScan::from_degrees(85.0, 1.0);
    assert!(message(good, over_the_top).contains("rows between -90° and 90°"));
    let flat = Intrinsics { fx: 0.0, fy: 1.0, cx: 0.0, cy: 0.0 };
    let message = Pinhole::new(SIZE, flat).unwrap_err().to_string();
    assert_eq!(message, "fx = 0: a positive focal length in pixels");
}

#[test]
fn points_at_the_origin_are_missing_not_real() {
    let size = ImageSize { rows: 2, cols: 2 };
    let points = vec![
        Point3::origin(),
        Point3::new(1.0, 0.0, 5.0),
        Point3::new(0.0, 1.0, 5.0),
        Point3::new(1.0, 1.0, 5.0),
    ];
    let starts = RayStarts::Parallel(Vector3::z());
    let (grid, image) = PointGrid::new(size, points, starts).unwrap();
    assert_eq!(image.valid_count(), 3);
    assert_eq!(grid.point(Pixel::new(0, 0), 1.0), None);
}

#[test]
fn a_missing_point_between_two_others_has_a_ray_between_theirs() {
    let size = ImageSize { rows: 5, cols: 5 };
    let viewpoint = Point3::new(0.2, 0.0, -0.1);
    let of = |pixel: Pixel| {
        let (x, y) = (pixel.col as f64 - 2.0, pixel.row as f64 - 2.0);
        // A wall, and a nearer one to the right of column 2.
        Point3::new(0.1 * x, 0.1 * y, if pixel.col < 3 { 4.0 } else { 2.0 })
    };
    let missing = [Pixel::new(0, 2), Pixel::new(2, 2), Pixel::new(4, 0)];
    let points =
        size.all_pixels().map(|p| if missing.contains(&p) { MISSING_POINT } else { of(p) });
    let starts = RayStarts::Viewpoint(viewpoint);
    let (grid, image) = PointGrid::new(size, points.collect(), starts).unwrap();
    assert_eq!(image.valid_count(), size.pixels() - 3, "the samples stay missing");
    // Pixel (0, 2) lies between both walls; (2, 2) does so in its row, but not in its column.
    for (pixel, has_ray) in missing.into_iter().zip([true, true, false]) {
        assert_eq!(grid.ray(pixel).is_some(), has_ray, "{pixel}");
    }
    let true_point = of(missing[1]);
    let found = grid.point(missing[1], (true_point - viewpoint).norm()).unwrap();
    assert!((found - true_point).norm() < 1e-12, "{found}");
    let mut row = [PairGeometry::MISSING; 5];
    grid.pair_row(&image, 2, Neighbour::Left, &mut row);
    assert!(row[2].lateral.is_nan() && row[3].lateral.is_nan(), "no pair without a sample");
}

#[test]
fn a_full_circle_of_points_joins_its_last_column_to_its_first() {
    let step = 360.0 / SIZE.cols as f64;
    let phi = AngularScan::from_degrees(-10.0, 1.0);
    let flat = RangeImage::from_values(SIZE, vec![2.0; SIZE.pixels()]).unwrap();
    let wraps = |step: f64| {
        let radar = ImagingRadar::new(SIZE, AngularScan::from_degrees(-180.0, step), phi).unwrap();
        grid_of(&radar, &flat).unwrap().0.columns_wrap()
    };
    assert!(wraps(step));
    assert!(!wraps(0.8 * step), "a gap of a fifth of the circle");
}

#[test]
fn grids_without_a_side_or_with_wild_points_are_handled() {
    let size = ImageSize { rows: 3, cols: 3 };
    let line = (0..9).map(|k| Point3::new(f64::from(k), 0.0, 5.0)).collect();
    let starts = RayStarts::Viewpoint(Point3::origin());
    let error = PointGrid::new(size, line, starts).unwrap_err().to_string();
    assert_eq!(error, "no three neighbouring points show from which side the grid is seen");

    let at = |k: i32| Point3::new(f64::from(k % 3), f64::from(k / 3), 5.0);
    let mut points: Vec<_> = (0..9).map(at).collect();
    points[4] = Point3::new(1e40, 0.0, 0.0);
    let (grid, image) = PointGrid::new(size, points, starts).unwrap();
    assert_eq!(image.valid_count(), 8);
    assert_eq!(grid.extent(&Vector3::x(), 0.0, 1e40), (0.0, 2.0));

    let lost = RayStarts::CarriedPinhole(transect_sensors::CarriedPinhole {
        y: f64::NAN,
        z: 9.0,
        slant: 0.0,
    });
    let error = PointGrid::new(size, (0..9).map(at).collect(), lost).unwrap_err();
    assert!(error.to_string().contains("pinhole = NaN"), "{error}");
}
