//! Materials of solids.

use super::SolidError;
use std::sync::Arc;

/// A matt material: light comes back by the cosine law, in proportion to its reflectivity.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: Arc<str>,
    reflectivity: f64,
}

impl Material {
    /// A material. `reflectivity` is the share of the light that comes back from a surface seen
    /// head-on, where 1 is a perfect white one.
    ///
    /// # Errors
    /// [`SolidError::BadReflectivity`] unless it is above 0 and at most 1.
    pub fn new(name: impl Into<Arc<str>>, reflectivity: f64) -> Result<Self, SolidError> {
        if reflectivity > 0.0 && reflectivity <= 1.0 {
            Ok(Self { name: name.into(), reflectivity })
        } else {
            Err(SolidError::BadReflectivity(reflectivity))
        }
    }

    /// The name of the material.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Share of the light that comes back from a surface seen head-on.
    pub fn reflectivity(&self) -> f64 {
        self.reflectivity
    }
}
