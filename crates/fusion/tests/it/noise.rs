//! How far noise is taken out, and how well the result knows what is left of it.
//!
//! `cargo test -p transect-fusion --test it noise -- --nocapture` prints the tables.

use crate::draws::Noise;
use nalgebra::Vector3;
use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, consensus};
use transect_geometry::{Curve, Node, Point2};

/// Distance between neighbouring nodes, and one node's own standard deviation.
const SPACING: f64 = 0.02;
const SIGMA: f64 = 0.004;

/// Errors around a ring of standard deviation 1, each the mean of `shared` neighbouring ones.
fn around(noise: &mut Noise, count: usize, shared: usize) -> Vec<f64> {
    let own: Vec<f64> = (0..count).map(|_| noise.normal()).collect();
    let mean = |k: usize| (0..shared).map(|j| own[(k + j) % count]).sum::<f64>();
    (0..count).map(|k| mean(k) / (shared as f64).sqrt()).collect()
}

/// A circle of radius 1 as one view saw it, its errors the mean of some neighbouring ones.
fn ring(seed: u64, shared: usize) -> Vec<Curve> {
    let mut noise = Noise(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let phase = noise.uniform();
    let errors = around(&mut noise, (TAU / SPACING) as usize, shared);
    let correlation = if shared > 1 { shared as f64 * SPACING } else { 0.0 };
    let node = |(k, e): (usize, &f64)| {
        let a = TAU * (k as f64 + phase) / errors.len() as f64;
        let r = 1.0 + SIGMA * e;
        Node::at(Point2::new(r * a.cos(), r * a.sin()))
            .with_sigma(SIGMA as f32)
            .with_footprint(SPACING as f32)
            .with_correlation(correlation as f32)
    };
    vec![Curve::new(errors.iter().enumerate().map(node).collect(), true).unwrap()]
}

/// Root mean square of the errors, and of the standard deviations the result claims.
fn observed_and_predicted(views: u64, shared: usize, rounds: u64) -> (f64, f64) {
    let (mut errors, mut claims, mut count) = (0.0, 0.0, 0.0);
    for round in 0..rounds {
        let views: Vec<_> = (0..views).map(|v| ring(1 + v + 1000 * round, shared)).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let fused = consensus(&slices, &ConsensusOptions::default());
        for n in fused.curves.iter().flat_map(|c| c.nodes()) {
            errors += (n.position.coords.norm() - 1.0).powi(2);
            claims += f64::from(n.sigma).powi(2);
            count += 1.0;
        }
    }
    ((errors / count).sqrt(), (claims / count).sqrt())
}

#[test]
fn the_error_falls_with_the_root_of_the_number_of_views() {
    for shared in [1, 4] {
        let counts = [1_u64, 2, 4, 8, 16, 32, 64];
        let errors = counts.map(|v| observed_and_predicted(v, shared, 2).0);
        println!("errors shared by {shared}: views, rms error in standard deviations of a node");
        counts.iter().zip(errors).for_each(|(v, e)| println!("{v:>4} {:.4}", e / SIGMA));
        // Slope of the line through all points but the first, in logarithms.
        let points: Vec<(f64, f64)> =
            counts.iter().zip(errors).skip(1).map(|(v, e)| ((*v as f64).ln(), e.ln())).collect();
        let n = points.len() as f64;
        let mean = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
        let (xy, xx) = points.iter().fold((0.0, 0.0), |s, p| {
            let x = p.0 - mean.0;
            (s.0 + x * (p.1 - mean.1), s.1 + x * x)
        });
        println!("slope {:.3}", xy / xx);
        assert!((-0.6..-0.4).contains(&(xy / xx)), "slope {}", xy / xx);
    }
}

#[test]
fn the_result_knows_its_own_error() {
    println!("views shared  observed predicted  ratio");
    for (views, shared) in [(2, 1), (4, 1), (12, 1), (2, 3), (4, 3), (12, 3), (4, 6), (12, 6)] {
        let (observed, predicted) = observed_and_predicted(views, shared, 6);
        let ratio = predicted / observed;
        println!("{views:>5} {shared:>6} {observed:>9.6} {predicted:>9.6} {ratio:>6.3}");
        assert!((0.8..1.25).contains(&ratio), "{views} views, {shared} shared: {ratio}");
    }
}

#[test]
fn normals_and_shared_lengths_reach_the_result() {
    let outward = |curve: &Curve| {
        let give = |n: &Node| {
            let p = n.position.coords.normalize();
            n.with_normal(Some(Vector3::new(p.x as f32, p.y as f32, 0.5).normalize()))
        };
        Curve::new(curve.nodes().iter().map(give).collect(), curve.is_closed()).unwrap()
    };
    let views: Vec<Vec<Curve>> = (1..5).map(|v| ring(v, 4).iter().map(outward).collect()).collect();
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let fused = consensus(&slices, &ConsensusOptions::default());
    for n in fused.curves.iter().flat_map(|c| c.nodes()) {
        let p = n.position.coords.normalize();
        let normal = n.normal.unwrap();
        let along = f64::from(normal.x) * p.x + f64::from(normal.y) * p.y;
        assert!((normal.norm() - 1.0).abs() < 1e-5 && (along - 0.8944).abs() < 0.01, "{n:?}");
        // At least what the views say, at most the widest window.
        let spacings = f64::from(n.correlation) / SPACING;
        assert!((3.99..25.0).contains(&spacings), "{spacings}");
    }
}

/// A straight wall as one view saw it from a pose that errs across the wall by `pose_error`.
fn wall(seed: u64, pose_error: f64) -> Vec<Curve> {
    let mut noise = Noise(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let (phase, offset) = (noise.uniform(), pose_error * noise.normal());
    let mut node = |k: u32| {
        let place = Point2::new((f64::from(k) + phase) * SPACING, offset + 1e-3 * noise.normal());
        Node::at(place).with_sigma(1e-3).with_footprint(SPACING as f32)
    };
    vec![Curve::new((0..100).map(&mut node).collect(), false).unwrap()]
}

#[test]
fn views_farther_apart_than_samples_are_known_to_err() {
    for footprints in [1.0, 2.0, 2.5] {
        let pose_error = footprints * SPACING;
        let (mut errors, mut claims) = (0.0, 0.0);
        for round in 0..240 {
            let views: Vec<_> = (1..=8).map(|v| wall(v + 1000 * round, pose_error)).collect();
            let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
            let fused = consensus(&slices, &ConsensusOptions::default());
            for n in fused.curves.iter().flat_map(|c| c.nodes()) {
                errors += n.position.y.powi(2);
                claims += f64::from(n.sigma).powi(2);
            }
        }
        let ratio = (claims / errors).sqrt();
        println!("poses err by {footprints} footprints: predicted over observed {ratio:.2}");
        assert!((0.7..1.4).contains(&ratio), "{footprints} footprints: {ratio}");
    }
}

/// The units of a curve that turn by more than 90 degrees, and are shorter than their noise.
fn hooks(curve: &Curve) -> usize {
    let nodes = curve.nodes();
    let turns = |w: &[Node]| {
        let [before, after] = [w[1].position - w[0].position, w[2].position - w[1].position];
        let noise = |a: &Node, b: &Node| f64::from(a.sigma.hypot(b.sigma));
        let is_short = before.norm() < noise(&w[0], &w[1]) || after.norm() < noise(&w[1], &w[2]);
        before.dot(&after) < 0.0 && is_short
    };
    nodes.windows(3).filter(|w| turns(w)).count()
}

#[test]
fn units_within_the_noise_rarely_run_backwards() {
    let [mut left, mut without_step] = [0; 2];
    for seed in 1..40 {
        let mut noise = Noise(seed);
        let mut view = |_| {
            let node = |k: u32| {
                let place = [2.0 * f64::from(k) + 3.0 * noise.normal(), 6.0 * noise.normal()];
                Node::at(Point2::from(place)).with_sigma(6.0).with_footprint(2.0)
            };
            vec![Curve::new((0..60).map(node).collect(), false).unwrap()]
        };
        let views: Vec<Vec<Curve>> = (0..2).map(&mut view).collect();
        let views: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let count = |options: &ConsensusOptions| {
            consensus(&views, options).curves.iter().map(hooks).sum::<usize>()
        };
        let mut without = ConsensusOptions::default();
        without.steps.backward = false;
        without_step += count(&without);
        left += count(&ConsensusOptions::default());
    }
    println!("{left} hooks left, {without_step} without the step");
    // Units beside the ends of curves stay, and those of the shortest curves.
    assert!(10 * left < without_step, "{left} hooks left, {without_step} without the step");
}
