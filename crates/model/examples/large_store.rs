//! Builds a store of ten million fused nodes and measures it: `cargo run --release -p transect-model
//! --example large_store [FOLDER] [PLANES]`.
//!
//! A scan along a corridor: every plane is seen by four views, every view sees forty planes, with 5000
//! nodes on each. 2000 planes make ten million fused nodes; the file takes about 1.5 GB.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a measuring program")]

use std::path::{Path, PathBuf};
use std::time::Instant;
use transect_geometry::{
    Curve, Isometry3, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, Point3, StraightGuide,
    Vector3,
};
use transect_model::store::{SpaceQuery, Store, StoreHeader, ViewEntry, ViewId};

const PLANES_PER_VIEW: i64 = 40;
const NEW_PLANES_PER_VIEW: i64 = 10;
const CURVES: usize = 5;
const NODES_PER_CURVE: usize = 1000;
const INTERVAL: f64 = 0.01;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().map_or_else(std::env::temp_dir, PathBuf::from);
    let planes: i64 = arguments.next().map_or(2000, |n| n.parse().unwrap());
    let path = folder.join(format!("large_store-{}.transect", std::process::id()));
    build(&path, planes);
    ask(&path, planes);
    let copy = path.with_extension("copy");
    open_after_a_crash(&path, &copy);
    std::fs::remove_file(&path).unwrap();
    std::fs::remove_file(&copy).unwrap();
}

fn header() -> StoreHeader {
    let guide = StraightGuide::along(Vector3::z()).unwrap();
    let planes = PlaneFamily::new(guide, 0.0, INTERVAL).unwrap();
    let (options, tool) = (String::new(), "large_store".to_owned());
    StoreHeader { unit: LengthUnit::Metre, planes, options, tool }
}

fn entry(view: i64) -> ViewEntry {
    let id = format!("{view:06}");
    ViewEntry {
        name: id.clone(),
        source: String::new(),
        id: ViewId(id),
        sensor: String::new(),
        source_hash: String::new(),
        world_from_sensor: Isometry3::identity(),
        sigma: None,
    }
}

/// Pipes beside each other, of slightly different radii in each plane and view.
fn curves(view: i64, plane: i64) -> Vec<Curve> {
    let pipe = |pipe: usize| {
        let radius = 0.4 + 1e-4 * ((view * 7 + plane * 3) % 11) as f64;
        let node = |i: usize| {
            let (sin, cos) = (i as f64 * std::f64::consts::TAU / NODES_PER_CURVE as f64).sin_cos();
            Node::at(Point2::new(pipe as f64 + radius * cos, radius * sin))
        };
        Curve::new((0..NODES_PER_CURVE).map(node).collect(), true).unwrap()
    };
    (0..CURVES).map(pipe).collect()
}

/// Stands for fusion, whose own time is not measured here: the curves of the first view.
fn fuse(_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
    partials.first().map(|(_, curves)| curves.clone()).unwrap_or_default()
}

fn build(path: &Path, planes: i64) {
    let store = Store::create(path, &header()).unwrap();
    let (mut adding, mut committing) = (Vec::new(), Vec::new());
    for view in 0..planes / NEW_PLANES_PER_VIEW {
        let first = view * NEW_PLANES_PER_VIEW;
        let seen = (first..(first + PLANES_PER_VIEW).min(planes))
            .map(|plane| (PlaneIndex(plane), curves(view, plane)));
        let begin = Instant::now();
        let mut transaction = store.begin_view(entry(view)).unwrap();
        transaction.add_planes(seen, &fuse).unwrap();
        adding.push(ms(begin));
        let begin = Instant::now();
        transaction.commit().unwrap();
        committing.push(ms(begin));
    }
    println!("views                    {}", adding.len());
    for (what, times) in [("adding    ", adding), ("committing", committing)] {
        let parts =
            times.chunks(times.len().div_ceil(8)).map(|part| format!("{:.0}", median(part)));
        let parts = parts.collect::<Vec<_>>().join(" ");
        println!("{what} one view      {parts} ms (medians of eight parts of the run)");
    }
    let begin = Instant::now();
    store.close().unwrap();
    println!("closing                  {:.1} ms", ms(begin));
    println!(
        "file                     {:.0} MB",
        std::fs::metadata(path).unwrap().len() as f64 / 1e6
    );
    println!("peak memory, building    {}", peak_memory());
}

fn ask(path: &Path, planes: i64) {
    let begin = Instant::now();
    let store = Store::open(path).unwrap();
    println!("opening                  {:.1} ms", ms(begin));
    let snapshot = store.read().unwrap();
    let reads = (0..200).map(|i| {
        let begin = Instant::now();
        let section = snapshot.plane(PlaneIndex(i * 7919 % planes)).unwrap().unwrap();
        assert_eq!(section.node_count(), CURVES * NODES_PER_CURVE);
        ms(begin)
    });
    println!("reading one plane        {:.2} ms (median)", median(&reads.collect::<Vec<_>>()));
    let begin = Instant::now();
    let nodes: usize = snapshot.planes().unwrap().map(|entry| entry.unwrap().1.node_count()).sum();
    println!("streaming all planes     {:.0} ms, {nodes} fused nodes", ms(begin));

    let mut query = SpaceQuery::new(store.read().unwrap(), SpaceQuery::DEFAULT_CAPACITY);
    let (mut cold, mut warm) = (Vec::new(), Vec::new());
    for i in 0..20_000_i64 {
        let unit = |step: f64| (i as f64 * step).fract();
        let z = (planes / 2) as f64 * INTERVAL + unit(0.618_033_988_75) * 50.0 * INTERVAL;
        let p = Point3::new(5.0 * unit(0.754_877_666_2) - 0.5, unit(0.569_840_290_998) - 0.5, z);
        let begin = Instant::now();
        query.locate(&p).unwrap();
        if i < 1000 { &mut cold } else { &mut warm }.push(ms(begin) * 1e3);
    }
    println!("point query              {:.1} µs (median of 19000, after 1000 cold)", median(&warm));
    println!("point query, worst cold  {:.0} µs", cold.iter().copied().fold(0.0, f64::max));
    println!("peak memory              {}", peak_memory());
}

/// The file as it is while the store is open is what a crash leaves.
fn open_after_a_crash(path: &Path, copy: &Path) {
    let store = Store::open(path).unwrap();
    let mut view = store.begin_view(entry(999_999)).unwrap();
    view.add_plane(PlaneIndex(0), &curves(0, 0), &fuse).unwrap();
    view.commit().unwrap();
    std::fs::copy(path, copy).unwrap();
    std::fs::File::open(copy).unwrap().sync_all().unwrap();
    let begin = Instant::now();
    let mut crashed = Store::open(copy).unwrap();
    println!("opening after a crash    {:.1} ms", ms(begin));
    let begin = Instant::now();
    let found = crashed.verify().unwrap();
    println!("verifying                {:.0} ms, {} partial nodes", ms(begin), found.partial_nodes);
    println!("peak memory, verifying   {}", peak_memory());
}

fn ms(begin: Instant) -> f64 {
    begin.elapsed().as_secs_f64() * 1e3
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The largest resident set so far, where the system says it.
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or_else(|| "unknown".to_owned(), |peak| peak.trim().to_owned())
}
