//! What merging curve by curve must keep, on shapes whose truth is known.

use crate::scene::{Look, Outline, circle_arcs, looks, moved, outlines, see, slices};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use transect_fusion::pairwise::{GrowingPlane, GrowthCase, GrowthCounts};
use transect_fusion::pattern::{Fork, OverlapTolerance, Parts, Verdict, verdict};
use transect_fusion::{FusedPlane, PairwiseOptions, pairwise};
use transect_geometry::{Curve, Envelope, Node, Point2, Vector2};

const DISTANCE: f64 = 0.05;

fn tolerance() -> OverlapTolerance {
    OverlapTolerance::within(DISTANCE).unwrap()
}

fn fuse(views: &[Vec<Curve>]) -> FusedPlane {
    pairwise(&slices(views), &PairwiseOptions::default())
}

fn polyline(points: &[(f64, f64)]) -> Curve {
    let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, false).unwrap()
}

/// Along x at a height, with nodes every 0.1.
fn wall(from: i32, to: i32, y: f64) -> Curve {
    polyline(&(from..=to).map(|k| (0.1 * f64::from(k), y)).collect::<Vec<_>>())
}

/// An arc of a circle of some radius, with nodes every 0.02 rad.
fn arc(radius: f64, from: f64, to: f64) -> Curve {
    let count = ((to - from) / 0.02).round();
    let at = |k: i32| {
        let a = from + (to - from) * f64::from(k) / count;
        (radius * a.cos(), radius * a.sin())
    };
    polyline(&(0..=count as i32).map(at).collect::<Vec<_>>())
}

/// A closed circle.
fn ring(radius: f64) -> Curve {
    let nodes = arc(radius, 0.0, TAU).into_nodes();
    Curve::new(nodes[1..].to_vec(), true).unwrap()
}

fn grown(views: &[Vec<Curve>]) -> (Vec<Curve>, GrowthCounts) {
    let mut plane = GrowingPlane::new(tolerance());
    for view in views {
        plane.grow(view);
    }
    let counts = *plane.counts();
    (plane.into_curves(), counts)
}

/// Pairs of curves that forked, whether one was cut or both stayed.
fn forks(counts: &GrowthCounts) -> usize {
    counts.cut + counts.refused()
}

fn radii(curve: &Curve) -> Vec<f64> {
    curve.nodes().iter().map(|n| n.position.coords.norm()).collect()
}

fn distance(curves: &[Curve], p: &Point2) -> f64 {
    curves.iter().map(|c| c.foot(p).distance).fold(f64::INFINITY, f64::min)
}

/// Longest step from one node to the next.
fn longest_unit(curve: &Curve) -> f64 {
    curve.units().map(|u| u.vector().norm()).fold(0.0, f64::max)
}

// Growth (5.2.2).

#[test]
fn a_plane_grows_by_the_three_cases() {
    let mut plane = GrowingPlane::new(tolerance());
    assert_eq!(plane.grow(&[wall(0, 20, 0.0)]), GrowthCase::NewPlane);
    assert_eq!(plane.grow(&[wall(0, 20, 1.0)]), GrowthCase::Appended);
    // Its envelope meets that of the first, but the two do not overlap.
    assert_eq!(plane.grow(&[polyline(&[(1.0, 0.03), (1.5, 0.9)])]), GrowthCase::Appended);
    assert_eq!(plane.grow(&[wall(15, 40, 0.02)]), GrowthCase::Merged);
    let counts = *plane.counts();
    assert_eq!((counts.appended, counts.merged, counts.dropped), (3, 1, 0));
    assert_eq!(plane.curves().count(), 3);
    // The merged curve has the newest record, and the envelopes know it.
    let curve = plane.curves().last().unwrap();
    assert_eq!(curve.envelope().size().x, 4.0);
    // Its own and that of the slanting curve; the cancelled record is gone.
    assert_eq!(plane.envelopes().meeting(curve).len(), 2);
}

