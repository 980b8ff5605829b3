//! Whether a model and its reference have the same unit and frame.
//!
//! A mesh file states no unit. A mesh in another unit has sections of a thousand times the length,
//! or none. The boxes around model and mesh are therefore compared before anything is cut.

use std::fmt;
use transect_geometry::Point3;

/// The ratios of the length units in use, to one another.
const UNIT_RATIOS: [f64; 8] = [10.0, 12.0, 25.4, 30.48, 100.0, 304.8, 1000.0, 1e6];

/// Largest distance of corresponding corners of two boxes that count as the same, as a share of
/// the diagonal. Chosen by hand: scans lack some side of an object, units differ by 10 at least.
/// Doubled, references that are larger than the scan may pass for another unit.
const SAME_BOX: f64 = 0.25;

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
        let factors = UNIT_RATIOS.into_iter().flat_map(|ratio| [ratio, 1.0 / ratio]);
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

    /// The error of a reference that no plane of this model cuts.
    pub fn uncut(&self, reference: &Self) -> ExtentError {
        ExtentError::Uncut { reference: *reference, model: *self }
    }
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
        for ratio in [25.4, 100.0, 304.8, 1000.0, 1.0 / 25.4, 0.001] {
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
