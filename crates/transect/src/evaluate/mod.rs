//! How accurate curves are, against sections that are known.
//!
//! The idea: walk along every curve in small steps of equal length and ask, inside its plane, how
//! far the truth is; walk along the truth and ask how far the curves are. The first walk finds what
//! is wrong, the second what is missing; neither notices what the other does.
//!
//! 1. Each curve unit is split into equal parts no longer than a fifth of the tolerance; each
//!    part's midpoint is a sample that stands for the part's length.
//! 2. Samples of the curves: distance to the nearest unit of the truth on the same plane, and
//!    whether that unit runs the same way (solid on the same side).
//! 3. Samples of the truth: distance to the nearest curve unit on the same plane. Stretches of the truth's
//!    curves that were seen, with no gap as long as the tolerance or four samples of the views, are the
//!    curves to expect.
//! 4. Samples of the curves again, against the curves: whether another piece of the same direction
//!    lies within the tolerance, which is surface that was modelled twice.
//! 5. Shares count lengths; median and 95 % quantile count samples (linear between neighbouring
//!    samples).
//!
//! An independent scorer that works on samples only agrees with these figures. Departures from it:
//! distances and duplicates are found among whole units rather than their samples; where several
//! units of the truth are equally near, as at a corner, a curve agrees with the truth if it agrees
//! with one of them; curves on planes without truth are infinitely far from it, not a large number.
//!
//! Cost: O(s log u) time for s samples and u units, 8 bytes per sample of the curves. Planes are
//! measured in parallel and added up in their order, so the figures do not depend on the threads.
//! Do not use it to compare curves whose planes differ: a curve is only seen by its own plane.
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
//! let options = EvaluateOptions { tolerance: 0.005, from: None };
//! let accuracy = evaluate(&planes, &line(1.0, 0.001)?, &line(2.0, 0.0)?, &options)?;
//! assert!((accuracy.median.unwrap() - 0.001).abs() < 1e-9);
//! assert!((accuracy.completeness.unwrap() - 0.5).abs() < 0.005);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accuracy;
mod closeness;
mod index;
mod own;
mod quantile;
mod rows;
mod sample;
mod stretches;

pub use accuracy::{Accuracy, Duplication};
pub use rows::Row;

use closeness::Closeness;
use index::UnitIndex;
use own::Own;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point2};

/// Samples per tolerance. More of them sharpen the shares' ends, which are found to within half a
/// sample, and take as much more time.
const SAMPLES_PER_TOLERANCE: f64 = 5.0;

/// Most samples that are taken; more are taken for a tolerance in the wrong unit.
///
/// The distances of that many samples fill 2 GiB.
pub const MAX_SAMPLES: usize = 1 << 28;

/// Curves by section plane.
type PlaneCurves = BTreeMap<PlaneIndex, Vec<Curve>>;

/// How curves are evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvaluateOptions {
    /// What counts as near, in the model's length unit.
    pub tolerance: f64,
    /// Only planes at this station or above it count, in the model's length unit; all if `None`.
    ///
    /// It excludes what the reference lacks or the views did not see, such as an object's base.
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
    #[error("a tolerance of {tolerance} takes {samples:.0} samples; at most {most} are accepted")]
    TooFine {
        /// The tolerance, in the model's length unit.
        tolerance: f64,
        /// How many samples it would take.
        samples: f64,
        /// How many are accepted.
        most: usize,
    },
}

/// How well curves agree with the sections that the solid really has.
///
/// `planes` is only asked which planes [`EvaluateOptions::from`] means: both maps have their planes
/// from this family. Planes without curves and planes without truth count as what they are.
///
/// # Errors
/// [`EvaluateError`] if an option is no usable length.
pub fn evaluate(
    planes: &PlaneFamily,
    curves: &PlaneCurves,
    truth: &PlaneCurves,
    options: &EvaluateOptions,
) -> Result<Accuracy, EvaluateError> {
    evaluate_seen(planes, curves, truth, &|_, _| true, options)
}

/// Whether a point of the truth, in plane coordinates, counts for completeness.
pub type Seen<'a> = dyn Fn(PlaneIndex, &Point2) -> bool + Sync + 'a;

/// As [`evaluate`], with completeness of that part of the truth alone which the views could see.
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
        let seen = |p: &Point2| seen(k, p);
        (Own::of(curves, &index, &ruler), Closeness::of((curves, &index), truth, seen, &ruler))
    };
    let measured: Vec<_> = pairs.par_iter().map(measure).collect();
    let (own, closeness): (Vec<_>, Vec<_>) = measured.into_iter().unzip();
    Ok(Accuracy::new(Own::total(own), Closeness::total(closeness)))
}

/// What curves tell about themselves, without any truth: how many there are, and how much of them
/// runs beside another piece of the same direction within the tolerance.
///
/// Another piece is another curve, or the same one more than ten tolerances away along it; the ends
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
    fn first_plane(&self, planes: &PlaneFamily) -> Result<PlaneIndex, EvaluateError> {
        match self.from {
            None => Ok(PlaneIndex(i64::MIN)),
            Some(station) if station.is_finite() => Ok(planes.first_at_or_above(station)),
            Some(station) => Err(EvaluateError::BadFrom(station)),
        }
    }
}

/// What all planes are measured with; both in the model's length unit.
struct Ruler {
    /// What counts as near.
    tolerance: f64,
    /// Longest part of a curve that one sample stands for.
    step: f64,
}

impl Ruler {
    /// A ruler fit for these curves.
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
