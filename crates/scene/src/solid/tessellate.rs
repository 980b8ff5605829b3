//! Shapes as triangle meshes with a bounded chord error.
//!
//! Vertices lie on the shape's surface, so a mesh of a convex round shape is inscribed. No point of
//! it is farther from the true surface than the chord error, and all of it is on the inner side. A
//! torus is saddle-shaped around its hole; its mesh keeps the chord error on either side there.

use super::{Frustum, Kind, Shape, Torus};
use crate::{Mesh, parry};
use std::f64::consts::{PI, TAU};
use transect_geometry::Point3;

/// Segments of a full circle, beyond which a ball would have more than 16 million faces.
const MOST_SEGMENTS: f64 = 4096.0;
/// Fewest segments of a full circle. Chosen by hand: a coarse ball is still recognisable. Doubled,
/// coarse meshes have four times as many faces.
const FEWEST_SEGMENTS: f64 = 8.0;

/// Smallest possible chord error of a shape of this radius, in the radius's unit.
pub(crate) fn smallest_chord_error(radius: f64) -> f64 {
    2.0 * radius * (1.0 - (PI / MOST_SEGMENTS).cos())
}

/// Segments of a circle whose sagitta stays within an error.
fn segments(radius: f64, sagitta: f64) -> u32 {
    let half_angle = (1.0 - (sagitta / radius).clamp(0.0, 1.0)).acos();
    (PI / half_angle).ceil().clamp(FEWEST_SEGMENTS, MOST_SEGMENTS) as u32
}

impl Shape {
    /// The largest radius of a curved surface; `None` for flat-faced shapes.
    pub(crate) fn radius(&self) -> Option<f64> {
        match self.0 {
            Kind::Ball { radius } => Some(radius),
            Kind::Frustum(Frustum { bottom, top, .. }) => Some(bottom.max(top)),
            Kind::Torus(Torus { radius, tube }) => Some(radius + tube),
            Kind::Box { .. } | Kind::Mesh(_) => None,
        }
    }

    /// The shape's surface in its own frame.
    pub(crate) fn mesh_of(&self, chord_error: f64) -> Mesh {
        match &self.0 {
            Kind::Box { half } => box_mesh(half.x, half.y, half.z),
            Kind::Frustum(frustum) => {
                frustum_mesh(frustum, segments(frustum.bottom.max(frustum.top), chord_error))
            }
            Kind::Torus(Torus { radius, tube }) => {
                // Half of the error along the ring, half around the tube.
                let along = segments(radius + tube, 0.5 * chord_error);
                torus_mesh(*radius, *tube, along, segments(*tube, 0.5 * chord_error))
            }
            // Half of the error along meridians, half along parallels.
            Kind::Ball { radius } => ball_mesh(*radius, segments(*radius, 0.5 * chord_error)),
            Kind::Mesh(surface) => Mesh {
                vertices: surface.vertices().iter().map(|&p| parry::from_point(p)).collect(),
                faces: surface.indices().to_vec(),
            },
        }
    }
}

fn box_mesh(x: f64, y: f64, z: f64) -> Mesh {
    // Bit 0 of a corner's number is its x side, bit 1 its y side, bit 2 its z side.
    let side =
        |corner: usize, bit: usize, half: f64| if corner >> bit & 1 == 1 { half } else { -half };
    let corner = |c: usize| Point3::new(side(c, 0, x), side(c, 1, y), side(c, 2, z));
    // Each quad counter-clockwise seen from outside.
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), faces }
}

fn frustum_mesh(frustum: &Frustum, segments: u32) -> Mesh {
    let Frustum { bottom, top, half_height } = *frustum;
    let ends = [Ring { radius: bottom, z: -half_height }, Ring { radius: top, z: half_height }];
    // A tip is the end point of the surface already.
    let rings: Vec<_> = ends.into_iter().filter(|ring| ring.radius > 0.0).collect();
    revolved(-half_height, &rings, half_height, segments)
}

fn torus_mesh(radius: f64, tube: f64, along: u32, around: u32) -> Mesh {
    let angle = |k: u32, count: u32| (TAU * f64::from(k) / f64::from(count)).sin_cos();
    let point = |k: u32| {
        let ((sin, cos), (up, out)) = (angle(k / around, along), angle(k % around, around));
        let from_axis = radius + tube * out;
        Point3::new(from_axis * cos, from_axis * sin, tube * up)
    };
    let vertex = |i: u32, j: u32| i % along * around + j % around;
    let quads = (0..along * around).flat_map(|k| {
        let (i, j) = (k / around, k % around);
        let (a, b, c) = (vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1));
        [[a, b, c], [a, c, vertex(i, j + 1)]]
    });
    Mesh { vertices: (0..along * around).map(point).collect(), faces: quads.collect() }
}

