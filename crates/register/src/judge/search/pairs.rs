//! Pairs of points with normals, found by what does not depend on their pose.

use super::points::Oriented;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use rayon::prelude::*;
use transect_device::Isometry3;

/// Distance of a pair's points, over the spacing: least and largest. No unit. Chosen by hand: a
/// nearer pair tells the turn badly, and half a view is 25 wide. Doubled, few pairs are left.
const DISTANCES: [f64; 2] = [5.0, 25.0];

/// Step by which these are counted, over the spacing. No unit. Chosen by hand: points of one
/// surface are thinned to other places, half a spacing away. Doubled, more pairs seem alike.
const DISTANCE_STEP: f64 = 2.0;

/// Step of the angles, in degrees. Chosen by hand: what half a spacing turns in the nearest pairs,
/// with room for bent surfaces. Doubled, more pairs seem alike.
const ANGLE_STEP_DEGREES: f64 = 15.0;

/// Largest cosine between a pair's line or second normal and its first normal. No unit. Chosen by
/// hand: 18 degrees, within which they tell no direction. Doubled, there is no limit.
const LARGEST_COSINE: f64 = 0.95;

/// A pair of points.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Its distance and its three angles, in steps.
    key: u32,
    /// World coordinates from those of the pair: origin in its middle, x along the first normal, y
    /// towards the second point.
    pub frame: Isometry3,
}

impl Shape {
    fn new(a: &Oriented, b: &Oriented, spacing: f64) -> Option<Self> {
        let key = key(a, b, spacing)?;
        let z = a.normal.cross(&(b.point - a.point)).normalize();
        let axes = Matrix3::from_columns(&[a.normal, z.cross(&a.normal), z]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let middle = nalgebra::center(&a.point, &b.point);
        Some(Self { key, frame: Isometry3::from_parts(Translation3::from(middle.coords), turn) })
    }

    /// Pairs of points, so many at most.
    pub fn of_all(points: &[Oriented], spacing: f64, most: usize) -> Vec<Self> {
        let after = |gap: usize| points.iter().zip(points.iter().cycle().skip(gap));
        let pairs = (1..points.len()).flat_map(after);
        pairs.filter_map(|(a, b)| Self::new(a, b, spacing)).take(most).collect()
    }
}

/// What pairs of one shape have in common; `None` for a pair that does not fix a pose.
fn key(a: &Oriented, b: &Oriented, spacing: f64) -> Option<u32> {
    let between = b.point - a.point;
    let steps = between.norm() / spacing;
    let [least, largest] = DISTANCES;
    if steps < least || steps > largest {
        return None;
    }
    let along = between.normalize();
    let (of_line, of_normals) = (a.normal.dot(&along), a.normal.dot(&b.normal));
    if of_line.abs() > LARGEST_COSINE || of_normals.abs() > LARGEST_COSINE {
        return None;
    }
    let angle =
        |cosine: f64| (cosine.clamp(-1.0, 1.0).acos().to_degrees() / ANGLE_STEP_DEGREES) as u32;
    let angles = [of_line, b.normal.dot(&along), of_normals].map(angle);
    let distance = (steps / DISTANCE_STEP) as u32;
    Some(angles.into_iter().fold(distance, |key, angle| key << 4 | angle))
}

/// All pairs of some points, by their shape.
pub struct PairTable<'a> {
    points: &'a [Oriented],
    spacing: f64,
    /// Key, and the two points.
    pairs: Vec<(u32, u16, u16)>,
}

impl<'a> PairTable<'a> {
    /// Of 65 535 points at most.
    pub fn new(points: &'a [Oriented], spacing: f64) -> Self {
        let numbered = || points.iter().zip(0..=u16::MAX);
        let with = |(a, i): (&'a Oriented, u16)| {
            numbered().filter_map(move |(b, j)| Some((key(a, b, spacing)?, i, j)))
        };
        let first: Vec<_> = numbered().collect();
        let mut pairs: Vec<_> = first.into_par_iter().flat_map_iter(with).collect();
        pairs.par_sort_unstable();
        Self { points, spacing, pairs }
    }

    /// The frames of pairs of a shape, so many at most, evenly over them.
    pub fn matches(&self, shape: &Shape, most: usize) -> impl Iterator<Item = Isometry3> {
        let from = self.pairs.partition_point(|(key, ..)| *key < shape.key);
        let to = self.pairs.partition_point(|(key, ..)| *key <= shape.key);
        let step = (to - from).div_ceil(most).max(1);
        let alike = self.pairs.iter().take(to).skip(from).step_by(step);
        alike.filter_map(|(_, a, b)| {
            let [a, b] = [a, b].map(|k| self.points.get(usize::from(*k)));
            Some(Shape::new(a?, b?, self.spacing)?.frame)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_device::{Point3, Vector3};

    fn oriented() -> impl Strategy<Value = Oriented> {
        let number = || prop::array::uniform3(-1.0..1.0_f64);
        (number(), number()).prop_filter_map("a direction", |(point, normal)| {
            let normal = Vector3::from(normal).try_normalize(0.1)?;
            Some(Oriented { point: Point3::from(10.0 * Vector3::from(point)), normal })
        })
    }

    proptest! {
        #[test]
        fn matches_of_a_moved_pair_tell_the_motion(
            points in prop::collection::vec(oriented(), 12),
            shift in prop::array::uniform3(-5.0..5.0_f64),
            turn in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let motion = Isometry3::new(Vector3::from(shift), Vector3::from(turn));
            let moved: Vec<Oriented> = points.iter().map(|p| p.moved(&motion)).collect();
            let table = PairTable::new(&moved, 1.0);
            for shape in Shape::of_all(&points, 1.0, 20) {
                let mut poses = table.matches(&shape, 1000).map(|f| f * shape.frame.inverse());
                let is_motion = |pose: Isometry3| {
                    (pose.to_homogeneous() - motion.to_homogeneous()).norm() < 1e-6
                };
                // A pair at the edge of a step may count as one of the next step.
                let at_edge = Shape::of_all(&moved, 1.0, 1000).iter().all(|m| m.key != shape.key);
                prop_assert!(at_edge || poses.any(is_motion));
            }
        }
    }
}