#[test]
fn ends_that_touch_in_a_gap_are_no_second_overlap() {
    // All the way round but for a gap, and an arc that begins in it.
    for from in [0.0, 0.01, 0.02, 0.03] {
        let (curves, counts) = grown(&[vec![arc(1.0, 0.03, TAU)], vec![arc(1.0, from, 1.0)]]);
        assert_eq!((curves.len(), counts.merged, forks(&counts)), (1, 1, 0), "from {from}");
    }
}

#[test]
fn two_arcs_of_one_circle_become_one_curve() {
    let (curves, counts) = grown(&[vec![arc(1.0, 0.0, 2.0)], vec![arc(1.02, 1.0, 3.0)]]);
    assert_eq!((curves.len(), counts.merged, counts.dropped), (1, 1, 0));
    let curve = &curves[0];
    assert!((curve.length() - 3.0).abs() < 0.1, "{}", curve.length());
    assert!(longest_unit(curve) < 0.06);
    let between = |from: f64, to: f64| {
        let inside = |p: &&Node| (from..to).contains(&p.position.y.atan2(p.position.x));
        let nodes: Vec<_> = curve.nodes().iter().filter(inside).collect();
        let sum: f64 = nodes.iter().map(|n| n.position.coords.norm()).sum();
        sum / nodes.len() as f64
    };
    assert!((between(0.0, 0.98) - 1.0).abs() < 1e-9);
    let middle = between(1.05, 1.95);
    assert!((middle - 1.01).abs() < 1e-3, "{middle}");
    assert!((between(2.05, 3.0) - 1.02).abs() < 1e-9);
}

#[test]
fn a_second_arc_closes_a_ring() {
    let (first, second) = (arc(1.0, 0.0, 3.6), arc(1.01, 3.0, TAU + 0.7));
    for views in [[first.clone(), second.clone()], [second, first]] {
        let (curves, counts) = grown(&views.map(|c| vec![c]));
        assert_eq!((curves.len(), counts.rings, counts.dropped), (1, 1, 0));
        assert!(curves[0].is_closed());
        assert!(longest_unit(&curves[0]) < 0.06);
        let area = curves[0].signed_area().unwrap();
        assert!((PI..PI * 1.01_f64.powi(2)).contains(&area), "{area}");
        assert!(radii(&curves[0]).iter().all(|r| (0.999..1.011).contains(r)));
    }
}

#[test]
fn a_curve_round_all_but_a_short_gap_is_closed_by_what_bridges_it() {
    // The gap and what sticks out of it are shorter than what counts as nothing.
    let almost = arc(1.0, 0.1, TAU);
    for (from, to) in [(-0.14, 0.26), (-1.0, 0.14), (-0.04, 3.0)] {
        for views in [[almost.clone(), arc(1.0, from, to)], [arc(1.0, from, to), almost.clone()]] {
            let (curves, counts) = grown(&views.map(|c| vec![c]));
            assert_eq!((curves.len(), counts.rings, counts.refused()), (1, 1, 0));
            assert!(curves[0].is_closed() && longest_unit(&curves[0]) < 0.06);
        }
    }
}

#[test]
fn touching_ends_close_no_ring() {
    let (curves, counts) = grown(&[vec![arc(1.0, 0.1, TAU - 0.01)], vec![arc(1.0, 0.0, 1.0)]]);
    assert_eq!((curves.len(), counts.merged, counts.rings, counts.refused()), (1, 1, 0, 0));
    assert!(!curves[0].is_closed() && (curves[0].length() - (TAU - 0.01)).abs() < 1e-3);
}

#[test]
fn closed_curves_take_in_arcs_and_each_other() {
    for (first, second) in [
        (ring(1.0), arc(1.02, 6.0, 7.5)),
        (ring(1.0), arc(1.02, 1.0, 2.0)),
        (ring(1.0), ring(1.02)),
    ] {
        for views in [[first.clone(), second.clone()], [second, first]] {
            let (curves, counts) = grown(&views.map(|c| vec![c]));
            assert_eq!((curves.len(), counts.merged, counts.dropped), (1, 1, 0));
            assert!(curves[0].is_closed() && longest_unit(&curves[0]) < 0.06);
            assert!(curves[0].signed_area().unwrap() > PI * 0.999);
        }
    }
}

