//! A range image with its device frame and pose.

use crate::{DeviceFrame, ImageSize, Isometry3, PinholeScale, Pixel, Point3, RangeImage};
use std::sync::Arc;

/// Why an image, a frame and a pose cannot make a view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// Image and device frame have different sizes.
    #[error("the image has {image}, its sensor {frame}")]
    SizeMismatch {
        /// Size of the image.
        image: ImageSize,
        /// Size the device frame expects.
        frame: ImageSize,
    },
    /// The image has no valid pixel at all.
    #[error("every pixel is missing: zero, negative, infinite or not a number")]
    NoValidPixel,
    /// The pose has a component that is NaN or infinite.
    #[error(
        "the pose has {component} = {value}; every component must be a finite number. Correct the \
         pose, or leave the view out"
    )]
    PoseNotFinite {
        /// The component: x, y or z of the translation, or of the quaternion qx, qy, qz or qw.
        component: &'static str,
        /// Its value: a translation in the model's length unit, a quaternion without unit.
        value: f64,
    },
    /// The rotation of the pose is none: its quaternion has another length than 1, as that of a
    /// matrix with few digits. `UnitQuaternion::new_normalize` mends small deviations.
    #[error(
        "the pose is no rigid motion: its quaternion has length {0}, not 1; normalise it, or take \
         the nearest rotation of its matrix"
    )]
    PoseNotRigid(f64),
    /// The noise is negative, NaN or infinite.
    #[error("the range noise must be a length of at least 0, got {0}")]
    BadSigma(f64),
}

/// Largest deviation of a quaternion's length from 1. No unit. Chosen by hand: as models allow, far
/// above rounding, and below what moves a surface. Doubled, nothing changes.
const RIGID: f64 = 1e-9;

fn check_finite(pose: &Isometry3) -> Result<(), ViewError> {
    let names = ["x", "y", "z", "qx", "qy", "qz", "qw"];
    let values = pose.translation.vector.iter().chain(pose.rotation.coords.iter());
    match names.into_iter().zip(values).find(|(_, value)| !value.is_finite()) {
        Some((component, value)) => Err(ViewError::PoseNotFinite { component, value: *value }),
        None => Ok(()),
    }
}

/// One range image, placed in the world.
#[derive(Debug, Clone)]
pub struct View {
    name: String,
    image: RangeImage,
    frame: Arc<dyn DeviceFrame>,
    world_from_sensor: Isometry3,
    sigma: Option<f64>,
}

impl View {
    /// A view from its parts. Reports show `name`, usually the file's name. `sigma` is the standard
    /// deviation of a range along its ray, in the model's length unit, if known.
    ///
    /// # Errors
    /// [`ViewError`] if the sizes differ, no pixel is valid, the pose is no rigid motion, or pose
    /// or noise are not finite.
    pub fn new(
        name: impl Into<String>,
        image: RangeImage,
        frame: Arc<dyn DeviceFrame>,
        world_from_sensor: Isometry3,
        sigma: Option<f64>,
    ) -> Result<Self, ViewError> {
        if image.size() != frame.size() {
            return Err(ViewError::SizeMismatch { image: image.size(), frame: frame.size() });
        }
        if image.valid_count() == 0 {
            return Err(ViewError::NoValidPixel);
        }
        check_finite(&world_from_sensor)?;
        let length = world_from_sensor.rotation.norm();
        if (length - 1.0).abs() > RIGID {
            return Err(ViewError::PoseNotRigid(length));
        }
        if let Some(bad) = sigma.filter(|s| !(s.is_finite() && *s >= 0.0)) {
            return Err(ViewError::BadSigma(bad));
        }
        Ok(Self { name: name.into(), image, frame, world_from_sensor, sigma })
    }

    /// The same view with another image of the same scene, for example a filtered one.
    ///
    /// # Errors
    /// [`ViewError`] if the sizes differ or no pixel is valid.
    pub fn with_image(&self, image: RangeImage) -> Result<Self, ViewError> {
        let (name, frame) = (self.name.clone(), Arc::clone(&self.frame));
        Self::new(name, image, frame, self.world_from_sensor, self.sigma)
    }

    /// The view of an image that holds this length and was read as the other one. `None` unless the
    /// sensor is a camera whose images hold the other one.
    pub fn reread(&self, holds: PinholeScale) -> Option<Self> {
        self.frame.pinhole_scale().filter(|scale| *scale != holds)?;
        let value = |pixel| {
            let value = f64::from(self.image.get(pixel)?);
            // A point at this value lies too far out, or too near, by a factor along its ray.
            Some((value * value / holds.value(&self.frame.point(pixel, value)?)) as f32)
        };
        let size = self.image.size();
        let values = size.all_pixels().map(|pixel| value(pixel).unwrap_or(f32::NAN)).collect();
        self.with_image(RangeImage::from_values(size, values).ok()?).ok()
    }

