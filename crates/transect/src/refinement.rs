//! The options of refinement: where planes are inserted between those of the setup.

use transect_geometry::{GuideError, PlaneFamily};

/// Inserts planes where the curves of neighbouring planes differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    tolerance: f64,
    levels: u32,
}

/// Why options of refinement cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefinementError {
    /// The tolerance is zero, negative, NaN or infinite.
    #[error("the tolerance must be a positive length, got {0}")]
    BadTolerance(f64),
    /// The interval cannot be halved that often.
    #[error("the interval can be halved 1 to {most} times, not {0}", most = Refinement::MAX_LEVELS)]
    BadLevels(u32),
    /// The smallest interval is not the interval, halved 1 to 10 times.
    #[error(
        "the smallest interval {least} is not {interval} halved 1 to {most} times: {}, …",
        [2.0, 4.0, 8.0, 16.0].map(|parts| (interval / parts).to_string()).join(", "),
        most = Refinement::MAX_LEVELS
    )]
    BadLeastInterval {
        /// The smallest interval that was given.
        least: f64,
        /// The interval of the planes.
        interval: f64,
    },
}

impl Refinement {
    /// Largest number of times that the interval may be halved. Chosen by hand: 2¹⁰ planes per
    /// interval fill the memory of most machines. Doubled, a mistyped number takes days.
    pub const MAX_LEVELS: u32 = 10;

    /// Default number of times that the interval is halved: down to a sixteenth. Chosen by hand.
    pub const DEFAULT_LEVELS: u32 = 4;

    /// Inserts planes where curves differ by more than `tolerance`, in the model's length unit. The
    /// interval is halved at most `levels` times.
    ///
    /// # Errors
    /// [`RefinementError`] if one of the values cannot be used.
    pub fn new(tolerance: f64, levels: u32) -> Result<Self, RefinementError> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(RefinementError::BadTolerance(tolerance));
        }
        if !(1..=Self::MAX_LEVELS).contains(&levels) {
            return Err(RefinementError::BadLevels(levels));
        }
        Ok(Self { tolerance, levels })
    }

    /// As [`Refinement::new`], down to a smallest interval: `interval` halved a whole number of
    /// times.
    ///
    /// # Errors
    /// [`RefinementError`] if the tolerance or the smallest interval cannot be used.
    pub fn down_to(tolerance: f64, interval: f64, least: f64) -> Result<Self, RefinementError> {
        /// Relative error of lengths that were typed or converted. Chosen by hand; it must stay far
        /// below 0.5, where two levels could be confused.
        const ROUNDING: f64 = 1e-6;
        let halved = |levels: &u32| {
            let exact = interval / f64::from(1_u32 << levels);
            (exact - least).abs() <= ROUNDING * exact
        };
        let bad = RefinementError::BadLeastInterval { least, interval };
        Self::new(tolerance, (1..=Self::MAX_LEVELS).find(halved).ok_or(bad)?)
    }

    /// Largest accepted distance between curves of neighbouring planes, in the model's length unit.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Number of times that the interval may be halved.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// The family with the smallest interval: plane `k` of `planes` is its plane `k · 2^levels`.
    ///
    /// # Errors
    /// [`GuideError`] if the smallest interval is no positive number.
    pub fn family(&self, planes: &PlaneFamily) -> Result<PlaneFamily, GuideError> {
        let interval = planes.interval() / self.planes_per_interval() as f64;
        PlaneFamily::new(planes.guide().clone(), planes.offset(), interval)
    }

    pub(crate) fn planes_per_interval(&self) -> i64 {
        1 << self.levels
    }
}