#[test]
fn a_partial_curve_bridges_global_ones() {
    let pieces = [wall(0, 20, 0.0), wall(40, 60, 0.0), wall(80, 100, 0.0)];
    let bridge = wall(15, 85, 0.02);
    let (curves, counts) = grown(&[pieces.to_vec(), vec![bridge]]);
    assert_eq!((curves.len(), counts.merged, counts.appended), (1, 3, 3));
    assert_eq!(curves[0].envelope().size().x, 10.0);
    assert!(curves[0].units().all(|u| u.vector().x > 0.0), "the curve never turns back");
    for (x, y) in [(1.0, 0.0), (3.0, 0.02), (5.0, 0.01), (7.0, 0.02), (9.0, 0.0)] {
        assert!(distance(&curves, &Point2::new(x, y)) < 1e-9, "at {x}");
    }
}

#[test]
fn a_grown_curve_reaches_what_the_partial_one_did_not() {
    // The second wall ends where the partial curve, from another height, does not come near.
    let pieces = vec![wall(0, 20, 0.0), wall(19, 40, -0.07)];
    let (curves, counts) = grown(&[pieces, vec![wall(5, 30, -0.035)]]);
    assert_eq!((curves.len(), counts.refused()), (1, 0));
    assert_eq!(curves[0].envelope().size().x, 4.0);
}

#[test]
fn the_worst_cases_of_figure_5_4_stay_apart() {
    // Envelopes meet and directions agree, but the curves run side by side.
    for (from, to) in [(1.05, 2.6), (-0.7, 0.7), (0.5, 1.0)] {
        let views = [vec![arc(1.0, 0.0, 1.57)], vec![arc(0.9, from, to)]];
        let (curves, counts) = grown(&views);
        assert_eq!((curves.len(), counts.appended, counts.refused()), (2, 2, 0));
    }
}

// The rule table (5.4).

#[test]
fn valid_patterns_are_merged_and_the_shorter_stub_of_a_fork_is_cut_off() {
    for parts_a in Parts::ALL {
        for parts_b in Parts::ALL {
            let curve = |parts: Parts, slope: f64| {
                let away = |x: f64, d: f64| (x, slope * d);
                let before = (0..20).map(|k| away(0.1 * f64::from(k), 2.0 - 0.1 * f64::from(k)));
                let behind = (1..=20).map(|k| away(4.0 + 0.1 * f64::from(k), 0.1 * f64::from(k)));
                let inside = (20..=40).map(|k| (0.1 * f64::from(k), 0.0));
                let points = before.filter(|_| parts.begins_unenclosed).chain(inside);
                let behind = behind.filter(|_| parts.ends_unenclosed);
                polyline(&points.chain(behind).collect::<Vec<_>>())
            };
            let (a, b) = (curve(parts_a, 0.0), curve(parts_b, 1.0));
            let (curves, counts) = grown(&[vec![a.clone()], vec![b.clone()]]);
            assert_eq!(counts.dropped, 0);
            match verdict(parts_a, parts_b) {
                Verdict::Valid(_) => {
                    assert_eq!((curves.len(), counts.merged, counts.refused()), (1, 1, 0));
                    let x = |e: Envelope| (e.min.x, e.max.x);
                    let both = x(a.envelope().merged(&b.envelope()));
                    assert_eq!(x(curves[0].envelope()), both, "{parts_a:?} {parts_b:?}");
                }
                Verdict::Fork(fork) => {
                    // A stub for each fork, and one curve of all else.
                    let stubs = if fork == Fork::AtBothEnds { 2 } else { 1 };
                    assert_eq!((curves.len(), counts.cut, counts.merged), (1 + stubs, stubs, 1));
                    let all = [a.clone(), b.clone()];
                    assert_eq!(lost(&[all.to_vec()], &curves, DISTANCE), 0);
                    let length = |curves: &[Curve]| curves.iter().map(Curve::length).sum::<f64>();
                    // The overlap, once; beside it only what is within reach of the fork.
                    let both = length(&all) - length(&curves);
                    assert!((1.8..2.1).contains(&both), "{parts_a:?} {parts_b:?}: {both}");
                }
            }
        }
    }
}

