//! Lookup table of a scanner on a coordinate measuring machine (dissertation, 4.4, 4.7, HYSCAN).
//!
//! ```text
//!   P         R               one sweep: a fan of beams in the plane (u, v)
//!    \\\                      column j ↔ θ = θ₀ + j Δθ
//!   ──\─\─\────── depth 1     d3 = p, the spot's place on the detector, read off the depth lines
//!      \  \  \                row i    ↔ y = y₀ + i Δy on the linear axis (y₀, Δy signed)
//!   ────\──\──\── depth n
//!        v      u →           x–z mounting, tilt τ about y:  x = u cos τ + v sin τ
//!                                                            z = v cos τ − u sin τ
//! ```
//!
//! Axes: right-handed; z away from the scanner at tilt 0, y (x–z mounting) or x (y–z mounting) the
//! linear axis. y–z mounting, tilt about x: y = u cos τ − v sin τ, z = u sin τ + v cos τ. The frame
//! is fixed in the world: row i lies where the linear axis stood. Handedness depends on the
//! mounting and the signs of the steps, and is worked out from them.
//!
//! `d3` is `p` in the detector's unit, positive and growing with range; all else is in the model's
//! length unit, angles in radians. Pixel `(i, j)` is the centre of sweep i's beam j. Missing: a
//! column the calibration left without a beam has no ray, a value outside the digitised field is no
//! point. An image of a single row is valid. Noise is an error of `p`, so an error along the beam
//! that grows with range.
//!
//! Equations. A beam is the line `a u + b v + c = 0` (4.17) with the depth lines (4.18) marked on
//! it as values of `p`. `f`: interpolate between the two marks around the given `p`. `F` of a
//! plane: its line in the sweep `y = y₀` (4.19) meets the beam, and `p` is interpolated between the
//! two marks around that point. Between beams both are bilinear in (θ, p). The interpolation is
//! linear, so its error falls with the square of the depth lines' spacing: at most
//! `Δp² / 8 · |d²t/dp²|` along the beam, t the distance along it.
//!
//! A ray starts where the beam passes the projector, if [`Viewpoints`] are given, and at the
//! beam's nearest digitised point if not. Objects before that point are then unknown to the frame.
//! [`DeviceFrame::second_viewpoint`] is the receiver's pivot, known only with [`Viewpoints`].
//!
//! Departures from the source: entries of the tables are moved onto their beam's line, which makes
//! `f` and `F` exact inverses. More are listed where the tables are made, at [`digitize`].

pub mod alignment;
mod calibration;
mod field;
mod filter;
mod mounting;
mod synchronized;

pub use calibration::{
    CalibrationOptions, CalibrationSample, CalibrationSweep, DepthPairs, ThetaSteps, digitize,
};
pub use field::{Beam, BeamLine, DigitizedField, GridNode};
pub use mounting::{LinearSteps, Mounting, ScanPlane};
pub use synchronized::{CarriedScanner, SynchronizedScanner};

use crate::error::{SensorError, require};
use mounting::Axes;
use nalgebra::Point2;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, Pixel, Point3, Ray, SensorPlane, Vector3,
};

/// Start of the light, and the point that sees it, in the local frame (u, v); lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoints {
    /// Pivot of the projecting mirror.
    pub projector: Point2<f64>,
    /// Pivot of the receiving mirror.
    pub receiver: Point2<f64>,
}

/// The device frame of a table-driven scanner on a linear axis; see the module's page.
///
/// ```
/// use transect_device::{DeviceFrame, Pixel, SensorPlane, Vector3};
/// use transect_sensors::LookupTable;
/// use transect_sensors::lookup_table::LinearSteps;
///
/// let table = LookupTable::hyscan(LinearSteps::new(0.0, 0.5, 100))?; // millimetres
/// let wall = SensorPlane { normal: Vector3::z(), offset: 150.0 };
/// let d3 = table.plane_value(Pixel::new(20, 128), &wall).ok_or("the ray misses the plane")?;
/// let p = table.point(Pixel::new(20, 128), d3).ok_or("no point")?;
/// assert!((p.z - 150.0).abs() < 1e-9 && p.y == 10.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct LookupTable {
    field: DigitizedField,
    rows: LinearSteps,
    mounting: Mounting,
    axes: Axes,
    viewpoints: Option<Viewpoints>,
}

impl LookupTable {
    /// A scanner with calibrated tables, carried along a linear axis.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] for a zero step `dy`, no `rows`, or numbers that are not
    /// finite.
    pub fn new(
        field: DigitizedField,
        rows: LinearSteps,
        mounting: Mounting,
    ) -> Result<Self, SensorError> {
        let (rows, axes) = (rows.checked()?, mounting.axes()?);
        Ok(Self { field, rows, mounting, axes, viewpoints: None })
    }

    /// The same scanner, with the places of its mirrors.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] naming `projector` or `receiver` if they are not finite, or
    /// the projector does not lie before the digitised field.
    pub fn with_viewpoints(self, viewpoints: Viewpoints) -> Result<Self, SensorError> {
        let Viewpoints { projector, receiver } = viewpoints;
        require("receiver", receiver.coords.sum(), true, "a finite place")?;
        for (_, beam) in self.field.beams() {
            let ahead = beam.direction().dot(&(projector - beam.near_end()));
            require("projector", ahead, ahead < 0.0, "a place before the digitised field")?;
        }
        Ok(Self { viewpoints: Some(viewpoints), ..self })
    }

