//! The pieces of fusion, one by one: `cargo bench -p transect-fusion`.
//!
//! Everything is given per input node. Views are noisy arcs and rings on one plane. What a piece
//! costs beyond another one is the difference of two lines: errors are measured within each
//! consensus, too.
#![allow(clippy::expect_used, missing_docs, reason = "a benchmark, with curves of its own")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::f64::consts::TAU;
use std::time::Duration;
use transect_fusion::pattern::{OverlapTolerance, classify};
use transect_fusion::screening::may_overlap;
use transect_fusion::{ConsensusOptions, PairwiseOptions, consensus, measure, pairwise};
use transect_geometry::{Curve, Node, Point2};

/// Nodes of a whole ring.
const NODES: usize = 1000;
/// Distance between nodes of a ring of radius 1, and their noise.
const SPACING: f64 = TAU / NODES as f64;
const SIGMA: f64 = 0.2 * SPACING;

/// A number in -1..1 without relation to its neighbours (the finaliser of SplitMix64).
fn noise(k: u64) -> f64 {
    let k = k.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let k = (k ^ (k >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let k = (k ^ (k >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((k ^ (k >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A wavy ring, or an arc of it, sampled at a phase of its own.
fn look(view: u64, from: f64, sweep: f64) -> Vec<Curve> {
    let closed = sweep >= TAU;
    let phase = noise(view << 32);
    let node = |k: u64| {
        let a = from + SPACING * (k as f64 + phase);
        let r = 1.0 + 0.1 * (5.0 * a).cos() + 3_f64.sqrt() * SIGMA * noise(view << 32 | (k + 1));
        let (sigma, footprint) = (SIGMA as f32, SPACING as f32);
        // Half a footprint of shared errors, as smoothing leaves them.
        let correlation = 0.5 * footprint;
        Node::at(Point2::new(r * a.cos(), r * a.sin()))
            .with_sigma(sigma)
            .with_footprint(footprint)
            .with_correlation(correlation)
    };
    let count = (sweep / SPACING).round() as u64;
    vec![Curve::new((0..count).map(node).collect(), closed).expect("a thousand nodes")]
}

fn rings(views: u64) -> Vec<Vec<Curve>> {
    (0..views).map(|v| look(v, 0.0, TAU)).collect()
}

/// Arcs that begin all round the ring.
fn arcs(views: u64) -> Vec<Vec<Curve>> {
    (0..views).map(|v| look(v, 2.4 * v as f64, 0.4 * TAU)).collect()
}

fn slices(views: &[Vec<Curve>]) -> Vec<&[Curve]> {
    views.iter().map(Vec::as_slice).collect()
}

fn node_count(views: &[Vec<Curve>]) -> Throughput {
    Throughput::Elements(views.iter().flatten().map(|c| c.nodes().len() as u64).sum())
}

/// Runs a piece on the same scene from more and more views.
fn by_views<T>(
    criterion: &mut Criterion,
    name: &str,
    scene: fn(u64) -> Vec<Vec<Curve>>,
    counts: &[u64],
    piece: impl Fn(&[&[Curve]]) -> T,
) {
    let mut group = criterion.benchmark_group(name);
    for &count in counts {
        let views = scene(count);
        let views_of_curves = slices(&views);
        group.throughput(node_count(&views));
        let id = BenchmarkId::from_parameter(format!("{count} views"));
        group.bench_function(id, |b| b.iter(|| piece(&views_of_curves)));
    }
    group.finish();
}

/// A whole plane by the default method: rings seen whole, and arcs with their ends.
fn whole_plane(criterion: &mut Criterion) {
    let options = ConsensusOptions::default();
    by_views(criterion, "consensus of rings", rings, &[1, 4, 16, 64], |v| consensus(v, &options));
    by_views(criterion, "consensus of arcs", arcs, &[16], |v| consensus(v, &options));
}

/// The spread between views: canonical order, directions, weights and a sample of distances.
fn spread(criterion: &mut Criterion) {
    let options = ConsensusOptions::default();
    by_views(criterion, "spread", rings, &[4, 16, 64], |v| measure(v, &options));
}

/// A whole plane the dissertation's way.
fn dissertation(criterion: &mut Criterion) {
    let options = PairwiseOptions::default();
    by_views(criterion, "pairwise of arcs", arcs, &[4, 16], |v| pairwise(v, &options));
}

/// Screening and classification of one pair of curves, overlapping and far apart.
fn overlaps(criterion: &mut Criterion) {
    let tolerance = OverlapTolerance::within(8.0 * SIGMA).expect("a distance");
    let pairs = [
        ("side by side", look(0, 0.0, 0.4 * TAU), look(1, 0.2 * TAU, 0.4 * TAU)),
        ("apart", look(0, 0.0, 0.4 * TAU), look(1, 0.5 * TAU, 0.4 * TAU)),
    ];
    let mut group = criterion.benchmark_group("classification of two arcs");
    for (name, a, b) in pairs {
        let (a, b) = (&a[0], &b[0]);
        group.throughput(Throughput::Elements((a.nodes().len() + b.nodes().len()) as u64));
        group.bench_function(name, |bench| bench.iter(|| classify(a, b, &tolerance)));
        let common = a.envelope().merged(&b.envelope());
        let angle = tolerance.max_angle_rad();
        group.bench_function(format!("screening, {name}"), |bench| {
            bench.iter(|| may_overlap(a, b, &common, angle));
        });
    }
    group.finish();
}

criterion_group! {
    name = pieces;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = whole_plane, spread, dissertation, overlaps
}
criterion_main!(pieces);
