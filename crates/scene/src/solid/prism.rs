//! Flat-faced solids from polygons: pyramids and prisms, as exact meshes.
//!
//! End faces are cut into triangles by clipping ears: a corner whose triangle holds no other corner
//! is cut off until three are left. O(n²) in practice and O(n³) at worst, for outlines drawn by
//! hand.

use super::SolidError;
use crate::{LARGEST, Mesh};
use transect_geometry::{Point2, Point3, Vector3};

/// Most corners of a polygon. Measured: with more corners, clipping ears takes seconds. Doubled, it
/// may take eight times as long.
const MOST_CORNERS: usize = 2048;

/// A pyramid on a rectangle, centred on its height's middle.
pub fn pyramid(size: Vector3) -> Mesh {
    let half = size * 0.5;
    let vertices = vec![
        Point3::new(-half.x, -half.y, -half.z),
        Point3::new(half.x, -half.y, -half.z),
        Point3::new(half.x, half.y, -half.z),
        Point3::new(-half.x, half.y, -half.z),
        Point3::new(0.0, 0.0, half.z),
    ];
    Mesh { vertices, faces: vec![[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]] }
}

/// A prism between two polygons, centred on its height's middle.
pub fn prism(bottom: &[Point2], top: &[Point2], height: f64) -> Result<Mesh, SolidError> {
    let runs_left = checked_area("bottom", bottom)? > 0.0;
    if top.len() != bottom.len() {
        let reason = "it must have as many corners as the bottom";
        return Err(bad("top", reason));
    }
    if (checked_area("top", top)? > 0.0) != runs_left {
        let reason = "it must run the same way round as the bottom";
        return Err(bad("top", reason));
    }
    let end = |polygon: &[Point2], z: f64| {
        let mut corners: Vec<_> = polygon.iter().map(|p| Point3::new(p.x, p.y, z)).collect();
        if !runs_left {
            corners.reverse();
        }
        corners
    };
    let (low, high) = (end(bottom, -0.5 * height), end(top, 0.5 * height));
    let floor = triangles("bottom", &low)?;
    let roof = triangles("top", &high)?;
    let count = low.len() as u32;
    let mut faces: Vec<_> = floor.into_iter().map(|[a, b, c]| [a, c, b]).collect();
    faces.extend(roof.into_iter().map(|face| face.map(|i| i + count)));
    for a in 0..count {
        let b = (a + 1) % count;
        faces.extend([[a, b, b + count], [a, b + count, a + count]]);
    }
    Ok(Mesh { vertices: low.into_iter().chain(high).collect(), faces })
}

fn bad(key: &'static str, reason: impl Into<String>) -> SolidError {
    SolidError::BadPolygon { key, reason: reason.into() }
}

/// Signed area of a polygon, positive if it runs counter-clockwise. A polygon that crosses or
/// touches itself is an error.
fn checked_area(key: &'static str, polygon: &[Point2]) -> Result<f64, SolidError> {
    let count = polygon.len();
    if !(3..=MOST_CORNERS).contains(&count) {
        let reason = format!("a polygon has at least 3 and at most {MOST_CORNERS} corners");
        return Err(bad(key, reason));
    }
    if !polygon.iter().all(|p| p.coords.iter().all(|c| c.abs() <= LARGEST)) {
        return Err(bad(key, format!("a corner is not finite, or beyond {LARGEST:e}")));
    }
    let edge = |i: usize| (polygon[i % count], polygon[(i + 1) % count]);
    // Neighbours share a corner; they must not run back over each other.
    let runs_back = |i: usize| {
        let ((a, b), (_, c)) = (edge(i), edge(i + 1));
        a == b || (turn(a, b, c) == 0.0 && (b - a).dot(&(c - b)) < 0.0)
    };
    if (0..count).any(runs_back) {
        return Err(bad(key, "two corners coincide or an edge runs back over its neighbour"));
    }
    let apart = |i: usize| i + 2..if i == 0 { count - 1 } else { count };
    if (0..count).any(|i| apart(i).any(|j| meet(edge(i), edge(j)))) {
        return Err(bad(key, "it crosses or touches itself"));
    }
    Ok((1..count - 1).map(|i| 0.5 * turn(polygon[0], polygon[i], polygon[i + 1])).sum())
}

/// Twice the signed area of a triangle: positive where the way over three points turns left.
fn turn(a: Point2, b: Point2, c: Point2) -> f64 {
    (b - a).perp(&(c - a))
}

/// Whether two segments have a point in common.
fn meet((a, b): (Point2, Point2), (c, d): (Point2, Point2)) -> bool {
    let apart = |p: f64, q: f64, r: f64, s: f64| p.max(q) < r.min(s) || r.max(s) < p.min(q);
    let crosses = |a, b, c, d| turn(a, b, c) * turn(a, b, d) <= 0.0;
    let boxes_meet = !apart(a.x, b.x, c.x, d.x) && !apart(a.y, b.y, c.y, d.y);
    boxes_meet && crosses(a, b, c, d) && crosses(c, d, a, b)
}

