//! Small motions of views, and the distances between poses.

use crate::prior::PosePrior;
use nalgebra::{UnitQuaternion, Vector6};
use transect_device::Isometry3;

/// A rigid motion to first order: translation of the sensor, and rotation about it.
pub type Motion = Vector6<f64>;

/// The pose after a motion.
pub fn moved(world_from_sensor: &Isometry3, motion: &Motion) -> Isometry3 {
    let turn = UnitQuaternion::from_scaled_axis(motion.fixed_rows::<3>(3).into_owned());
    let shift = motion.fixed_rows::<3>(0).into_owned();
    let at = world_from_sensor.translation.vector + shift;
    Isometry3::from_parts(at.into(), turn * world_from_sensor.rotation)
}

/// The motion between two poses.
pub fn motion_between(from: &Isometry3, to: &Isometry3) -> Motion {
    let shift = to.translation.vector - from.translation.vector;
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

/// Standard deviation of each component of a motion.
pub fn sizes(prior: &PosePrior) -> [f64; 6] {
    let (t, r) = (prior.translation, prior.rotation);
    [t, t, t, r, r, r]
}
