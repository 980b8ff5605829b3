//! Laws of the queries, with the winding number and the search through all curves as oracles.

use super::*;
use crate::samples::{circle, empty, polyline, rectangle, rings, strip, tangles};
use proptest::prelude::*;

/// How often closed curves run round a point, by the signed crossings of a ray along +x.
fn winding_number(curves: &[Curve], p: &Point2) -> i32 {
    let crossing = |u: CurveUnit| match (u.start.y <= p.y, u.end.y <= p.y) {
        (true, false) if u.line_value(p) < 0.0 => 1,
        (false, true) if u.line_value(p) > 0.0 => -1,
        _ => 0,
    };
    curves.iter().flat_map(|c| c.units().map(crossing).collect::<Vec<_>>()).sum()
}

fn points() -> impl Strategy<Value = Point2> {
    (-1.5..3.5, -1.5..1.5).prop_map(|(x, y)| Point2::new(x, y))
}

proptest! {
    #[test]
    fn closed_curves_agree_with_their_winding_number(curves in rings(), p in points()) {
        let winding = winding_number(&curves, &p);
        let expected = if winding == 1 { Location::Inside } else { Location::Outside };
        let answer = locate_in_plane(&Section::new(curves).unwrap(), &p);
        prop_assume!(answer.distance_to_nearest_curve > Some(1e-9));
        prop_assert_eq!(answer.location, expected);
    }

    #[test]
    fn the_index_answers_like_a_search_through_all_curves(
        curves in prop_oneof![rings(), tangles()], p in points(), node in 0..1000usize,
    ) {
        let nodes: Vec<_> = curves.iter().flat_map(|c| c.nodes().to_vec()).collect();
        let at_node = nodes[node % nodes.len()].position;
        let section = Section::new(curves).unwrap();
        let index = SectionIndex::new(section.clone());
        for p in [p, at_node] {
            prop_assert_eq!(index.locate(&p), locate_in_plane(&section, &p));
        }
    }

    #[test]
    fn the_order_of_curves_does_not_matter(mut curves in tangles(), p in points()) {
        let section = Section::new(curves.clone()).unwrap();
        curves.reverse();
        let reversed = Section::new(curves).unwrap();
        prop_assert_eq!(locate_in_plane(&section, &p), locate_in_plane(&reversed, &p));
    }

    #[test]
    fn turning_every_curve_round_swaps_inside_and_outside(curves in tangles(), p in points()) {
        let turned = curves.iter().map(Curve::reversed).collect();
        let answer = locate_in_plane(&Section::new(curves).unwrap(), &p);
        // Within rounding of a curve, or on the line of one, both ways round count as inside.
        prop_assume!(answer.distance_to_nearest_curve > Some(1e-6));
        let other = locate_in_plane(&Section::new(turned).unwrap(), &p);
        let swapped = match answer.location {
            Location::Inside => Location::Outside,
            Location::Outside => Location::Inside,
            Location::Unknown => Location::Unknown,
        };
        prop_assert_eq!(other.location, swapped);
    }
}

#[test]
fn beyond_an_open_end_and_on_an_empty_plane_nothing_is_known() {
    let section = Section::new(vec![strip()]).unwrap();
    let beyond = locate_in_plane(&section, &Point2::new(0.0, -0.5));
    assert_eq!(beyond.location, Location::Unknown);
    assert!((beyond.distance_to_nearest_curve.unwrap() - 1.25f64.sqrt()).abs() < 1e-12);
    let beside = locate_in_plane(&section, &Point2::new(-1.5, -0.5));
    assert_eq!(beside.location, Location::Inside);

    let nothing = empty().locate(&Point3::origin());
    let expected = SpaceAnswer {
        location: Location::Unknown,
        distance_to_nearest_curve: None,
        planes: Vec::new(),
    };
    assert_eq!(nothing, expected);
}

