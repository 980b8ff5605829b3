//! Other readings of the same poses: what the numbers of a file may have meant.
//!
//! **Problem.** A file of poses states no convention. Read by the wrong one, its poses are sound
//! rigid motions, and no two views agree.
//!
//! **Idea.** Each reading turns a pose that was read by this program into the pose that the same
//! numbers have under another convention.

mod accord;
mod distances;
mod find_reading;

pub use accord::Accord;
pub use find_reading::{FoundReading, Reading, StatedPoses, find_reading};

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use std::f64::consts::PI;
use std::fmt;
use transect_device::{Isometry3, Vector3};

/// A convention by which the poses of a scan may have been written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseReading {
    /// The poses are sensor from world, and were read as world from sensor.
    Inverse,
    /// The quaternions rotate the other way round; the positions are right.
    Conjugate,
    /// The quaternions were written w, x, y, z, and were read as x, y, z, w.
    Wxyz,
    /// The quaternions were written x, y, z, w, and were read as w, x, y, z.
    Xyzw,
    /// In the cameras x points right, y up and z back (OpenGL, Blender), where this program's
    /// cameras have x right, y down and z forward.
    CameraYUp,
    /// The positions are millimetres in a scan whose unit is the metre.
    Millimetres,
    /// The positions are metres in a scan whose unit is the millimetre.
    Metres,
    /// The rotations are vectors along the axis in radians, and the writer of the poses took them
    /// for degrees. The reverse cannot be read: full turns of 57 times the angle are lost.
    Radians,
}

impl PoseReading {
    /// Every reading.
    pub const ALL: [Self; 8] = [
        Self::Inverse,
        Self::Conjugate,
        Self::Wxyz,
        Self::Xyzw,
        Self::CameraYUp,
        Self::Millimetres,
        Self::Metres,
        Self::Radians,
    ];

    /// The name by which options and reports call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inverse => "inverse",
            Self::Conjugate => "conjugate",
            Self::Wxyz => "wxyz",
            Self::Xyzw => "xyzw",
            Self::CameraYUp => "camera-y-up",
            Self::Millimetres => "millimetres",
            Self::Metres => "metres",
            Self::Radians => "radians",
        }
    }

    /// The assumption of the reading about the poses, as a sentence without a full stop.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Inverse => "the poses are sensor from world, not world from sensor",
            Self::Conjugate => "the quaternions rotate the other way round",
            Self::Wxyz => "the quaternions are written w, x, y, z, not x, y, z, w",
            Self::Xyzw => "the quaternions are written x, y, z, w, not w, x, y, z",
            Self::CameraYUp => "the cameras' y axis points up and their z axis back",
            Self::Millimetres => "the positions are in millimetres, the images in metres",
            Self::Metres => "the positions are in metres, the images in millimetres",
            Self::Radians => "the rotations are in radians, not in degrees",
        }
    }

    /// The pose under this reading, from the pose that this program read.
    pub fn apply(self, pose: &Isometry3) -> Isometry3 {
        let turned = |rotation| Isometry3::from_parts(pose.translation, rotation);
        let moved = |scale: f64| {
            let translation = Translation3::from(pose.translation.vector * scale);
            Isometry3::from_parts(translation, pose.rotation)
        };
        // The numbers in the order in which this program keeps them: x, y, z, w.
        let [x, y, z, w]: [f64; 4] = pose.rotation.into_inner().coords.into();
        let unit = |w, x, y, z| UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        match self {
            Self::Inverse => pose.inverse(),
            Self::Conjugate => turned(pose.rotation.inverse()),
            Self::Wxyz => turned(unit(x, y, z, w)),
            Self::Xyzw => turned(unit(z, w, x, y)),
            Self::CameraYUp => {
                let half_turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
                turned(pose.rotation * half_turn)
            }
            Self::Millimetres => moved(0.001),
            Self::Metres => moved(1000.0),
            Self::Radians => {
                let vector = pose.rotation.scaled_axis() * 1f64.to_degrees();
                turned(UnitQuaternion::from_scaled_axis(vector))
            }
        }
    }
}

impl fmt::Display for PoseReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
