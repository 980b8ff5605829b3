//! Exact sections of triangle meshes as oriented curves.
//!
//! Every vertex has a level, its height over plane 0 in plane intervals. It is high over plane `k`
//! if its level is **strictly above** `k`; on the plane counts as low. Each triangle with both
//! kinds then gives exactly one segment, from the edge it descends (high to low, in its winding)
//! to the edge it ascends, which puts the solid of an outward-wound mesh on the left. Neighbouring
//! triangles share an edge and therefore an end point, bit by bit: segments are linked by edge
//! keys, never by coordinates, so nothing is closed that the mesh leaves open.
//!
//! 1. Levels and plane coordinates of all vertices, once.
//! 2. Every triangle goes to the buckets of the planes it spans, once.
//! 3. Per plane: link segments into chains, open ones first, then closed ones.
//!
//! Time: O(vertices + segments · log segments), whatever the number of planes. Memory: 16 bytes per
//! segment. A face that lies in a plane gives the section just above it.

mod link;
mod merge;

pub use merge::merge_overlaps;

use crate::mesh::check_parts;
use crate::{Mesh, MeshError};
use link::{Chain, EdgeKey, Segment, link};
use std::collections::BTreeMap;
use transect_geometry::{Curve, Node, PlaneFamily, PlaneIndex, Point2, Point3};

/// Most section planes that a mesh may cross; more are taken for a wrong unit or interval.
pub const MAX_PLANES: usize = 1 << 24;

/// The section of a mesh by one plane; open curves where the mesh has holes.
///
/// # Errors
/// [`MeshError`] if a coordinate is not finite or a face names a missing vertex.
pub fn slice_mesh(
    vertices: &[Point3],
    faces: &[[u32; 3]],
    planes: &PlaneFamily,
    k: PlaneIndex,
) -> Result<Vec<Curve>, MeshError> {
    check_parts(vertices, faces)?;
    let lifted = lift(vertices, planes);
    let segments = faces.iter().filter_map(|face| crossing(face, &lifted, k.0 as f64));
    Ok(curves(segments.collect(), &lifted, k.0 as f64))
}

/// The sections of a mesh by all planes of a family that it crosses.
///
/// # Errors
/// [`MeshError`] if a coordinate is not finite, a face names a missing vertex, or the mesh crosses
/// more than [`MAX_PLANES`] planes.
pub fn sections(
    mesh: &Mesh,
    planes: &PlaneFamily,
) -> Result<BTreeMap<PlaneIndex, Vec<Curve>>, MeshError> {
    mesh.check()?;
    let lifted = lift(&mesh.vertices, planes);
    let (first, buckets) = bucket(&mesh.faces, &lifted)?;
    let cut = buckets.into_iter().zip(first..).filter(|(segments, _)| !segments.is_empty());
    Ok(cut.map(|(segments, k)| (PlaneIndex(k), curves(segments, &lifted, k as f64))).collect())
}

/// A vertex as the planes see it.
#[derive(Clone, Copy)]
struct Lifted {
    level: f64,
    in_plane: Point2,
}

/// All planes of a straight guide have one pair of axes and their origins on one normal, so plane
/// coordinates are the same in every plane.
fn lift(vertices: &[Point3], planes: &PlaneFamily) -> Vec<Lifted> {
    let frame = planes.frame(PlaneIndex(0));
    let one = |p: &Point3| Lifted { level: planes.level(p), in_plane: frame.plane_from_world(p) };
    vertices.iter().map(one).collect()
}

fn corners(face: &[u32; 3], lifted: &[Lifted]) -> [f64; 3] {
    face.map(|i| lifted.get(i as usize).map_or(f64::NAN, |v| v.level))
}

/// The segment in which a plane crosses a triangle.
fn crossing(face: &[u32; 3], lifted: &[Lifted], k: f64) -> Option<Segment> {
    let high = corners(face, lifted).map(|level| level > k);
    let edge = |descending: bool| {
        let side = (0..3).find(|&i| high[i] == descending && high[(i + 1) % 3] != descending)?;
        Some(EdgeKey::new(face[side], face[(side + 1) % 3]))
    };
    Some(Segment { from: edge(true)?, to: edge(false)? })
}

/// The segments of all planes; the first plane's number and a bucket for each from there on.
fn bucket(faces: &[[u32; 3]], lifted: &[Lifted]) -> Result<(i64, Vec<Vec<Segment>>), MeshError> {
    let used = faces.iter().flat_map(|face| corners(face, lifted));
    let (low, high) = used.fold((f64::MAX, f64::MIN), |(a, b), v| (v.min(a), v.max(b)));
    // Plane k is crossed if low <= k < high.
    let planes = high.ceil() - low.ceil();
    if planes > MAX_PLANES as f64 {
        return Err(MeshError::TooManyPlanes { planes, most: MAX_PLANES });
    }
    let first = low.ceil();
    let mut buckets = vec![Vec::new(); planes.max(0.0) as usize];
    for face in faces {
        let [a, b, c] = corners(face, lifted);
        let begin = (a.min(b).min(c).ceil() - first) as usize;
        let end = (a.max(b).max(c).ceil() - first) as usize;
        for (k, bucket) in (begin..).zip(buckets.get_mut(begin..end).unwrap_or_default()) {
            bucket.extend(crossing(face, lifted, first + k as f64));
        }
    }
    Ok((first as i64, buckets))
}

fn curves(segments: Vec<Segment>, lifted: &[Lifted], k: f64) -> Vec<Curve> {
    link(segments).into_iter().filter_map(|chain| curve(&chain, lifted, k)).collect()
}

/// The curve along a chain of mesh edges; `None` if it shrinks to less than a curve, as around a
/// vertex that lies on the plane.
fn curve(chain: &Chain, lifted: &[Lifted], k: f64) -> Option<Curve> {
    let mut points: Vec<_> = chain.edges.iter().filter_map(|e| edge_point(e, lifted, k)).collect();
    points.dedup();
    while chain.closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    Curve::new(points.into_iter().map(Node::at).collect(), chain.closed).ok()
}

/// Where a mesh edge meets the plane; the same bits from both sides of the edge.
fn edge_point(edge: &EdgeKey, lifted: &[Lifted], k: f64) -> Option<Point2> {
    let (a, b) = (lifted.get(edge.low() as usize)?, lifted.get(edge.high() as usize)?);
    let t = (k - a.level) / (b.level - a.level);
    // This form returns either end exactly.
    Some(Point2::from(a.in_plane.coords * (1.0 - t) + b.in_plane.coords * t))
}

#[cfg(test)]
mod tests;
