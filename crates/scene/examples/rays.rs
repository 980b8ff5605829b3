//! How many rays per second one core casts in the bundled room.
//!
//! ```text
//! cargo run --release -p transect-scene --example rays
//! ```
//!
//! The four stations are scanned without noise, as range images with all that belongs to them: the
//! pixel's ray, the nearest hit among all solids, and its value. Printed is the fastest of some
//! rounds, since other programs can only slow a round down.

#![allow(clippy::print_stdout, reason = "an example that prints its result")]

use std::error::Error;
use std::time::Instant;
use transect_scene::{BUNDLED_ROOM, Description, Noise, Station};

const ROUNDS: usize = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let room = Description::parse(BUNDLED_ROOM)?;
    let scene = room.scene();
    let frames = room.stations.iter().map(Station::frame).collect::<Result<Vec<_>, _>>()?;
    let rays: usize = frames.iter().map(|f| f.size().pixels()).sum();
    for (what, noise) in [("perfect", Noise::NONE), ("noisy", room.noise)] {
        let mut best = f64::INFINITY;
        for _ in 0..ROUNDS {
            let start = Instant::now();
            for (view, (frame, station)) in (0..).zip(frames.iter().zip(&room.stations)) {
                scene.scan(frame.as_ref(), &station.world_from_sensor, &noise, view)?;
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        let rate = rays as f64 / best / 1e6;
        println!("{what}: {rays} rays in {best:.3} s, {rate:.2} million rays per second");
    }
    Ok(())
}
