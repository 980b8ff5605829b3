//! Corners of sections come out sharp, and what is round stays round.

use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use transect_fusion::{ConsensusOptions, PairwiseOptions, consensus, pairwise};
use transect_geometry::{Curve, Node, Point2, Vector2};

/// Distance between neighbouring nodes, and a node's standard deviation.
const SPACING: f64 = 0.02;
const SIGMA: f64 = 0.0005;

/// A square from -1 to 1 whose corners are rounded with a radius; 0 for sharp ones.
#[derive(Debug, Clone, Copy)]
struct Square {
    radius: f64,
}

impl Square {
    /// Length of a straight side, and of one with the arc behind it.
    fn lengths(&self) -> (f64, f64) {
        let side = 2.0 * (1.0 - self.radius);
        (side, side + self.radius * FRAC_PI_2)
    }

    /// The place at an arc length, counter-clockwise, so that the solid lies to the left.
    fn at(&self, s: f64) -> Point2 {
        let (side, period) = self.lengths();
        let (s, corner) = (s.rem_euclid(period), s.div_euclid(period));
        let r = self.radius;
        let local = if s <= side {
            Vector2::new(s - 0.5 * side, -1.0)
        } else {
            let (sin, cos) = ((s - side) / r).sin_cos();
            Vector2::new(0.5 * side + r * sin, r - 1.0 - r * cos)
        };
        let (sin, cos) = (corner * FRAC_PI_2).sin_cos();
        Point2::new(cos * local.x - sin * local.y, sin * local.x + cos * local.y)
    }

    fn seen(&self, view: u64, sigma: f64) -> Vec<Curve> {
        let length = 4.0 * self.lengths().1;
        let count = (length / SPACING) as u64;
        let node = |k: u64| {
            let s = (k as f64 + 0.31 * view as f64) * length / count as f64;
            let error = Vector2::new(noise(view, 2 * k), noise(view, 2 * k + 1)) * sigma;
            Node::at(self.at(s) + error)
                .with_sigma(sigma.max(1e-6) as f32)
                .with_footprint(SPACING as f32)
        };
        vec![Curve::new((0..count).map(node).collect(), true).unwrap()]
    }

    fn fused(&self, sigma: f64) -> Vec<Curve> {
        let views: Vec<Vec<Curve>> = (0..6).map(|view| self.seen(view, sigma)).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        consensus(&slices, &ConsensusOptions::default()).curves
    }

    /// Largest distance of the square's outline from a curve.
    fn farthest_from(&self, curve: &Curve) -> f64 {
        let length = 4.0 * self.lengths().1;
        let places = (0..4000).map(|k| self.at(f64::from(k) * length / 4000.0));
        places.map(|p| curve.foot(&p).distance).fold(0.0, f64::max)
    }
}

