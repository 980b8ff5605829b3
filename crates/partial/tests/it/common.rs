//! Simulated views of balls, from which sections are known exactly.

use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageSize, Isometry3, MISSING_POINT, Pixel, Point3, RangeImage, Vector3, View,
};
use transect_sensors::{
    AngularScan, ImagingRadar, Intrinsics, Pinhole, PinholeScale, PointGrid, RayStarts,
};

pub const SIZE: ImageSize = ImageSize { rows: 48, cols: 64 };

#[derive(Debug, Clone, Copy)]
pub struct Ball {
    pub centre: Point3,
    pub radius: f64,
}

impl Ball {
    fn hit(&self, from: &Point3, direction: &Vector3) -> Option<f64> {
        let to_centre = self.centre - from;
        let along = to_centre.dot(direction);
        let gap_squared = to_centre.norm_squared() - along * along;
        let half_chord = (self.radius * self.radius - gap_squared).max(0.0).sqrt();
        (gap_squared < self.radius * self.radius && along > half_chord)
            .then_some(along - half_chord)
    }
}

/// What a sensor sees of balls (in the world); pixels in `dropped` are missing.
pub fn look(
    frame: Arc<dyn DeviceFrame>,
    world_from_sensor: Isometry3,
    balls: &[Ball],
    dropped: &[bool],
) -> Option<View> {
    let nearest = |pixel: Pixel| {
        let ray = frame.ray(pixel)?;
        let from = world_from_sensor * ray.start;
        let direction = world_from_sensor * ray.direction;
        let ranges = balls.iter().filter_map(|b| b.hit(&from, &direction));
        let range = ranges.fold(f64::INFINITY, f64::min);
        let hit = ray.start + ray.direction * range;
        range.is_finite().then(|| frame.device_point(&hit)).flatten().map(|d| d.d3 as f32)
    };
    let value = |k: usize| {
        let pixel = Pixel::new(k / SIZE.cols, k % SIZE.cols);
        if dropped.get(k) == Some(&true) { None } else { nearest(pixel) }
    };
    let values = (0..SIZE.pixels()).map(|k| value(k).unwrap_or(f32::NAN)).collect();
    let image = RangeImage::from_values(SIZE, values).unwrap();
    View::new("balls", image, frame, world_from_sensor, Some(0.0)).ok()
}

/// The same view as a grid of points.
pub fn as_point_grid(view: &View) -> Option<View> {
    let size = view.image().size();
    let pixels = size.all_pixels();
    let points = pixels.map(|p| view.point_in_sensor(p).unwrap_or(MISSING_POINT)).collect();
    let starts = RayStarts::Viewpoint(Point3::origin());
    let (grid, image) = PointGrid::new(size, points, starts).ok()?;
    View::new("grid", image, Arc::new(grid), *view.world_from_sensor(), Some(0.0)).ok()
}

/// Radars and cameras of either handedness that look along +x or +z of their frame.
pub fn frames() -> impl Strategy<Value = Arc<dyn DeviceFrame>> {
    let radar = (0.8..1.2_f64, any::<bool>(), any::<bool>()).prop_map(|(field, flip_t, flip_p)| {
        let scan = |count: usize, flip: bool| {
            let step = field / count as f64 * if flip { -1.0 } else { 1.0 };
            AngularScan::from_radians(-0.5 * step * (count - 1) as f64, step)
        };
        let radar = ImagingRadar::new(SIZE, scan(SIZE.cols, flip_t), scan(SIZE.rows, flip_p));
        Arc::new(radar.unwrap()) as Arc<dyn DeviceFrame>
    });
    let camera = (40.0..70.0_f64).prop_map(|f| {
        let k = Intrinsics { fx: f, fy: f, cx: 31.5, cy: 23.5 };
        Arc::new(Pinhole::new(SIZE, k).unwrap()) as Arc<dyn DeviceFrame>
    });
    prop_oneof![radar, camera]
}

/// Poses that put the sensor 5 units from the origin and point it there.
pub fn pose_towards_origin(
    frame: &dyn DeviceFrame,
    azimuth: f64,
    elevation: f64,
    roll: f64,
) -> Isometry3 {
    let axis = frame.ray(Pixel::new(SIZE.rows / 2, SIZE.cols / 2)).unwrap().direction;
    let (s, c) = azimuth.sin_cos();
    let from = Vector3::new(c * elevation.cos(), s * elevation.cos(), elevation.sin()) * 5.0;
    let turn = nalgebra::UnitQuaternion::rotation_between(&axis, &-from);
    let turn =
        turn.unwrap_or_else(|| nalgebra::UnitQuaternion::from_scaled_axis(Vector3::y() * 3.2));
    let roll = nalgebra::UnitQuaternion::from_scaled_axis(-from.normalize() * roll);
    Isometry3::from_parts(from.into(), roll * turn)
}