/// Triangles, counter-clockwise, of a polygon that runs counter-clockwise.
fn triangles(key: &'static str, corners: &[Point3]) -> Result<Vec<[u32; 3]>, SolidError> {
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut faces = Vec::with_capacity(corners.len() - 2);
    while left.len() > 2 {
        let ear = (0..left.len()).find(|&i| is_ear(corners, &left, i));
        // Every simple polygon has an ear; rounding may hide it in a nearly flat one.
        let Some(i) = ear else {
            return Err(bad(key, "it is too thin to be cut up"));
        };
        faces.push(around(&left, i).map(|corner| corner as u32));
        left.remove(i);
    }
    Ok(faces)
}

/// A corner with its two neighbours.
fn around(left: &[usize], i: usize) -> [usize; 3] {
    let count = left.len();
    [left[(i + count - 1) % count], left[i], left[(i + 1) % count]]
}

/// Whether a corner can be cut off: its triangle must hold no other corner, also not on the cut. So
/// corners in straight edges stay corners of a triangle, and the mesh stays closed.
fn is_ear(corners: &[Point3], left: &[usize], i: usize) -> bool {
    let flat = |k: usize| corners[k].xy();
    let ear = around(left, i);
    let [a, b, c] = ear.map(flat);
    let outside = |p| turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
    turn(a, b, c) > 0.0 && left.iter().filter(|k| !ear.contains(k)).all(|&k| outside(flat(k)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Vec<Point2> {
        corners.iter().map(|&c| Point2::from(c)).collect()
    }

    /// An angle bracket with a corner in the middle of a straight edge.
    fn bracket() -> Vec<Point2> {
        polygon(&[[0., 0.], [2., 0.], [4., 0.], [4., 1.], [1., 1.], [1., 3.], [0., 3.]])
    }

    #[test]
    fn a_concave_prism_is_closed_and_has_its_volume() {
        let mesh = prism(&bracket(), &bracket(), 2.0).unwrap();
        assert_eq!(mesh.check_closed(), Ok(()));
        assert!((mesh.signed_volume() - 12.0).abs() < 1e-12);
        let mut turned = bracket();
        turned.reverse();
        let again = prism(&turned, &turned, 2.0).unwrap();
        assert_eq!(again.check_closed(), Ok(()));
        assert!((again.signed_volume() - 12.0).abs() < 1e-12);
    }

    #[test]
    fn a_comb_and_a_star_are_cut_up() {
        let mut comb = polygon(&[[0., 0.], [20., 0.]]);
        comb.extend((0..20).flat_map(|k| {
            let x = 20.0 - f64::from(k);
            polygon(&[[x, 5.0], [x - 0.5, 1.0]])
        }));
        comb.push(Point2::new(0.0, 5.0));
        let mesh = prism(&comb, &comb, 1.0).unwrap();
        assert_eq!(mesh.check_closed(), Ok(()));
        let star: Vec<_> = (0..64)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 32.0).sin_cos();
                Point2::new(cos, sin) * if k % 2 == 0 { 3.0 } else { 0.5 }
            })
            .collect();
        assert_eq!(prism(&star, &star, 1.0).unwrap().check_closed(), Ok(()));
    }

    #[test]
    fn top_and_bottom_may_differ() {
        let square = |h: f64| polygon(&[[-h, -h], [h, -h], [h, h], [-h, h]]);
        let mesh = prism(&square(2.0), &square(1.0), 3.0).unwrap();
        assert_eq!(mesh.check_closed(), Ok(()));
        // A pyramid of height 6 without its upper half: 7/8 of 4 · 4 · 6 / 3.
        assert!((mesh.signed_volume() - 28.0).abs() < 1e-12);
    }

    #[test]
    fn bad_polygons_are_named() {
        let square = polygon(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        let triangle = polygon(&[[0., 0.], [1., 0.], [1., 1.]]);
        let reversed: Vec<_> = square.iter().rev().copied().collect();
        let bow = polygon(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]]);
        let touching = polygon(&[[0., 0.], [2., 0.], [2., 2.], [1., 0.], [0., 2.]]);
        let spike = polygon(&[[0., 0.], [2., 0.], [1., 0.], [0., 2.]]);
        let twice = polygon(&[[0., 0.], [1., 0.], [1., 0.], [0., 2.]]);
        let nan = polygon(&[[0., 0.], [1., 0.], [f64::NAN, 1.]]);
        for (bottom, top, expected) in [
            (&square, &triangle, "top: it must have as many corners"),
            (&square, &reversed, "top: it must run the same way"),
            (&bow, &square, "bottom: it crosses"),
            (&touching, &touching, "bottom: it crosses or touches"),
            (&spike, &square, "bottom: two corners coincide or an edge runs back"),
            (&twice, &square, "bottom: two corners coincide"),
            (&nan, &nan, "bottom: a corner is not finite"),
            (&Vec::new(), &square, "bottom: a polygon has at least 3"),
        ] {
            let found = prism(bottom, top, 1.0).unwrap_err().to_string();
            assert!(found.contains(expected), "{found}\nshould contain {expected}");
        }
    }
}
