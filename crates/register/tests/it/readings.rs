//! Poses that were written by another convention are explained by it; sound ones are not.

use crate::common::{coarse, real, simulated, turned};
use proptest::prelude::*;
use transect_device::{Isometry3, Vector3, View};
use transect_register::{PoseReading, explain};

/// The pose that was written by a convention, as a program reads it that does not know it.
fn misread(written: PoseReading, pose: &Isometry3) -> Isometry3 {
    match written {
        PoseReading::Wxyz => PoseReading::Xyzw.apply(pose),
        PoseReading::Xyzw => PoseReading::Wxyz.apply(pose),
        PoseReading::Millimetres => PoseReading::Metres.apply(pose),
        PoseReading::Metres => PoseReading::Millimetres.apply(pose),
        PoseReading::Radians => {
            let degrees = pose.rotation.scaled_axis() * 1f64.to_radians();
            Isometry3::new(pose.translation.vector, degrees)
        }
        PoseReading::Degrees => {
            let radians = pose.rotation.scaled_axis() * 1f64.to_degrees();
            Isometry3::new(pose.translation.vector, radians)
        }
        other => other.apply(pose),
    }
}

/// All readings but one: degrees that are read as radians lose their full turns.
fn recoverable() -> impl Iterator<Item = PoseReading> {
    PoseReading::ALL.into_iter().filter(|reading| *reading != PoseReading::Degrees)
}

fn every_wrong_reading_is_named(name: &str, views: &[View]) {
    assert_eq!(explain(&coarse(views)), None, "{name}");
    for written in recoverable() {
        let misread = |v: &View| v.with_pose(misread(written, v.world_from_sensor())).unwrap();
        let found = explain(&coarse(&views.iter().map(misread).collect::<Vec<_>>()));
        assert_eq!(found.map(|e| e.reading), Some(written), "{name}: {found:?}");
    }
}

#[test]
fn wrong_readings_of_simulated_scans_are_named() {
    // The scanners of the tunnel are not turned at all: there, several readings are one.
    for name in ["room", "face_mask", "machined_part", "kitchen"] {
        every_wrong_reading_is_named(name, &simulated(name, ""));
    }
}

#[test]
fn wrong_readings_of_real_scans_are_named() {
    for name in ["rgbd_redkitchen", "stanford_bunny"] {
        if let Some(views) = real(name) {
            every_wrong_reading_is_named(name, &views);
        }
    }
}

#[test]
fn one_wrong_view_is_no_convention() {
    for scene in ["room", "face_mask"] {
        for degrees in [3.0, 30.0, 180.0] {
            let mut views = simulated(scene, "");
            views[1] = turned(&views[1], 1, degrees);
            assert_eq!(explain(&coarse(&views)), None, "{scene} by {degrees}");
        }
    }
}

#[test]
fn names_are_read_back_and_others_are_refused() {
    for reading in PoseReading::ALL {
        assert_eq!(reading.to_string().parse(), Ok(reading));
    }
    let refused = "nonsense".parse::<PoseReading>().unwrap_err();
    assert!(refused.starts_with("\"nonsense\" is no convention of poses"), "{refused}");
    assert!(refused.ends_with("metres, radians, degrees"), "{refused}");
}

#[test]
fn whole_degrees_survive_radians() {
    for degrees in [-170.0_f64, -45.0, 0.0, 1.0, 30.0, 179.0] {
        let right = Isometry3::new(Vector3::x(), Vector3::z() * degrees.to_radians());
        let read = PoseReading::Degrees.apply(&misread(PoseReading::Degrees, &right));
        assert!(read.rotation.angle_to(&right.rotation) < 1e-9, "{degrees}");
    }
}

proptest! {
    /// Each reading but the one of full turns is undone by its counterpart.
    #[test]
    fn readings_are_undone(
        turn in prop::array::uniform3(-1.7..1.7),
        shift in prop::array::uniform3(-5.0..5.0),
    ) {
        let pose = Isometry3::new(Vector3::from(shift), Vector3::from(turn));
        for written in recoverable() {
            let back = written.apply(&misread(written, &pose));
            prop_assert!(back.rotation.angle_to(&pose.rotation) < 1e-6, "{}", written);
            prop_assert!((back.translation.vector - pose.translation.vector).norm() < 1e-9);
        }
    }
}
