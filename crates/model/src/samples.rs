//! Small models and curves that the tests of this crate share, and strategies for random ones.

use crate::{Model, ViewRecord};
use proptest::prelude::*;
use transect_geometry::{
    Curve, Isometry3, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, StraightGuide, Vector3,
};

pub(crate) fn polyline(points: &[(f64, f64)], closed: bool) -> Curve {
    let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, closed).unwrap()
}

/// A counter-clockwise rectangle: solid inside.
pub(crate) fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Curve {
    polyline(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)], true)
}

/// A counter-clockwise polygon of `n` nodes on a circle.
pub(crate) fn circle(centre: Point2, radius: f64, n: usize) -> Curve {
    let at = |i: usize| {
        let (sin, cos) = (i as f64 * std::f64::consts::TAU / n as f64).sin_cos();
        (centre.x + radius * cos, centre.y + radius * sin)
    };
    polyline(&(0..n).map(at).collect::<Vec<_>>(), true)
}

/// An open curve of three nodes along +x: solid above.
pub(crate) fn strip() -> Curve {
    polyline(&[(-3.0, -1.0), (-2.0, -1.0), (-1.0, -1.0)], false)
}

/// Horizontal planes at heights 0, 0.5, 1, …
pub(crate) fn family() -> PlaneFamily {
    let guide = StraightGuide::along(Vector3::z()).unwrap();
    PlaneFamily::new(guide, 0.0, 0.5).unwrap()
}

pub(crate) fn empty() -> Model {
    Model::new(LengthUnit::Millimetre, family())
}

pub(crate) fn view(name: &str) -> ViewRecord {
    let world_from_sensor = Isometry3::rotation(Vector3::new(0.1, 0.2, 0.3));
    let source = format!("{name}.npy");
    ViewRecord { name: name.to_owned(), source, world_from_sensor, sigma: Some(0.5), nodes: 11 }
}

/// Two planes with three curves, and a view: every kind of record in a few hundred bytes.
pub(crate) fn small() -> Model {
    let mut model = empty();
    model.set_curves(PlaneIndex(4), vec![rectangle(0.0, 0.0, 2.0, 1.0), strip()]);
    model.set_curves(PlaneIndex(-1), vec![rectangle(0.0, 0.0, 1.0, 1.0)]);
    model.add_view(view("first"));
    model
}

/// A star-shaped closed curve, counter-clockwise, with radii in `radii` about `centre`.
pub(crate) fn stars(centre: (f64, f64), radii: (f64, f64)) -> impl Strategy<Value = Curve> {
    prop::collection::vec(radii.0..radii.1, 3..40).prop_map(move |radii| {
        let step = std::f64::consts::TAU / radii.len() as f64;
        let at = |(i, r): (usize, &f64)| {
            let (sin, cos) = (i as f64 * step).sin_cos();
            (centre.0 + r * cos, centre.1 + r * sin)
        };
        polyline(&radii.iter().enumerate().map(at).collect::<Vec<_>>(), true)
    })
}

/// Two rings of solid, each with a hole, next to each other; nothing touches anything.
///
/// A star of n nodes dips to `cos(pi / n)` of its smallest radius between nodes, at worst a half.
pub(crate) fn rings() -> impl Strategy<Value = Vec<Curve>> {
    let ring = |x: f64| (stars((x, 0.0), (0.5, 0.9)), stars((x, 0.0), (0.05, 0.2)));
    (ring(0.0), ring(2.0))
        .prop_map(|((a, hole_a), (b, hole_b))| vec![a, hole_a.reversed(), b, hole_b.reversed()])
}

/// Open and closed random polylines, wild enough to cross themselves and each other.
pub(crate) fn tangles() -> impl Strategy<Value = Vec<Curve>> {
    let points = prop::collection::vec((-2.0..2.0, -2.0..2.0), 3..12);
    let curve = (points, any::<bool>()).prop_map(|(points, closed)| polyline(&points, closed));
    prop::collection::vec(curve, 1..6)
}