/// A number of about normal distribution, by view and node.
fn noise(view: u64, k: u64) -> f64 {
    let mut x = (view << 32 | k).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut uniform = || {
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

#[test]
fn corners_between_samples_come_out_sharp() {
    let square = Square { radius: 0.0 };
    for sigma in [0.0, SIGMA] {
        let curves = square.fused(sigma);
        assert_eq!(curves.len(), 1);
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let off = curves[0].foot(&Point2::new(x, y)).distance;
            // Chords between nodes a footprint apart cut off up to a third of one.
            assert!(off <= 0.05 * SPACING + sigma, "({x}, {y}) at {sigma}: {off}");
        }
    }
}

#[test]
fn fillets_of_three_footprints_stay_round() {
    for sigma in [0.0, SIGMA] {
        let square = Square { radius: 3.0 * SPACING };
        let curves = square.fused(sigma);
        assert_eq!(curves.len(), 1);
        // The sharp corner lies 0.41 radii off.
        let off = square.farthest_from(&curves[0]);
        assert!(off < 0.12 * SPACING + 3.0 * sigma, "{sigma}: {off}");
    }
}

#[test]
fn no_corner_goes_where_nobody_saw_the_ground() {
    // Errors that samples share, as smoothing leaves them, say that a single pixel's are large.
    let shared = (0.2 * SPACING, 5.0 * SPACING);
    let corner = Point2::new(1.0, 1.0);
    let square = Square { radius: 0.0 };
    let view = |view: u64| {
        let seen = square.seen(view, 0.1 * SIGMA).remove(0);
        let far = |n: &&Node| (n.position - corner).norm() > 2.6 * SPACING;
        let from = seen.nodes().iter().position(|n| !far(&n)).unwrap();
        let nodes = [&seen.nodes()[from..], &seen.nodes()[..from]].concat();
        let known = |n: &Node| n.with_sigma(shared.0 as f32).with_correlation(shared.1 as f32);
        vec![Curve::new(nodes.iter().filter(far).map(known).collect(), false).unwrap()]
    };
    let views: Vec<Vec<Curve>> = (0..6).map(view).collect();
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let curves = consensus(&slices, &ConsensusOptions::default()).curves;
    assert_eq!(curves.len(), 1);
    assert!(curves[0].nodes().iter().any(|n| n.bridged), "a gap that no view saw");
    for node in curves[0].nodes().iter().filter(|n| n.views.is_some()) {
        assert!((node.position - corner).norm() > 2.0 * SPACING, "{}", node.position);
    }
}

/// The outline of a thin bar along x, its right end a half circle or square, its left one far away.
#[derive(Debug, Clone, Copy)]
struct Bar {
    width: f64,
    round: bool,
}

impl Bar {
    const LENGTH: f64 = 60.0 * SPACING;

    /// The place at an arc length, round the right end from the lower side to the upper one.
    fn at(&self, s: f64) -> Point2 {
        let half = 0.5 * self.width;
        let end = if self.round { PI * half } else { self.width };
        let straight = if self.round { Self::LENGTH - half } else { Self::LENGTH };
        match s - straight {
            before if before <= 0.0 => Point2::new(s, -half),
            after if after >= end => Point2::new(straight - (after - end), half),
            on if self.round => {
                let (sin, cos) = (on / half).sin_cos();
                Point2::new(straight + half * sin, -half * cos)
            }
            on => Point2::new(straight, on - half),
        }
    }

    fn fused(&self, sigma: f64) -> Vec<Curve> {
        let length = 2.0 * Self::LENGTH;
        let view = |view: u64| {
            let node = |k: u64| {
                let s = (k as f64 + 0.31 * view as f64) * SPACING;
                let error = Vector2::new(noise(view, 2 * k), noise(view, 2 * k + 1)) * sigma;
                let sigma = sigma.max(1e-6) as f32;
                Node::at(self.at(s) + error).with_sigma(sigma).with_footprint(SPACING as f32)
            };
            vec![Curve::new((0..(length / SPACING) as u64).map(node).collect(), false).unwrap()]
        };
        let views: Vec<Vec<Curve>> = (0..6).map(view).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        consensus(&slices, &ConsensusOptions::default()).curves
    }
}

#[test]
fn the_end_of_a_thin_bar_has_two_corners() {
    for footprints in [3.0, 4.0, 5.0] {
        for sigma in [SIGMA, 3.0 * SIGMA] {
            let bar = Bar { width: footprints * SPACING, round: false };
            let curves = bar.fused(sigma);
            for y in [-0.5, 0.5] {
                let corner = Point2::new(Bar::LENGTH, y * bar.width);
                let off = curves.iter().map(|c| c.foot(&corner).distance);
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(off <= 0.1 * SPACING + 2.0 * sigma, "{footprints} {sigma} {y}: {off}");
            }
        }
    }
}

#[test]
fn the_round_end_of_a_thin_bar_stays_round() {
    for footprints in [4.0, 5.0, 6.0] {
        for sigma in [0.0, SIGMA, 3.0 * SIGMA] {
            let bar = Bar { width: footprints * SPACING, round: true };
            for curve in bar.fused(sigma) {
                for node in curve.nodes().iter().filter(|n| n.position.x > 0.5 * Bar::LENGTH) {
                    // A corner would lie 0.41 half widths outside.
                    let d = node.position - Point2::new(Bar::LENGTH - 0.5 * bar.width, 0.0);
                    let off = d.y.hypot(d.x.max(0.0)) - 0.5 * bar.width;
                    assert!(off < 0.12 * SPACING + 3.0 * sigma, "{footprints} {sigma}: {off}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Rings have no corner, however few nodes they have.
    #[test]
    fn rings_get_no_corners(footprints in 2.0_f64..30.0, phase in 0.0_f64..1.0, sigma in 0.0..SIGMA) {
        let radius: f64 = footprints * SPACING;
        let count = f64::ceil(TAU * footprints) as u64;
        let view = |view: u64| {
            let node = |k: u64| {
                let a = (k as f64 + phase + 0.31 * view as f64) * TAU / count as f64;
                let r: f64 = radius + sigma * noise(view, k);
                let sigma = sigma.max(1e-6) as f32;
                Node::at(Point2::new(r * a.cos(), r * a.sin())).with_sigma(sigma).with_footprint(SPACING as f32)
            };
            vec![Curve::new((0..count).map(node).collect(), true).unwrap()]
        };
        let views: Vec<Vec<Curve>> = (0..6).map(view).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let fused = consensus(&slices, &ConsensusOptions::default());
        for node in fused.curves.iter().flat_map(Curve::nodes) {
            // A corner on three footprints of arc would lie a third of one outside.
            let off = node.position.coords.norm() - radius;
            prop_assert!(off < 4.0 * sigma + 0.05 * SPACING, "{off}");
        }
    }
}

#[test]
fn sharp_corners_seen_by_many_views_do_not_fork() {
    let square = Square { radius: 0.0 };
    let view = |k: i32| {
        // A step of its own for each view, and poses that are off by up to 0.004.
        let (from, step) = (1.7 * f64::from(k), 0.018 + 0.001 * f64::from(k % 4));
        let off = Vector2::new(f64::from(k % 3 - 1), f64::from(k % 5 - 2)) * 0.002;
        let node = |i: i32| Node::at(square.at(from + step * f64::from(i)) + off);
        vec![Curve::new((0..150).map(node).collect(), false).unwrap()]
    };
    for count in [8, 40] {
        let views: Vec<_> = (0..count).map(view).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let fused = pairwise(&slices, &PairwiseOptions::default());
        let growth = fused.growth.unwrap();
        assert_eq!((fused.curves.len(), growth.cut + growth.refused()), (1, 0), "{count} views");
        assert!(fused.curves[0].is_closed());
        let area = fused.curves[0].signed_area().unwrap();
        assert!((area - 4.0).abs() < 0.02, "{count} views: {area}");
    }
}
