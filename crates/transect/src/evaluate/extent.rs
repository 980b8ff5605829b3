//! Whether a model and its reference have the same unit and frame.
//!
//! A mesh file states no unit. A mesh in another unit has sections of a thousand times the length,
//! or none. The boxes around model and mesh are therefore compared before anything is cut.

use std::fmt;
use transect_geometry::{LengthUnit, Point3};

/// Least ratio of two units that boxes alone tell. Chosen by hand: a scan of one room in the middle
/// of a flat has a box that is a third of the flat's. Doubled, centimetres and millimetres are told
/// by scores alone.
const TOLD_BY_BOXES: f64 = 10.0;

/// Largest distance of corresponding corners of two boxes that count as the same, as a share of
/// the diagonal. Chosen by hand: scans lack some side of an object, units differ by 10 at least.
/// Doubled, references that are larger than the scan may pass for another unit.
const SAME_BOX: f64 = 0.25;

/// Diagonal of a reference beside that of a model, at most, where other units are tried. Chosen by
/// hand: a scan of one room of a house. Doubled, cutting a wrong reference takes twice the time.
const MOST_LARGER: f64 = 10.0;

/// The box around points, along the world's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    min: Point3,
    max: Point3,
}

/// Why a reference cannot belong to a model.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtentError {
    /// The reference is the model in another unit.
    #[error(
        "the reference spans {reference}, the model {model}; they fit if the reference is multiplied \
         by {factor}. Convert the reference to the model's unit"
    )]
    OtherUnit {
        /// The box around the reference.
        reference: Extent,
        /// The box around the model.
        model: Extent,
        /// The factor with which they fit.
        factor: f64,
    },
    /// The boxes have no point in common.
    #[error(
        "the reference spans {reference}, the model {model}; they do not overlap. Bring the \
         reference into the model's frame and unit"
    )]
    Apart {
        /// The box around the reference.
        reference: Extent,
        /// The box around the model.
        model: Extent,
    },
    /// The boxes overlap, but no plane of the model cuts the reference.
    #[error(
        "the reference spans {reference}, the model {model}; no plane of the model cuts the \
         reference. Bring the reference into the model's frame and unit (a mesh states no unit)"
    )]
    Uncut {
        /// The box around the reference.
        reference: Extent,
        /// The box around the model.
        model: Extent,
    },
}

impl Extent {
    /// The box around points; `None` without points.
    pub fn of(points: impl IntoIterator<Item = Point3>) -> Option<Self> {
        let single = |p| Self { min: p, max: p };
        let merged = |a: Self, b: Self| Self { min: a.min.inf(&b.min), max: a.max.sup(&b.max) };
        points.into_iter().map(single).reduce(merged)
    }

    /// Refuses a reference that is this model in another unit, or is elsewhere. `margin` is the
    /// distance that counts as overlap.
    ///
    /// # Errors
    /// [`ExtentError`] with both boxes, and the factor if there is one.
    pub fn check(&self, reference: &Self, margin: f64) -> Result<(), ExtentError> {
        let (model, reference) = (*self, *reference);
        let miss = |factor: f64| {
            let corners = [(reference.min, model.min), (reference.max, model.max)];
            let far = corners.map(|(r, m)| (r.coords * factor - m.coords).norm());
            f64::max(far[0], far[1])
        };
        let factors = unit_ratios().filter(|f| f.max(1.0 / f) >= TOLD_BY_BOXES);
        let best = factors.min_by(|a, b| miss(*a).total_cmp(&miss(*b))).unwrap_or(1.0);
        let same = SAME_BOX * (model.max - model.min).norm();
        if miss(best) <= same && miss(best) < miss(1.0) {
            return Err(ExtentError::OtherUnit { reference, model, factor: best });
        }
        let axes = || (0..3).map(|axis| (model.min[axis], model.max[axis], axis));
        let apart = axes().any(|(low, high, axis)| {
            reference.min[axis] > high + margin || reference.max[axis] < low - margin
        });
        if apart { Err(ExtentError::Apart { reference, model }) } else { Ok(()) }
    }

