//! The costs of building, opening and querying a store that is larger than memory.
//!
//! A scan along a corridor: four views see each plane, each view sees forty planes, with 5000 nodes
//! on each. The first view's curves take the place of the fused curves: the time of fusion is
//! measured elsewhere.

use super::super::lab::Lab;
use crate::failure::Failure;
use crate::statistics::median;
use crate::table::{Row, digits, say};
use std::path::Path;
use std::time::Instant;
use transect_geometry::{
    Curve, CurveError, Isometry3, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, Point3,
    StraightGuide, Vector3,
};
use transect_model::store::{SpaceQuery, Store, StoreHeader, ViewDescription, ViewId};
use transect_workflow::peak_memory_mib as peak_mib;

const PLANES_PER_VIEW: i64 = 40;
const NEW_PLANES_PER_VIEW: i64 = 10;
const CURVES: usize = 5;
const NODES_PER_CURVE: usize = 1000;
const INTERVAL: f64 = 0.01;

/// Runs the experiment.
pub fn run(folder: &Path, planes: i64, lab: &Lab) -> Result<(), Failure> {
    say("A store along a corridor: every view touches 40 planes of 5000 nodes\n");
    let path = folder.join(format!("transect-large-{}.store", std::process::id()));
    let rows = build(&path, planes).and_then(|mut rows| {
        rows.extend(ask(&path, planes)?);
        rows.extend(after_a_crash(&path)?);
        Ok(rows)
    });
    // The files are large and not needed any more, also after a failure.
    let _ = std::fs::remove_file(&path);
    let _ = std::fs::remove_file(path.with_extension("copy"));
    let cells = |row: Row| vec![row.metric, row.value, row.unit];
    lab.times("step | value | unit", rows?.into_iter().map(cells))
}

fn header() -> Result<StoreHeader, Failure> {
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 0.0, INTERVAL)?;
    let (options, tool) = (String::new(), "experiments database".to_owned());
    Ok(StoreHeader { unit: LengthUnit::Metre, planes, options, tool })
}

fn entry(view: i64) -> ViewDescription {
    let id = format!("{view:06}");
    ViewDescription {
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
fn curves(view: i64, plane: i64) -> Result<Vec<Curve>, CurveError> {
    let pipe = |pipe: usize| {
        let radius = 0.4 + 1e-4 * ((view * 7 + plane * 3) % 11) as f64;
        let node = |i: usize| {
            let (sin, cos) = (i as f64 * std::f64::consts::TAU / NODES_PER_CURVE as f64).sin_cos();
            Node::at(Point2::new(pipe as f64 + radius * cos, radius * sin))
        };
        Curve::new((0..NODES_PER_CURVE).map(node).collect(), true)
    };
    (0..CURVES).map(pipe).collect()
}

/// Takes the place of fusion.
fn fuse(_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
    partials.first().map(|(_, curves)| curves.clone()).unwrap_or_default()
}

fn build(path: &Path, planes: i64) -> Result<Vec<Row>, Failure> {
    let store = Store::create(path, &header()?)?;
    let mut times = Vec::new();
    for view in 0..planes / NEW_PLANES_PER_VIEW {
        let first = view * NEW_PLANES_PER_VIEW;
        let seen = (first..(first + PLANES_PER_VIEW).min(planes))
            .map(|plane| Ok((PlaneIndex(plane), curves(view, plane)?)));
        let seen = seen.collect::<Result<Vec<_>, CurveError>>()?;
        let begin = Instant::now();
        let mut transaction = store.begin_view(entry(view))?;
        transaction.add_planes(seen, &fuse)?;
        transaction.commit()?;
        times.push(ms(begin));
    }
    store.close()?;
    let parts = times.chunks(times.len().div_ceil(5)).map(|part| format!("{:.0}", median(part)));
    let size = std::fs::metadata(path)?.len();
    Ok(vec![
        Row::plain("views", times.len()),
        Row::new("adding a view, by fifths of the run", parts.collect::<Vec<_>>().join(" "), "ms"),
        Row::new("file", digits(size as f64 / 1e6), "MB"),
        peak("peak memory, building"),
    ])
}

fn ask(path: &Path, planes: i64) -> Result<Vec<Row>, Failure> {
    let begin = Instant::now();
    let store = Store::open(path)?;
    let opening = ms(begin);
    let snapshot = store.read()?;
    let mut reads = Vec::new();
    for i in 0..200 {
        let begin = Instant::now();
        snapshot.plane(PlaneIndex(i * 7919 % planes))?;
        reads.push(ms(begin));
    }
    let mut rows = vec![
        Row::new("opening", digits(opening), "ms"),
        Row::new("reading one plane, median", digits(median(&reads)), "ms"),
    ];
    rows.push(point_query(&store, planes)?);
    rows.push(peak("peak memory, asking"));
    Ok(rows)
}

fn point_query(store: &Store, planes: i64) -> Result<Row, Failure> {
    let mut query = SpaceQuery::new(store.read()?, SpaceQuery::DEFAULT_CAPACITY);
    let mut times = Vec::new();
    for i in 0..20_000_i64 {
        let unit = |step: f64| (i as f64 * step).fract();
        let z = (planes / 2) as f64 * INTERVAL + unit(0.618_033_988_75) * 20.0 * INTERVAL;
        let p = Point3::new(5.0 * unit(0.754_877_666_2) - 0.5, unit(0.569_840_290_998) - 0.5, z);
        let begin = Instant::now();
        query.locate(&p)?;
        times.push(ms(begin) * 1e3);
    }
    // The first thousand fill the cache.
    Ok(Row::new("point query, median of 19000", digits(median(&times[1000..])), "µs"))
}

/// A crash leaves the file in the state that it has while the store is open.
fn after_a_crash(path: &Path) -> Result<Vec<Row>, Failure> {
    let copy = path.with_extension("copy");
    let store = Store::open(path)?;
    let mut view = store.begin_view(entry(999_999))?;
    view.add_planes([(PlaneIndex(0), curves(0, 0)?)], &fuse)?;
    view.commit()?;
    std::fs::copy(path, &copy)?;
    drop(store);
    let begin = Instant::now();
    let mut crashed = Store::open(&copy)?;
    let opening = ms(begin);
    let begin = Instant::now();
    crashed.verify()?;
    Ok(vec![
        Row::new("opening after a crash", digits(opening), "ms"),
        Row::new("verifying", digits(ms(begin)), "ms"),
        peak("peak memory, verifying"),
    ])
}

fn ms(begin: Instant) -> f64 {
    begin.elapsed().as_secs_f64() * 1e3
}

fn peak(metric: &str) -> Row {
    Row::new(metric, peak_mib().map_or("unknown".to_owned(), digits), "MiB")
}
