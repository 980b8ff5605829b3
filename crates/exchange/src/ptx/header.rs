//! The ten lines before the points of a scan.

use super::lines::Lines;
use crate::{Place, ReadError, pose};
use nalgebra::{Matrix3, Vector3};
use transect_device::ImageSize;
use transect_geometry::{Isometry3, Point3};

/// Largest deviation of an axis' length from 1 that is rounding of printed digits. Ten times the
/// step of four decimals. Doubled, a scale that is 0.2 % off 1 is left out of the points.
const SCALE_ROUNDING: f64 = 1e-3;

/// Largest deviation of a matrix from a rotation that is rounding of its printed digits. Theory:
/// six decimals deviate by up to 2e-6; this is five times as much. Doubled, no note tells of a
/// repaired pose that deviates by 2e-5, which moves points 100 m away by a millimetre.
const PRINTED: f64 = 1e-5;

/// The facts of a scan's header.
#[derive(Debug, Clone)]
pub(super) struct Header {
    pub(super) size: ImageSize,
    pub(super) world_from_sensor: Isometry3,
    /// The scanner's stated place in the frame of the points: the origin, unless they are in the
    /// world's frame.
    pub(super) scanner: Point3,
    /// Factors of the coordinates x, y and z, which the matrix applies before the rotation.
    pub(super) scale: Vector3<f64>,
    pub(super) notes: Vec<String>,
}

impl Header {
    /// Reads the header of the scan `at`.
    pub(super) fn read(lines: &mut Lines, at: &Place) -> Result<Self, ReadError> {
        let cols = count(lines, at, "the number of columns")?;
        let rows = count(lines, at, "the number of rows")?;
        let size = ImageSize { rows, cols };
        let place: [f64; 3] = lines.numbers(at, "the scanner's position: x y z", 3..=3)?;
        for axis in ["x", "y", "z"] {
            let wanted = format!("the scanner's {axis} axis: three numbers");
            let _axis: [f64; 3] = lines.numbers(at, &wanted, 3..=3)?;
        }
        let mut matrix = [[0.0; 4]; 4];
        for (line, row) in (1..).zip(&mut matrix) {
            *row = lines.numbers(at, &format!("line {line} of the 4 × 4 matrix"), 4..=4)?;
        }
        let motion = Motion::of(&matrix).map_err(|problem| lines.problem(at, &problem))?;
        let Motion { world_from_sensor, scale, notes } = motion;
        let scanner = world_from_sensor.inverse_transform_point(&Point3::from(place));
        Ok(Self { size, world_from_sensor, scanner, scale, notes })
    }
}

fn count(lines: &mut Lines, at: &Place, wanted: &str) -> Result<usize, ReadError> {
    let [number] = lines.numbers(at, wanted, 1..=1)?;
    // A cast of a negative number, of a fraction or of a huge number changes it.
    let count = number as usize;
    if count as f64 == number && number < f64::from(u32::MAX) {
        return Ok(count);
    }
    Err(lines.problem(at, &format!("found {number}; expected {wanted}; correct the line")))
}

/// The matrix of a scan as a scale of the coordinates and a rigid motion.
#[derive(Debug)]
struct Motion {
    world_from_sensor: Isometry3,
    scale: Vector3<f64>,
    notes: Vec<String>,
}

impl Motion {
    /// Splits (x y z 1) · M. The lengths of the first three lines are the scale: a scan in
    /// millimetres has 0.001. Shears and reflections are refused.
    fn of(m: &[[f64; 4]; 4]) -> Result<Self, String> {
        let [[a, b, c, p], [d, e, f, q], [g, h, i, r], [x, y, z, one]] = *m;
        if [p, q, r, one] != [0.0, 0.0, 0.0, 1.0] {
            let last = [p, q, r, one];
            return Err(format!("the 4th column of the matrix is {last:?}; expected 0 0 0 1"));
        }
        let axes = Matrix3::new(a, b, c, d, e, f, g, h, i);
        let lengths = Vector3::from_fn(|k, _| axes.row(k).norm());
        let (mut scale, mut notes) = (Vector3::repeat(1.0), Vec::new());
        if (lengths - scale).amax() > SCALE_ROUNDING && lengths.iter().all(|n| *n > 0.0) {
            let [x, y, z] = lengths.into();
            notes.push(format!("the matrix scales x, y and z by {x}, {y} and {z}; applied"));
            scale = lengths;
        }
        // The transpose of the axes, because the pose multiplies columns.
        let axis = |k: usize| axes.row(k) / scale.get(k).copied().unwrap_or(1.0);
        let (u, v, w) = (axis(0), axis(1), axis(2));
        let numbers = [u.x, v.x, w.x, x, u.y, v.y, w.y, y, u.z, v.z, w.z, z, 0.0, 0.0, 0.0, 1.0];
        let pose = pose::from_row_major(&numbers).map_err(|problem| {
            format!(
                "{problem}; the lines of the matrix are {a} {b} {c}, {d} {e} {f}, {g} {h} {i}; \
                 export the scan with a rigid pose"
            )
        })?;
        let note = |by| format!("pose replaced by the nearest rotation; it deviated by {by:.1e}");
        notes.extend(pose.repaired.filter(|by| *by > PRINTED).map(note));
        Ok(Self { world_from_sensor: pose.world_from_sensor, scale, notes })
    }
}