    /// The view at half its resolution: every other row and column, from row 0 and column 0 on.
    /// `None` if its frame cannot be halved, or if these pixels are all missing.
    pub fn halved(&self) -> Option<Self> {
        let (name, pose) = (self.name.clone(), self.world_from_sensor);
        Self::new(name, self.image.halved(), self.frame.halved()?, pose, self.sigma).ok()
    }

    /// The same view with another pose, for example from a better registration.
    ///
    /// # Errors
    /// [`ViewError::PoseNotFinite`] or [`ViewError::PoseNotRigid`].
    pub fn with_pose(&self, world_from_sensor: Isometry3) -> Result<Self, ViewError> {
        let (name, frame) = (self.name.clone(), Arc::clone(&self.frame));
        Self::new(name, self.image.clone(), frame, world_from_sensor, self.sigma)
    }

    /// The view under another name.
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// The name that reports show.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The range image.
    pub fn image(&self) -> &RangeImage {
        &self.image
    }

    /// The device frame the image was sampled in.
    pub fn frame(&self) -> &dyn DeviceFrame {
        self.frame.as_ref()
    }

    /// The device frame, for users that outlive the view.
    pub fn shared_frame(&self) -> Arc<dyn DeviceFrame> {
        Arc::clone(&self.frame)
    }

    /// The pose: world coordinates from sensor coordinates.
    pub fn world_from_sensor(&self) -> &Isometry3 {
        &self.world_from_sensor
    }

    /// Standard deviation of a range along its ray, in the model's length unit, if known.
    pub fn sigma(&self) -> Option<f64> {
        self.sigma
    }

    /// The sensor-frame point of a pixel; `None` if it is missing.
    #[inline]
    pub fn point_in_sensor(&self, pixel: Pixel) -> Option<Point3> {
        self.frame.point(pixel, f64::from(self.image.get(pixel)?))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests may fail loudly")]
mod tests {
    use super::*;
    use crate::{DevicePoint, Handedness, Ray, SensorPlane, Vector3};
    use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion};

    /// Parallel rays, a unit apart.
    #[derive(Debug)]
    struct Parallel;

    impl DeviceFrame for Parallel {
        fn size(&self) -> ImageSize {
            ImageSize { rows: 1, cols: 2 }
        }

        fn kind(&self) -> &'static str {
            "Parallel"
        }

        fn ray(&self, pixel: Pixel) -> Option<Ray> {
            let start = Point3::new(pixel.col as f64, 0.0, 0.0);
            Some(Ray { start, direction: Vector3::z() })
        }

        fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
            Some(Point3::new(pixel.col as f64, 0.0, d3))
        }

        fn handedness(&self) -> Handedness {
            Handedness::ColumnsRight
        }

        fn device_point(&self, _: &Point3) -> Option<DevicePoint> {
            None
        }

        fn plane_value(&self, _: Pixel, _: &SensorPlane) -> Option<f64> {
            None
        }

        fn extent(&self, _: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
            (nearest, farthest)
        }
    }

    fn at(rotation: Matrix3<f64>) -> Result<View, ViewError> {
        let image = RangeImage::from_values(Parallel.size(), vec![1.0; 2]).unwrap();
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
        let pose = Isometry3::from_parts(Translation3::identity(), rotation);
        View::new("a", image, Arc::new(Parallel), pose, None)
    }

    #[test]
    fn a_pose_that_is_not_finite_is_refused_with_the_component() {
        let view = at(Matrix3::identity()).unwrap();
        let mut pose = *view.world_from_sensor();
        pose.translation.vector.y = f64::NEG_INFINITY;
        assert_eq!(
            view.with_pose(pose).unwrap_err().to_string(),
            "the pose has y = -inf; every component must be a finite number. Correct the pose, or \
             leave the view out"
        );
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
        let pose = Isometry3::from_parts(Translation3::identity(), rotation);
        let error = view.with_pose(pose).unwrap_err();
        assert!(matches!(error, ViewError::PoseNotFinite { component: "qw", .. }), "{error}");
    }

    #[test]
    fn a_pose_that_is_no_rigid_motion_is_refused() {
        assert!(at(Matrix3::identity()).is_ok());
        let c = 0.5_f64.sqrt();
        assert!(at(Matrix3::new(c, -c, 0.0, c, c, 0.0, 0.0, 0.0, 1.0)).is_ok());
        // Twice as large, and a rotation with three digits.
        for wrong in [
            Matrix3::identity() * 2.0,
            Matrix3::new(0.866, -0.5, 0.0, 0.5, 0.866, 0.0, 0.0, 0.0, 1.0),
        ] {
            let error = at(wrong).unwrap_err();
            assert!(matches!(error, ViewError::PoseNotRigid(_)), "{error}");
        }
    }
}