fn ball_mesh(radius: f64, segments: u32) -> Mesh {
    let count = segments.div_ceil(2);
    let ring = |k: u32| {
        let (sin, cos) = (PI * f64::from(k) / f64::from(count)).sin_cos();
        Ring { radius: radius * sin, z: -radius * cos }
    };
    let rings: Vec<_> = (1..count).map(ring).collect();
    revolved(-radius, &rings, radius, segments)
}

/// A circle around the z axis.
struct Ring {
    radius: f64,
    z: f64,
}

/// The surface from a bottom point on the axis over rings of rising z to a top point.
fn revolved(bottom: f64, rings: &[Ring], top: f64, segments: u32) -> Mesh {
    let mut vertices = vec![Point3::new(0.0, 0.0, bottom), Point3::new(0.0, 0.0, top)];
    for ring in rings {
        vertices.extend((0..segments).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(segments)).sin_cos();
            Point3::new(ring.radius * cos, ring.radius * sin, ring.z)
        }));
    }
    let last = (rings.len() as u32).saturating_sub(1);
    let vertex = |ring: u32, k: u32| 2 + ring * segments + k % segments;
    let mut faces = Vec::new();
    for k in 0..segments {
        faces.push([0, vertex(0, k + 1), vertex(0, k)]);
        for ring in 0..last {
            let (a, b) = (vertex(ring, k), vertex(ring, k + 1));
            let (c, d) = (vertex(ring + 1, k + 1), vertex(ring + 1, k));
            faces.extend([[a, b, c], [a, c, d]]);
        }
        faces.push([1, vertex(last, k), vertex(last, k + 1)]);
    }
    Mesh { vertices, faces }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::Vector3;

    #[test]
    fn all_meshes_are_closed_and_have_the_volume_of_their_shape() {
        let block = Shape::cuboid(Vector3::new(1.0, 2.0, 3.0)).unwrap();
        let can = Shape::cylinder(0.5, 2.0).unwrap();
        let ball = Shape::ball(2.0).unwrap();
        let cone = Shape::cone(0.5, 3.0).unwrap();
        let bucket = Shape::frustum(1.0, 2.0, 3.0).unwrap();
        let ring = Shape::torus(2.0, 0.5).unwrap();
        let pyramid = Shape::pyramid(Vector3::new(1.0, 2.0, 3.0)).unwrap();
        let shapes = [block, can, ball, cone, bucket, ring, pyramid];
        let volumes = [6.0, 0.5 * PI, 32.0 / 3.0 * PI, 0.25 * PI, 7.0 * PI, PI * PI, 2.0];
        for (shape, volume) in shapes.iter().zip(volumes) {
            let mesh = shape.mesh_of(1e-4);
            assert_eq!(mesh.check_closed(), Ok(()), "{shape:?}");
            let lost = 1.0 - mesh.signed_volume() / volume;
            assert!((-1e-12..1e-3).contains(&lost), "{shape:?} lost {lost}");
        }
    }

    #[test]
    fn a_torus_keeps_its_chord_error_on_both_sides() {
        let (radius, tube, error) = (2.0, 0.5, 1e-2);
        let mesh = Shape::torus(radius, tube).unwrap().mesh_of(error);
        let (mut inmost, mut outmost) = (0.0f64, 0.0f64);
        for face in &mesh.faces {
            let [a, b, c] = face.map(|i| mesh.vertices[i as usize].coords);
            for (u, v) in [(0.5, 0.5), (0.5, 0.0), (0.0, 0.5), (0.33, 0.33), (0.2, 0.4)] {
                let p = a * (1.0 - u - v) + b * u + c * v;
                let off = (p.x.hypot(p.y) - radius).hypot(p.z) - tube;
                (inmost, outmost) = (inmost.min(off), outmost.max(off));
            }
        }
        assert!(-error <= inmost && outmost <= error, "{inmost} to {outmost}");
        assert!(outmost > 0.1 * error && inmost < -0.5 * error, "the error is made use of");
    }

    #[test]
    fn a_ball_keeps_its_chord_error() {
        let (radius, error) = (0.7, 1e-3);
        let mesh = Shape::ball(radius).unwrap().mesh_of(error);
        for face in &mesh.faces {
            let [a, b, c] = face.map(|i| mesh.vertices[i as usize].coords);
            // The point of the face's plane nearest to the centre is as deep as the face can be.
            let normal = (b - a).cross(&(c - a)).normalize();
            let depth = radius - normal.dot(&a);
            assert!((0.0..=error).contains(&depth), "{depth}");
        }
    }
}