#[test]
fn of_a_bulge_and_the_straight_way_the_shorter_one_becomes_a_curve_of_its_own() {
    let straight = wall(0, 80, 0.0);
    let height = |k: i32| (2.0 - (0.1 * f64::from(k) - 4.0).abs()).max(0.0);
    let bulging = polyline(&(0..=80).map(|k| (0.1 * f64::from(k), height(k))).collect::<Vec<_>>());
    let (curves, counts) = grown(&[vec![straight], vec![bulging]]);
    assert_eq!((curves.len(), counts.cut, counts.merged), (2, 2, 2));
    let lengths: Vec<f64> = curves.iter().map(Curve::length).collect();
    let is_there = |length: f64| lengths.iter().any(|l| (l - length).abs() < 0.2);
    assert!(is_there(4.0) && is_there(4.0 + 32_f64.sqrt()), "{lengths:?}");
}

#[test]
fn a_ring_on_the_middle_of_an_open_curve_is_refused() {
    // The open curve leaves the solid's outline at both ends, and goes all the way round between.
    let there: Vec<_> = (0..20).map(|k| (1.0, -2.0 + 0.1 * f64::from(k))).collect();
    let round = arc(1.0, 0.0, TAU - 0.02);
    let round = round.nodes().iter().map(|n| (n.position.x, n.position.y));
    let back = (1..=20).map(|k| (1.0, 0.1 * f64::from(k)));
    let open = polyline(&there.into_iter().chain(round).chain(back).collect::<Vec<_>>());
    let (curves, counts) = grown(&[vec![ring(1.0)], vec![open]]);
    assert_eq!((curves.len(), counts.merged, counts.refused()), (2, 0, 1));
}

#[test]
fn opposite_directions_never_merge() {
    for height in [0.0, 0.001, 0.04] {
        let views = [vec![wall(0, 40, 0.0)], vec![wall(0, 40, height).reversed()]];
        let (curves, counts) = grown(&views);
        assert_eq!((curves.len(), counts.merged, counts.refused()), (2, 0, 0));
        assert_eq!(fuse(&views).curves.len(), 2);
    }
}

#[test]
fn where_averaging_would_lose_a_node_the_better_supported_curve_stays() {
    // The mean of all others takes the curve farther from one node than the threshold.
    let height = |k: i32| if k == 22 { 0.045 } else { -0.045 };
    let fine: Vec<_> = (0..=40).map(|k| (0.1 * f64::from(k), height(k))).collect();
    let coarse = polyline(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)]);
    let (curves, counts) = grown(&[vec![coarse], vec![polyline(&fine)]]);
    assert_eq!((counts.merged, counts.kept_as_seen, counts.dropped), (1, 1, 0));
    assert_eq!(curves, [polyline(&fine)]);
}

#[test]
fn overlap_does_not_erode_ends() {
    let (curves, counts) = grown(&(0..20).map(|_| vec![wall(0, 30, 0.0)]).collect::<Vec<_>>());
    assert_eq!((curves.len(), counts.merged), (1, 19));
    assert_eq!(curves[0].envelope().size().x, 3.0);
}

// Laws.

#[test]
fn nothing_in_nothing_out() {
    assert!(fuse(&[]).curves.is_empty());
    assert!(fuse(&[Vec::new(), Vec::new()]).curves.is_empty());
    let point = Curve::new(vec![Node::at(Point2::new(0.0, 5.0)); 5], false).unwrap();
    let fused = fuse(&[vec![point.clone()], vec![wall(0, 9, 0.0), point]]);
    assert_eq!((fused.curves.len(), fused.counts.dropped), (1, 10));
    let nothing = fuse(&[vec![Curve::new(vec![Node::at(Point2::origin()); 5], true).unwrap()]]);
    assert_eq!((nothing.counts.observations, nothing.counts.dropped), (5, 5));
}

