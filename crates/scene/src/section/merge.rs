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
///
/// # Errors
/// [`MergeError`] if no grid holds the closed curves. That needs coordinates beyond 2⁵⁰⁰, or an
/// extent below 1e-290, in the model's length unit.
pub fn merge_overlaps(curves: Vec<Curve>) -> Result<Vec<Curve>, MergeError> {
    let (closed, open): (Vec<_>, Vec<_>) = curves.into_iter().partition(Curve::is_closed);
    let mut merged = union(&closed)?;
    merged.extend(open);
    Ok(merged)
}

/// Closed curves for which no grid exists.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "closed curves within {extent:e} of each other, with coordinates up to {largest:e}, cannot be \
     united: no grid holds them. Check the size and the unit of the solids"
)]
pub struct MergeError {
    /// Width or height of the box around the curves, the larger one, in the model's length unit.
    pub extent: f64,
    /// Largest coordinate of the curves in their plane, in the model's length unit.
    pub largest: f64,
}

fn union(closed: &[Curve]) -> Result<Vec<Curve>, MergeError> {
    let around = closed.iter().map(Curve::envelope).reduce(|a, b| Envelope::merged(&a, &b));
    // Curves that lie in one place bound nothing.
    let Some(around) = around.filter(|around| around.size().amax() > 0.0) else {
        return Ok(Vec::new());
    };
    let rings: Vec<Vec<[f64; 2]>> = closed.iter().map(ring).collect();
    let count = rings.iter().map(Vec::len).sum();
    let overlay = FloatOverlay::with_adapter(adapter(&around)?, count);
    let mut overlay = overlay.unsafe_add_source(&rings, ShapeType::Subject);
    let shapes = overlay.overlay(OverlayRule::Subject, FillRule::Positive);
    Ok(shapes.iter().flatten().filter_map(|ring| curve(ring)).collect())
}

/// The grid that positions within an envelope snap to.
fn adapter(around: &Envelope) -> Result<FloatPointAdapter<[f64; 2], i64>, MergeError> {
    let extent = around.size().amax();
    let largest = around.min.coords.amax().max(around.max.coords.amax());
    let refused = MergeError { extent, largest };
    let corners = [[around.min.x, around.min.y], [around.max.x, around.max.y]];
    let rect = FloatRect::with_iter(corners.iter()).ok().flatten().ok_or(refused)?;
    // A power of two, so that round coordinates stay round.
    let scale = 1.0 / (GRID * extent.log2().ceil().exp2());
    FloatPointAdapter::try_with_scale_conservative(rect, scale).map_err(|_| refused)
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
        let merged =
            merge_overlaps(vec![rectangle(0., 0., 2., 2.), rectangle(1., 1., 3., 3.)]).unwrap();
        assert_eq!(areas(&merged), [7.0]);
        assert_eq!(merged[0].nodes().len(), 8);
    }

    #[test]
    fn touching_but_for_rounding_leaves_no_slit() {
        let nearly = 2.0 + 4e-16;
        let merged =
            merge_overlaps(vec![rectangle(0., 0., 2., 2.), rectangle(nearly, 0., 4., 2.)]).unwrap();
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
        ])
        .unwrap();
        assert_eq!(areas(&merged), [30.0, -12.0]);
    }

    #[test]
    fn nested_solids_fill_and_holes_stay() {
        let hole = rectangle(1., 1., 2., 2.).reversed();
        let merged = merge_overlaps(vec![rectangle(0., 0., 4., 4.), hole]).unwrap();
        assert_eq!(areas(&merged), [16.0, -1.0]);
        let nested =
            merge_overlaps(vec![rectangle(0., 0., 4., 4.), rectangle(1., 1., 2., 2.)]).unwrap();
        assert_eq!(areas(&nested), [16.0]);
    }

    #[test]
    fn open_curves_pass_and_nothing_gives_nothing() {
        let open = Curve::new(rectangle(0., 0., 1., 1.).into_nodes(), false).unwrap();
        assert_eq!(merge_overlaps(vec![open.clone()]).unwrap(), [open]);
        assert_eq!(merge_overlaps(Vec::new()).unwrap(), []);
        let point = curve(&[[3.0, 4.0]; 3]).unwrap();
        assert_eq!(merge_overlaps(vec![point]).unwrap(), [], "a point bounds nothing");
    }

    #[test]
    fn curves_that_no_grid_holds_are_refused_and_not_passed_on_as_they_are() {
        let overlapping = |size: f64| {
            merge_overlaps(vec![
                rectangle(0., 0., 2.0 * size, 2.0 * size),
                rectangle(size, size, 3.0 * size, 3.0 * size),
            ])
        };
        for size in [1e-280, 1e-9, 1.0, 1e12] {
            assert_eq!(overlapping(size).map(|merged| merged.len()), Ok(1), "{size}");
        }
        for size in [1e-310, 1e160] {
            let error = overlapping(size).unwrap_err();
            assert_eq!(error, MergeError { extent: 3.0 * size, largest: 3.0 * size });
            assert!(error.to_string().contains("cannot be united: no grid holds them"), "{error}");
        }
    }

    #[test]
    fn world_sized_coordinates_keep_their_area() {
        let (x, y) = (5.0e5, 5.4e6);
        let merged = merge_overlaps(vec![
            rectangle(x, y, x + 2.0, y + 2.0),
            rectangle(x + 1.0, y + 1.0, x + 3.0, y + 3.0),
        ])
        .unwrap();
        assert!((areas(&merged)[0] - 7.0).abs() < 1e-7);
    }
}
