//! A process that adds views is killed at random instants; no view is lost, none is there by half.
//!
//! This program is both processes: without [`CHILD`] in its environment it starts itself with it
//! and kills that process. Then it opens the store and compares it with one that was built without
//! interruption. 20 kills, or as many as `TRANSECT_KILLS` says.

#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::panic, reason = "a test")]

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use transect_geometry::{
    Curve, Isometry3, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, StraightGuide, Vector3,
};
use transect_model::store::{Store, StoreHeader, ViewDescription, ViewId};

/// Path of the store that this process is to add views to, if it is the one that will be killed.
const CHILD: &str = "TRANSECT_KILL_TEST_STORE";
const VIEWS: usize = 40;

fn main() {
    match std::env::var_os(CHILD) {
        Some(path) => add_views(&open_or_create(Path::new(&path))),
        None => kill_many(),
    }
}

fn header() -> StoreHeader {
    let guide = StraightGuide::along(Vector3::z()).unwrap();
    let planes = PlaneFamily::new(guide, 0.0, 0.5).unwrap();
    StoreHeader { unit: LengthUnit::Metre, planes, options: String::new(), tool: "kill".to_owned() }
}

fn entry(view: usize) -> ViewDescription {
    let id = format!("view-{view:03}");
    ViewDescription {
        name: id.clone(),
        source: format!("{id}.npy"),
        id: ViewId(id),
        sensor: "none".to_owned(),
        source_hash: String::new(),
        world_from_sensor: Isometry3::translation(view as f64, 0.0, 0.0),
        sigma: None,
    }
}

/// Six planes, of which neighbouring views share five; hundreds of nodes, so that values span
/// pages.
fn curves(view: usize) -> Vec<(PlaneIndex, Vec<Curve>)> {
    let node = |i: usize| Node::at(Point2::new((i * (view + 3) % 97) as f64, i as f64));
    let curve =
        || Curve::new((0..200 + 10 * view).map(node).collect(), view.is_multiple_of(2)).unwrap();
    (0..6).map(|k| (PlaneIndex((view + k) as i64), vec![curve()])).collect()
}

fn fuse(_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
    partials.iter().flat_map(|(_, curves)| curves.clone()).collect()
}

fn open_or_create(path: &Path) -> Store {
    if path.exists() { Store::open(path).unwrap() } else { Store::create(path, &header()).unwrap() }
}

fn add_view(store: &Store, view: usize) {
    let mut transaction = store.begin_view(entry(view)).unwrap();
    transaction.add_planes(curves(view), &fuse).unwrap();
    transaction.commit().unwrap();
}

/// Adds the views that are missing, and says so after each commit.
fn add_views(store: &Store) {
    for view in store.views().unwrap().len()..VIEWS {
        add_view(store, view);
        println!("{view}");
        std::io::stdout().flush().unwrap();
    }
}

fn export(store: &Store) -> Vec<u8> {
    let mut text = Vec::new();
    store.export(&mut text).unwrap();
    text
}

/// The export after every view, of a store that nobody interrupts, and the time it took.
fn uninterrupted(path: &Path) -> (Vec<Vec<u8>>, Duration) {
    let store = Store::create(path, &header()).unwrap();
    let mut exports = vec![export(&store)];
    let mut time = Duration::ZERO;
    for view in 0..VIEWS {
        let begin = Instant::now();
        add_view(&store, view);
        time += begin.elapsed();
        exports.push(export(&store));
    }
    (exports, time)
}

/// Starts the other process, kills it after a while, and returns how many views it said it
/// committed.
fn run_and_kill(path: &Path, after: Duration) -> usize {
    let program = std::env::current_exe().unwrap();
    let mut command = Command::new(program);
    let mut child = command.env(CHILD, path).stdout(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(after);
    child.kill().unwrap();
    let mut said = String::new();
    child.stdout.take().unwrap().read_to_string(&mut said).unwrap();
    let status = child.wait().unwrap();
    assert!(status.code().is_none_or(|code| code == 0 || cfg!(windows)), "it failed: {status}");
    said.matches('\n').count()
}

/// While this process has the store open, another one is told so.
fn check_that_others_are_refused(path: &Path) {
    let program = std::env::current_exe().unwrap();
    let output = Command::new(program).env(CHILD, path).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.contains("InUse"), "{said}");
}

/// A reader repairs what the killed process left, in memory.
fn check_that_reading_writes_nothing(path: &Path, exports: &[Vec<u8>]) {
    let before = std::fs::read(path).unwrap();
    let mut store = Store::open_read_only(path).unwrap();
    store.verify().unwrap();
    assert!(export(&store) == exports[store.views().unwrap().len()], "read otherwise");
    drop(store);
    assert!(std::fs::read(path).unwrap() == before, "reading changed the file");
}

fn kill_many() {
    let kills = std::env::var("TRANSECT_KILLS").map_or(20, |n| n.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let (exports, time) = uninterrupted(&folder.path().join("whole.transect"));
    let path = folder.path().join("killed.transect");
    let (mut there, mut finished, mut within) = (0, 0, 0);
    for kill in 0..kills as u64 {
        // Steps of the golden ratio spread the instants evenly; the machine adds the chance.
        let part = (kill as f64 * 0.618_033_988_75).fract();
        let committed = run_and_kill(&path, time.mul_f64(part * 0.4));
        if !path.exists() {
            continue;
        }
        check_that_reading_writes_nothing(&path, &exports);
        let mut store = Store::open(&path).unwrap();
        store.verify().unwrap();
        let views = store.views().unwrap().len();
        assert!(views >= there + committed, "{views} views, {there} before, {committed} committed");
        assert!(export(&store) == exports[views], "kill {kill}: not what {views} views make");
        within += usize::from(views < VIEWS);
        there = views;
        if views == VIEWS {
            drop(store);
            std::fs::remove_file(&path).unwrap();
            (there, finished) = (0, finished + 1);
        }
    }
    let store = open_or_create(&path);
    for view in store.views().unwrap().len()..VIEWS {
        add_view(&store, view);
    }
    assert!(export(&store) == exports[VIEWS], "resuming gives another store");
    check_that_others_are_refused(&path);
    assert!(within > 0, "no kill fell into the work");
    println!(
        "{kills} kills, {within} of them while views were added; {finished} runs came to their end"
    );
}
