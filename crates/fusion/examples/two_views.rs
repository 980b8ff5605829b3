//! Fuses what two views measured of the corner of a room:
//! `cargo run -p transect-fusion --example two_views`.

use transect_fusion::{FusionMethod, fuse_plane};
use transect_geometry::{Curve, CurveError, Node, Point2};

/// Distance between the samples of a view, in metres.
const SPACING: f64 = 0.02;

/// A view's curve of the corner at the origin: the wall along x from `from` to the corner,
/// and the wall along y up to `to`. All its points are `off` to the side.
fn view(from: f64, to: f64, off: f64) -> Result<Vec<Curve>, CurveError> {
    let steps = |length: f64| 1..=(length / SPACING) as u32;
    let along_x = steps(from).rev().map(|k| Point2::new(-SPACING * f64::from(k), off));
    let along_y = steps(to).map(|k| Point2::new(off, SPACING * f64::from(k)));
    let node = |place| Node::at(place).with_footprint(SPACING as f32).with_sigma(0.001);
    Ok(vec![Curve::new(along_x.chain(along_y).map(node).collect(), false)?])
}

fn main() -> Result<(), CurveError> {
    // The first view saw 3 m of one wall and 1 m of the other, the second view 1 m and 2 m.
    let views = [view(3.0, 1.0, 0.0)?, view(1.0, 2.0, 0.002)?];
    let slices = [views[0].as_slice(), views[1].as_slice()];
    let plane = fuse_plane(&slices, &FusionMethod::default());

    // One curve round the corner, as long as both views together saw.
    assert_eq!(plane.curves.len(), 1);
    assert!((plane.curves[0].length() - 5.0).abs() < 0.1);
    // Where both saw the wall, the curve runs between them.
    let shared = plane.curves[0].foot(&Point2::new(-0.5, 0.0)).point;
    assert!((0.0005..0.0015).contains(&shared.y));
    Ok(())
}
