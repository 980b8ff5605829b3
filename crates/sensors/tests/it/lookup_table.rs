//! Laws of lookup tables inside their digitised field, and what calibration makes of bad data.

use crate::noise::Noise;
use crate::tables::tables;
use nalgebra::Point2;
use proptest::prelude::*;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, Pixel, Point3, RangeImage, SensorPlane,
    Vector3,
};
use transect_sensors::LookupTable;
use transect_sensors::lookup_table::{
    CalibrationOptions, CalibrationSweep, DepthPairs, DigitizedField, LinearSteps, Mounting,
    ScanPlane, SynchronizedScanner, ThetaSteps, digitize,
};

fn pixels() -> impl Strategy<Value = Pixel> {
    (0..12_usize, 0..17_usize).prop_map(|(row, col)| Pixel::new(row, col))
}

/// The value at a part of a column's digitised range.
fn value(table: &LookupTable, col: usize, part: f64) -> f64 {
    let (low, high) = table.field().beam(col).unwrap().p_range();
    low + part * (high - low)
}

fn directions() -> impl Strategy<Value = Vector3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("has a direction", |v: &Vector3| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

proptest! {
    #[test]
    fn going_to_the_device_frame_and_back_returns_the_point(
        table in tables(), pixel in pixels(), part in 0.0..=1.0,
    ) {
        let d3 = value(&table, pixel.col, part);
        let p = table.point(pixel, d3).unwrap();
        let d = table.device_point(&p).unwrap();
        prop_assert!((d.row - pixel.row as f64).abs() < 1e-9, "{d:?}");
        prop_assert!((d.col - pixel.col as f64).abs() < 1e-9, "{d:?}");
        prop_assert!((d.d3 - d3).abs() < 1e-9 * d3);
        prop_assert!((table.point(pixel, d.d3).unwrap() - p).norm() < 1e-9 * p.coords.norm());
    }

    #[test]
    fn so_it_does_between_pixels(
        table in tables(), row in -2.0..14.0, col in 0.0..16.0, part in 0.0..=1.0,
    ) {
        let left = f64::floor(col) as usize;
        // Inside both neighbouring beams' ranges.
        let ends = [left, left + 1].map(|c| table.field().beam(c).unwrap().p_range());
        let (low, high) = (ends[0].0.max(ends[1].0), ends[0].1.min(ends[1].1));
        let there = DevicePoint { row, col, d3: low + part * (high - low) };
        let p = table.point_at(&there).unwrap();
        let d = table.device_point(&p).unwrap();
        let off = (d.row - row).abs().max((d.col - col).abs()).max((d.d3 - there.d3).abs());
        prop_assert!(off < 1e-8, "{there:?} came back as {d:?}");
    }

    #[test]
    fn a_value_survives_its_rounding_to_f32(table in tables(), pixel in pixels(), end in 0..2) {
        let d3 = f64::from(value(&table, pixel.col, f64::from(end)) as f32);
        let p = table.point(pixel, d3).unwrap();
        prop_assert!((table.device_point(&p).unwrap().d3 - d3).abs() < 1e-9 * d3);
    }

    #[test]
    fn the_value_of_a_plane_lies_on_the_plane_and_on_the_ray(
        table in tables(), pixel in pixels(), normal in directions(), part in 0.0..=1.0,
    ) {
        // A plane through a point of another pixel, so that it often crosses the field.
        let near = Pixel::new((pixel.row + 5) % 12, (pixel.col + 3) % 17);
        let on = table.point(near, value(&table, near.col, part)).unwrap();
        let plane = SensorPlane { normal, offset: normal.dot(&on.coords) };
        if let Some(d3) = table.plane_value(pixel, &plane) {
            let p = table.point(pixel, d3).unwrap();
            let ray = table.ray(pixel).unwrap();
            let along = p - ray.start;
            prop_assert!((normal.dot(&p.coords) - plane.offset).abs() < 1e-9 * p.coords.norm());
            prop_assert!(along.cross(&ray.direction).norm() < 1e-9 * p.coords.norm());
            prop_assert!(along.dot(&ray.direction) > -1e-4);
        }
        let own = table.point(pixel, value(&table, pixel.col, part)).unwrap();
        let plane = SensorPlane { normal, offset: normal.dot(&own.coords) };
        let grazing = normal.dot(&table.ray(pixel).unwrap().direction).abs() < 1e-3;
        let met = table.plane_value(pixel, &plane);
        let expected = value(&table, pixel.col, part);
        let inside = part > 1e-6 && part < 1.0 - 1e-6;
        prop_assert!(grazing || !inside || (met.unwrap() - expected).abs() < 1e-7);
    }

    #[test]
    fn larger_values_are_farther_along_the_ray(
        table in tables(), pixel in pixels(), a in 0.0..=1.0, b in 0.0..=1.0,
    ) {
        let ray = table.ray(pixel).unwrap();
        prop_assert!((ray.direction.norm() - 1.0).abs() < 1e-12);
        let range = |part: f64| {
            let p = table.point(pixel, value(&table, pixel.col, part)).unwrap();
            (p - ray.start).dot(&ray.direction)
        };
        prop_assert_eq!(a < b, range(a) < range(b));
    }

    #[test]
    fn no_point_lies_outside_the_extent(
        table in tables(), direction in directions(), near in 0.0..1.0, far in 0.0..1.0,
    ) {
        let (near, far) = (value(&table, 8, f64::min(near, far)), value(&table, 8, f64::max(near, far)));
        let (low, high) = table.extent(&direction, near, far);
        for (row, col, step) in pixels_and_parts(12, 17, 8) {
            let d3 = near + (far - near) * step as f64 / 7.0;
            let Some(p) = table.point(Pixel::new(row, col), d3) else { continue };
            let along = direction.dot(&p.coords);
            prop_assert!(along > low - 1e-9 && along < high + 1e-9, "{low} {along} {high}");
        }
    }

    #[test]
    fn stated_handedness_is_the_one_of_the_points(
        table in tables(), pixel in pixels(), part in 0.1..0.9,
    ) {
        prop_assume!(pixel.row > 0 && pixel.col > 0);
        let d3 = value(&table, pixel.col, part);
        let at = |row, col| table.point(Pixel::new(row, col), d3);
        let here = at(pixel.row, pixel.col).unwrap();
        let Some(left) = at(pixel.row, pixel.col - 1) else { return Ok(()) };
        let along_rows = here - at(pixel.row - 1, pixel.col).unwrap();
        let turn = (here - left).cross(&along_rows).dot(&table.ray(pixel).unwrap().direction);
        prop_assert_eq!(turn > 0.0, table.handedness() == Handedness::ColumnsRight);
    }

    #[test]
    fn outside_the_digitised_field_there_is_nothing(
        table in tables(), pixel in pixels(), off in 0.001..5.0,
    ) {
        let (low, high) = table.field().beam(pixel.col).unwrap().p_range();
        for d3 in [low - off, high + off, f64::NAN, f64::INFINITY, -1.0] {
            prop_assert_eq!(table.point(pixel, d3), None);
        }
        prop_assert_eq!(table.point(Pixel::new(12, pixel.col), low), None);
        prop_assert_eq!(table.point(Pixel::new(pixel.row, 17), low), None);
        // Before the nearest and behind the farthest depth line, and beside the outermost beams.
        let ray = table.ray(pixel).unwrap().direction;
        let (near, far) = (table.point(pixel, low).unwrap(), table.point(pixel, high).unwrap());
        prop_assert_eq!(table.device_point(&(near - off * ray)), None);
        prop_assert_eq!(table.device_point(&(far + off * ray)), None);
        for (outer, inner) in [(0, 1), (16, 15)] {
            let d3 = value(&table, outer, 0.5);
            let edge = table.point(Pixel::new(0, outer), d3).unwrap();
            let Some(next) = table.point(Pixel::new(0, inner), d3) else { continue };
            let outwards = (edge - next).normalize();
            prop_assert_eq!(table.device_point(&(edge + off * outwards)), None);
        }
    }
}

fn pixels_and_parts(
    rows: usize,
    cols: usize,
    steps: usize,
) -> impl Iterator<Item = (usize, usize, usize)> {
    let all = (0..rows).flat_map(move |row| (0..cols).map(move |col| (row, col)));
    all.flat_map(move |(row, col)| (0..steps).map(move |step| (row, col, step)))
}

/// The field of the example's scanner from so many unequal depths and columns.
fn field(depths: usize, columns: &ThetaSteps) -> DigitizedField {
    let sweeps = sweeps(depths, columns);
    digitize(&sweeps, columns, CalibrationOptions::EXACT).unwrap()
}

fn sweeps(depths: usize, columns: &ThetaSteps) -> Vec<CalibrationSweep> {
    let depth = |k: usize| 110.0 + 90.0 * (k as f64 / (depths - 1) as f64).powf(1.2);
    (0..depths).map(|k| SynchronizedScanner::hyscan().sweep(columns, depth(k), 0.02)).collect()
}

/// Largest distance of the tables' point from the true spot, and largest error of `p`.
fn worst_errors(field: &DigitizedField, columns: &ThetaSteps, beside: f64) -> (f64, f64) {
    let scanner = SynchronizedScanner::hyscan();
    let step = columns.angle(1) - columns.angle(0);
    let mut worst = (0.0_f64, 0.0_f64);
    for col in 0..columns.count() - 1 {
        let theta = columns.angle(col) + beside * step;
        for k in 0..500 {
            let p = 3.0 + 14.0 * f64::from(k) / 499.0;
            let Some(at) = field.forward(col as f64 + beside, p) else { continue };
            let spot = scanner.spot(theta, p).unwrap();
            worst.0 = worst.0.max((at - spot).norm());
            let Some((_, found)) = field.inverse(&spot) else { continue };
            worst.1 = worst.1.max((found - p).abs());
        }
    }
    assert!(worst.0 > 0.0 && worst.1 > 0.0, "nothing was compared");
    worst
}

fn columns(count: usize) -> ThetaSteps {
    let (first, last) = (-0.1, 0.38);
    ThetaSteps::from_radians(first, (last - first) / (count - 1) as f64, count)
}

#[test]
fn the_interpolation_error_falls_with_the_square_of_the_depths_spacing() {
    let nine = columns(9);
    let errors: Vec<_> =
        [7, 13, 25, 49].map(|n| worst_errors(&field(n, &nine), &nine, 0.0)).to_vec();
    for (coarse, fine) in errors.iter().zip(errors.iter().skip(1)) {
        let order = ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2());
        println!("depths: error {:.5} mm, {:.6} of p; orders {order:.2?}", fine.0, fine.1);
        assert!(order.0 > 1.8 && order.1 > 1.8, "{order:?}");
    }
}

