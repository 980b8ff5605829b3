//! Curves of known shape as views would see them.

use std::f64::consts::TAU;
use transect_geometry::{Curve, Node, Point2};

/// Uniform and normal numbers from a seed (SplitMix64; sum of twelve).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// How a circle around the origin is seen.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    pub radius: f64,
    /// Where the arc begins, and how far it goes, in radians.
    pub from: f64,
    pub sweep: f64,
    pub spacing: f64,
    pub sigma: f64,
}

impl Look {
    /// What is seen: an arc, closed if it goes all the way round, sampled at a phase of its own.
    pub fn curve(&self, seed: u64) -> Option<Curve> {
        let mut random = Random::new(1 + seed);
        let closed = self.sweep >= TAU;
        let count = (self.sweep.min(TAU) * self.radius / self.spacing) as usize;
        let step = if closed { TAU / count as f64 } else { self.spacing / self.radius };
        let phase = random.uniform();
        let node = |k: usize| {
            let a = self.from + step * (k as f64 + phase);
            let r = self.radius + self.sigma * random.normal();
            Node::at(Point2::new(r * a.cos(), r * a.sin()))
                .with_sigma(self.sigma as f32)
                .with_footprint(self.spacing as f32)
        };
        Curve::new((0..count).map(node).collect(), closed).ok()
    }
}

/// References to the curves of every view.
pub fn slices(views: &[Vec<Curve>]) -> Vec<&[Curve]> {
    views.iter().map(Vec::as_slice).collect()
}
