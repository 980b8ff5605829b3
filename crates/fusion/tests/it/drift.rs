//! How far each method moves a noise-free circle, by the number of arcs that were merged.
//!
//! `cargo test -p transect-fusion --test it drift -- --nocapture` prints the table.

use crate::scene::{SPACING, circle_arcs, slices};
use transect_fusion::{ConsensusOptions, FusedPlane, PairwiseOptions, consensus, pairwise};
use transect_geometry::Curve;

/// Mean signed distance of a fused circle of radius 1 from the true one, in sagittas of the chord
/// between two neighbouring samples; negative inside.
fn drift(fuse: impl Fn(&[&[Curve]]) -> FusedPlane, arcs: u64) -> f64 {
    let views = circle_arcs(arcs, 0.0);
    let fused = fuse(&slices(&views));
    let errors: Vec<f64> = fused
        .curves
        .iter()
        .flat_map(|c| c.nodes().iter().map(|n| n.position.coords.norm() - 1.0))
        .collect();
    let sagitta = SPACING.powi(2) / 8.0;
    errors.iter().sum::<f64>() / errors.len() as f64 / sagitta
}

fn by_consensus(views: &[&[Curve]]) -> FusedPlane {
    consensus(views, &ConsensusOptions::default())
}

fn by_pairs(views: &[&[Curve]]) -> FusedPlane {
    pairwise(views, &PairwiseOptions::default())
}

#[test]
fn merging_by_pairs_moves_a_circle_inwards_and_the_consensus_stays() {
    println!("arcs   consensus    pairwise   (mean signed distance in chord sagittas)");
    for arcs in [10, 50, 100] {
        let (stays, drifts) = (drift(by_consensus, arcs), drift(by_pairs, arcs));
        println!("{arcs:>4} {stays:>11.4} {drifts:>11.2}");
        assert!(stays.abs() < 0.1, "{arcs} arcs: {stays} sagittas");
        // Nodes on chords lie inside the arc. The newest curve weighs half, which also takes back
        // half of the loss so far: it settles.
        assert!((-3.0..-0.5).contains(&drifts), "{arcs} arcs: {drifts} sagittas");
    }
}

#[test]
fn noise_of_forty_sagittas_is_taken_out_to_three() {
    let sagitta = SPACING.powi(2) / 8.0;
    let views = circle_arcs(50, 40.0 * sagitta);
    let fused = by_consensus(&slices(&views));
    assert_eq!(fused.curves.len(), 1);
    let errors: Vec<f64> =
        fused.curves[0].nodes().iter().map(|n| n.position.coords.norm() - 1.0).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt() / sagitta;
    println!("noise of 40 sagittas, 50 arcs: rms {rms:.2} sagittas");
    // Draws scatter by a tenth.
    assert!(rms < 3.2, "{rms}");
}