#[test]
fn curves_that_disagree_at_one_distance_leave_it_unknown() {
    let up = polyline(&[(0.0, -1.0), (1.0, -1.0)], false);
    let also_up = polyline(&[(0.0, 1.0), (1.0, 1.0)], false);
    let middle = Point2::new(0.5, 0.0);
    let clash = Section::new(vec![up.clone(), also_up.clone()]).unwrap();
    assert_eq!(locate_in_plane(&clash, &middle).location, Location::Unknown);
    let wall = Section::new(vec![up, also_up.reversed()]).unwrap();
    assert_eq!(locate_in_plane(&wall, &middle).location, Location::Inside);
}

#[test]
fn both_neighbouring_planes_must_agree() {
    // Planes at heights 0, 0.5 and 1.5; a post that is thinner at 0.5.
    let mut model = empty();
    model.set_curves(PlaneIndex(0), vec![rectangle(0.0, 0.0, 4.0, 4.0)]);
    model.set_curves(PlaneIndex(1), vec![rectangle(1.0, 1.0, 3.0, 3.0)]);
    model.set_curves(PlaneIndex(3), vec![rectangle(1.0, 1.0, 3.0, 3.0)]);
    let index = ModelIndex::new(&model);
    for (p, expected) in [
        (Point3::new(2.0, 2.0, 0.25), Location::Inside),
        (Point3::new(5.0, 2.0, 0.25), Location::Outside),
        (Point3::new(0.5, 2.0, 0.25), Location::Unknown),
        (Point3::new(0.5, 2.0, 0.0), Location::Inside),
        (Point3::new(0.5, 2.0, 0.5), Location::Outside),
        (Point3::new(2.0, 2.0, 0.75), Location::Unknown),
        (Point3::new(2.0, 2.0, 1.25), Location::Unknown),
        (Point3::new(2.0, 2.0, 1.5), Location::Inside),
        (Point3::new(2.0, 2.0, f64::NAN), Location::Unknown),
        (Point3::new(f64::INFINITY, 2.0, 0.0), Location::Unknown),
        (Point3::new(2.0, 2.0, 1e300), Location::Unknown),
    ] {
        assert_eq!(model.locate(&p).location, expected, "{p}");
        assert_eq!(index.locate(&p), model.locate(&p), "{p}");
    }
}

#[test]
fn planes_that_nobody_asked_for_are_not_asked() {
    // Planes at heights 0 and 2, and one between them that only the first model looked at.
    let mut model = empty();
    model.set_curves(PlaneIndex(0), vec![rectangle(0.0, 0.0, 4.0, 4.0)]);
    model.set_curves(PlaneIndex(4), vec![rectangle(1.0, 1.0, 3.0, 3.0)]);
    let between = Point3::new(2.0, 2.0, 0.5);
    assert_eq!(model.locate(&between).location, Location::Unknown);
    let some = model.clone().with_selection([]);
    for (p, expected) in [
        (between, Location::Inside),
        (Point3::new(2.0, 2.0, 1.8), Location::Inside),
        (Point3::new(0.5, 2.0, 1.8), Location::Unknown),
        (Point3::new(2.0, 2.0, 2.1), Location::Unknown),
        (Point3::new(2.0, 2.0, -0.1), Location::Unknown),
        (Point3::new(0.5, 2.0, 0.0), Location::Inside),
    ] {
        let answer = some.locate(&p);
        assert_eq!(answer.location, expected, "{p}");
        assert_eq!(ModelIndex::new(&some).locate(&p), answer, "{p}");
    }
    let asked = model.with_selection([PlaneIndex(2)]);
    assert_eq!(asked.locate(&between).location, Location::Unknown);
}

#[test]
fn far_from_the_origin_a_point_on_a_plane_is_still_on_it() {
    let (guide, interval) = (empty().planes().guide().clone(), 1e-3);
    let planes = PlaneFamily::new(guide, 5.4e6, interval).unwrap();
    for k in 0..100 {
        let on_plane = Point3::new(0.0, 0.0, 5.4e6 + f64::from(k) * interval);
        assert_eq!(
            planes_around(&planes, &PlaneSelection::ALL, &on_plane),
            [PlaneIndex(i64::from(k))]
        );
    }
}