    /// Factors between units that bring a reference around this model, so that its surface can be
    /// compared with the model's. The smallest factor comes first.
    pub fn unit_factors(&self, reference: &Self) -> Vec<f64> {
        let margin = SAME_BOX * (self.max - self.min).norm();
        let fits = |factor: &f64| {
            let [min, max] = [reference.min, reference.max].map(|p| p.coords * *factor);
            let holds = (0..3).all(|axis| {
                min[axis] <= self.min[axis] + margin && max[axis] >= self.max[axis] - margin
            });
            holds && (max - min).norm() <= MOST_LARGER * (self.max - self.min).norm()
        };
        let mut factors: Vec<f64> = unit_ratios().filter(fits).collect();
        factors.sort_by(f64::total_cmp);
        factors.dedup_by(|a, b| (*a / *b - 1.0).abs() < 1e-9);
        factors
    }

    /// The error of a reference that fits this model if it is multiplied by a factor.
    pub fn in_other_unit(&self, reference: &Self, factor: f64) -> ExtentError {
        ExtentError::OtherUnit { reference: *reference, model: *self, factor }
    }

    /// The error of a reference that no plane of this model cuts.
    pub fn uncut(&self, reference: &Self) -> ExtentError {
        ExtentError::Uncut { reference: *reference, model: *self }
    }
}

/// The ratios of all length units to one another. Some occur several times.
fn unit_ratios() -> impl Iterator<Item = f64> {
    let pairs = LengthUnit::ALL.into_iter().flat_map(|a| LengthUnit::ALL.map(|b| (a, b)));
    pairs.filter(|(a, b)| a != b).map(|(a, b)| a.in_metres() / b.in_metres())
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (a, b) = (self.min, self.max);
        let digits = super::digits;
        write!(f, "({}, {}, {})", digits(a.x), digits(a.y), digits(a.z))?;
        write!(f, " to ({}, {}, {})", digits(b.x), digits(b.y), digits(b.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(min: [f64; 3], max: [f64; 3]) -> Extent {
        Extent::of([min, max].map(Point3::from)).unwrap()
    }

    /// The bunny in metres, without its base, and its reference in other units.
    #[test]
    fn a_reference_in_another_unit_is_named_with_its_factor() {
        let model = extent([-0.094, 0.04, -0.06], [0.06, 0.18, 0.058]);
        for ratio in [25.4, 1.0 / 0.0254, 100.0, 304.8, 1000.0, 1.0 / 25.4, 0.001] {
            let whole = [[-0.095, 0.033, -0.062], [0.061, 0.187, 0.059]];
            let [min, max] = whole.map(|corner| corner.map(|c| c * ratio));
            let error = model.check(&extent(min, max), 0.001).unwrap_err();
            let ExtentError::OtherUnit { factor, .. } = error else { panic!("{error}") };
            assert!((factor * ratio - 1.0).abs() < 1e-9, "{ratio}: {factor}");
            assert!(error.to_string().contains("they fit if the reference is multiplied by"));
        }
        assert_eq!(
            model.check(&extent([-0.095, 0.033, -0.062], [0.061, 0.187, 0.059]), 0.0),
            Ok(())
        );
    }

    #[test]
    fn factors_that_bring_a_reference_around_the_model_are_those_of_units() {
        let model = extent([-0.5, 0.2, -0.5], [0.5, 0.5, 0.5]);
        let feet = extent([-1.64; 3], [1.64; 3]);
        let factors = model.unit_factors(&feet);
        let has = |ratio: f64| factors.iter().any(|f| (f / ratio - 1.0).abs() < 1e-9);
        assert!(has(0.3048) && has(0.01 / 0.0254) && has(2.54), "{factors:?}");
        assert!(!has(1000.0) && !has(0.01) && !has(1.0), "{factors:?}");
    }

    /// A detail of a building is ten times smaller, in the same unit.
    #[test]
    fn references_larger_than_the_model_are_accepted_and_others_elsewhere_are_not() {
        let model = extent([4.0, 4.0, 0.0], [5.0, 5.0, 1.0]);
        assert_eq!(model.check(&extent([0.0; 3], [10.0, 10.0, 10.0]), 0.0), Ok(()));
        let error = model.check(&extent([6.0, 0.0, 0.0], [7.0, 9.0, 1.0]), 0.5).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("(6.000, 0, 0) to (7.000, 9.000, 1.000), the model (4.000, 4.000, 0)"),
            "{error}"
        );
        assert_eq!(model.check(&extent([5.4, 0.0, 0.0], [7.0, 9.0, 1.0]), 0.5), Ok(()));
    }
}
