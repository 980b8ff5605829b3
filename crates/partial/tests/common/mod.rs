//! Simulated views of balls, from which sections are known exactly.

use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, Vector3, View,
};
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole, PointGrid, RayStarts};

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
    let pixels = (0..SIZE.pixels()).map(|k| Pixel::new(k / SIZE.cols, k % SIZE.cols));
    let missing = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let points = pixels.map(|p| view.point_in_sensor(p).unwrap_or(missing)).collect();
    let starts = RayStarts::Viewpoint(Point3::origin());
    let (grid, image) = PointGrid::new(SIZE, points, starts).ok()?;
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
