//! Time by the number of views, and of one more view in small and large models.

use super::rings::{Look, slices};
use crate::bench::timing::{Variant, time};
use crate::table::{print_grid, say};
use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::Curve;

const ROUNDS: usize = 3;

/// Nodes of one view on one plane.
const NODES: usize = 1000;

/// Planes that one view touches.
const TOUCHED: usize = 5;

/// Prints both tables.
pub fn print() {
    by_views();
    say("");
    by_model();
}

fn ring(seed: u64) -> Vec<Curve> {
    let spacing = TAU / NODES as f64;
    let look = Look { radius: 1.0, from: 0.0, sweep: TAU, spacing, sigma: 0.2 * spacing };
    look.curve(seed).into_iter().collect()
}

fn fuse(views: &[Vec<Curve>]) -> FusedPlane {
    consensus(&slices(views), &ConsensusOptions::default())
}

fn by_views() {
    let counts = [1_usize, 4, 16, 64, 256];
    let all: Vec<Vec<Curve>> = (0..256).map(ring).collect();
    let mut variants = counts.map(|n| {
        let all = &all;
        Variant::new("views", move || drop(fuse(&all[..n])))
    });
    let seconds = time(&mut variants, ROUNDS);
    let line = |(n, s): (&usize, &f64)| {
        let nodes = (n * NODES) as f64;
        vec![n.to_string(), format!("{:.2}", 1e3 * s), format!("{:.2}", 1e6 * s / nodes)]
    };
    let lines: Vec<_> = counts.iter().zip(&seconds).map(line).collect();
    print_grid(&["views", "ms", "us per input node"], &lines);
    say("\nTime by views: rings of 1000 nodes on one plane.");
}

/// One more view in a model: the planes it touches are fused again from what their views saw.
fn by_model() {
    let sizes = [10_usize, 1000];
    let models = sizes.map(|planes| (0..planes).map(|k| vec![ring(k as u64)]).collect::<Vec<_>>());
    let mut variants = models.each_ref().map(|model| {
        Variant::new("view", move || {
            let step = model.len() / TOUCHED;
            for (k, plane) in model.iter().step_by(step).enumerate() {
                let mut views = plane.clone();
                views.push(ring(9000 + k as u64));
                drop(fuse(&views));
            }
        })
    });
    let seconds = time(&mut variants, ROUNDS);
    let line = |(planes, s): (&usize, &f64)| {
        vec![(planes * NODES).to_string(), TOUCHED.to_string(), format!("{:.2}", 1e3 * s)]
    };
    let lines: Vec<_> = sizes.iter().zip(&seconds).map(line).collect();
    print_grid(&["nodes in the model", "planes touched", "ms"], &lines);
    say("\nTime of one view more: only the planes it touches are fused again.");
}
