//! Views weigh less where they saw a surface obliquely, if and as far as they err more there.

use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, consensus};
use transect_geometry::{Curve, Node, Point2};

const SPACING: f64 = 0.02;
const SIGMA: f64 = 0.0005;
const ERROR: f64 = 0.003;

/// How obliquely a view may see the circle.
const LARGEST_INCIDENCE_DEG: f64 = 72.0;

/// The arc of a circle of radius 1 that a view sees from afar. All of it errs in common, by an
/// amount that follows from the tangent of the incidence.
fn arc(view: u32, error: impl Fn(f64) -> f64, is_known: bool) -> Vec<Curve> {
    let from = TAU * f64::from(view) / 10.0;
    let most = LARGEST_INCIDENCE_DEG.to_radians();
    let count = (2.0 * most / SPACING) as u32;
    let node = |k: u32| {
        // Views do not look at the same places.
        let share = (f64::from(k) + 0.1 * f64::from(view)) / f64::from(count);
        let incidence = most * (2.0 * share - 1.0);
        let tangent = incidence.tan().abs();
        // Slow along the arc, and unlike those of other views.
        let wave = 2.0_f64.sqrt() * (4.0 * incidence + 2.4 * f64::from(view * view)).sin();
        let r = 1.0 + error(tangent) * wave;
        let (sin, cos) = (from + incidence).sin_cos();
        Node::at(Point2::new(r * cos, r * sin))
            .with_sigma(SIGMA as f32)
            .with_footprint(SPACING as f32)
            .with_tan_incidence(is_known.then_some(tangent as f32))
    };
    vec![Curve::new((0..count).map(node).collect(), false).unwrap()]
}

/// Root mean square of the result's errors.
fn error_of_result(error: impl Fn(f64) -> f64 + Copy, is_known: bool) -> f64 {
    let views: Vec<_> = (0..10).map(|view| arc(view, error, is_known)).collect();
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let fused = consensus(&slices, &ConsensusOptions::default());
    let nodes = fused.curves.iter().flat_map(Curve::nodes);
    let squares: Vec<f64> = nodes.map(|n| (n.position.coords.norm() - 1.0).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn oblique_views_weigh_less_where_they_err_more() {
    let error = |tangent: f64| ERROR * tangent;
    let (known, unknown) = (error_of_result(error, true), error_of_result(error, false));
    assert!(known < 0.6 * unknown, "{known} instead of {unknown}");
}

#[test]
fn and_as_much_as_others_where_they_do_not() {
    let error = |_: f64| ERROR;
    let (known, unknown) = (error_of_result(error, true), error_of_result(error, false));
    assert!(known < 1.05 * unknown, "{known} instead of {unknown}");
}
