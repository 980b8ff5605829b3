//! A range image with its device frame and pose.

use crate::{DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage};
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
    #[error("the pose is not finite")]
    PoseNotFinite,
    /// The noise is negative, NaN or infinite.
    #[error("the range noise must be a length of at least 0, got {0}")]
    BadSigma(f64),
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
    /// [`ViewError`] if the sizes differ, no pixel is valid, or pose or noise are not finite.
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
        let pose = world_from_sensor.to_homogeneous();
        if !pose.iter().all(|c| c.is_finite()) {
            return Err(ViewError::PoseNotFinite);
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

    /// The view at half its resolution: every other row and column, from row 0 and column 0 on.
    /// `None` if its frame cannot be halved, or if these pixels are all missing.
    pub fn halved(&self) -> Option<Self> {
        let (name, pose) = (self.name.clone(), self.world_from_sensor);
        Self::new(name, self.image.halved(), self.frame.halved()?, pose, self.sigma).ok()
    }

    /// The same view with another pose, for example from a better registration.
    ///
    /// # Errors
    /// [`ViewError::PoseNotFinite`].
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
