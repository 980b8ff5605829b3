//! Neighbouring surfaces: both sides of a sheet, and two sheets that face the same way.

use super::rings::{Random, slices};
use crate::table::{print_grid, say};
use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::{Curve, Node, Point2};

const SIGMA: f64 = 0.004;
const SPACING: f64 = 0.02;
const NODES: usize = 200;
const VIEWS: u64 = 8;

/// Draws of the noise for sheets that face the same way.
const DRAWS: u64 = 15;

/// Prints both tables.
pub fn print() {
    let opposite = [0.5, 1.0, 2.0, 4.0, 10.0].map(|apart| {
        let fused = consensus(&slices(&views(0, apart, true)), &ConsensusOptions::default());
        let found = (height(&fused, false) - height(&fused, true)) / SIGMA;
        vec![format!("{apart}"), format!("{found:.3}"), format!("{:+.3}", found - apart)]
    });
    print_grid(&["thickness", "found", "difference"], &opposite);
    say("");
    let same = [2.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 16.0].map(|apart| {
        let mut line = vec![format!("{apart}")];
        line.extend(curves(|draw| views(draw, apart, false)));
        line.extend(curves(|draw| each_by_half(views(draw, apart, false))));
        line
    });
    let heads = ["apart", "one curve", "two", "more", "by half each: one curve", "two", "more"];
    print_grid(&heads, &same);
    say(&format!(
        "\nSheets: two surfaces with opposite directions, and two with the same, each seen by {VIEWS} views; lengths in \
         standard deviations of one sample. Of those with the same direction, in how many of {DRAWS} draws so many curves \
         came out; on the right every view saw only one of the two."
    ));
}

/// In how many draws one curve came out, two, and more.
fn curves(views: impl Fn(u64) -> Vec<Vec<Curve>>) -> [String; 3] {
    let mut counts = [0_u64; 3];
    for draw in 0..DRAWS {
        let fused = consensus(&slices(&views(draw)), &ConsensusOptions::default());
        counts[fused.curves.len().clamp(1, 3) - 1] += 1;
    }
    counts.map(|c| c.to_string())
}

/// What the views saw of two surfaces some standard deviations apart.
fn views(draw: u64, apart: f64, turned: bool) -> Vec<Vec<Curve>> {
    let first = 2 * VIEWS * draw;
    let view = |v: u64| {
        let (low, high) = (first + 2 * v, first + 2 * v + 1);
        let layers = [layer(low, 0.0, false), layer(high, apart * SIGMA, turned)];
        layers.into_iter().flatten().collect()
    };
    (0..VIEWS).map(view).collect()
}

/// The same if every view saw only one of the surfaces.
fn each_by_half(views: Vec<Vec<Curve>>) -> Vec<Vec<Curve>> {
    let one = |(v, curves): (usize, Vec<Curve>)| curves.into_iter().skip(v % 2).take(1).collect();
    views.into_iter().enumerate().map(one).collect()
}

/// A surface along x at a height; turned ones run back, with their solid below.
fn layer(seed: u64, height: f64, turned: bool) -> Option<Curve> {
    let mut random = Random::new(1 + seed);
    let node = |k: usize| {
        let (x, y) = (SPACING * k as f64, height + SIGMA * random.normal());
        let x = if turned { SPACING * NODES as f64 - x } else { x };
        Node::at(Point2::new(x, y)).with_sigma(SIGMA as f32).with_footprint(SPACING as f32)
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
