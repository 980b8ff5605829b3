//! The pieces of the partial modeler, one by one: `cargo bench -p transect-partial`.
//!
//! Rows and pairs are given per pixel, curves per vertex. What a piece costs beyond another one is
//! the difference of two lines. With no plane met, a sweep is levels and pair tests. With planes,
//! it is also emission, links and lines. Small bands make following and joining dear, large ones
//! leave the cache.
#![allow(clippy::expect_used, missing_docs, reason = "a benchmark, with a view of its own")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::sync::Arc;
use std::time::Duration;
use transect_device::{ImageSize, Isometry3, Neighbour, PairGeometry, RangeImage, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_image::RangeNoise;
use transect_image::smooth::smooth;
use transect_partial::dissertation::{self, DissertationOptions};
use transect_partial::one_pass::{
    Effort, Instructions, OnePassOptions, Workspace, contours, partial_model_with,
};
use transect_partial::{BreakRule, SectionAxes};
use transect_sensors::{AngularScan, ImagingRadar};

const SIZE: usize = 512;
/// Width and height of the field of view, in degrees.
const FIELD: f64 = 80.0;
/// Distance of the wavy wall, in metres.
const RANGE: f64 = 3.0;

/// A wavy wall with a box before it, seen from its middle, with every 49th pixel missing.
fn view(sigma: f64) -> View {
    let step = FIELD / SIZE as f64;
    let scan = AngularScan::from_degrees(-0.5 * FIELD, step);
    let shape = ImageSize { rows: SIZE, cols: SIZE };
    let value = |k: usize| {
        let (i, j) = (k / SIZE, k % SIZE);
        let (phi, theta) = (scan.angle(i), scan.angle(j));
        let on_box = (100..200).contains(&i) && (300..420).contains(&j);
        let wall = RANGE + 0.2 * (5.0 * theta).sin() * (7.0 * phi).cos();
        let grain = sigma * ((k * 7919 % 1009) as f64 / 504.5 - 1.0);
        let range = if on_box { 0.7 * RANGE } else { wall };
        if k.is_multiple_of(49) { f32::NAN } else { (range + grain) as f32 }
    };
    let image = RangeImage::from_values(shape, (0..SIZE * SIZE).map(value).collect());
    let radar = ImagingRadar::new(shape, scan, scan).expect("a field of 80 degrees");
    View::new(
        "bench",
        image.expect("as many values as pixels"),
        Arc::new(radar),
        Isometry3::identity(),
        Some(sigma),
    )
    .expect("image and sensor have one size")
}

/// Planes oblique to the view, `count` of them within what it sees.
fn planes(count: usize) -> PlaneFamily {
    let guide = StraightGuide::along(Vector3::new(0.3, 0.5, 0.8)).expect("a direction");
    PlaneFamily::new(guide, 0.0123, 4.0 / count as f64).expect("an interval")
}

fn rule() -> BreakRule {
    BreakRule::new(80_f64.to_radians(), 0.0)
}

/// One row at a time, as sensors without tables are read.
fn rows(criterion: &mut Criterion) {
    let (view, planes) = (view(0.0), planes(64));
    let axes = SectionAxes::new(&view, &planes).expect("few planes");
    let mut group = criterion.benchmark_group("row");
    group.throughput(Throughput::Elements(SIZE as u64));
    let mut levels = vec![0.0; SIZE];
    group.bench_function("levels", |b| {
        b.iter(|| view.frame().form_row(view.image(), SIZE / 2, axes.level(), &mut levels));
    });
    let mut pairs = vec![PairGeometry::MISSING; SIZE];
    for (name, neighbour) in [("left pairs", Neighbour::Left), ("upward pairs", Neighbour::Up)] {
        group.bench_function(name, |b| {
            b.iter(|| view.frame().pair_row(view.image(), SIZE / 2, neighbour, &mut pairs));
        });
    }
    group.finish();
}

/// Levels and pair tests of the whole image: planes that nothing meets.
fn detection(criterion: &mut Criterion) {
    let view = view(0.0);
    let far = PlaneFamily::new(planes(1).guide(), 1e6, 1e5).expect("an interval");
    let axes = SectionAxes::new(&view, &far).expect("few planes");
    let mut group = criterion.benchmark_group("detection");
    group.throughput(Throughput::Elements((SIZE * SIZE) as u64));
    let all = [Instructions::Portable, Instructions::Avx2, Instructions::Best];
    for instructions in all {
        let effort = Effort { instructions, ..Effort::default() };
        let mut work = Workspace::default();
        group.bench_function(BenchmarkId::from_parameter(format!("{instructions:?}")), |b| {
            b.iter(|| lines(&view, &axes, &effort, &mut work));
        });
    }
    group.finish();
}

fn lines(view: &View, axes: &SectionAxes, effort: &Effort, work: &mut Workspace) -> usize {
    contours(view, axes, &rule(), effort, work).map_or(0, |found| found.vertex_count())
}

/// Detection, emission, links, pieces and lines, per vertex.
fn sweep(criterion: &mut Criterion) {
    let view = view(0.0);
    let mut group = criterion.benchmark_group("lines");
    for (count, band_size) in
        [(16, 1 << 14), (256, 1 << 14), (1024, 1 << 14), (1024, 1 << 12), (1024, 1 << 20)]
    {
        let planes = planes(count);
        let axes = SectionAxes::new(&view, &planes).expect("few planes");
        let effort = Effort { band_size, ..Effort::default() };
        let mut work = Workspace::default();
        group.throughput(Throughput::Elements(lines(&view, &axes, &effort, &mut work) as u64));
        group.bench_function(format!("{count} planes, bands of {band_size}"), |b| {
            b.iter(|| lines(&view, &axes, &effort, &mut work));
        });
    }
    group.finish();
}

/// The whole model without smoothing, per vertex: lines, and what is known of every node.
fn nodes(criterion: &mut Criterion) {
    let (view, planes) = (view(0.0), planes(64));
    let axes = SectionAxes::new(&view, &planes).expect("few planes");
    let mut options = OnePassOptions::default();
    options.smooth = false;
    let effort = Effort::default();
    let mut work = Workspace::default();
    let mut group = criterion.benchmark_group("model");
    group.throughput(Throughput::Elements(lines(&view, &axes, &effort, &mut work) as u64));
    group.bench_function("nodes", |b| {
        b.iter(|| partial_model_with(&view, &planes, &options, &effort, &mut work));
    });
    group.finish();
}

/// Smoothing of the whole image, per pixel.
fn smoothing(criterion: &mut Criterion) {
    let view = view(0.003);
    let noise = RangeNoise::of(&view);
    let rule = BreakRule::new(80_f64.to_radians(), 4.0 * noise.length());
    let mut group = criterion.benchmark_group("smoothing");
    group.throughput(Throughput::Elements((SIZE * SIZE) as u64));
    group.bench_function("all pixels", |b| b.iter(|| smooth(&view, &noise, &rule)));
    group.finish();
}

/// The dissertation's method on a plane, per pixel.
fn one_plane(criterion: &mut Criterion) {
    let view = view(0.0);
    let planes = planes(1);
    let mut options = DissertationOptions::default();
    options.smooth = false;
    let mut group = criterion.benchmark_group("dissertation");
    group.throughput(Throughput::Elements((SIZE * SIZE) as u64));
    group.bench_function("about one plane", |b| {
        b.iter(|| dissertation::partial_model(&view, &planes, &options));
    });
    group.finish();
}

criterion_group! {
    name = pieces;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = rows, detection, sweep, nodes, smoothing, one_plane
}
criterion_main!(pieces);
