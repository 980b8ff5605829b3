//! How far each method moves a circle, by the number of arcs that were merged.

use super::rings::{Look, slices};
use crate::table::{print_grid, say};
use transect_fusion::{ConsensusOptions, FusedPlane, PairwiseOptions, consensus, pairwise};
use transect_geometry::Curve;

const SPACING: f64 = 0.02;

/// Arc height of a chord between two samples: the smallest error that means anything.
const SAGITTA: f64 = SPACING * SPACING / 8.0;

/// Prints the table.
pub fn print() {
    let mut lines = Vec::new();
    for (arcs, noise) in [(10, 0.0), (50, 0.0), (100, 0.0), (10, 40.0), (50, 40.0), (100, 40.0)] {
        let views = arcs_of_a_circle(arcs, noise * SAGITTA);
        let views = slices(&views);
        let fused = [
            consensus(&views, &ConsensusOptions::default()),
            pairwise(&views, &PairwiseOptions::default()),
        ];
        let mut line = vec![arcs.to_string(), format!("{noise:.0}")];
        for plane in &fused {
            let [mean, rms] = errors(plane);
            line.extend([format!("{mean:+.3}"), format!("{rms:.3}"), state(plane)]);
        }
        lines.push(line);
    }
    let heads =
        ["arcs", "noise", "consensus: mean", "rms", "curves", "pairwise: mean", "rms", "curves"];
    print_grid(&heads, &lines);
    say(
        "\nDrift: arcs of 120 degrees of a circle of radius 1, samples 0.02 apart. Signed distance of nodes \
         from the circle, and noise, in chord sagittas (0.00005).",
    );
}

fn arcs_of_a_circle(count: u64, sigma: f64) -> Vec<Vec<Curve>> {
    let look =
        |k: u64| Look { radius: 1.0, from: 2.4 * k as f64, sweep: 2.1, spacing: SPACING, sigma };
    (0..count).map(|k| look(k).curve(k).into_iter().collect()).collect()
}

/// Mean and root mean square of the nodes' distances from the circle, in sagittas.
fn errors(plane: &FusedPlane) -> [f64; 2] {
    let nodes = plane.curves.iter().flat_map(|c| c.nodes());
    let errors: Vec<f64> = nodes.map(|n| (n.position.coords.norm() - 1.0) / SAGITTA).collect();
    let count = errors.len() as f64;
    let square = errors.iter().map(|e| e * e).sum::<f64>() / count;
    [errors.iter().sum::<f64>() / count, square.sqrt()]
}

fn state(plane: &FusedPlane) -> String {
    let closed = plane.curves.iter().filter(|c| c.is_closed()).count();
    format!("{} ({closed} closed)", plane.curves.len())
}
