//! A process that grows a store is killed at random instants; no view is lost, none is there by
//! half, and going on gives what nobody interrupted.
//!
//! This program is both processes: without [`CHILD`] in its environment it starts itself with it,
//! kills that process, and opens the store. It verifies the store and compares it with one run over
//! the views that are there. 20 kills, or as many as `TRANSECT_KILLS` says.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::panic, reason = "a test")]
#![allow(dead_code, reason = "some helpers are for the other tests")]

#[path = "it/objects.rs"]
mod objects;

use objects::{noisy_views, setup};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use transect::{Grower, Stage, Unwatched, Watch, reconstruct};
use transect_device::{Isometry3, View};
use transect_exchange::write_contours;
use transect_model::Model;
use transect_model::store::Store;

/// Path of the store that this process is to grow, if it is the one that will be killed.
const CHILD: &str = "TRANSECT_GROWN_STORE";
/// Whether that process adds views one by one, each with its planes, in place of all at once.
const ONE_BY_ONE: &str = "TRANSECT_ONE_BY_ONE";
/// Whether that process moves all views of the store, in place of adding some.
const MOVE_ALL: &str = "TRANSECT_MOVE_ALL";

fn main() {
    match std::env::var_os(CHILD) {
        Some(path) => grow(&open_or_create(Path::new(&path))),
        None => {
            kill_many();
            kill_while_moving();
        }
    }
}

/// Twelve views: the four of the scene, and those of sensors a little to the side.
fn views() -> Vec<View> {
    let moved = |round: usize, view: &View| {
        let by = Isometry3::translation(0.01 * round as f64, -0.02 * round as f64, 0.0);
        let pose = by * view.world_from_sensor();
        let name = format!("{round}-{}", view.name());
        let (image, frame) = (view.image().clone(), objects::frame_of(view.name()));
        View::new(name, image, frame, pose, view.sigma()).unwrap()
    };
    let own = noisy_views();
    (0..3).flat_map(|round| own.iter().map(move |view| moved(round, view))).collect()
}

fn open_or_create(path: &Path) -> Store {
    if path.exists() {
        Store::open(path).unwrap()
    } else {
        Store::create(path, &setup().store_header()).unwrap()
    }
}

/// Says when a view is in the store.
struct Saying;

impl Watch for Saying {
    fn begin(&self, _: Stage, _: usize) {}
    fn step(&self, stage: Stage) {
        if stage == Stage::Views {
            println!("view");
            std::io::stdout().flush().unwrap();
        }
    }
}

fn grow(store: &Store) {
    let (setup, views) = (setup(), views());
    let grower = Grower::new(store, &setup).unwrap();
    if std::env::var_os(MOVE_ALL).is_some() {
        let moved = moved(&views).into_iter().map(|view| (view.name().into(), view));
        grower.replace_views(&moved.collect::<Vec<_>>(), &Saying).unwrap();
        return;
    }
    if std::env::var_os(ONE_BY_ONE).is_none() {
        grower.add_views(&views, &Saying).unwrap();
        return;
    }
    for view in &views {
        grower.add_view(view).unwrap();
        Saying.step(Stage::Views);
    }
}

fn contours(model: &Model) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_contours(model, &mut bytes).unwrap();
    bytes
}

/// The contour file of one run over each number of views.
fn uninterrupted(views: &[View]) -> Vec<Vec<u8>> {
    let run = |count: usize| match count {
        0 => contours(&Model::new(setup().unit, setup().planes)),
        _ => contours(&reconstruct(&views[..count], &setup(), &Unwatched).unwrap().model),
    };
    (0..=views.len()).map(run).collect()
}

