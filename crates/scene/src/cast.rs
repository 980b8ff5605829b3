//! Range images of a scene: one ray per pixel of any device frame (dissertation, section 4.5.3).
//!
//! 1. The pixel's ray, moved into the world, meets the scene at some distance.
//! 2. Noise moves the hit along the ray, or drops it.
//! 3. The value `d3` is the one that a plane through the hit, perpendicular to the ray, would have
//!    at the pixel ([`DeviceFrame::plane_value`]). On the pixel's own ray that is exact for every
//!    scale a frame may have, needs no inverse `F` and no arc tangent, and makes noise mean an
//!    error along the ray for depths just as for ranges.
//!
//! Serial on purpose: views may be cast in parallel by the caller, and rows depend on nothing but
//! themselves.

use crate::noise::RowNoise;
use crate::parry::{self, Motion};
use crate::scene::WorldRay;
use crate::{Noise, Scene};
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageError, Isometry3, Pixel, RangeImage, SensorPlane, View, ViewError,
};

/// Why a scene gives no view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CastError {
    /// The device frame has an impossible size.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// No ray hit anything, or the pose is not finite.
    #[error(transparent)]
    View(#[from] ViewError),
}

impl Scene {
    /// The range image of a perfect sensor.
    ///
    /// A pixel is missing where its ray meets nothing, or starts inside a solid.
    ///
    /// # Errors
    /// [`ImageError`] if the frame's size is absurd.
    pub fn cast(
        &self,
        frame: &dyn DeviceFrame,
        world_from_sensor: &Isometry3,
    ) -> Result<RangeImage, ImageError> {
        self.scan(frame, world_from_sensor, &Noise::NONE, 0)
    }

    /// The range image of a noisy sensor. `view` is the view's number: together with the noise's
    /// seed it decides every random number, so that views may be cast in any order.
    ///
    /// # Errors
    /// [`ImageError`] if the frame's size is absurd.
    pub fn scan(
        &self,
        frame: &dyn DeviceFrame,
        world_from_sensor: &Isometry3,
        noise: &Noise,
        view: u64,
    ) -> Result<RangeImage, ImageError> {
        let size = frame.size();
        // Refuses absurd sizes before anything is allocated for them.
        if size.rows.checked_mul(size.cols).is_none_or(|n| n > transect_device::MAX_PIXELS) {
            return Err(ImageError::AbsurdSize { rows: size.rows, cols: size.cols });
        }
        let motion = Motion::new(world_from_sensor);
        let least_cosine = noise.least_cosine();
        let caster = Caster { scene: self, frame, world_from_sensor: motion, least_cosine };
        let mut values = Vec::with_capacity(size.pixels());
        for row in 0..size.rows {
            let mut row_noise = noise.row(view, row);
            values.extend((0..size.cols).map(|col| {
                let value = caster.value(Pixel::new(row, col), &mut row_noise);
                value.map_or(f32::NAN, |d3| d3 as f32)
            }));
        }
        RangeImage::from_values(size, values)
    }

    /// A whole view of the scene, ready for modelling, with the noise's sigma on record.
    ///
    /// # Errors
    /// [`CastError`] if the frame's size is absurd, nothing was hit, or the pose is not finite.
    pub fn view(
        &self,
        name: impl Into<String>,
        frame: Arc<dyn DeviceFrame>,
        world_from_sensor: Isometry3,
        noise: &Noise,
        view: u64,
    ) -> Result<View, CastError> {
        let image = self.scan(frame.as_ref(), &world_from_sensor, noise, view)?;
        Ok(View::new(name, image, frame, world_from_sensor, Some(noise.sigma))?)
    }
}

/// What all pixels of a view share.
struct Caster<'a> {
    scene: &'a Scene,
    frame: &'a dyn DeviceFrame,
    world_from_sensor: Motion,
    least_cosine: Option<f64>,
}

impl Caster<'_> {
    /// A pixel's `d3`; `None` where nothing comes back.
    fn value(&self, pixel: Pixel, noise: &mut RowNoise) -> Option<f64> {
        // Drawn even if the ray misses: a pixel's noise must not depend on its neighbours' hits.
        let error = noise.next_error();
        let in_sensor = self.frame.ray(pixel)?;
        let start = self.world_from_sensor.point(parry::point(&in_sensor.start));
        let direction = self.world_from_sensor.rotation * parry::vector(&in_sensor.direction);
        let distance = self.distance(&WorldRay::new(start, direction), direction)? + error?;
        if distance <= 0.0 {
            return None;
        }
        let normal = in_sensor.direction;
        let offset = normal.dot(&in_sensor.start.coords) + distance;
        self.frame.plane_value(pixel, &SensorPlane { normal, offset })
    }

    /// Distance of the first surface that returns something.
    fn distance(&self, ray: &WorldRay, direction: parry3d_f64::math::Vector) -> Option<f64> {
        let (solid, distance) = self.scene.nearest(ray)?;
        if distance <= 0.0 {
            return None;
        }
        if let Some(least) = self.least_cosine {
            let normal = self.scene.normal(ray, solid, distance)?;
            return (-normal.dot(direction) >= least).then_some(distance);
        }
        Some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Shape, Solid};
    use transect_device::{ImageSize, Point3, Vector3};
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
        let (scene, frame, pose) = (wall_at(4.0), radar(), Isometry3::identity());
        let noise = Noise { sigma: 0.01, dropout: 0.1, seed: 11, ..Noise::NONE };
        let scan = |view| bytes(&scene.scan(&frame, &pose, &noise, view).unwrap());
        let forward: Vec<_> = (0..3).map(scan).collect();
        let backward: Vec<_> = (0..3).rev().map(scan).collect();
        assert!(forward.iter().eq(backward.iter().rev()));
        assert_ne!(forward[0], forward[1]);
        let other = Noise { seed: 12, ..noise };
        assert_ne!(bytes(&scene.scan(&frame, &pose, &other, 0).unwrap()), forward[0]);
    }
}
