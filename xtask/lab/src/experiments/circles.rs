//! Fusion of circles of radius 1: how far it moves them, and how much noise it takes out.

use super::lab::Lab;
use super::poses::Normal;
use crate::failure::Failure;
use crate::table::say;
use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, FusionMethod, PairwiseOptions, fuse_plane};
use transect_geometry::{Curve, Node, Point2};

/// Distance between neighbouring samples of a view.
const SPACING: f64 = 0.02;

/// Sweep of the arcs that are merged, in radians: 120°.
const ARC: f64 = TAU / 3.0;

/// Standard deviation of the noise along the radius.
const SIGMA: f64 = 0.004;

/// Draws whose errors are averaged.
const DRAWS: u64 = 4;

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let consensus = FusionMethod::Consensus(ConsensusOptions::default());
    let pairwise = FusionMethod::Pairwise(PairwiseOptions::default());
    let sagitta = SPACING.powi(2) / 8.0;
    let drift = |arcs: u64, method: &FusionMethod| {
        let views = (0..arcs).map(|k| arc(k, 2.4 * k as f64, ARC, 0.0)).collect();
        let errors = fused(views, method);
        format!("{:.3}", errors.iter().sum::<f64>() / errors.len() as f64 / sagitta)
    };
    let line = |arcs: u64| vec![arcs.to_string(), drift(arcs, &consensus), drift(arcs, &pairwise)];
    lab.table("drift", "arcs | `consensus` | `pairwise`", [10, 50, 100].map(line))?;
    say("Mean distance of the nodes from the circle in chord sagittas, negative inside.\n");
    let rms = |views: u64| {
        let rings = |draw: u64| {
            let ring = |k| arc(1 + k + 1000 * draw, 0.0, TAU, SIGMA);
            fused((0..views).map(ring).collect(), &consensus)
        };
        let errors: Vec<f64> = (0..DRAWS).flat_map(rings).collect();
        let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        vec![views.to_string(), format!("{:.3}", square.sqrt() / SIGMA)]
    };
    let lines = [1, 2, 4, 8, 16, 32, 64].map(rms);
    lab.table("noise", "views | rms error, standard deviations of a sample", lines)
}

/// One view's curve of the circle: nodes at a phase of their own, with noise.
fn arc(seed: u64, from: f64, sweep: f64, sigma: f64) -> Vec<Curve> {
    let mut numbers = Normal(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let phase = numbers.uniform();
    let count = (sweep / SPACING) as usize;
    let step = sweep / count as f64;
    let mut node = |k: usize| {
        let (a, r) = (from + step * (k as f64 + phase), 1.0 + sigma * numbers.next());
        let at = Point2::new(r * a.cos(), r * a.sin());
        Node::at(at).with_sigma(sigma as f32).with_footprint(SPACING as f32)
    };
    let nodes = (0..count).map(&mut node).collect();
    Curve::new(nodes, sweep >= TAU).into_iter().collect()
}

/// Distances of the fused nodes from the circle.
fn fused(views: Vec<Vec<Curve>>, method: &FusionMethod) -> Vec<f64> {
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let curves = fuse_plane(&slices, method).curves;
    curves.iter().flat_map(Curve::nodes).map(|n| n.position.coords.norm() - 1.0).collect()
}
