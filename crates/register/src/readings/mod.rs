//! Other readings of the same poses: what the numbers of a file may have meant.
//!
//! **Problem.** A file of poses states no convention. Read by the wrong one, its poses are sound
//! rigid motions, and no two views agree.
//!
//! **Idea.** Each reading turns a pose that was read by this program into the pose that the same
//! numbers have under another convention.

mod explain;

pub use explain::{Accord, Explanation, explain};

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::str::FromStr;
use transect_device::{Isometry3, Vector3};

/// Distance of an angle in degrees from a whole number that counts as rounding. In degrees. Chosen
/// by hand: poses are written with six digits or more. Doubled, one angle in fifty passes that is
/// not whole.
const WHOLE: f64 = 1e-4;

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
    /// The rotations are vectors in radians along the axis, and were read as degrees.
    Radians,
    /// The rotations are vectors in degrees along the axis, and were read as radians.
    Degrees,
}

impl PoseReading {
    /// Every reading.
    pub const ALL: [Self; 9] = [
        Self::Inverse,
        Self::Conjugate,
        Self::Wxyz,
        Self::Xyzw,
        Self::CameraYUp,
        Self::Millimetres,
        Self::Metres,
        Self::Radians,
        Self::Degrees,
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
            Self::Degrees => "degrees",
        }
    }

    /// What the reading takes the poses for, as a sentence without a full stop.
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
            Self::Degrees => "the rotations are in degrees, not in radians",
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
        let scaled =
            |factor: f64| UnitQuaternion::from_scaled_axis(pose.rotation.scaled_axis() * factor);
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
            Self::Radians => turned(scaled(1f64.to_degrees())),
            Self::Degrees => turned(degrees(&pose.rotation)),
        }
    }
}

/// The rotation whose vector in degrees was read as radians.
///
/// Full turns of the wrong angle are lost: 45 radians and 45 - 14 pi look alike. Of the angles up
/// to 180 that look alike, the one closest to a whole number is taken if it is [`WHOLE`]:
/// turntables stop there. Otherwise it is the smallest.
fn degrees(wrong: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let Some((axis, smallest)) = wrong.axis_angle() else { return *wrong };
    let turns = (-28..=28).map(|k| smallest + f64::from(k) * TAU);
    let off = |angle: &f64| (angle - angle.round()).abs();
    let whole = turns.filter(|a| a.abs() <= 180.0).min_by(|a, b| off(a).total_cmp(&off(b)));
    let angle = whole.filter(|angle| off(angle) < WHOLE).unwrap_or(smallest);
    UnitQuaternion::from_axis_angle(&axis, angle.to_radians())
}

impl fmt::Display for PoseReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for PoseReading {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|reading| reading.name() == name).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|reading| reading.name()).collect();
            format!("{name:?} is no convention of poses; expected one of {}", names.join(", "))
        })
    }
}
