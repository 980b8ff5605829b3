//! Neighbouring surfaces of one direction: two stay two, one stays one.
//!
//! `cargo test -p transect-fusion --test sheets -- --nocapture` prints the table.
#![allow(clippy::unwrap_used, reason = "test code; shared helpers are outside test functions")]

mod draws;

use draws::Noise;
use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::{Curve, Node, Point2};

const SIGMA: f64 = 0.004;
const LENGTH: f64 = 4.0;
const DRAWS: u64 = 15;

/// Sheets above each other, along arcs or straight.
#[derive(Debug, Clone, Copy)]
struct Sheets {
    views: u64,
    spacing: f64,
    /// Curvature; 0 for straight ones.
    bend: f64,
    /// Standard deviation of what a view errs by in common, in those of a node.
    common: f64,
}

const PLAIN: Sheets = Sheets { views: 8, spacing: 0.02, bend: 0.0, common: 0.0 };

impl Sheets {
    /// A place by its way along the lowest sheet and its height above it.
    fn at(&self, along: f64, height: f64) -> Point2 {
        if self.bend == 0.0 {
            return Point2::new(along, height);
        }
        let radius = 1.0 / self.bend;
        let (sin, cos) = (along * self.bend).sin_cos();
        Point2::new((radius - height) * sin, radius - (radius - height) * cos)
    }

    fn height(&self, p: &Point2) -> f64 {
        let radius = 1.0 / self.bend;
        if self.bend == 0.0 { p.y } else { radius - (p - Point2::new(0.0, radius)).norm() }
    }

    fn layer(&self, noise: &mut Noise, height: f64, (from, to): (f64, f64)) -> Curve {
        let phase = noise.uniform();
        let node = |k: usize| {
            let along = from + self.spacing * (k as f64 + phase);
            let position = self.at(along, height + SIGMA * noise.normal());
            Node::at(position).with_sigma(SIGMA as f32).with_footprint(self.spacing as f32)
        };
        let count = ((to - from) / self.spacing) as usize;
        Curve::new((0..count).map(node).collect(), false).unwrap()
    }

    /// Surfaces at heights in standard deviations, the first whole and the others over a part, seen by
    /// all views.
    fn fuse(&self, draw: u64, heights: &[f64], part: (f64, f64)) -> FusedPlane {
        let mut noise = Noise(1 + 1000 * draw);
        let view = |_| {
            let common = self.common * noise.normal();
            let layer = |(k, h): (usize, &f64)| {
                let part = if k == 0 { (0.0, LENGTH) } else { part };
                self.layer(&mut noise, (h + common) * SIGMA, part)
            };
            heights.iter().enumerate().map(layer).collect()
        };
        let views: Vec<Vec<Curve>> = (0..self.views).map(view).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        consensus(&slices, &ConsensusOptions::default())
    }

    /// In how many draws two sheets come out as one, as two, and as more curves.
    fn counts(&self, apart: f64) -> [u64; 3] {
        let mut counts = [0; 3];
        for draw in 0..DRAWS {
            let curves = self.fuse(draw, &[0.0, apart], (0.0, LENGTH)).curves.len();
            counts[curves.clamp(1, 3) - 1] += 1;
        }
        counts
    }
}

/// The kinds of sheets that are looked at.
const KINDS: [(&str, Sheets); 6] = [
    ("8 views", PLAIN),
    ("3 views", Sheets { views: 3, ..PLAIN }),
    ("finer", Sheets { spacing: 0.006, ..PLAIN }),
    ("coarser", Sheets { spacing: 0.05, ..PLAIN }),
    ("bent", Sheets { bend: 0.5, ..PLAIN }),
    ("shifted", Sheets { common: 0.7, ..PLAIN }),
];

#[test]
fn two_sheets_stay_two_from_six_sigma_on() {
    println!("of {DRAWS} draws as one, two, more curves, by the gap in standard deviations");
    for (name, kind) in KINDS {
        print!("{name:>8}");
        let all = [4.0, 5.0, 6.0, 7.0, 8.0, 10.0];
        for &apart in if name == "8 views" { &all[..] } else { &all[2..3] } {
            let counts = kind.counts(apart);
            print!("  {apart}: {counts:?}");
            // Six are less than five of what shifted views differ by, and fine samples say less each.
            let least = match name {
                "shifted" => DRAWS / 2,
                "finer" => DRAWS - 2,
                _ => DRAWS,
            };
            assert!(apart < 6.0 || counts[1] >= least, "{name}, {apart} apart: {counts:?}");
            assert!(apart > 4.0 || counts[0] == DRAWS, "{name}, {apart} apart: {counts:?}");
        }
        println!();
    }
}

#[test]
fn one_sheet_stays_one() {
    for (name, kind) in KINDS {
        for draw in 0..DRAWS {
            let fused = kind.fuse(draw, &[0.0], (0.0, LENGTH));
            assert_eq!(fused.curves.len(), 1, "{name}, draw {draw}");
        }
    }
}

#[test]
fn sheets_six_sigma_apart_are_where_they_are() {
    for kind in [PLAIN, Sheets { bend: 0.5, ..PLAIN }] {
        for draw in 0..DRAWS {
            // Three of them, the upper two shorter.
            let fused = kind.fuse(draw, &[0.0, 6.0, 12.0], (1.0, 3.0));
            let length: f64 = fused.curves.iter().map(Curve::length).sum();
            assert!((7.8..8.3).contains(&length), "{kind:?}, draw {draw}: {length}");
            let heights = [0.0, 6.0, 12.0].map(|h| {
                let inner = fused.curves.iter().flat_map(|c| c.nodes());
                let of_layer = inner.map(|n| kind.height(&n.position) / SIGMA - h);
                let off: Vec<f64> = of_layer.filter(|off| off.abs() < 3.0).collect();
                off.iter().sum::<f64>() / off.len() as f64
            });
            assert!(
                heights.iter().all(|off| off.abs() < 0.1),
                "{kind:?}, draw {draw}: {heights:?}"
            );
        }
    }
}
