//! A sheet that several views measured stays one curve, whatever their noise.

use crate::draws::Noise;
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

    /// Surfaces at heights in standard deviations, the first whole and the others over a part, seen
    /// by all views.
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
fn one_sheet_stays_one() {
    for (name, kind) in KINDS {
        for draw in 0..DRAWS {
            let fused = kind.fuse(draw, &[0.0], (0.0, LENGTH));
            assert_eq!(fused.curves.len(), 1, "{name}, draw {draw}");
        }
    }
}