#[test]
fn a_given_tolerance_is_used() {
    let views = [vec![wall(0, 40, 0.0)], vec![wall(0, 40, 0.2)]];
    let with = |distance: f64| {
        let tolerance = OverlapTolerance::within(distance).ok();
        pairwise(&slices(&views), &{
            let mut options = PairwiseOptions::default();
            options.tolerance = tolerance;
            options
        })
    };
    assert_eq!((with(0.1).curves.len(), with(0.3).curves.len()), (2, 1));
    assert_eq!(with(0.3).threshold, 0.3);
}

/// A surface of any shape, with sharp corners, folds and repeated nodes.
fn surfaces() -> impl Strategy<Value = Vec<Point2>> {
    let step = (0.02..0.4_f64, -2.5..2.5_f64, 0..6_u8);
    prop::collection::vec(step, 4..40).prop_map(|steps| {
        let (mut at, mut heading) = (Point2::origin(), 0.0);
        let node = |(length, turn, kind): (f64, f64, u8)| {
            let (turn, length) = match kind {
                0 => (turn, length),
                1 => (0.0, 0.0),
                _ => (0.1 * turn, length),
            };
            heading += turn;
            at += Vector2::new(f64::cos(heading), f64::sin(heading)) * length;
            at
        };
        steps.into_iter().map(node).collect()
    })
}

/// What a view sees of it: from where, how far, with noise, every how many nodes, and whether a
/// node leaps.
fn glimpses() -> impl Strategy<Value = (f64, f64, Vec<(f64, f64)>, usize, Option<usize>)> {
    let noise = prop::collection::vec((-0.3..0.3, -0.3..0.3), 8);
    let leap = prop::option::weighted(0.2, 0..40_usize);
    (0.0..0.8, 0.2..1.0, noise, 1..3_usize, leap)
}

/// Views of one surface, which may be closed.
fn scribbles(closed: impl Strategy<Value = bool>) -> impl Strategy<Value = Vec<Vec<Curve>>> {
    let view = prop::collection::vec(glimpses(), 1..3);
    (surfaces(), prop::collection::vec(view, 1..6), closed).prop_map(|(surface, views, closed)| {
        let glimpse = |(from, share, noise, stride, leap): &(_, _, Vec<(f64, f64)>, _, _)| {
            let count = surface.len() as f64;
            let first = (from * count) as usize;
            let most = if closed { usize::MAX } else { surface.len() - first };
            let nodes = ((share * count * 1.5) as usize).clamp(2, most.max(2));
            let node = |k: usize| {
                let (x, y) = noise[k % noise.len()];
                let far = if *leap == Some(k) { 8.0 } else { 1.0 };
                Node::at(surface[(first + k) % surface.len()] + Vector2::new(x, y) * DISTANCE * far)
            };
            let whole = closed && nodes >= surface.len();
            let nodes = (0..nodes.min(surface.len())).step_by(*stride).map(node);
            let nodes: Vec<_> = nodes.collect();
            let whole = whole && nodes.len() > 2;
            Curve::new(nodes, whole).ok()
        };
        views.iter().map(|v| v.iter().filter_map(glimpse).collect()).collect()
    })
}