/// Starts the other process, kills it after a while, and returns how many views it said were there.
fn run_and_kill(path: &Path, after: Duration, mode: Option<&str>) -> usize {
    let mut command = Command::new(std::env::current_exe().unwrap());
    if let Some(mode) = mode {
        command.env(mode, "1");
    }
    let mut child = command.env(CHILD, path).stdout(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(after);
    child.kill().unwrap();
    let mut said = String::new();
    child.stdout.take().unwrap().read_to_string(&mut said).unwrap();
    let status = child.wait().unwrap();
    assert!(status.code().is_none_or(|code| code == 0 || cfg!(windows)), "it failed: {status}");
    said.matches('\n').count()
}

/// Checks a store that a killed process left; how many views it has, and how many planes wait.
fn check(path: &Path, said: usize, views: &[View], expected: &[Vec<u8>]) -> (usize, u64) {
    let mut store = Store::open(path).unwrap();
    let pending = store.verify().unwrap().pending;
    let names: Vec<String> = store.views().unwrap().into_iter().map(|v| v.entry.id.0).collect();
    let mut wanted: Vec<&str> = views[..names.len()].iter().map(View::name).collect();
    wanted.sort_unstable();
    assert_eq!(names, wanted, "other views than the first ones");
    assert!(names.len() >= said, "{} views, though {said} were said to be there", names.len());
    // On a copy: the next process must find what the killed one left.
    drop(store);
    let copy = path.with_extension("copy");
    std::fs::copy(path, &copy).unwrap();
    let store = Store::open(&copy).unwrap();
    Grower::new(&store, &setup()).unwrap().fuse_pending(&Unwatched).unwrap();
    let found = contours(&store.read().unwrap().model().unwrap());
    assert!(found == expected[names.len()], "not what {} views make", names.len());
    (names.len(), pending)
}

/// The views at other poses, as a registration gives them.
fn moved(views: &[View]) -> Vec<View> {
    let by = Isometry3::translation(0.01, -0.02, 0.005);
    views.iter().map(|view| view.with_pose(by * view.world_from_sensor()).unwrap()).collect()
}

/// All views of a store are moved in one transaction: after a kill they are as before or all moved.
fn kill_while_moving() {
    let folder = tempfile::tempdir().unwrap();
    let (own, path) = (views(), folder.path().join("moved.transect"));
    let (begin, copy) = (folder.path().join("begin.transect"), folder.path().join("copy"));
    grow(&open_or_create(&begin));
    let at_once =
        |views: &[View]| contours(&reconstruct(views, &setup(), &Unwatched).unwrap().model);
    let [before, after] = [at_once(&own), at_once(&moved(&own))];
    let found = |path: &Path| {
        std::fs::copy(path, &copy).unwrap();
        let mut store = Store::open(&copy).unwrap();
        assert_eq!(store.verify().unwrap().pending, 0, "planes wait");
        contours(&store.read().unwrap().model().unwrap())
    };
    let kills: usize = std::env::var("TRANSECT_KILLS").map_or(20, |n| n.parse().unwrap()) / 2;
    let started = Instant::now();
    std::fs::copy(&begin, &path).unwrap();
    let whole = Command::new(std::env::current_exe().unwrap())
        .env(CHILD, &path)
        .env(MOVE_ALL, "1")
        .stdout(Stdio::null())
        .status();
    assert!(whole.unwrap().success());
    let time = started.elapsed();
    assert!(found(&path) == after, "the run that was not killed");
    let mut ended = 0;
    for kill in 1..=kills {
        std::fs::copy(&begin, &path).unwrap();
        run_and_kill(&path, time.mul_f64(kill as f64 / kills as f64), Some(MOVE_ALL));
        let found = found(&path);
        assert!(found == before || found == after, "some views are moved, others are not");
        ended += usize::from(found == after);
    }
    println!("{kills} kills while all views moved; {ended} of them after the end");
}

fn kill_many() {
    let kills = std::env::var("TRANSECT_KILLS").map_or(20, |n| n.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let views = views();
    let expected = uninterrupted(&views);
    let path = folder.path().join("killed.transect");
    let begin = Instant::now();
    grow(&open_or_create(&path));
    let time = begin.elapsed();
    std::fs::remove_file(&path).unwrap();
    let (mut within, mut waiting, mut finished) = (0, 0, 0);
    for kill in 0..kills as u64 {
        // Steps of the golden ratio spread the instants evenly; the machine adds the chance.
        let part = (kill as f64 * 0.618_033_988_75).fract();
        let mode = (kill % 2 == 1).then_some(ONE_BY_ONE);
        let said = run_and_kill(&path, time.mul_f64(0.9 * part), mode);
        if !path.exists() {
            continue;
        }
        let (there, pending) = check(&path, said, &views, &expected);
        within += usize::from(there > 0 && there < views.len());
        waiting += usize::from(pending > 0);
        if there == views.len() {
            std::fs::remove_file(&path).unwrap();
            finished += 1;
        }
    }
    let store = open_or_create(&path);
    Grower::new(&store, &setup()).unwrap().add_views(&views, &Unwatched).unwrap();
    let found = contours(&store.read().unwrap().model().unwrap());
    assert!(found == expected[views.len()], "going on gives another model");
    assert!(within > 0, "no kill fell into the work");
    println!(
        "{kills} kills, {within} of them among the views, {waiting} while planes waited; {finished} runs ended"
    );
}
