//! No curve of a result crosses or touches itself or another one, whatever the views say.

use proptest::prelude::*;
use transect_fusion::{ConsensusOptions, FusionMethod, PairwiseOptions, fuse_plane};
use transect_geometry::{Curve, Node, Point2, crossings};

/// The start of a walk, its heading, its turns and steps, and whether it is closed.
type Walk = ((f64, f64), f64, Vec<(f64, f64)>, bool);

/// A view's curves: walks of random turns, off the other views' by any pose error.
fn walks() -> impl Strategy<Value = Vec<Curve>> {
    let walk = (
        (-1.0..1.0, -1.0..1.0),
        0.0..6.3,
        prop::collection::vec((-0.9..0.9, 0.02..0.2), 3..40),
        any::<bool>(),
    );
    let curve = |((x, y), heading, steps, closed): Walk| {
        let start = (Point2::new(x, y), heading);
        let places = steps.into_iter().scan(start, |(at, heading), (turn, step)| {
            *heading += turn;
            at.x += step * heading.cos();
            at.y += step * heading.sin();
            Some(Node::at(*at).with_footprint(0.1).with_sigma(0.01))
        });
        Curve::new(places.collect(), closed).unwrap()
    };
    prop::collection::vec(walk.prop_map(curve), 1..4)
}

/// Views of one wavy wall that differ by several footprints.
fn misplaced_walls() -> impl Strategy<Value = Vec<Vec<Curve>>> {
    let view = (-0.3..0.3, -0.3..0.3, 0.0..0.1, 0_u32..1000);
    let wall = |(offset, slope, noise, seed): (f64, f64, f64, u32)| {
        let node = |k: u32| {
            let x = 0.05 * f64::from(k);
            let wave = noise * (f64::from(k * 7919 + seed) * 0.7).sin();
            let place = Point2::new(x, offset + slope * (x - 2.0) + wave);
            Node::at(place).with_footprint(0.05).with_sigma(0.005)
        };
        vec![Curve::new((0..80).map(node).collect(), false).unwrap()]
    };
    prop::collection::vec(view.prop_map(wall), 2..8)
}

fn assert_planar(views: &[Vec<Curve>]) -> Result<(), TestCaseError> {
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    for method in [
        FusionMethod::Consensus(ConsensusOptions::default()),
        FusionMethod::Pairwise(PairwiseOptions::default()),
    ] {
        let plane = fuse_plane(&slices, &method);
        prop_assert_eq!(crossings(&plane.curves), vec![], "{:?}", method);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn nothing_crosses_however_wild_the_views(views in prop::collection::vec(walks(), 1..5)) {
        assert_planar(&views)?;
    }

    #[test]
    fn nothing_crosses_however_far_off_the_poses(views in misplaced_walls()) {
        assert_planar(&views)?;
    }
}
