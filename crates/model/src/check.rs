//! The check of a model's invariants.

use crate::section::around;
use crate::{CurveIndex, CurveRecord, InvariantError, Model, Section, ViewRecord};
use transect_geometry::{Guide, Isometry3, PlaneFamily, PlaneIndex, StraightGuide};

/// Largest deviation of the length of a unit vector or unit quaternion from 1. Chosen by hand:
/// rounding stays below 1e-15, and vectors that were never normalised deviate by far more. Doubled
/// or halved, it still separates the two.
const UNIT_TOLERANCE: f64 = 1e-9;

impl Model {
    /// Checks the promises that every model keeps: usable planes, exact envelopes, rigid poses.
    /// Curves keep their own: reading one from a file or a store calls
    /// [`Curve::new`](transect_geometry::Curve::new).
    ///
    /// Saving and loading call it. Cost: one pass over all nodes.
    ///
    /// # Errors
    /// The first [`InvariantError`] in order of views, planes and curves.
    pub fn check(&self) -> Result<(), InvariantError> {
        check_planes(self.planes())?;
        if let Some((first, last)) = self.planes().ends() {
            let selected = self.selected().into_iter().flatten().copied();
            let mut used = self.sections().map(|(k, _)| k).chain(selected);
            let beyond = used.find(|k| *k < first || *k > last);
            beyond.map_or(Ok(()), |k| Err(InvariantError::BeyondGuide(k)))?;
        }
        let stray = self.sections().map(|(k, _)| k).find(|k| !self.selection().contains(*k));
        stray.map_or(Ok(()), |k| Err(InvariantError::NotSelected(k)))?;
        self.views().iter().try_for_each(check_view)?;
        self.sections().try_for_each(|(plane, section)| check_section(plane, section))
    }
}

pub(crate) fn check_planes(planes: &PlaneFamily) -> Result<(), InvariantError> {
    let remade = PlaneFamily::new(planes.guide().clone(), planes.offset(), planes.interval());
    remade.map_err(InvariantError::Planes)?;
    // A curved guide is rebuilt from its points, and thereby checked, whenever it is read.
    let Guide::Straight(guide) = planes.guide() else { return Ok(()) };
    let direction = guide.direction();
    StraightGuide::along(direction).map_err(InvariantError::Planes)?;
    let length = direction.norm();
    let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
    is_unit.then_some(()).ok_or(InvariantError::GuideNotUnit(length))
}

fn check_view(view: &ViewRecord) -> Result<(), InvariantError> {
    check_pose(&view.name, &view.world_from_sensor)?;
    check_sigma(&view.name, view.sigma)
}

pub(crate) fn check_pose(name: &str, pose: &Isometry3) -> Result<(), InvariantError> {
    let at_finite_place = pose.translation.vector.iter().all(|c| c.is_finite());
    // A NaN or infinite quaternion also fails this comparison.
    let turned_rigidly = (pose.rotation.norm() - 1.0).abs() <= UNIT_TOLERANCE;
    let rigid = at_finite_place && turned_rigidly;
    rigid.then_some(()).ok_or_else(|| InvariantError::Pose(name.to_owned()))
}

pub(crate) fn check_sigma(name: &str, sigma: Option<f64>) -> Result<(), InvariantError> {
    match sigma {
        Some(sigma) if !(sigma.is_finite() && sigma >= 0.0) => {
            Err(InvariantError::Sigma { name: name.to_owned(), sigma })
        }
        _ => Ok(()),
    }
}

fn check_section(plane: PlaneIndex, section: &Section) -> Result<(), InvariantError> {
    let records = section.curve_records();
    for (index, record) in records.iter().enumerate() {
        check_curve(plane, CurveIndex(index), record)?;
    }
    let envelope = around(records).ok_or(InvariantError::EmptySection(plane))?;
    let right = envelope == section.envelope();
    right.then_some(()).ok_or(InvariantError::PlaneEnvelope(plane))
}

fn check_curve(
    plane: PlaneIndex,
    curve: CurveIndex,
    record: &CurveRecord,
) -> Result<(), InvariantError> {
    let right = record.curve().envelope() == record.envelope();
    right.then_some(()).ok_or(InvariantError::CurveEnvelope { plane, curve })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{small, view};
    use transect_geometry::Vector3;

    #[test]
    fn a_built_model_is_sound() {
        assert_eq!(small().check(), Ok(()));
    }

    #[test]
    fn a_plane_beyond_a_curved_guide_is_found() {
        let ends = vec![
            transect_geometry::Point3::origin(),
            transect_geometry::Point3::new(1.0, 0.0, 0.0),
        ];
        let guide = transect_geometry::CurvedGuide::polyline(ends, None).unwrap();
        let planes = PlaneFamily::new(guide, 0.0, 0.5).unwrap();
        let mut model = Model::new(transect_geometry::LengthUnit::Metre, planes);
        let square = || vec![crate::samples::rectangle(0.0, 0.0, 1.0, 1.0)];
        model.set_curves(PlaneIndex(2), square());
        assert_eq!(model.check(), Ok(()));
        for beyond in [-1, 3] {
            let mut model = model.clone();
            model.set_curves(PlaneIndex(beyond), square());
            assert_eq!(model.check(), Err(InvariantError::BeyondGuide(PlaneIndex(beyond))));
        }
    }

    #[test]
    fn a_view_without_a_place_or_with_negative_noise_is_named() {
        let mut model = small();
        let lost = Isometry3::translation(f64::NAN, 0.0, 0.0);
        model.add_view(ViewRecord { world_from_sensor: lost, ..view("lost") });
        assert_eq!(model.check(), Err(InvariantError::Pose("lost".to_owned())));

        let mut model = small();
        model.add_view(ViewRecord { sigma: Some(-1.0), ..view("loud") });
        let text = model.check().unwrap_err().to_string();
        assert_eq!(
            text,
            "view \"loud\" has the range noise -1, which must be finite and at least 0"
        );
    }

    #[test]
    fn a_stretching_pose_is_not_rigid() {
        let mut model = small();
        let quaternion = nalgebra::Quaternion::new(2.0, 0.0, 0.0, 0.0);
        let stretching = Isometry3::from_parts(
            Vector3::zeros().into(),
            nalgebra::Unit::new_unchecked(quaternion),
        );
        model.add_view(ViewRecord { world_from_sensor: stretching, ..view("big") });
        assert_eq!(model.check(), Err(InvariantError::Pose("big".to_owned())));
    }
}