/// Nodes of all views that are farther than a distance from all curves.
fn lost(views: &[Vec<Curve>], curves: &[Curve], limit: f64) -> usize {
    let nodes = views.iter().flatten().flat_map(|c| c.nodes());
    nodes.filter(|n| distance(curves, &n.position) > limit).count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn what_was_seen_is_in_the_result_or_counted(
        outline in outlines(), looks in looks(), sigma in 0.0..0.004_f64,
    ) {
        let views: Vec<_> = looks.iter().map(|l| vec![see(&outline, l, sigma)]).collect();
        let fused = fuse(&views);
        // One merge may move a curve by a threshold's half, and there are up to seven.
        let near = 2.0 * fused.threshold;
        prop_assert_eq!(lost(&views, &fused.curves, near), 0);
        for node in fused.curves.iter().flat_map(|c| c.nodes()) {
            let seen = views.iter().map(|v| distance(v, &node.position));
            let nearest = seen.fold(f64::INFINITY, f64::min);
            prop_assert!(nearest <= fused.threshold, "{} from all input: {:?}", nearest, node);
        }
    }

    #[test]
    fn views_of_one_outline_do_not_fork(outline in outlines(), looks in looks()) {
        let views: Vec<_> = looks.iter().map(|l| vec![see(&outline, l, 0.0)]).collect();
        let fused = fuse(&views);
        prop_assert_eq!(forks(&fused.growth.unwrap()), 0);
        prop_assert_eq!(forks(&grown(&views).1), 0);
        for curve in &fused.curves {
            let along: f64 = curve.units().map(|u| u.start.coords.perp(&u.end.coords)).sum();
            prop_assert!(along > 0.0, "a curve runs the wrong way round the outline");
            prop_assert!(longest_unit(curve) < 0.2);
        }
    }

    #[test]
    fn moving_the_plane_moves_the_answer(
        outline in outlines(), looks in looks(), angle in 0.0..TAU, x in -1e3..1e3, y in -1e3..1e3,
    ) {
        let shift = Vector2::new(x, y);
        let views: Vec<_> = looks.iter().map(|l| vec![see(&outline, l, 0.002)]).collect();
        let there: Vec<Vec<_>> =
            views.iter().map(|v| v.iter().map(|c| moved(c, angle, shift)).collect()).collect();
        let (here, there) = (grown(&views), grown(&there));
        prop_assert_eq!(here.1, there.1);
        for (a, b) in here.0.iter().zip(&there.0) {
            prop_assert_eq!(a.nodes().len(), b.nodes().len());
            for (p, q) in moved(a, angle, shift).nodes().iter().zip(b.nodes()) {
                prop_assert!((p.position - q.position).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn no_merge_of_scribbles_invents_anything(views in scribbles(any::<bool>())) {
        let (curves, counts) = grown(&views);
        // Half the threshold is what one merge may move a curve by.
        let limit = (1.0 + 0.5 * counts.merged as f64) * DISTANCE;
        let seen: Vec<_> = views.iter().flatten().cloned().collect();
        for node in curves.iter().flat_map(|c| c.nodes()) {
            prop_assert!(distance(&seen, &node.position) <= limit);
        }
    }

    #[test]
    fn any_scribble_is_fused_and_what_it_loses_is_counted(views in scribbles(any::<bool>())) {
        for tolerance in [None, Some(tolerance())] {
            let mut options = PairwiseOptions::default(); options.tolerance = tolerance;
            let fused = pairwise(&slices(&views), &options);
            let nodes = |curves: &[Curve]| curves.iter().map(|c| c.nodes().len()).sum::<usize>();
            let seen = views.iter().map(|v| nodes(v)).sum();
            let counts = (fused.counts.observations, fused.counts.dropped);
            let lost = lost(&views, &fused.curves, fused.threshold);
            prop_assert_eq!(counts, (seen, lost));
        }
    }

    #[test]
    fn the_order_in_which_a_view_lists_its_curves_does_not_matter(
        mut views in scribbles(any::<bool>()), turn in 0..4_usize,
    ) {
        let here = grown(&views);
        for view in &mut views {
            let turn = turn % view.len().max(1);
            view.rotate_left(turn);
        }
        prop_assert_eq!(here, grown(&views));
    }
}

#[test]
fn one_curve_comes_of_many_noisy_arcs() {
    let fused = fuse(&circle_arcs(30, 0.002));
    let outer = &fused.curves[0];
    assert!(outer.is_closed());
    let errors = radii(outer).into_iter().map(|r| (r - 1.0).powi(2));
    let rms = (errors.sum::<f64>() / outer.nodes().len() as f64).sqrt();
    assert!(rms < 0.002, "{rms}");
}

#[test]
fn a_look_at_everything_is_one_closed_curve() {
    let look = Look { from: 0.0, sweep: TAU, spacing: 0.02, seed: 1 };
    let views: Vec<_> = (0..5)
        .map(|seed| vec![see(&Outline { bump: 0.1, lobes: 3.0 }, &Look { seed, ..look }, 0.001)])
        .collect();
    let fused = fuse(&views);
    assert_eq!((fused.curves.len(), forks(&fused.growth.unwrap())), (1, 0));
    assert!(fused.curves[0].is_closed());
}