#[test]
fn huge_coordinates_do_not_panic() {
    let huge = polyline(&[(-1e308, -1e308), (1e308, 1e308), (0.0, 1e308)], true);
    let section = Section::new(vec![huge, strip()]).unwrap();
    let index = SectionIndex::new(section);
    for p in [Point2::origin(), Point2::new(-1e308, 1e308)] {
        index.locate(&p);
    }
    assert_eq!(index.locate(&Point2::new(f64::NAN, 0.0)), PlaneAnswer::NOTHING);
}

#[test]
fn the_distance_between_planes_is_the_one_in_space() {
    let mut model = empty();
    model.set_curves(PlaneIndex(0), vec![rectangle(0.0, 0.0, 4.0, 4.0)]);
    model.set_curves(PlaneIndex(1), vec![rectangle(1.0, 1.0, 3.0, 3.0)]);
    for (p, expected) in [
        // The corner (0, 0, 0) is 0.3, 0.4 and 0.1 away.
        (Point3::new(-0.3, -0.4, 0.1), Some(0.26f64.sqrt())),
        // The edge x = 1 of the plane at 0.5 is nearer than x = 0 at 0.
        (Point3::new(0.9, 2.0, 0.3), Some(0.05f64.sqrt())),
        (Point3::new(2.0, 0.5, 0.5), Some(0.5)),
        (Point3::new(2.0, 2.0, 5.0), None),
    ] {
        let found = model.locate(&p).distance_to_nearest_curve;
        match (found, expected) {
            (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-12, "{p}"),
            other => assert_eq!(other, (None, None), "{p}"),
        }
    }
}

/// A ball of radius 1 that is hollow within a radius of 0.5, and the signed distance from its
/// surface, positive in the solid.
fn hollow_ball(interval: f64, nodes: usize) -> (Model, impl Fn(&Point3) -> f64) {
    let guide = transect_geometry::StraightGuide::along(transect_geometry::Vector3::z()).unwrap();
    let planes = PlaneFamily::new(guide, 0.3 * interval, interval).unwrap();
    let mut model = Model::new(transect_geometry::LengthUnit::Metre, planes.clone());
    let reach = (1.0 / interval) as i64 + 1;
    for k in (-reach..=reach).map(PlaneIndex) {
        let z = planes.station(k);
        let at = |radius: f64| {
            let within = radius * radius - z * z;
            (within > 1e-6).then(|| circle(Point2::origin(), within.sqrt(), nodes))
        };
        let curves = at(1.0).into_iter().chain(at(0.5).map(|hole| hole.reversed()));
        model.set_curves(k, curves.collect());
    }
    (model, |p: &Point3| (1.0 - p.coords.norm()).min(p.coords.norm() - 0.5))
}

#[test]
fn no_point_of_a_hollow_ball_is_misplaced_by_more_than_the_sampling() {
    let (interval, nodes) = (0.04, 256);
    let (model, depth) = hollow_ball(interval, nodes);
    let index = ModelIndex::new(&model);
    // Chords lie inside of the circle by at most this; planes are at most an interval away.
    let sagitta = 1.0 - (std::f64::consts::PI / nodes as f64).cos();
    let mut rng = proptest::test_runner::TestRng::deterministic_rng(
        proptest::test_runner::RngAlgorithm::ChaCha,
    );
    let mut coordinate = || f64::from(rng.random_range(-1_200_000..1_200_000)) * 1e-6;
    let (mut unknown, mut asked) = (0, 0);
    for _ in 0..100_000 {
        let p = Point3::new(coordinate(), coordinate(), coordinate());
        let answer = index.locate(&p);
        let inside = depth(&p) > 0.0;
        if p.z.abs() < 0.9 {
            asked += 1;
            unknown += usize::from(answer.location == Location::Unknown);
        }
        let wrong = match answer.location {
            Location::Inside => !inside,
            Location::Outside => inside,
            Location::Unknown => false,
        };
        assert!(!wrong || depth(&p).abs() < interval + sagitta, "{p}: {answer:?}");
    }
    // Where neighbouring planes disagree: a share of the points near the surface.
    assert!(unknown * 20 < asked, "{unknown} of {asked} unknown");
}
