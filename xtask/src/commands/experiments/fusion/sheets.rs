//! Neighbouring surfaces: both sides of a sheet, and two sheets that face the same way.

use super::super::table;
use super::rings::{Random, slices};
use crate::table::say;
use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::{Curve, Node, Point2};

const SIGMA: f64 = 0.004;
const SPACING: f64 = 0.02;
const NODES: usize = 200;
const VIEWS: u64 = 8;

/// Prints both tables.
pub fn print() {
    let opposite = [0.5, 1.0, 2.0, 4.0, 10.0].map(|apart| {
        let fused = fuse(apart, true);
        let found = (height(&fused, false) - height(&fused, true)) / SIGMA;
        vec![format!("{apart}"), format!("{found:.3}"), format!("{:+.3}", found - apart)]
    });
    table::print(&["thickness", "found", "difference"], &opposite);
    say("");
    let same = [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 16.0].map(|apart| {
        let fused = fuse(apart, false);
        vec![format!("{apart}"), fused.curves.len().to_string()]
    });
    table::print(&["apart", "curves"], &same);
    say(&format!(
        "\nSheets: two surfaces with opposite directions, and two with the same, each seen by {VIEWS} views; lengths in \
         standard deviations of one sample."
    ));
}

fn fuse(apart: f64, turned: bool) -> FusedPlane {
    let view = |v: u64| {
        let layers = [layer(2 * v, 0.0, false), layer(2 * v + 1, apart * SIGMA, turned)];
        layers.into_iter().flatten().collect()
    };
    let views: Vec<Vec<Curve>> = (0..VIEWS).map(view).collect();
    consensus(&slices(&views), &ConsensusOptions::default())
}

/// A surface along x at a height; turned ones run back, with their solid below.
fn layer(seed: u64, height: f64, turned: bool) -> Option<Curve> {
    let mut random = Random::new(1 + seed);
    let node = |k: usize| {
        let (x, y) = (SPACING * k as f64, height + SIGMA * random.normal());
        let x = if turned { SPACING * NODES as f64 - x } else { x };
        Node { sigma: SIGMA as f32, footprint: SPACING as f32, ..Node::at(Point2::new(x, y)) }
    };
    Curve::new((0..NODES).map(node).collect(), false).ok()
}

/// Mean height of the units that run one way, away from the ends.
fn height(fused: &FusedPlane, forward: bool) -> f64 {
    let units = fused.curves.iter().flat_map(Curve::units);
    let one_way = units.filter(|u| (u.vector().x > 0.0) == forward).map(|u| u.at(0.5));
    let inner: Vec<f64> = one_way.filter(|p| (0.3..3.7).contains(&p.x)).map(|p| p.y).collect();
    inner.iter().sum::<f64>() / inner.len() as f64
}
