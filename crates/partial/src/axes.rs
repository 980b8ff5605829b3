//! Levels and plane coordinates as affine functions of sensor coordinates.

use crate::error::{MAX_LEVELS, MAX_PLANE, PartialError};
use transect_device::{LinearForm, Point3, SensorPlane, Vector3, View};
use transect_geometry::{PlaneFamily, PlaneIndex, Point2};

/// Levels and plane coordinates as functions of a view's sensor coordinates.
///
/// Levels count from plane [`SectionAxes::base`], in the middle of what the view can see, so that
/// coordinates of any size leave the levels' resolution alone.
#[derive(Debug, Clone, Copy)]
pub struct SectionAxes {
    base: i64,
    level: LinearForm,
    x: LinearForm,
    y: LinearForm,
    interval: f64,
}

impl SectionAxes {
    /// The axes of a plane family, seen from a view.
    ///
    /// # Errors
    /// * [`PartialError::CurvedGuide`] if the planes are not parallel.
    /// * [`PartialError::NoPoints`] if no value of the view has a point.
    /// * [`PartialError::TooManyPlanes`] if the view's sensing volume spans more than
    ///   [`MAX_LEVELS`].
    /// * [`PartialError::TooFar`] if the view is too far from plane 0.
    pub fn new(view: &View, planes: &PlaneFamily) -> Result<Self, PartialError> {
        if planes.guide().straight().is_none() {
            return Err(PartialError::CurvedGuide);
        }
        let frame = planes.frame(PlaneIndex(0));
        let interval = planes.interval();
        let mut axes = Self {
            base: 0,
            level: form(view, &(frame.normal() / interval), -planes.offset() / interval),
            // The guide runs through the world's origin, so in-plane coordinates of plane 0 are
            // those of every plane.
            x: form(view, &frame.x_axis(), 0.0),
            y: form(view, &frame.y_axis(), 0.0),
            interval,
        };
        let (low, high) = axes.involved_levels(view);
        if low > high {
            let (nearest, farthest) = view.image().extremes().unwrap_or_default();
            return Err(PartialError::NoPoints { nearest, farthest });
        }
        let middle = (0.5 * (low + high)).floor();
        let planes = high - low;
        if planes.is_nan() || planes >= MAX_LEVELS as f64 {
            return Err(PartialError::TooManyPlanes { planes, interval });
        }
        if middle.abs() >= MAX_PLANE {
            return Err(PartialError::TooFar { planes: middle.abs(), interval });
        }
        axes.base = middle as i64;
        axes.level.constant -= middle;
        Ok(axes)
    }

    /// Smallest and largest level, from the base, that the view's sensing volume can hold.
    fn involved_levels(&self, view: &View) -> (f64, f64) {
        let Some((near, far)) = view.image().extremes() else { return (0.0, 0.0) };
        let (near, far) = (f64::from(near), f64::from(far));
        let (low, high) = view.frame().extent(&self.level.gradient, near, far);
        (low + self.level.constant, high + self.level.constant)
    }

    /// The plane from which levels count.
    pub fn base(&self) -> PlaneIndex {
        PlaneIndex(self.base)
    }

    /// The plane at a level counted from the base.
    pub fn plane(&self, level: i32) -> PlaneIndex {
        PlaneIndex(self.base + i64::from(level))
    }

    /// Distance between neighbouring planes, in the model's length unit.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Level of a sensor-frame point, from the base, in intervals.
    pub fn level(&self) -> &LinearForm {
        &self.level
    }

    /// The plane at a level from the base, in the sensor frame.
    pub fn sensor_plane(&self, level: i32) -> SensorPlane {
        // A level's gradient has the length of 1 / interval.
        SensorPlane {
            normal: self.level.gradient * self.interval,
            offset: (f64::from(level) - self.level.constant) * self.interval,
        }
    }

    /// Plane coordinates of a sensor-frame point.
    pub fn in_plane(&self, p: &Point3) -> Point2 {
        Point2::new(self.x.at(p), self.y.at(p))
    }

    /// A sensor-frame direction in plane coordinates, its height third, all in the length unit.
    pub fn turn(&self, v: &Vector3) -> Vector3 {
        let (x, y) = (self.x.gradient.dot(v), self.y.gradient.dot(v));
        Vector3::new(x, y, self.level.gradient.dot(v) * self.interval)
    }
}

/// `axis · p_world + constant` as a form of sensor coordinates.
fn form(view: &View, axis_in_world: &Vector3, constant: f64) -> LinearForm {
    let pose = view.world_from_sensor();
    LinearForm {
        gradient: pose.rotation.inverse_transform_vector(axis_in_world),
        constant: axis_in_world.dot(&pose.translation.vector) + constant,
    }
}
