//! Exact sections of triangle meshes as oriented curves.
//!
//! Every vertex has a level, its height over plane 0 in plane intervals. It is high over plane `k`
//! if its level is **strictly above** `k`; on the plane counts as low. Each triangle with both
//! kinds then gives exactly one segment. It runs from the edge it descends (high to low, in its
//! winding) to the edge it ascends. The solid of an outward-wound mesh is then on its left.
//! Neighbouring triangles share an edge and therefore an end point, bit by bit. Segments are linked
//! by edge keys, never by coordinates, so a gap in the mesh stays a gap in the section.
//!
//! 1. Levels and plane coordinates of all vertices, once.
//! 2. Every triangle goes to the buckets of the planes it spans, once.
//! 3. Per plane: link segments into chains, open ones first, then closed ones.
//!
//! Time: O(vertices + segments · log segments), whatever the number of planes. Memory: 16 bytes per
//! segment. A face that lies in a plane gives the section just above it.

mod link;
mod merge;

pub use merge::{MergeError, merge_overlaps};

use crate::{Mesh, MeshError};
use link::{Chain, EdgeKey, Segment, link};
use std::collections::BTreeMap;
use transect_geometry::{
    Curve, CurvedGuide, Node, PlaneFamily, PlaneFrame, PlaneIndex, Point2, Point3,
};

/// Most section planes that a mesh may cross. Chosen by hand: more planes mean a wrong unit or
/// interval. Doubled, a wrong unit may take twice the memory before it is refused.
pub const MAX_PLANES: usize = 1 << 24;

/// The sections of a mesh by all planes of a family that it crosses; open curves where the mesh has
/// holes.
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
    let ends = planes.ends();
    let exists = |k: i64| ends.is_none_or(|(a, b)| (a.0..=b.0).contains(&k));
    let cut = buckets.into_iter().zip(first..).filter(|(s, k)| !s.is_empty() && exists(*k));
    let curves_on = |segments, k| curves(segments, &Cut::new(planes, &lifted, &mesh.vertices, k));
    Ok(cut.map(|(segments, k)| (PlaneIndex(k), curves_on(segments, k))).collect())
}

/// A vertex in plane coordinates.
#[derive(Clone, Copy)]
struct Lifted {
    level: f64,
    in_plane: Point2,
}

/// The vertices along a curved guide. Points beyond its ends have a level beyond its planes; points
/// beyond its reach have none. Faces must be small relative to the guide's bends, because only
/// their corners get a level.
fn lift_along(guide: &CurvedGuide, vertices: &[Point3], planes: &PlaneFamily) -> Vec<Lifted> {
    let mut hint = None;
    let one = |p: &Point3| {
        let station = guide.extended_station(p, hint).ok();
        hint = station.or(hint);
        let level = station.map_or(f64::NAN, |s| (s - planes.offset()) / planes.interval());
        Lifted { level, in_plane: Point2::origin() }
    };
    vertices.iter().map(one).collect()
}

/// All planes of a straight guide have one pair of axes and their origins on one normal, so plane
/// coordinates are the same in every plane.
fn lift(vertices: &[Point3], planes: &PlaneFamily) -> Vec<Lifted> {
    if let Some(guide) = planes.guide().curved() {
        return lift_along(guide, vertices, planes);
    }
    let frame = planes.frame(PlaneIndex(0));
    let one = |p: &Point3| Lifted { level: planes.level(p), in_plane: frame.plane_from_world(p) };
    vertices.iter().map(one).collect()
}

fn corners(face: &[u32; 3], lifted: &[Lifted]) -> [f64; 3] {
    face.map(|i| lifted.get(i as usize).map_or(f64::NAN, |v| v.level))
}

/// The segment in which a plane crosses a triangle; `None` if a corner of the triangle has no
/// level.
fn crossing(face: &[u32; 3], lifted: &[Lifted], k: f64) -> Option<Segment> {
    let levels = corners(face, lifted);
    if levels.iter().any(|level| level.is_nan()) {
        return None;
    }
    let high = levels.map(|level| level > k);
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

fn curves(segments: Vec<Segment>, cut: &Cut<'_>) -> Vec<Curve> {
    link(segments).into_iter().filter_map(|chain| curve(&chain, cut)).collect()
}

/// One plane, and the mesh that it cuts.
struct Cut<'a> {
    lifted: &'a [Lifted],
    k: f64,
    /// Of a plane along a curved guide: its own frame, and the vertices in the world.
    turned: Option<(PlaneFrame, &'a [Point3])>,
}

impl<'a> Cut<'a> {
    fn new(planes: &PlaneFamily, lifted: &'a [Lifted], vertices: &'a [Point3], k: i64) -> Self {
        let curved = planes.guide().curved().is_some();
        let turned = curved.then(|| (planes.frame(PlaneIndex(k)), vertices));
        Self { lifted, k: k as f64, turned }
    }

    /// Where a mesh edge meets the plane; the same bits from both sides of the edge.
    fn edge_point(&self, edge: &EdgeKey) -> Option<Point2> {
        let (low, high) = (edge.low() as usize, edge.high() as usize);
        let (t, a, b) = if let Some((frame, vertices)) = &self.turned {
            let (a, b) = (vertices.get(low)?, vertices.get(high)?);
            let (below, above) = (frame.height(a), frame.height(b));
            // Stations decide the side of a vertex; heights may differ from them by rounding.
            let t = (below / (below - above)).clamp(0.0, 1.0);
            (t, frame.plane_from_world(a), frame.plane_from_world(b))
        } else {
            let (a, b) = (self.lifted.get(low)?, self.lifted.get(high)?);
            ((self.k - a.level) / (b.level - a.level), a.in_plane, b.in_plane)
        };
        // This form returns either end exactly.
        Some(Point2::from(a.coords * (1.0 - t) + b.coords * t))
    }
}

/// The curve along a chain of mesh edges; `None` if it shrinks to less than a curve, as around a
/// vertex that lies on the plane.
fn curve(chain: &Chain, cut: &Cut<'_>) -> Option<Curve> {
    let mut points: Vec<_> = chain.edges.iter().filter_map(|e| cut.edge_point(e)).collect();
    points.dedup();
    while chain.closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    Curve::new(points.into_iter().map(Node::at).collect(), chain.closed).ok()
}

#[cfg(test)]
mod tests;