    /// The dissertation's scanner on its machine, in millimetres, mounted in x–z without tilt.
    ///
    /// Depth 90 from a minimum range of 110, the field 100 wide at its far end: v from 110 to 200,
    /// u from −50 to 50 there. Its 24 calibration sweeps, unequally spaced over a table that leans
    /// 1°, come from the assumed [`SynchronizedScanner::hyscan`]; 256 columns of 0.108°. The field
    /// follows those leaning sweeps. Linear interpolation errs by at most 0.03 mm.
    ///
    /// # Errors
    /// As [`LookupTable::new`].
    pub fn hyscan(rows: LinearSteps) -> Result<Self, SensorError> {
        CarriedScanner::hyscan(rows).table()
    }

    /// The columns of [`LookupTable::hyscan`]: from the projector to (−50, 200) and (50, 200).
    pub fn hyscan_columns() -> ThetaSteps {
        const COLUMNS: usize = 256;
        let projector = SynchronizedScanner::hyscan().projector();
        let angle = |u: f64| (u - projector.x).atan2(200.0);
        let (first, last) = (angle(-50.0), angle(50.0));
        ThetaSteps::from_radians(first, (last - first) / (COLUMNS - 1) as f64, COLUMNS)
    }

    /// Both tables.
    pub fn field(&self) -> &DigitizedField {
        &self.field
    }

    /// `f` at device coordinates that may lie between pixels; `None` outside the digitised field.
    pub fn point_at(&self, device: &DevicePoint) -> Option<Point3> {
        let local = self.field.forward(device.col, device.d3)?;
        Some(self.axes.point(&local, self.rows.place(device.row)))
    }

    /// The beam of a pixel and the place of its row.
    fn beam(&self, pixel: Pixel) -> Option<(&Beam, f64)> {
        let beam = self.field.beam(pixel.col)?;
        let inside = pixel.row < self.rows.rows();
        inside.then(|| (beam, self.rows.place(pixel.row as f64)))
    }

    /// Distance along a beam of its ray's start from the near end; 0 or less.
    fn ray_start(&self, beam: &Beam) -> f64 {
        self.viewpoints.map_or(0.0, |v| beam.direction().dot(&(v.projector - beam.near_end())))
    }
}

impl DeviceFrame for LookupTable {
    fn size(&self) -> ImageSize {
        ImageSize { rows: self.rows.rows(), cols: self.field.columns() }
    }

    fn kind(&self) -> &'static str {
        "LookupTable"
    }

    fn handedness(&self) -> Handedness {
        // Neighbouring columns lie along ±(a, b), neighbouring rows along the linear axis. (a, b)
        // is a quarter turn from u to v off the ray, so (a, b) × linear · ray has this sign.
        let quarter_turn = self.axes.v.cross(&self.axes.linear).dot(&self.axes.u);
        Handedness::of(quarter_turn * self.field.turn() * self.rows.step())
    }

    fn largest_angle(&self) -> Option<f64> {
        Some(self.mounting.tilt_rad)
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let (beam, place) = self.beam(pixel)?;
        let start = self.axes.point(&beam.at(self.ray_start(beam)), place);
        Some(Ray { start, direction: self.axes.direction(&beam.direction()) })
    }

    fn second_viewpoint(&self, pixel: Pixel) -> Option<Point3> {
        let (_, place) = self.beam(pixel)?;
        Some(self.axes.point(&self.viewpoints?.receiver, place))
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        let (beam, place) = self.beam(pixel)?;
        Some(self.axes.point(&beam.at(beam.distance_of(d3)?), place))
    }

    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint> {
        let row = self.rows.row(self.axes.linear.dot(&in_sensor.coords));
        let local = Point2::from(self.axes.local(&in_sensor.coords));
        let (col, d3) = self.field.inverse(&local)?;
        row.is_finite().then_some(DevicePoint { row, col, d3 })
    }

    /// Eq. 4.19 intersected with 4.17, then `p` between the two depth lines around the point.
    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        let (beam, place) = self.beam(pixel)?;
        let in_sweep = self.axes.local(&plane.normal);
        let offset = plane.offset - place * self.axes.linear.dot(&plane.normal);
        let ahead = offset - in_sweep.dot(&beam.near_end().coords);
        beam.p_of(ahead / in_sweep.dot(&beam.direction()))
    }

    /// Exact: every beam's part with these values is a segment, and rows only shift it.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        let in_sweep = self.axes.local(direction);
        let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
        for (_, beam) in self.field.beams() {
            let Some((near, far)) = beam.span(nearest, farthest) else { continue };
            for at in [beam.at(near), beam.at(far)] {
                let value = in_sweep.dot(&at.coords);
                extremes = (value.min(extremes.0), value.max(extremes.1));
            }
        }
        let shift = |row: f64| self.axes.linear.dot(direction) * self.rows.place(row);
        let (first, last) = (shift(0.0), shift(self.rows.rows() as f64 - 1.0));
        (extremes.0 + first.min(last), extremes.1 + first.max(last))
    }
}
