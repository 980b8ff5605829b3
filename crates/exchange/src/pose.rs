//! Rigid motions from the numbers in files.

use crate::Place;
use nalgebra::{Matrix3, Quaternion, Rotation3, SVD, Translation3, UnitQuaternion};
use std::path::Path;
use transect_device::Note;
use transect_geometry::Isometry3;

/// Deviation from orthonormality that is rounding of printed `f64` numbers.
const ROUNDING: f64 = 1e-9;
/// Deviation that is rounding of few printed digits or of `f32`; beyond, the matrix is no rotation.
/// Ten times this would let a shear of 0.1 rad pass for rounding.
const REPAIRABLE: f64 = 1e-2;
/// Largest deviation of the last row from 0 0 0 1 that is rounding. No unit. Six printed digits
/// round by up to 5e-7, and an inversion in `f32` by a few 1e-7. Doubled, nothing changes. At 1e-2,
/// a transposed pose whose translation is 1 cm passes for a pose without a translation.
const ROW_ROUNDING: f64 = 1e-6;
/// Largest deviation of a quaternion's length from 1 that counts as rounding of printed digits.
/// Chosen by hand. Doubled, a note about a normalised quaternion may be missing.
const QUATERNION_ROUNDING: f64 = 1e-3;

/// A pose, and how far its matrix was from a rotation if it had to be repaired.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pose {
    pub(crate) world_from_sensor: Isometry3,
    /// Largest entry of |RᵀR − 1|, or deviation of the last row if that is larger.
    pub(crate) repaired: Option<f64>,
}

/// The pose of a row-major homogeneous matrix, sensor to world.
///
/// A matrix that is almost a rotation is replaced by the nearest one (the polar factor, from the
/// singular value decomposition). A last row that is almost 0 0 0 1 is replaced by it. The error is
/// a sentence for the caller to put after the place.
pub(crate) fn from_row_major(numbers: &[f64; 16]) -> Result<Pose, String> {
    let [a, b, c, x, d, e, f, y, g, h, i, z, last @ ..] = *numbers;
    if !numbers.iter().all(|n| n.is_finite()) {
        return Err("the pose has a number that is not finite".to_owned());
    }
    let row = last.iter().zip([0.0, 0.0, 0.0, 1.0]).map(|(n, wanted)| (n - wanted).abs());
    let row = row.fold(0.0, f64::max);
    if row > ROW_ROUNDING {
        return Err(format!("the last row of the pose is {last:?}, not 0 0 0 1"));
    }
    let matrix = Matrix3::new(a, b, c, d, e, f, g, h, i);
    let deviation = (matrix.transpose() * matrix - Matrix3::identity()).amax();
    if !deviation.is_finite() || deviation > REPAIRABLE {
        return Err(format!(
            "the pose is no rotation: its columns deviate from orthonormal by {deviation:.2e}, \
             more than {REPAIRABLE}"
        ));
    }
    if matrix.determinant() < 0.0 {
        return Err("the pose is a reflection: its determinant is negative".to_owned());
    }
    let deviation = deviation.max(row);
    let exact = deviation <= ROUNDING;
    let rotation = if exact { matrix } else { nearest_rotation(matrix).unwrap_or(matrix) };
    let unit = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    // The conversion of a matrix with a deviation gives a quaternion with one.
    let rotation = UnitQuaternion::new_normalize(unit.into_inner());
    let world_from_sensor = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
    Ok(Pose { world_from_sensor, repaired: (!exact).then_some(deviation) })
}

/// The pose of a row-major homogeneous matrix, sensor to world, as a person would give it. A matrix
/// that is almost a rotation is replaced by the nearest one; its deviation is returned, too.
///
/// # Errors
/// A sentence: why it is no rigid motion.
pub fn pose_of_row_major(numbers: &[f64; 16]) -> Result<(Isometry3, Option<f64>), String> {
    from_row_major(numbers).map(|pose| (pose.world_from_sensor, pose.repaired))
}

/// Largest deviation of a quaternion's length from 1 in formats of unit quaternions. Chosen by
/// hand: TUM prints four digits. Doubled, a damaged quaternion passes for a rotation.
const UNIT_QUATERNION: f64 = 0.01;

/// The pose of a translation and a quaternion of length 1.
///
/// # Errors
/// A sentence for the caller to put after the place.
pub(crate) fn from_unit_quaternion(
    translation: [f64; 3],
    q: Quaternion<f64>,
) -> Result<Isometry3, String> {
    let (pose, _) = from_quaternion(translation, q)?;
    let length = q.norm();
    if (length - 1.0).abs() > UNIT_QUATERNION {
        return Err(format!("the quaternion has length {length}; a rotation has length 1"));
    }
    Ok(pose)
}