#[test]
fn the_interpolation_error_stays_within_the_stated_bound() {
    // Along a beam: Δp² / 8 · |d²t/dp²|, the second derivative from a finite difference.
    let (nine, scanner) = (columns(9), SynchronizedScanner::hyscan());
    let field = field(12, &nine);
    for (col, beam) in field.beams() {
        let theta = nine.angle(col);
        let spot = |p: f64| scanner.spot(theta, p).unwrap();
        let along = |p: f64| (spot(p) - scanner.projector()).norm();
        let bend = |p: f64| (along(p + 1e-3) - 2.0 * along(p) + along(p - 1e-3)) / 1e-6;
        let marks: Vec<f64> = beam.nodes().map(|n| n.p).collect();
        for pair in marks.windows(2) {
            let step = pair[1] - pair[0];
            let bound = step * step / 8.0 * bend(pair[0]).abs().max(bend(pair[1]).abs());
            for part in [0.1, 0.3, 0.5, 0.7, 0.9] {
                let p = pair[0] + part * step;
                let error = (field.forward(col as f64, p).unwrap() - spot(p)).norm();
                assert!(error < 1.01 * bound, "{error} over {bound}");
                assert!(part != 0.5 || error > 0.5 * bound, "{error} far below {bound}");
            }
        }
    }
}

