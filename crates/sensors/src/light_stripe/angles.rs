//! The table of scanning angles: one per column.

use crate::SensorError;
use std::f64::consts::PI;

/// Largest angle between a point and the sheet of a scan with one single angle, in radians. Chosen
/// by hand: a thousandth of a millimetre at a metre. With more angles, the columns' spacing is the
/// limit. Doubled, points twice as far off count as on the sheet.
const SINGLE_SHEET: f64 = 1e-6;

/// The laser's scanning angles `θ_laser`, one per column, between the base line and the sheet.
///
/// Checked by [`LightStripe::new`](super::LightStripe::new): between 0° and 180°, and all
/// increasing or all decreasing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LaserAngles {
    radians: Vec<f64>,
}

impl LaserAngles {
    /// Any angles, in radians.
    pub fn from_radians(radians: Vec<f64>) -> Self {
        Self { radians }
    }

    /// `count` angles from `first` on, `step` apart, in degrees.
    pub fn equal_steps_degrees(first: f64, step: f64, count: usize) -> Self {
        let angle = |k: usize| (first + k as f64 * step).to_radians();
        Self { radians: (0..count).map(angle).collect() }
    }

    /// The angles in radians, in the order of the columns.
    pub fn as_radians(&self) -> &[f64] {
        &self.radians
    }

    /// Whether the angles increase with the column; true for a single one.
    pub fn ascending(&self) -> bool {
        self.radians.first() <= self.radians.last()
    }

    pub(super) fn check(&self) -> Result<(), SensorError> {
        let key = "theta_laser";
        let bad = |value, wanted| Err(SensorError::BadParameter { key, value, wanted });
        if self.radians.is_empty() {
            return bad(0.0, "at least one angle");
        }
        if let Some(&angle) = self.radians.iter().find(|a| !(**a > 0.0 && **a < PI)) {
            return bad(angle, "angles between 0 and π, in radians");
        }
        let ascending = self.ascending();
        for (&before, &angle) in self.radians.iter().zip(self.radians.iter().skip(1)) {
            if before == angle || (before < angle) != ascending {
                return bad(angle, "angles that all increase or all decrease");
            }
        }
        Ok(())
    }

    /// Smallest and largest angle that belong to a column: half a step outside the first and last.
    pub(super) fn field(&self) -> (f64, f64) {
        let (first, last) = (self.radians.first(), self.radians.last());
        let ends = first.zip(last).map_or((0.0, 0.0), |(&a, &b)| (a.min(b), a.max(b)));
        let half_step = |a: Option<&f64>, b: Option<&f64>| match a.zip(b) {
            Some((a, b)) => 0.5 * (a - b).abs(),
            None => SINGLE_SHEET,
        };
        let n = self.radians.len();
        let at_first = half_step(self.radians.first(), self.radians.get(1));
        let at_last = half_step(n.checked_sub(2).and_then(|k| self.radians.get(k)), last);
        let (low, high) = if self.ascending() { (at_first, at_last) } else { (at_last, at_first) };
        ((ends.0 - low).max(0.0), (ends.1 + high).min(PI))
    }

    /// The column of an angle, linear between neighbouring columns; `None` outside the field.
    pub(super) fn column(&self, theta: f64) -> Option<f64> {
        let (low, high) = self.field();
        if !(theta >= low && theta <= high) {
            return None;
        }
        let ascending = self.ascending();
        let passed = |a: &f64| if ascending { *a <= theta } else { *a >= theta };
        let after = self.radians.partition_point(passed);
        // The first or last pair of columns also serves the half step outside it.
        let left = after.saturating_sub(1).min(self.radians.len().saturating_sub(2));
        let Some((a, b)) = self.radians.get(left).zip(self.radians.get(left + 1)) else {
            return Some(0.0);
        };
        Some(left as f64 + (theta - a) / (b - a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_run_linearly_between_uneven_angles_either_way_round() {
        let up = LaserAngles::from_radians(vec![0.5, 0.6, 1.0]);
        let down = LaserAngles::from_radians(vec![1.0, 0.6, 0.5]);
        for (theta, column) in [(0.5, 0.0), (0.55, 0.5), (0.6, 1.0), (0.7, 1.25), (1.0, 2.0)] {
            assert!((up.column(theta).unwrap() - column).abs() < 1e-12, "{theta}");
            assert!((down.column(theta).unwrap() - (2.0 - column)).abs() < 1e-12, "{theta}");
        }
        assert!((up.column(0.46).unwrap() + 0.4).abs() < 1e-12);
        assert!((up.column(1.1).unwrap() - 2.25).abs() < 1e-12);
        assert_eq!(up.column(0.44), None, "half a column before the first");
        assert_eq!(up.column(1.21), None);
        assert_eq!(up.column(f64::NAN), None);
    }

    #[test]
    fn a_single_angle_owns_its_sheet_only() {
        let one = LaserAngles::from_radians(vec![1.2]);
        assert!(one.check().is_ok() && one.ascending());
        assert_eq!(one.column(1.2 + 1e-9), Some(0.0));
        assert_eq!(one.column(1.2001), None);
    }
}