/// The pose of a translation and a quaternion of any length, with a note if it was normalised.
///
/// # Errors
/// A sentence for the caller to put after the place.
pub(crate) fn from_quaternion(
    translation: [f64; 3],
    q: Quaternion<f64>,
) -> Result<(Isometry3, Option<String>), String> {
    if !translation.iter().chain(q.coords.iter()).all(|n| n.is_finite()) {
        return Err("the pose has a number that is not finite".to_owned());
    }
    let length = q.norm();
    if !(length.is_finite() && length > 0.0) {
        return Err(format!("the quaternion has length {length}, which is no rotation"));
    }
    let rotation = UnitQuaternion::new_normalize(q);
    let normalised = (length - 1.0).abs() > QUATERNION_ROUNDING;
    let note = normalised.then(|| format!("quaternion of length {length:.4} normalised"));
    Ok((Isometry3::from_parts(Translation3::from(translation), rotation), note))
}

/// One note about all poses that were replaced by the nearest rotation.
pub(crate) fn repairs_note(path: &Path, repairs: &[(f64, Place)], views: usize) -> Option<Note> {
    let (worst, at) = repairs.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let count = repairs.len();
    let text = format!(
        "{count} of {views} poses replaced by the nearest rotation; \
         largest deviation from orthonormal {worst:.1e}{at}"
    );
    Some(Note::about(path.display(), text))
}

/// The polar factor U Vᵀ; `None` if the decomposition does not converge.
fn nearest_rotation(matrix: Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = SVD::try_new(matrix, true, true, f64::EPSILON, 100)?;
    Some(svd.u? * svd.v_t?)
}

/// The row-major homogeneous matrix of a pose, as manifests hold it.
pub fn row_major(world_from_sensor: &Isometry3) -> [f64; 16] {
    let matrix = world_from_sensor.to_homogeneous().transpose();
    let mut numbers = [0.0; 16];
    for (n, value) in numbers.iter_mut().zip(matrix.iter()) {
        *n = *value;
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_geometry::Vector3;

    fn poses() -> impl Strategy<Value = Isometry3> {
        (prop::array::uniform3(-3.0..3.0), prop::array::uniform3(-6e6..6e6))
            .prop_map(|(axis, t)| Isometry3::new(Vector3::from(t), Vector3::from(axis)))
    }

    proptest! {
        #[test]
        fn writing_a_pose_and_reading_it_returns_it(pose in poses()) {
            let back = from_row_major(&row_major(&pose)).unwrap();
            prop_assert!(back.repaired.is_none());
            prop_assert_eq!(back.world_from_sensor.translation, pose.translation);
            prop_assert!(back.world_from_sensor.rotation.angle_to(&pose.rotation) < 1e-7);
            let difference = back.world_from_sensor.to_homogeneous() - pose.to_homogeneous();
            prop_assert!(difference.amax() < 1e-14);
        }

        #[test]
        fn rounded_rotations_are_repaired_to_the_nearest(
            pose in poses(), noise in prop::array::uniform9(-1e-3..1e-3),
        ) {
            let mut numbers = row_major(&pose);
            for (k, n) in noise.iter().enumerate() {
                numbers[k / 3 * 4 + k % 3] += n;
            }
            let back = from_row_major(&numbers).unwrap();
            prop_assert!(back.repaired.is_some_and(|d| d < 1e-2));
            let r = back.world_from_sensor.rotation.to_rotation_matrix();
            let moved = (r.matrix() - pose.rotation.to_rotation_matrix().matrix()).amax();
            prop_assert!(moved < 3e-3, "moved by {}", moved);
        }
    }

    #[test]
    fn a_last_row_that_differs_by_rounding_is_repaired() {
        let pose = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, 0.2, -0.1));
        for (by, is_noted) in [(1e-16, false), (1e-10, false), (1e-7, true), (9e-7, true)] {
            for at in 12..16 {
                let mut numbers = row_major(&pose);
                numbers[at] -= by;
                let back = from_row_major(&numbers).unwrap();
                let moved = back.world_from_sensor.to_homogeneous() - pose.to_homogeneous();
                assert!(moved.amax() < 1e-14, "{at}: {by}");
                assert_eq!(back.repaired.is_some(), is_noted, "{at}: {by}");
            }
        }
    }

    #[test]
    fn matrices_that_are_no_pose_are_told_apart() {
        let identity = row_major(&Isometry3::identity());
        let with = |at: usize, value: f64| {
            let mut numbers = identity;
            numbers[at] = value;
            from_row_major(&numbers).map(|p| p.world_from_sensor).unwrap_err()
        };
        assert_eq!(with(3, f64::NAN), "the pose has a number that is not finite");
        assert_eq!(with(13, 2.0), "the last row of the pose is [0.0, 2.0, 0.0, 1.0], not 0 0 0 1");
        assert!(with(15, 1.0 - 2e-6).starts_with("the last row of the pose is [0.0, 0.0, 0.0, 0."));
        assert_eq!(with(0, -1.0), "the pose is a reflection: its determinant is negative");
        assert!(with(0, 1.1).starts_with("the pose is no rotation: its columns deviate"));
        assert!(with(0, 1e200).starts_with("the pose is no rotation"));
        assert!(with(0, 1e-3).starts_with("the pose is no rotation"));
    }
}