pub fn balls() -> impl Strategy<Value = Vec<Ball>> {
    let ball = (-1.4..1.4, -1.4..1.4, -1.4..1.4, 0.3..0.8)
        .prop_map(|(x, y, z, radius)| Ball { centre: Point3::new(x, y, z), radius });
    // Apart by more than the range step that two neighbouring pixels may bridge, so that every
    // curve is that of one solid.
    let apart = |a: &Ball, b: &Ball| (a.centre - b.centre).norm() > a.radius + b.radius + 0.8;
    prop::collection::vec(ball, 1..4).prop_map(move |balls| {
        let mut kept: Vec<Ball> = Vec::new();
        for b in balls {
            if kept.iter().all(|k| apart(k, &b)) {
                kept.push(b);
            }
        }
        kept
    })
}

/// A view of random balls from a random place by a random sensor, with dropped pixels.
pub fn views() -> impl Strategy<Value = (View, Vec<Ball>)> {
    let place = (0.0..6.2_f64, -1.2..1.2_f64, 0.0..6.2_f64);
    let dropped = prop::collection::vec(prop::bool::weighted(0.03), SIZE.pixels());
    let parts = (frames(), place, balls(), dropped, any::<bool>());
    parts.prop_filter_map(
        "sees something",
        |(frame, (azimuth, elevation, roll), balls, dropped, grid)| {
            let pose = pose_towards_origin(frame.as_ref(), azimuth, elevation, roll);
            let view = look(frame, pose, &balls, &dropped)?;
            let view = if grid { as_point_grid(&view)? } else { view };
            Some((view, balls))
        },
    )
}

pub fn planes_along(normal: Vector3, interval: f64) -> transect_geometry::PlaneFamily {
    let guide = transect_geometry::StraightGuide::along(normal).unwrap();
    transect_geometry::PlaneFamily::new(guide, 0.0123, interval).unwrap()
}

pub fn normals() -> impl Strategy<Value = Vector3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("has a direction", |v: &Vector3| v.norm() > 0.1)
}

/// Sensors of any size: radars with and without a full circle, cameras of both scales.
fn sized_frames() -> impl Strategy<Value = Arc<dyn DeviceFrame>> {
    let size = (1..28_usize, 1..150_usize).prop_map(|(rows, cols)| ImageSize { rows, cols });
    let shape = (size, 0..4_u8, any::<bool>(), 0.3..1.4_f64);
    shape.prop_map(|(size, kind, flip, field)| {
        let turn = |angle: f64| if flip { -angle } else { angle };
        let scan = |angle: f64, count: usize| {
            let step = angle / count as f64;
            AngularScan::from_radians(-0.5 * step * (count - 1) as f64, step)
        };
        let theta = turn(if kind == 0 { std::f64::consts::TAU } else { field });
        let focal = size.cols as f64 / field;
        let k = Intrinsics { fx: focal, fy: 1.1 * focal, cx: 0.4 * size.cols as f64, cy: 3.0 };
        let scale = if kind == 2 { PinholeScale::Depth } else { PinholeScale::RayLength };
        match kind {
            0 | 1 => {
                let radar = ImagingRadar::new(size, scan(theta, size.cols), scan(field, size.rows));
                Arc::new(radar.unwrap()) as Arc<dyn DeviceFrame>
            }
            _ => Arc::new(Pinhole::new(size, k).unwrap().with_scale(scale)),
        }
    })
}

/// Views of any size with waves, steps, noise and missing pixels, some of them as grids of points.
pub fn random_views() -> impl Strategy<Value = View> {
    let waves = (0.05..1.0_f64, 0.05..1.0_f64, 0.0..1.0_f64, 0.0..0.02_f64);
    let missing = prop_oneof![Just(0.0), 0.0..0.3_f64];
    let parts = (sized_frames(), waves, missing, any::<u64>(), 0..4_u8);
    parts.prop_filter_map("sees something", |(frame, waves, missing, seed, grid)| {
        let (along, down, step, noise) = waves;
        let size = frame.size();
        let mut state = seed | 1;
        let mut uniform = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let value = |k: usize| {
            let (row, col) = ((k / size.cols) as f64, (k % size.cols) as f64);
            let wave = 0.4 * (along * col).sin() * (down * row).cos();
            let behind = if (0.13 * col + 0.21 * row).sin() > 0.6 { step } else { 0.0 };
            let value = 3.0 + wave + behind + noise * (uniform() - 0.5);
            if uniform() < missing { f32::NAN } else { value as f32 }
        };
        let image = RangeImage::from_values(size, (0..size.pixels()).map(value).collect()).ok()?;
        let pose = Isometry3::translation(1e3, -2e3, 3e2);
        let view = View::new("random", image, frame, pose, Some(0.0)).ok()?;
        if grid > 0 { Some(view) } else { as_point_grid(&view) }
    })
}

/// Orders of convergence between each spacing and the next: `ln(e₁/e₂) / ln(h₁/h₂)`. An error that
/// falls with the square of the spacing gives 2.
pub fn observed_orders(spacings: &[f64], errors: &[f64]) -> Vec<f64> {
    let pairs = spacings.windows(2).zip(errors.windows(2));
    pairs.map(|(h, e)| (e[0] / e[1]).ln() / (h[0] / h[1]).ln()).collect()
}
