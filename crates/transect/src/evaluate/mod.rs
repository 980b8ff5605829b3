//! The accuracy of curves, measured against known sections.
//!
//! Idea: walk along every curve in small steps of equal length and measure, inside its plane, the
//! distance to the truth. Then walk along the truth and measure the distance to the curves. The
//! first walk finds false curves, the second finds missing ones.
//!
//! 1. Each curve unit is split into equal parts no longer than a fifth of the tolerance; each
//!    part's midpoint is a sample that stands for the part's length. Samples are looked up in
//!    groups of neighbours.
//! 2. Samples of the curves: distance to the nearest unit of the truth on the same plane, and
//!    whether that unit runs the same way (solid on the same side).
//! 3. Samples of the truth: distance to the nearest curve unit on the same plane. The views are
//!    asked about every fifth sample, and about all samples between two different answers. A
//!    stretch of the truth that the views could see is a curve to expect. Gaps shorter than the
//!    tolerance, or than four sample spacings of the views, do not end a stretch.
//! 4. Samples of the curves again, against the curves: another piece of the same direction within
//!    the tolerance is surface that was modelled twice.
//! 5. Shares count lengths; median and 95 % quantile count samples (linear between neighbouring
//!    samples).
//!
//! An independent scorer that works on samples alone agrees with these figures. There are four
//! differences. Distances and duplicates are found among whole units, not among samples. The views
//! are not asked about samples between two equal answers. Where several units of the truth are
//! equally near, as at a corner, a curve agrees with the truth if it agrees with one of them.
//! Curves on planes without truth are infinitely far from it.
//!
//! Cost: O(s log u) time for s samples and u units, 8 bytes per sample of the curves. Planes are
//! measured in parallel and added up in their order, so the figures do not depend on the threads.
//! Do not use it to compare curves on different planes: a curve is compared within its own plane
//! only.
//!
//! ```
//! use std::collections::BTreeMap;
//! use transect::evaluate::{EvaluateOptions, evaluate};
//! use transect_geometry::{Curve, Node, PlaneFamily, PlaneIndex, Point2, StraightGuide, Vector3};
//!
//! // Metres: the curve lies 1 mm above a truth that is twice as long.
//! let line = |length, y| {
//!     let ends = [Point2::new(0.0, y), Point2::new(length, y)];
//!     Curve::new(ends.map(Node::at).to_vec(), false).map(|c| BTreeMap::from([(PlaneIndex(0), vec![c])]))
//! };
//! let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 0.0, 0.1)?;
//! let options = EvaluateOptions::new(0.005);
//! let accuracy = evaluate(&planes, &line(1.0, 0.001)?, &line(2.0, 0.0)?, &options)?;
//! assert!((accuracy.median.unwrap() - 0.001).abs() < 1e-9);
//! assert!((accuracy.completeness.unwrap() - 0.5).abs() < 0.005);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accuracy;
mod closeness;
mod extent;
mod index;
mod own;
mod quantile;
mod rows;
mod sample;
mod stretches;

pub use accuracy::{Accuracy, Duplication};
pub use extent::{Extent, ExtentError};
pub use rows::{Quantity, Row, digits};

use closeness::Closeness;
use index::UnitIndex;
use own::Own;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point2};

/// Samples per tolerance; chosen by hand. The ends of stretches are found to within half a sample.
/// Doubled, the ends are twice as sharp and the evaluation takes twice the time.
const SAMPLES_PER_TOLERANCE: f64 = 5.0;

/// Largest number of samples. More than that is taken for a tolerance in the wrong unit.
///
/// Chosen by hand: the distances of that many samples fill 2 GiB. Doubled, so does the memory.
pub const MAX_SAMPLES: usize = 1 << 28;

/// Curves by section plane.
type PlaneCurves = BTreeMap<PlaneIndex, Vec<Curve>>;

/// How curves are evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct EvaluateOptions {
    /// Largest distance that counts as near, in the model's length unit.
    pub tolerance: f64,
    /// Lowest station whose planes count, in the model's length unit; `None` counts all planes.
    ///
    /// It leaves out parts that the reference lacks or that no view saw, such as an object's base.
    pub from: Option<f64>,
}

/// Why curves cannot be evaluated.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// The tolerance is zero, negative, NaN or infinite.
    #[error("the tolerance must be a positive length, got {0}")]
    BadTolerance(f64),
    /// The first station is NaN or infinite.
    #[error("the first station must be a finite length, got {0}")]
    BadFrom(f64),
    /// The tolerance is so small that the samples would not fit into memory.
    #[error(
        "a tolerance of {tolerance} needs {samples:.0} samples; at most {most} are accepted. Is it in \
         the model's unit?"
    )]
    TooFine {
        /// The tolerance, in the model's length unit.
        tolerance: f64,
        /// How many samples it would take.
        samples: f64,
        /// How many are accepted.
        most: usize,
    },
}

