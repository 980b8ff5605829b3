//! A tunnel of a kilometre: the time of every view as the model grows, and of its stages.

use super::rings::Look;
use crate::bench::timing::once;
use crate::statistics::median;
use crate::table::{print_grid, say};
use std::collections::BTreeMap;
use std::hint::black_box;
use transect_fusion::{ConsensusOptions, consensus, measure};
use transect_geometry::{Curve, Node};

/// Distance between planes, and between views, in metres.
const INTERVAL: f64 = 0.5;

/// Planes that a view sees: 10 m of the tunnel.
const SEEN: u32 = 20;

/// Radius of the tunnel, distance between samples and their noise, in metres.
const RADIUS: f64 = 3.0;
const SPACING: f64 = 0.1;
const SIGMA: f64 = 0.01;

/// What is known of a plane: what each view saw, and the fused curves.
#[derive(Default)]
struct Plane {
    seen: Vec<Vec<Curve>>,
    fused: Vec<Curve>,
}

/// Seconds that the thread ran for one view.
#[derive(Debug, Clone, Copy, Default)]
struct Seconds {
    /// Making what the view sees, which takes the place of images and partial modelling.
    seeing: f64,
    /// Fusing every plane it touches again.
    fusing: f64,
    /// What of this goes into observations and the spread between views, measured by itself.
    measuring: f64,
}

/// Prints the table.
pub fn print(views: u32) {
    let mut model: BTreeMap<u32, Plane> = BTreeMap::new();
    let mut lines = Vec::new();
    let mut seconds = Vec::new();
    for view in 1..=views {
        seconds.push(add(&mut model, view));
        if view == 100 || view % (views / 4).max(1) == 0 {
            lines.push(line(view, &seconds, &model));
        }
    }
    let heads = [
        "views",
        "ms per view, the last 100",
        "of it seeing",
        "observations and spread",
        "curves",
        "nodes in the model",
        "bytes per metre of curve",
    ];
    print_grid(&heads, &lines);
    say(&format!(
        "\nScale: a tunnel of radius 3 m, planes and views every {INTERVAL} m, half of the wall of 10 m seen by each \
         view; every plane a view touches is fused again from all that was seen of it. Time that the thread ran, \
         medians over the views; what measuring takes is timed by itself."
    ));
}

/// Adds what a view sees of the planes ahead of it.
fn add(model: &mut BTreeMap<u32, Plane>, view: u32) -> Seconds {
    let mut seconds = Seconds::default();
    let options = ConsensusOptions::default();
    for k in view..view + SEEN {
        let plane = model.entry(k).or_default();
        seconds.seeing += once(|| {
            let from = 2.4 * f64::from(view);
            let look = Look { radius: RADIUS, from, sweep: 3.2, spacing: SPACING, sigma: SIGMA };
            plane.seen.push(look.curve(u64::from(view) * 64 + u64::from(k)).into_iter().collect());
        });
        let slices: Vec<&[Curve]> = plane.seen.iter().map(Vec::as_slice).collect();
        seconds.fusing += once(|| plane.fused = consensus(&slices, &options).curves);
        seconds.measuring += once(|| {
            black_box(measure(&slices, &options));
        });
    }
    seconds
}

fn line(view: u32, seconds: &[Seconds], model: &BTreeMap<u32, Plane>) -> Vec<String> {
    let last = |part: fn(&Seconds) -> f64| {
        median(&seconds.iter().rev().take(100).map(part).collect::<Vec<_>>())
    };
    let all = last(|s| s.seeing + s.fusing);
    let share = |part: f64| format!("{:.0} %", 100.0 * part / all);
    let (seeing, measuring) = (last(|s| s.seeing), last(|s| s.measuring));
    let curves = || model.values().flat_map(|p| &p.fused);
    let nodes: usize = curves().map(|c| c.nodes().len()).sum();
    let length: f64 = curves().map(Curve::length).sum();
    let bytes = (nodes * size_of::<Node>()) as f64 / length;
    vec![
        view.to_string(),
        format!("{:.2}", 1e3 * all),
        share(seeing),
        share(measuring),
        share(last(|s| s.fusing) - measuring),
        nodes.to_string(),
        format!("{bytes:.0}"),
    ]
}
