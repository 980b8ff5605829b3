use super::*;
use transect_geometry::Point2;

/// A polyline whose nodes have a footprint and a noise.
fn polyline(points: &[(f64, f64)], closed: bool, footprint: f32, sigma: f32) -> Curve {
    let node = |&(x, y): &(f64, f64)| {
        Node::at(Point2::new(x, y)).with_footprint(footprint).with_sigma(sigma)
    };
    Curve::new(points.iter().map(node).collect(), closed).unwrap()
}

fn square(x: f64, size: f64) -> Curve {
    polyline(&[(x, 0.0), (x + size, 0.0), (x + size, size), (x, size)], true, 0.0, 0.0)
}

fn reason(lower: &[Curve], upper: &[Curve]) -> Option<DifferenceReason> {
    difference(lower, upper, 0.1).map(|d| d.reason)
}

#[test]
fn what_moves_is_told_from_what_comes_and_goes() {
    let (post, far_post) = ([square(0.0, 2.0)], square(5.0, 1.0));
    assert_eq!(reason(&post, &post), None);
    assert_eq!(reason(&[], &[]), None);
    assert_eq!(reason(&post, &[square(0.05, 2.0)]), None);
    let moved = difference(&post, &[square(0.3, 2.0)], 0.1).unwrap();
    assert_eq!(moved.reason, DifferenceReason::CurvesMove);
    assert!((moved.distance.unwrap() - 0.3).abs() < 0.02, "{moved:?}");
    // Two sides of 2 on either plane, and what stands over at the others.
    assert!((moved.length - 8.8).abs() < 0.6, "{moved:?}");
    // All of it is far, but each is the other's nearest.
    assert_eq!(
        reason(&[square(0.0, 2.0)], &[square(0.5, 1.0)]),
        Some(DifferenceReason::CurvesMove)
    );
    let both = [square(0.0, 2.0), far_post];
    assert_eq!(reason(&post, &both), Some(DifferenceReason::CurveAppears));
    assert_eq!(reason(&both, &post), Some(DifferenceReason::CurveVanishes));
    let nothing = difference(&both, &[], 0.1).unwrap();
    assert_eq!((nothing.reason, nothing.distance), (DifferenceReason::CurveVanishes, None));
    assert!((nothing.length - 12.0).abs() < 1e-9);
    // A hole where the post was runs the other way round.
    assert!(reason(&post, &[square(0.0, 2.0).reversed()]).is_some());
}

#[test]
fn neither_noise_nor_ragged_ends_count() {
    let line = |length: f64, y: f64, footprint: f32, sigma: f32| {
        let nodes: Vec<_> =
            (0..=(length * 100.0) as i32).map(|k| (f64::from(k) * 0.01, y)).collect();
        polyline(&nodes, false, footprint, sigma)
    };
    let difference_of = |a: Curve, b: Curve| reason(&[a], &[b]);
    let floor = |y| line(2.0, y, 0.01, 0.02);
    // Three standard deviations of both are 0.085.
    assert_eq!(difference_of(floor(0.0), floor(0.18)), None);
    assert_eq!(difference_of(floor(0.0), floor(0.19)), Some(DifferenceReason::CurvesMove));
    // It goes on for 0.3, of which 0.2 are farther than the tolerance.
    let on =
        |footprint| difference_of(line(2.0, 0.0, footprint, 0.0), line(2.3, 0.0, footprint, 0.0));
    assert_eq!(on(0.06), None);
    assert_eq!(on(0.04), Some(DifferenceReason::EndsShift));
    let speck = line(0.2, 5.0, 0.06, 0.0);
    assert_eq!(reason(&[floor(0.0)], &[floor(0.0), speck.clone()]), None);
    assert!(!worth_a_plane(&speck) && worth_a_plane(&floor(0.0)));
}

#[test]
fn a_stretch_across_where_a_closed_curve_begins_is_one() {
    // The corner at which the square begins is pushed in; either half of the stretch is too short.
    let nodes = |corner: f64| {
        let side: Vec<f64> = (0..10).map(|k| f64::from(k) * 0.1).collect();
        let sides = side.iter().map(|&t| (t, 0.0)).chain(side.iter().map(|&t| (1.0, t)));
        let sides = sides.chain(side.iter().map(|&t| (1.0 - t, 1.0)));
        let mut sides: Vec<_> = sides.chain(side.iter().map(|&t| (0.0, 1.0 - t))).collect();
        sides[0] = (corner, corner);
        polyline(&sides, true, 0.04, 0.0)
    };
    let found = difference(&[nodes(0.0)], &[nodes(-0.4)], 0.1);
    assert!(found.is_some_and(|d| d.length > 0.5), "{found:?}");
}
