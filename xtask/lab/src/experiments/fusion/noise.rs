//! How the error falls with the number of views, and whether the result knows it.

use super::rings::{Look, slices};
use crate::table::{print_grid, say};
use std::f64::consts::TAU;
use transect_fusion::{ConsensusOptions, consensus};
use transect_geometry::Curve;

const SIGMA: f64 = 0.004;
const ROUNDS: u64 = 3;

/// Prints the table and the slope.
pub fn print() {
    let counts = [1_u64, 2, 4, 8, 16, 32, 64];
    let found = counts.map(observed_and_predicted);
    let line = |(views, [observed, predicted]): (&u64, &[f64; 2])| {
        vec![
            views.to_string(),
            format!("{:.4}", observed / SIGMA),
            format!("{:.4}", predicted / SIGMA),
            format!("{:.2}", predicted / observed),
        ]
    };
    let lines: Vec<_> = counts.iter().zip(&found).map(line).collect();
    print_grid(&["views", "rms error", "predicted", "predicted / observed"], &lines);
    let points: Vec<(f64, f64)> =
        counts.iter().zip(&found).map(|(v, [e, _])| ((*v as f64).ln(), e.ln())).collect();
    say(&format!(
        "\nNoise: rings of radius 1, samples 0.02 apart, noise 0.004 across; errors in standard deviations of one \
         sample. Slope in logarithms, from 2 views on: {:.3}; the square root would be -0.5.",
        slope(&points[1..])
    ));
}

fn observed_and_predicted(views: u64) -> [f64; 2] {
    let look = Look { radius: 1.0, from: 0.0, sweep: TAU, spacing: 0.02, sigma: SIGMA };
    let (mut errors, mut claims, mut count) = (0.0, 0.0, 0.0);
    for round in 0..ROUNDS {
        let see = |v: u64| look.curve(v + 1000 * round).into_iter().collect();
        let seen: Vec<Vec<Curve>> = (0..views).map(see).collect();
        let fused = consensus(&slices(&seen), &ConsensusOptions::default());
        for n in fused.curves.iter().flat_map(|c| c.nodes()) {
            errors += (n.position.coords.norm() - 1.0).powi(2);
            claims += f64::from(n.sigma).powi(2);
            count += 1.0;
        }
    }
    [(errors / count).sqrt(), (claims / count).sqrt()]
}

/// Slope of the line through points.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let sums = points.iter().fold((0.0, 0.0), |s, p| {
        let x = p.0 - mean.0;
        (s.0 + x * (p.1 - mean.1), s.1 + x * x)
    });
    sums.0 / sums.1
}
