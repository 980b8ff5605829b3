//! Where a plane passes between two neighbouring pixels (dissertation, section 3.6).
//!
//! **Problem.** A plane passes between the samples of two pixels. The point of the surface at which
//! it does is wanted, to a fraction of a pixel.
//!
//! **Idea.** Interpolate the scanned surface along the pair's row or column, which gives a curve on
//! the surface. Intersect that curve with the plane. The source offers three linear ways, which
//! differ in the frame they interpolate in. A fourth takes four points instead of two.
//!
//! | [`Subpixel`] | surface along the pair | plane | sensors |
//! |---|---|---|---|
//! | `Cartesian` | straight in space | exact | all |
//! | `DevicePlane` | `d3` linear in the scanning variable (3.6) | exact, in device coordinates (3.5) | analytic for a grid of two angles and a range, numeric for others |
//! | `DeviceCurves` | range linear in the scanning variable | 1/range linear in it | all |
//! | `FourPoint` | cubic through four samples in space | exact | all |
//!
//! On smooth surfaces without noise the error of the linear ways falls with the square of the
//! spacing of the samples, that of four points with its fourth power.
//!
//! **Departures from the source**, after its errata. The Cartesian solution has no special cases
//! and is clamped to the pair. The linearised plane of 3.6 has `b cos φ₀ cos θ₀ − a cos φ₀ sin θ₀`.
//! The plane's curve is interpolated by the reciprocal of its range, which stays finite where a ray
//! runs along the plane. Added here: the solution of the linearised equation is refined on the
//! exact one, so that the node lies on the plane. Heights that do not change sign along the pair
//! (labels moved by thinning) give the sample nearer to the plane.

mod angular_grid;
mod cartesian;
mod device_curves;
mod device_plane;
mod four_point;
mod root;

pub use angular_grid::AngularGrid;
pub(crate) use cartesian::parameter;

use serde::{Deserialize, Serialize};
use transect_device::{Pixel, Point3, SensorPlane, View};

/// How the point between two samples is found; see the module's page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subpixel {
    /// Curve and plane in the Cartesian frame, linear.
    #[default]
    Cartesian,
    /// Curve and plane in the device frame, linear (Eq. 3.5 and 3.6).
    DevicePlane,
    /// The surface's and the plane's curves in the device frame, both linear.
    DeviceCurves,
    /// A cubic through four samples and the plane, in the Cartesian frame; linear where one of the
    /// outer two is missing or on another surface.
    FourPoint,
}

impl Subpixel {
    /// All of them, for tables and tests.
    pub const ALL: [Self; 4] =
        [Self::Cartesian, Self::DevicePlane, Self::DeviceCurves, Self::FourPoint];

    /// Whether the method can use the angles of an [`AngularGrid`].
    pub fn uses_angles(self) -> bool {
        matches!(self, Self::DevicePlane | Self::DeviceCurves)
    }
}

impl std::fmt::Display for Subpixel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Cartesian => "cartesian",
            Self::DevicePlane => "device_plane",
            Self::DeviceCurves => "device_curves",
            Self::FourPoint => "four_point",
        })
    }
}

/// Two neighbouring pixels, and the next ones along their row or column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairLine {
    /// The pixel before the first; `None` unless it is on the same surface.
    pub before: Option<Pixel>,
    /// First pixel of the pair.
    pub first: Pixel,
    /// Second pixel of the pair.
    pub second: Pixel,
    /// The pixel after the second; `None` unless it is on the same surface.
    pub after: Option<Pixel>,
}

/// Where a plane meets the surface between two pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairMeeting {
    /// Share of the way from the first pixel to the second, from 0 to 1.
    pub parameter: f64,
    /// The point, in the sensor frame.
    pub point: Point3,
}

/// Solves pairs of one view and one plane.
#[derive(Debug, Clone, Copy)]
pub struct Solver<'a> {
    view: &'a View,
    plane: SensorPlane,
    method: Subpixel,
    angles: Option<&'a AngularGrid>,
}

impl<'a> Solver<'a> {
    /// A solver; `angles` are those of the view's sensor, if it is a grid of two angles.
    pub fn new(
        view: &'a View,
        plane: SensorPlane,
        method: Subpixel,
        angles: Option<&'a AngularGrid>,
    ) -> Self {
        Self { view, plane, method, angles }
    }

    /// Where the plane passes between the pair's pixels; `None` if one of the two is missing.
    pub fn meet(&self, line: &PairLine) -> Option<PairMeeting> {
        let ends =
            [self.view.point_in_sensor(line.first)?, self.view.point_in_sensor(line.second)?];
        let linear = cartesian::meet(&ends, &self.plane);
        let [a, b] = ends.map(|p| height(&self.plane, &p));
        if a * b >= 0.0 {
            return Some(linear);
        }
        let better = match self.method {
            Subpixel::Cartesian => None,
            Subpixel::DevicePlane => self.device_plane(line),
            Subpixel::DeviceCurves => self.device_curves(line),
            Subpixel::FourPoint => self.four_point(line, &ends),
        };
        Some(better.unwrap_or(linear))
    }

    fn device_plane(&self, line: &PairLine) -> Option<PairMeeting> {
        let values = self.values(line)?;
        match self.angles {
            Some(angles) => {
                device_plane::on_angles(&angles.step(line.first, line.second)?, values, &self.plane)
            }
            None => device_plane::on_any(self.view.frame(), line, values, &self.plane),
        }
    }

    fn device_curves(&self, line: &PairLine) -> Option<PairMeeting> {
        let frame = self.view.frame();
        let rays = [frame.ray(line.first)?, frame.ray(line.second)?];
        let [a, b] = self.values(line)?;
        let points = [frame.point(line.first, a)?, frame.point(line.second, b)?];
        let step = self.angles.and_then(|angles| angles.step(line.first, line.second));
        device_curves::meet(&rays, &points, &self.plane, step.as_ref())
    }

    fn four_point(&self, line: &PairLine, [b, c]: &[Point3; 2]) -> Option<PairMeeting> {
        let a = self.view.point_in_sensor(line.before?)?;
        let d = self.view.point_in_sensor(line.after?)?;
        four_point::meet(&[a, *b, *c, d], &self.plane)
    }

    /// The image's values of the pair.
    fn values(&self, line: &PairLine) -> Option<[f64; 2]> {
        let value = |p: Pixel| self.view.image().get(p).map(f64::from);
        Some([value(line.first)?, value(line.second)?])
    }
}

/// Signed distance of a point from a plane, both in the sensor frame.
fn height(plane: &SensorPlane, p: &Point3) -> f64 {
    plane.normal.dot(&p.coords) - plane.offset
}
