//! The union of overlapping sections in their plane.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::ShapeType;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::overlay::FloatOverlay;
use i_overlay::i_float::adapter::FloatPointAdapter;
use i_overlay::i_float::float::rect::FloatRect;
use transect_geometry::{Curve, Envelope, Node, Point2};

/// Positions snap to a grid of this share of the largest extent (2⁻³²; nanometres in a room).
///
/// Chosen by hand: fine enough for truth, and coarse enough that two solids which touch up to the
/// rounding of their poses share an edge without a slit. Doubling it changes nothing visible.
const GRID: f64 = 1.0 / 4_294_967_296.0;

/// Closed curves resolved into rings that bound their union: no two cross or overlap, outer ones
/// run counter-clockwise and holes clockwise. Open curves follow, unchanged.
///
/// A place belongs to the union if the curves wind around it a positive number of times; the ring
/// of a hole without its solid around it therefore vanishes. Vertices in straight edges go away,
/// positions move by no more than about 2⁻³¹ of the extent, and the nodes' other properties are
/// reset.
pub fn merge_overlaps(curves: Vec<Curve>) -> Vec<Curve> {
    let (closed, open): (Vec<_>, Vec<_>) = curves.into_iter().partition(Curve::is_closed);
    let mut merged = union(&closed).unwrap_or(closed);
    merged.extend(open);
    merged
}

/// `None` if there are no closed curves, or coordinates are too large for the grid.
fn union(closed: &[Curve]) -> Option<Vec<Curve>> {
    let around = closed.iter().map(Curve::envelope).reduce(|a, b| Envelope::merged(&a, &b))?;
    let rings: Vec<Vec<[f64; 2]>> = closed.iter().map(ring).collect();
    let corners = [[around.min.x, around.min.y], [around.max.x, around.max.y]];
    let rect = FloatRect::with_iter(corners.iter()).ok()??;
    // A power of two, so that round coordinates stay round.
    let extent = around.size().amax().log2().ceil().exp2();
    let adapter = FloatPointAdapter::<[f64; 2], i64>::try_with_scale_conservative(
        rect,
        1.0 / (GRID * extent),
    );
    let count = rings.iter().map(Vec::len).sum();
    let overlay = FloatOverlay::with_adapter(adapter.ok()?, count);
    let mut overlay = overlay.unsafe_add_source(&rings, ShapeType::Subject);
    let shapes = overlay.overlay(OverlayRule::Subject, FillRule::Positive);
    Some(shapes.iter().flatten().filter_map(|ring| curve(ring)).collect())
}

fn ring(curve: &Curve) -> Vec<[f64; 2]> {
    curve.nodes().iter().map(|n| [n.position.x, n.position.y]).collect()
}

fn curve(ring: &[[f64; 2]]) -> Option<Curve> {
    let nodes = ring.iter().map(|&[x, y]| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, true).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Curve {
        curve(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).unwrap()
    }

    fn areas(curves: &[Curve]) -> Vec<f64> {
        curves.iter().filter_map(Curve::signed_area).collect()
    }

    #[test]
    fn overlapping_rectangles_become_one_ring() {
        let merged = merge_overlaps(vec![rectangle(0., 0., 2., 2.), rectangle(1., 1., 3., 3.)]);
        assert_eq!(areas(&merged), [7.0]);
        assert_eq!(merged[0].nodes().len(), 8);
    }

    #[test]
    fn touching_but_for_rounding_leaves_no_slit() {
        let nearly = 2.0 + 4e-16;
        let merged = merge_overlaps(vec![rectangle(0., 0., 2., 2.), rectangle(nearly, 0., 4., 2.)]);
        assert_eq!(merged.len(), 1);
        assert_eq!(merged[0].nodes().len(), 4);
        assert!((areas(&merged)[0] - 8.0).abs() < 1e-8);
    }

    #[test]
    fn four_walls_enclose_a_clockwise_hole() {
        let merged = merge_overlaps(vec![
            rectangle(0., 0., 6., 1.),
            rectangle(0., 4., 6., 5.),
            rectangle(0., 0., 1., 5.),
            rectangle(5., 0., 6., 5.),
        ]);
        assert_eq!(areas(&merged), [30.0, -12.0]);
    }

    #[test]
    fn nested_solids_fill_and_holes_stay() {
        let hole = rectangle(1., 1., 2., 2.).reversed();
        let merged = merge_overlaps(vec![rectangle(0., 0., 4., 4.), hole]);
        assert_eq!(areas(&merged), [16.0, -1.0]);
        let nested = merge_overlaps(vec![rectangle(0., 0., 4., 4.), rectangle(1., 1., 2., 2.)]);
        assert_eq!(areas(&nested), [16.0]);
    }

    #[test]
    fn open_curves_pass_and_nothing_gives_nothing() {
        let open = Curve::new(rectangle(0., 0., 1., 1.).into_nodes(), false).unwrap();
        assert_eq!(merge_overlaps(vec![open.clone()]), [open]);
        assert_eq!(merge_overlaps(Vec::new()), []);
    }

    #[test]
    fn world_sized_coordinates_keep_their_area() {
        let (x, y) = (5.0e5, 5.4e6);
        let merged = merge_overlaps(vec![
            rectangle(x, y, x + 2.0, y + 2.0),
            rectangle(x + 1.0, y + 1.0, x + 3.0, y + 3.0),
        ]);
        assert!((areas(&merged)[0] - 7.0).abs() < 1e-7);
    }
}