/// Compares curves with the true sections of the solid.
///
/// Both maps have their planes from the family `planes`, which is needed for
/// [`EvaluateOptions::from`] alone. Planes without curves or without truth count too.
///
/// # Errors
/// [`EvaluateError`] if an option is no usable length.
pub fn evaluate(
    planes: &PlaneFamily,
    curves: &PlaneCurves,
    truth: &PlaneCurves,
    options: &EvaluateOptions,
) -> Result<Accuracy, EvaluateError> {
    evaluate_seen(planes, curves, truth, &|_, points| vec![true; points.len()], options)
}

/// Whether points of the truth, in plane coordinates, count for completeness: one answer for each
/// point. The points come in the order of a curve, so that what was found for one is tried first
/// for the next.
pub type Seen<'a> = dyn Fn(PlaneIndex, &[Point2]) -> Vec<bool> + Sync + 'a;

/// As [`evaluate`], with the completeness of the part of the truth that the views could see.
///
/// # Errors
/// [`EvaluateError`] if an option is no usable length.
pub fn evaluate_seen(
    planes: &PlaneFamily,
    curves: &PlaneCurves,
    truth: &PlaneCurves,
    seen: &Seen,
    options: &EvaluateOptions,
) -> Result<Accuracy, EvaluateError> {
    let first = options.first_plane(planes)?;
    let known: BTreeSet<PlaneIndex> =
        curves.range(first..).chain(truth.range(first..)).map(|(k, _)| *k).collect();
    let pairs: Vec<_> =
        known.into_iter().map(|k| (k, on_plane(curves, k), on_plane(truth, k))).collect();
    let all = pairs.iter().flat_map(|(_, c, t)| c.iter().chain(*t));
    let ruler = Ruler::new(options.tolerance, all)?;
    let measure = |&(k, curves, truth): &(PlaneIndex, &[Curve], &[Curve])| {
        let index = UnitIndex::new(curves);
        let seen = |points: &[Point2]| seen(k, points);
        (Own::of(curves, &index, &ruler), Closeness::of((curves, &index), truth, seen, &ruler))
    };
    let measured: Vec<_> = pairs.par_iter().map(measure).collect();
    let (own, closeness): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
    Ok(Accuracy::new(Own::total(own), Closeness::total(closeness)))
}

/// Measures curves without a truth: their number, and the share of their length that runs beside
/// another piece of the same direction within the tolerance.
///
/// Another piece is another curve, or the same one more than ten tolerances away along it. The ends
/// of a curve count as neighbours, whether it is closed or not quite.
///
/// # Errors
/// [`EvaluateError`] if the tolerance is no usable length.
pub fn duplication(curves: &PlaneCurves, tolerance: f64) -> Result<Duplication, EvaluateError> {
    let ruler = Ruler::new(tolerance, curves.values().flatten())?;
    let planes: Vec<_> = curves.values().collect();
    let own: Vec<_> = planes.par_iter().map(|c| Own::of(c, &UnitIndex::new(c), &ruler)).collect();
    Ok(Own::total(own).into())
}

fn on_plane(curves: &PlaneCurves, k: PlaneIndex) -> &[Curve] {
    curves.get(&k).map_or(&[], Vec::as_slice)
}

impl EvaluateOptions {
    /// A tolerance in the model's length unit, and all planes.
    pub const fn new(tolerance: f64) -> Self {
        Self { tolerance, from: None }
    }

    /// The same options for planes at a station or above it, in the model's length unit.
    #[must_use]
    pub const fn from_station(self, station: f64) -> Self {
        Self { from: Some(station), ..self }
    }

    fn first_plane(&self, planes: &PlaneFamily) -> Result<PlaneIndex, EvaluateError> {
        match self.from {
            None => Ok(PlaneIndex(i64::MIN)),
            Some(station) if station.is_finite() => Ok(planes.first_at_or_above(station)),
            Some(station) => Err(EvaluateError::BadFrom(station)),
        }
    }
}

/// The lengths with which all planes are measured, in the model's length unit.
struct Ruler {
    /// Largest distance that counts as near.
    tolerance: f64,
    /// Longest part of a curve that one sample stands for.
    step: f64,
}

impl Ruler {
    /// The ruler for these curves, if their samples fit into memory.
    fn new<'a>(
        tolerance: f64,
        curves: impl Iterator<Item = &'a Curve>,
    ) -> Result<Self, EvaluateError> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(EvaluateError::BadTolerance(tolerance));
        }
        let step = tolerance / SAMPLES_PER_TOLERANCE;
        // A unit has up to one sample more than its length takes.
        let samples: f64 = curves.map(|c| c.length() / step + c.units().len() as f64).sum();
        if samples <= MAX_SAMPLES as f64 {
            Ok(Self { tolerance, step })
        } else {
            Err(EvaluateError::TooFine { tolerance, samples, most: MAX_SAMPLES })
        }
    }
}

#[cfg(test)]
mod tests;
