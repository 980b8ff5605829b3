//! Views of a depth camera that errs with the square of the depth weigh by their noise.

use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, consensus};
use transect_geometry::{Curve, Node, Point2};

const SPACING: f64 = 0.02;
/// Noise and error of a view from a depth of 1.
const SIGMA: f64 = 0.0005;
const ERROR: f64 = 0.008;

/// Half of a circle of radius 1 that a view sees. All of it errs in common, by a multiple of the
/// error that waves slowly along the circle, unlike those of other views.
fn arc(view: u32, error: f64, sigma: f64) -> Vec<Curve> {
    let from = TAU * f64::from(view) / 12.0;
    let count = (0.5 * TAU / SPACING) as u32;
    let node = |k: u32| {
        let angle = from + SPACING * (f64::from(k) + 0.1 * f64::from(view));
        let wave = 2.0_f64.sqrt() * (3.0 * angle + 2.4 * f64::from(view * view)).sin();
        let (r, (sin, cos)) = (1.0 + error * wave, angle.sin_cos());
        Node::at(Point2::new(r * cos, r * sin))
            .with_sigma(sigma as f32)
            .with_footprint(SPACING as f32)
    };
    vec![Curve::new((0..count).map(node).collect(), false).unwrap()]
}

/// Root mean square of the result's errors, where every third view looks from near. `errors` and
/// `sigmas` tell those of a view from a depth.
fn error_of_result(errors: impl Fn(f64) -> f64, sigmas: impl Fn(f64) -> f64) -> f64 {
    let depth = |view: u32| if view.is_multiple_of(3) { 1.0 } else { 2.5 };
    let view = |view| arc(view, errors(depth(view)), sigmas(depth(view)));
    let views: Vec<_> = (0..12).map(view).collect();
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let fused = consensus(&slices, &ConsensusOptions::default());
    let nodes = fused.curves.iter().flat_map(Curve::nodes);
    let squares: Vec<f64> = nodes.map(|n| (n.position.coords.norm() - 1.0).powi(2)).collect();
    assert!(squares.len() > 200);
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn near_views_weigh_more_where_errors_go_with_the_noise() {
    let errors = |depth: f64| ERROR * depth * depth;
    let known = error_of_result(errors, |depth| SIGMA * depth * depth);
    let unknown = error_of_result(errors, |_| SIGMA);
    assert!(known < 0.6 * unknown, "{known} instead of {unknown}");
}

#[test]
fn and_as_much_as_others_where_errors_do_not() {
    let errors = |_: f64| 4.0 * ERROR;
    let known = error_of_result(errors, |depth| SIGMA * depth * depth);
    let unknown = error_of_result(errors, |_| SIGMA);
    assert!(known < 1.05 * unknown, "{known} instead of {unknown}");
}