#[test]
fn the_interpolation_error_falls_with_the_square_of_the_columns_spacing() {
    // Depths dense enough that columns are all that is left.
    let errors: Vec<_> =
        [5, 9, 17, 33].map(|n| worst_errors(&field(200, &columns(n)), &columns(n), 0.5)).to_vec();
    for (coarse, fine) in errors.iter().zip(errors.iter().skip(1)) {
        let order = ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2());
        println!("columns: error {:.5} mm, {:.6} of p; orders {order:.2?}", fine.0, fine.1);
        assert!(order.0 > 1.8 && order.1 > 1.8, "{order:?}");
    }
}

/// Gaussian noise on all, and gross errors on two samples in a hundred.
fn spoil(sweeps: &mut [CalibrationSweep], seed: u64) {
    let mut noise = Noise(seed);
    for s in sweeps.iter_mut().flat_map(|s| &mut s.samples) {
        s.p += 0.002 * noise.gauss();
        s.u += 0.02 * noise.gauss();
        s.v += 0.02 * noise.gauss();
        if noise.uniform() < 0.02 {
            s.p += 0.2 * noise.gauss();
            s.u += 5.0 * noise.gauss();
            s.v += 5.0 * noise.gauss();
        }
    }
}

/// Largest distance of a found beam line from the true beam, at both ends of the field.
fn worst_line(field: &DigitizedField, columns: &ThetaSteps) -> f64 {
    let projector = SynchronizedScanner::hyscan().projector();
    let off = |(col, depth): (usize, f64)| {
        let (sin, cos) = columns.angle(col).sin_cos();
        let on = projector + nalgebra::Vector2::new(sin, cos) * (depth / cos);
        field.beam(col).unwrap().line().distance(&on).abs()
    };
    let ends = (0..columns.count()).flat_map(|col| [(col, 110.0), (col, 200.0)]);
    ends.map(off).fold(0.0, f64::max)
}

