//! Curves as views would see them, for tests of whole planes.

use proptest::prelude::*;
use std::f64::consts::TAU;
use transect_geometry::{Curve, Node, Point2, Vector2};

/// A star-shaped outline: r(a) = 1 + bump · cos(lobes · a).
#[derive(Debug, Clone, Copy)]
pub struct Outline {
    pub bump: f64,
    pub lobes: f64,
}

impl Outline {
    pub const CIRCLE: Self = Self { bump: 0.0, lobes: 1.0 };

    pub fn at(&self, a: f64) -> Point2 {
        let r = 1.0 + self.bump * (self.lobes * a).cos();
        Point2::new(r * a.cos(), r * a.sin())
    }
}

/// What one view saw: an arc, sampled at a spacing and a phase of its own, with noise.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    pub from: f64,
    pub sweep: f64,
    pub spacing: f64,
    pub seed: u64,
}

/// Uniform noise in ±1 from a seed.
fn noise(seed: u64, k: u64) -> f64 {
    let mut x = seed ^ k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for _ in 0..2 {
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// The arc of an outline that a look shows, with noise of a standard deviation along the radius.
pub fn see(outline: &Outline, look: &Look, sigma: f64) -> Curve {
    let count = (look.sweep / look.spacing) as u64;
    let closed = look.sweep >= TAU;
    let phase = 0.5 * noise(look.seed, 99);
    let node = |k: u64| {
        let p = outline.at(look.from + look.spacing * (k as f64 + phase));
        // Uniform in ±√3 σ has the standard deviation σ.
        let off = sigma * 3_f64.sqrt() * noise(look.seed, k);
        let position = p + p.coords.normalize() * off;
        let (sigma, footprint) = (sigma as f32, look.spacing as f32);
        Node::at(position).with_sigma(sigma).with_footprint(footprint)
    };
    Curve::new((0..count).map(node).collect(), closed).unwrap()
}

/// Arcs of 2.1 rad around a circle of radius 1, each seen once.
pub fn circle_arcs(count: u64, sigma: f64) -> Vec<Vec<Curve>> {
    let look = |k: u64| Look { from: k as f64 * 2.4, sweep: 2.1, spacing: SPACING, seed: k };
    (0..count).map(|k| vec![see(&Outline::CIRCLE, &look(k), sigma)]).collect()
}

/// Distance between the nodes of [`circle_arcs`].
pub const SPACING: f64 = 0.02;

pub fn slices(views: &[Vec<Curve>]) -> Vec<&[Curve]> {
    views.iter().map(Vec::as_slice).collect()
}

pub fn moved(curve: &Curve, angle: f64, shift: Vector2) -> Curve {
    let (sin, cos) = angle.sin_cos();
    let turn = |p: Point2| Point2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y) + shift;
    let nodes = curve.nodes().iter().map(|n| n.moved_to(turn(n.position)));
    Curve::new(nodes.collect(), curve.is_closed()).unwrap()
}

pub fn outlines() -> impl Strategy<Value = Outline> {
    (0.0..0.2_f64, 2..6_u32).prop_map(|(bump, lobes)| Outline { bump, lobes: f64::from(lobes) })
}

pub fn looks() -> impl Strategy<Value = Vec<Look>> {
    let look = (0.0..TAU, 1.0..4.0_f64, 0.015..0.025_f64, any::<u64>())
        .prop_map(|(from, sweep, spacing, seed)| Look { from, sweep, spacing, seed });
    prop::collection::vec(look, 1..8)
}
