//! Laws of the queries, with the winding number and the search through all curves as oracles.

use super::*;
use crate::samples::{empty, polyline, rectangle, rings, strip, tangles};
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
        let index = SectionIndex::new(&section);
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
    assert_eq!(nothing, SpaceAnswer { location: Location::Unknown, planes: Vec::new() });
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
fn far_from_the_origin_a_point_on_a_plane_is_still_on_it() {
    let (guide, interval) = (empty().planes().guide(), 1e-3);
    let planes = PlaneFamily::new(guide, 5.4e6, interval).unwrap();
    for k in 0..100 {
        let on_plane = Point3::new(0.0, 0.0, 5.4e6 + f64::from(k) * interval);
        assert_eq!(planes_around(&planes, &on_plane), [PlaneIndex(i64::from(k))]);
    }
}

#[test]
fn huge_coordinates_do_not_break_the_tree() {
    let huge = polyline(&[(-1e308, -1e308), (1e308, 1e308), (0.0, 1e308)], true);
    let section = Section::new(vec![huge, strip()]).unwrap();
    let index = SectionIndex::new(&section);
    for p in [Point2::origin(), Point2::new(-1e308, 1e308), Point2::new(f64::NAN, 0.0)] {
        let _ = index.locate(&p);
    }
}