#[test]
fn calibration_recovers_beams_from_noise_and_outliers() {
    let columns = columns(120);
    let bounds = [(DepthPairs::Neighbours, 0.15), (DepthPairs::HalfApart, 0.06)];
    for (pairs, line_bound) in bounds {
        let options = CalibrationOptions { pairs, ..CalibrationOptions::default() };
        let mut worst = (0.0_f64, 0.0_f64);
        for seed in 0..5 {
            let mut sweeps = sweeps(24, &columns);
            spoil(&mut sweeps, seed);
            let field = digitize(&sweeps, &columns, options).unwrap();
            assert_eq!(field.beams().count(), 120, "every column keeps its beam");
            worst.0 = worst.0.max(worst_line(&field, &columns));
            worst.1 = worst.1.max(worst_errors(&field, &columns, 0.0).0);
        }
        println!("{pairs:?}: worst line {:.4} mm, worst point {:.4} mm", worst.0, worst.1);
        assert!(worst.0 < line_bound && worst.1 < 0.25, "{pairs:?}: {worst:?}");
    }
}

#[test]
fn the_filter_and_the_middle_third_are_what_recovers_them() {
    let columns = columns(120);
    let mut sweeps = sweeps(24, &columns);
    spoil(&mut sweeps, 1);
    let filtered = digitize(&sweeps, &columns, CalibrationOptions::default()).unwrap();
    let raw = digitize(&sweeps, &columns, CalibrationOptions::EXACT);
    let unfiltered = raw.map_or(f64::INFINITY, |f| worst_errors(&f, &columns, 0.0).0);
    assert!(unfiltered > 5.0 * worst_errors(&filtered, &columns, 0.0).0, "{unfiltered}");
}

#[test]
fn samples_that_are_missing_cost_no_column() {
    let columns = columns(60);
    let mut sweeps = sweeps(8, &columns);
    // Holes of three columns, a sweep that ends early, and a column seen at one depth only.
    sweeps[2].samples.drain(20..23);
    sweeps[0].samples.drain(50..);
    for sweep in &mut sweeps[1..] {
        sweep.samples.pop();
    }
    sweeps[0].samples.push(SynchronizedScanner::hyscan().sample(columns.angle(59), 110.0, 0.02));
    let field = digitize(&sweeps, &columns, CalibrationOptions::default()).unwrap();
    assert_eq!(field.beam(21).unwrap().nodes().count(), 8);
    assert_eq!(field.beam(55).unwrap().nodes().count(), 7);
    assert!(field.beam(59).is_none());
    let rows = LinearSteps::new(0.0, 0.5, 3);
    let mounting = Mounting::from_degrees(ScanPlane::Xz, 0.0);
    let table = LookupTable::new(field, rows, mounting).unwrap();
    assert_eq!(table.size(), ImageSize { rows: 3, cols: 60 });
    assert!(table.ray(Pixel::new(0, 59)).is_none());
    assert!(table.point(Pixel::new(0, 58), 10.0).is_some());
}

fn message(sweeps: &[CalibrationSweep], columns: &ThetaSteps) -> String {
    digitize(sweeps, columns, CalibrationOptions::default()).unwrap_err().to_string()
}

