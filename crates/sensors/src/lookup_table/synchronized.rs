//! An assumed geometry of the synchronised scanner, from which example sweeps are made.
//!
//! ```text
//!          v ^      . spot
//!            |     /|\           θ: beam from +v towards +u
//!            |    / . \          δ: parallax, between the beam and the line of sight
//!            |   /  δ  \
//!     -------P--/---+---R----> u          P (−B/2, 0) projector, R (B/2, 0) receiver
//! ```
//!
//! Both pivots turn together (Rioux), so that the receiver's axis always leans κ from the beam and
//! the spot's image position depends little on θ:
//!
//! `tan δ = B cos θ / (t − B sin θ)`, `p = p₀ + f tan(κ − δ)`, with t the length of the beam.
//!
//! `p` grows with range, because δ falls. The dissertation gives no such numbers (the table is the
//! vendor's); base line, focal length and convergence are assumed, chosen so that its field fits.

use super::calibration::{CalibrationSample, CalibrationSweep, ThetaSteps};
use super::{
    CalibrationOptions, LinearSteps, LookupTable, Mounting, ScanPlane, Viewpoints, digitize,
};
use crate::error::{SensorError, require};
use nalgebra::Point2;

/// A scanner whose beam and line of sight turn together about two pivots; lengths in one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SynchronizedScanner {
    /// Base line B: distance of the receiver's pivot from the projector's, along u.
    pub base: f64,
    /// Focal length f of the receiver.
    pub focal_length: f64,
    /// Convergence κ: angle between beam and receiver's axis, in radians.
    pub convergence_rad: f64,
    /// Place p₀ of the receiver's axis on the detector.
    pub detector_axis: f64,
}

impl SynchronizedScanner {
    /// The assumed scanner of the example, in millimetres: B = 60, f = 60, κ = 0.4, p₀ = 10.
    pub fn hyscan() -> Self {
        Self { base: 60.0, focal_length: 60.0, convergence_rad: 0.4, detector_axis: 10.0 }
    }

    /// Pivot of the projector in the local frame.
    pub fn projector(&self) -> Point2<f64> {
        Point2::new(-0.5 * self.base, 0.0)
    }

    /// Pivot of the receiver in the local frame.
    pub fn receiver(&self) -> Point2<f64> {
        Point2::new(0.5 * self.base, 0.0)
    }

    /// Both pivots.
    pub fn viewpoints(&self) -> Viewpoints {
        Viewpoints { projector: self.projector(), receiver: self.receiver() }
    }

    /// The spot seen at image position `p` on the beam at θ; `None` where the lines diverge.
    pub fn spot(&self, theta_rad: f64, p: f64) -> Option<Point2<f64>> {
        let (sin, cos) = theta_rad.sin_cos();
        let seen = ((p - self.detector_axis) / self.focal_length).atan();
        let parallax = self.convergence_rad - seen;
        let length = self.base * (sin + cos / parallax.tan());
        let converge = parallax > 0.0 && length > 0.0;
        converge.then(|| Point2::new(length * sin - 0.5 * self.base, length * cos))
    }

    /// The sample a flat table `v = depth + slope · u` gives on the beam at θ.
    pub fn sample(&self, theta_rad: f64, depth: f64, slope: f64) -> CalibrationSample {
        let (sin, cos) = theta_rad.sin_cos();
        let length = (depth - 0.5 * slope * self.base) / (cos - slope * sin);
        let parallax = (self.base * cos).atan2(length - self.base * sin);
        let seen = (self.convergence_rad - parallax).tan();
        CalibrationSample {
            theta_rad,
            p: self.detector_axis + self.focal_length * seen,
            u: length * sin - 0.5 * self.base,
            v: length * cos,
        }
    }

    /// A noise-free sweep of a flat table `v = depth + slope · u`.
    pub fn sweep(&self, columns: &ThetaSteps, depth: f64, slope: f64) -> CalibrationSweep {
        let angles = (0..columns.count()).map(|c| columns.angle(c));
        CalibrationSweep { samples: angles.map(|t| self.sample(t, depth, slope)).collect() }
    }
}

/// A synchronised scanner on a linear axis, calibrated by example sweeps; lengths in one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedScanner {
    /// The scanner.
    pub scanner: SynchronizedScanner,
    /// Its beams, one per column.
    pub columns: ThetaSteps,
    /// Depths of the first and the last calibration sweep.
    pub depths: [f64; 2],
    /// Places on the linear axis, one per row.
    pub rows: LinearSteps,
}

impl CarriedScanner {
    /// Depths of the first and the last sweep of the dissertation's scanner (4.7.1), in
    /// millimetres.
    pub const HYSCAN_DEPTHS: [f64; 2] = [110.0, 200.0];

    /// The dissertation's scanner on its machine, in millimetres; see
    /// [`LookupTable::hyscan`](super::LookupTable::hyscan).
    pub fn hyscan(rows: LinearSteps) -> Self {
        let columns = LookupTable::hyscan_columns();
        let scanner = SynchronizedScanner::hyscan();
        Self { scanner, columns, depths: Self::HYSCAN_DEPTHS, rows }
    }

    /// The same instrument in another length unit, or a smaller or larger one of the same shape.
    /// Its rows stay.
    pub fn scaled(self, factor: f64) -> Self {
        let scanner = SynchronizedScanner { base: self.scanner.base * factor, ..self.scanner };
        Self { scanner, depths: self.depths.map(|depth| depth * factor), ..self }
    }

    /// Its calibration, nearest first: 24 noise-free sweeps of a table that leans 1°, at depths
    /// that are not equally spaced.
    pub fn sweeps(&self) -> Vec<CalibrationSweep> {
        const DEPTHS: usize = 24;
        let slope = 1.0_f64.to_radians().tan();
        let [nearest, farthest] = self.depths;
        let sweep = |k: usize| {
            let part = k as f64 / (DEPTHS - 1) as f64;
            // Steps of 3.1 to 4.7 mm: hands set no equal depths.
            let uneven = part - 0.2 * part * (1.0 - part);
            self.scanner.sweep(&self.columns, nearest + (farthest - nearest) * uneven, slope)
        };
        (0..DEPTHS).map(sweep).collect()
    }

    /// Its device frame, mounted in x–z without tilt.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] naming the parameter that makes no scanner.
    pub fn table(&self) -> Result<LookupTable, SensorError> {
        let [nearest, farthest] = self.depths;
        require("baseline", self.scanner.base, self.scanner.base > 0.0, "a positive length")?;
        require("depth", nearest, nearest > 0.0, "a nearest depth of more than 0")?;
        require("depth", farthest, farthest > nearest, "a farthest depth beyond the nearest")?;
        let field = digitize(&self.sweeps(), &self.columns, CalibrationOptions::EXACT)?;
        let mounting = Mounting::from_radians(ScanPlane::Xz, 0.0);
        LookupTable::new(field, self.rows, mounting)?.with_viewpoints(self.scanner.viewpoints())
    }
}