#[test]
fn bad_sweeps_are_named() {
    let columns = columns(20);
    let good = sweeps(5, &columns);
    let spoiled = |spoil: &dyn Fn(&mut Vec<CalibrationSweep>)| {
        let mut sweeps = good.clone();
        spoil(&mut sweeps);
        message(&sweeps, &columns)
    };
    assert_eq!(message(&good[..1], &columns), "sweeps = 1: at least two depths");
    assert_eq!(spoiled(&|s| s[3].samples.clear()), "samples = 0: a sweep with samples");
    assert!(spoiled(&|s| s[1].samples.swap(4, 5)).contains("theta = "));
    assert!(spoiled(&|s| s[1].samples.swap(4, 5)).contains("angles that rise"));
    assert!(spoiled(&|s| s[1].samples[2].theta_rad += 0.01).contains("an angle of the columns"));
    assert_eq!(spoiled(&|s| s[0].samples[0].p = 0.0), "p = 0: positive image positions");
    assert_eq!(spoiled(&|s| s[0].samples[7].v = f64::NAN), "v = NaN: finite coordinates");
    assert!(spoiled(&|s| s.reverse()).starts_with("sweeps = 1: sweeps from the nearest depth"));
    let crossing = |s: &mut Vec<CalibrationSweep>| {
        s.iter_mut().flat_map(|s| &mut s.samples).for_each(|s| s.u = (s.v - 150.0) * s.theta_rad);
    };
    assert!(spoiled(&crossing).contains("beams that share depths and do not cross"));
    let still = ThetaSteps::from_degrees(0.0, 0.0, 20);
    assert_eq!(message(&good, &still), "dtheta = 0: a positive step");
    let even = CalibrationOptions { median_window: 4, ..CalibrationOptions::default() };
    let even = digitize(&good, &columns, even).unwrap_err().to_string();
    assert_eq!(even, "median_window = 4: an odd number of samples");
    let field = digitize(&good, &columns, CalibrationOptions::EXACT).unwrap();
    let still = LinearSteps::new(0.0, 0.0, 4);
    let mounting = Mounting::from_degrees(ScanPlane::Yz, 10.0);
    let error = LookupTable::new(field.clone(), still, mounting).unwrap_err();
    assert_eq!(error.to_string(), "dy = 0: a step other than 0");
    let endless = Mounting::from_degrees(ScanPlane::Yz, f64::NAN);
    let error = LookupTable::new(field, LinearSteps::single(0.0), endless).unwrap_err();
    assert_eq!(error.to_string(), "tilt = NaN: an angle");
}

#[test]
fn an_image_of_a_single_row_is_valid() {
    let table = LookupTable::hyscan(LinearSteps::single(12.5)).unwrap();
    assert_eq!(table.size(), ImageSize { rows: 1, cols: 256 });
    let image = RangeImage::from_values(table.size(), vec![10.0; 256]).unwrap();
    assert_eq!(image.valid_count(), 256);
    let p = table.point(Pixel::new(0, 100), 10.0).unwrap();
    assert!((p.y - 12.5).abs() < 1e-12);
    let d = table.device_point(&(p + Vector3::new(0.0, 2.0, 0.0))).unwrap();
    assert!((d.row - 2.0).abs() < 1e-12, "length units off the scanning plane");
    let (low, high) = table.extent(&Vector3::y(), 5.0, 15.0);
    assert!((low - 12.5).abs() < 1e-12 && (high - 12.5).abs() < 1e-12);
}

#[test]
fn the_example_has_the_dissertations_figures() {
    let table = LookupTable::hyscan(LinearSteps::new(0.0, 0.5, 100)).unwrap();
    let scanner = SynchronizedScanner::hyscan();
    let ends = |col: usize| {
        let nodes: Vec<_> = table.field().beam(col).unwrap().nodes().collect();
        (nodes[0].at, nodes[nodes.len() - 1].at)
    };
    let middle = ends(128);
    assert!((middle.0.y - 110.0).abs() < 1.0 && (middle.1.y - 200.0).abs() < 1.0, "{middle:?}");
    let (left, right) = (ends(0).1, ends(255).1);
    assert!(((right.x - left.x) - 100.0).abs() < 1.0, "{left} {right}");
    let (millimetres, _) = worst_errors(table.field(), &LookupTable::hyscan_columns(), 0.5);
    println!("the example's interpolation error: {millimetres:.4} mm");
    assert!(millimetres < 0.03);
    // Light leaves the projector and is watched from the receiver, row by row.
    let pixel = Pixel::new(40, 30);
    let start = table.ray(pixel).unwrap().start;
    let place = |p: Point2<f64>| Point3::new(p.x, 20.0, p.y);
    assert!((start - place(scanner.projector())).norm() < 1e-6, "{start}");
    assert_eq!(table.second_viewpoint(pixel), Some(place(scanner.receiver())));
    assert_eq!(table.handedness(), Handedness::ColumnsRight);
}
