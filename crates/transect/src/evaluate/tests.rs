use super::*;
use nalgebra::{Isometry2, Vector2};
use proptest::prelude::*;
use transect_geometry::{Node, Point2, StraightGuide, Vector3};

pub(super) fn polyline(points: &[(f64, f64)], closed: bool) -> Curve {
    let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, closed).unwrap()
}

/// One to four curves of three to seven nodes in a square of side 10.
pub(super) fn curves() -> impl Strategy<Value = Vec<Curve>> {
    let points = proptest::collection::vec((0.0..10.0, 0.0..10.0), 3..8);
    let curve = (points, any::<bool>()).prop_map(|(points, closed)| polyline(&points, closed));
    proptest::collection::vec(curve, 1..5)
}

fn planes() -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.0, 1.0).unwrap()
}

fn on_plane_0(curves: Vec<Curve>) -> PlaneCurves {
    BTreeMap::from([(PlaneIndex(0), curves)])
}

const TOLERANCE: f64 = 0.1;
const ALL: EvaluateOptions = EvaluateOptions::new(TOLERANCE);

fn score(curves: Vec<Curve>, truth: Vec<Curve>) -> Accuracy {
    evaluate(&planes(), &on_plane_0(curves), &on_plane_0(truth), &ALL).unwrap()
}

fn square(side: f64) -> Curve {
    polyline(&[(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)], true)
}

fn line(length: f64, y: f64) -> Curve {
    polyline(&[(0.0, y), (length, y)], false)
}

/// Shares of a few thousand samples; each is found to within a sample at either end.
fn assert_share(share: Option<f64>, expected: f64) {
    let share = share.unwrap();
    assert!((share - expected).abs() < 0.005, "{share} instead of {expected}");
}

#[test]
fn the_truth_itself_is_perfect() {
    let a = score(vec![square(10.0)], vec![square(10.0)]);
    assert!(a.max.unwrap() < 1e-12);
    assert_eq!((a.completeness, a.oriented, a.off), (Some(1.0), Some(1.0), Some(0.0)));
    assert_eq!((a.planes_closed_only, a.planes_same_loops), (Some(1.0), Some(1.0)));
    assert_eq!((a.pieces, a.closed, a.open, a.truth_pieces, a.vertices), (1, 1, 0, 1, 4));
    assert!((a.length - 40.0).abs() < 1e-9 && (a.truth_length - 40.0).abs() < 1e-9);
    assert_eq!(a.length_without_truth, 0.0);
}

#[test]
fn a_shifted_curve_is_as_far_as_it_was_shifted() {
    let a = score(vec![line(10.0, 0.03)], vec![line(10.0, 0.0)]);
    for distance in [a.median, a.p95, a.max] {
        assert!((distance.unwrap() - 0.03).abs() < 1e-12);
    }
    assert_eq!((a.completeness, a.off, a.oriented), (Some(1.0), Some(0.0), Some(1.0)));
}

#[test]
fn a_curve_at_the_tolerance_or_beyond_is_off() {
    let a = score(vec![line(10.0, 2.0 * TOLERANCE)], vec![line(10.0, 0.0)]);
    assert_eq!((a.completeness, a.off, a.oriented), (Some(0.0), Some(1.0), None));
}

#[test]
fn a_reversed_curve_is_near_but_not_oriented() {
    let a = score(vec![square(10.0).reversed()], vec![square(10.0)]);
    assert_eq!((a.completeness, a.off), (Some(1.0), Some(0.0)));
    assert_eq!(a.oriented, Some(0.0));
}

#[test]
fn a_missing_half_halves_the_completeness_only() {
    let a = score(vec![line(50.0, 0.0)], vec![line(100.0, 0.0)]);
    assert_share(a.completeness, 0.5);
    assert_eq!((a.off, a.oriented), (Some(0.0), Some(1.0)));
    assert_eq!(a.planes_closed_only, Some(0.0));
}

#[test]
fn curves_are_expected_where_the_truth_was_seen() {
    // Of a square of side 10 the views saw all but the right side and a spot on the left.
    let seen = |p: &Point2| p.x < 9.99 && !(p.x < 0.01 && (p.y - 5.0).abs() < 0.03);
    let of = |seen: &(dyn Fn(&Point2) -> bool + Sync)| {
        let (curves, truth) = (on_plane_0(Vec::new()), on_plane_0(vec![square(10.0), square(3.0)]));
        let all = |points: &[Point2]| points.iter().map(seen).collect();
        evaluate_seen(&planes(), &curves, &truth, &|_, points| all(points), &ALL).unwrap()
    };
    assert_eq!(of(&seen).expected_pieces, 2);
    assert_eq!(of(&|p| seen(p) && p.y > 0.01).expected_pieces, 2);
    assert_eq!(of(&|p| p.x > 3.5 && (p.x - 7.0).abs() > 1.0).expected_pieces, 3);
    let rows = of(&seen).rows(transect_geometry::LengthUnit::Metre);
    let row = rows.iter().find(|r| r.metric == "curves expected from what was seen").unwrap();
    assert_eq!(row.value, "2");
}

#[test]
fn doubled_curves_are_duplicates_of_each_other() {
    let doubled = vec![line(10.0, 0.0), line(10.0, 0.05)];
    assert_eq!(score(doubled.clone(), vec![line(10.0, 0.0)]).duplicated, Some(1.0));
    let alone = duplication(&on_plane_0(doubled), TOLERANCE).unwrap();
    assert_eq!((alone.duplicated, alone.pieces, alone.open), (Some(1.0), 2, 2));
    // A thin wall: its two faces run in opposite directions.
    let wall = on_plane_0(vec![line(10.0, 0.0), line(10.0, 0.05).reversed()]);
    assert_eq!(duplication(&wall, TOLERANCE).unwrap().duplicated, Some(0.0));
    let apart = on_plane_0(vec![line(10.0, 0.0), line(10.0, 0.2)]);
    assert_eq!(duplication(&apart, TOLERANCE).unwrap().duplicated, Some(0.0));
    let other_plane = BTreeMap::from([0, 1].map(|k| (PlaneIndex(k), vec![line(10.0, 0.0)])));
    assert_eq!(duplication(&other_plane, TOLERANCE).unwrap().duplicated, Some(0.0));
}

#[test]
fn a_curve_that_runs_round_twice_is_its_own_duplicate() {
    let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
    let twice = polyline(&[corners, corners.map(|(x, y)| (x + 0.01, y - 0.01))].concat(), true);
    assert_eq!(duplication(&on_plane_0(vec![twice]), TOLERANCE).unwrap().duplicated, Some(1.0));
}

#[test]
fn a_seam_is_no_duplicate() {
    let ring = |last: usize| {
        let at = |i: usize| (i as f64 / 100.0 * std::f64::consts::TAU).sin_cos();
        (0..last).map(at).collect::<Vec<_>>()
    };
    let closed = on_plane_0(vec![polyline(&ring(100), true)]);
    assert_eq!(duplication(&closed, TOLERANCE).unwrap().duplicated, Some(0.0));
    // An open curve that goes round and overlaps its own beginning by three tolerances.
    let overlapping = on_plane_0(vec![polyline(&ring(105), false)]);
    assert_eq!(duplication(&overlapping, TOLERANCE).unwrap().duplicated, Some(0.0));
}

#[test]
fn curves_on_planes_without_truth_are_off() {
    let curves = BTreeMap::from([
        (PlaneIndex(0), vec![line(30.0, 0.01)]),
        (PlaneIndex(1), vec![line(10.0, 0.0)]),
    ]);
    let a = evaluate(&planes(), &curves, &on_plane_0(vec![line(30.0, 0.0)]), &ALL).unwrap();
    assert!((a.length_without_truth - 10.0).abs() < 1e-9);
    assert_share(a.off, 0.25);
    assert!((a.median.unwrap() - 0.01).abs() < 1e-12 && (a.max.unwrap() - 0.01).abs() < 1e-12);
    assert_eq!((a.p95, a.planes_with_truth), (None, 1));
}

#[test]
fn planes_are_judged_by_their_curves() {
    let open = polyline(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], false);
    let with = |k, curves| (PlaneIndex(k), curves);
    let truth = BTreeMap::from([0, 1, 2, 3].map(|k| with(k, vec![square(1.0)])));
    let curves = BTreeMap::from([
        with(0, vec![square(1.0)]),
        with(1, vec![square(1.0), square(3.0)]),
        with(2, vec![square(1.0), open]),
        with(3, vec![]),
        with(4, vec![]),
    ]);
    let a = evaluate(&planes(), &curves, &truth, &ALL).unwrap();
    assert_eq!((a.planes_with_truth, a.pieces, a.closed, a.open), (4, 5, 4, 1));
    assert_eq!((a.planes_closed_only, a.planes_same_loops), (Some(0.5), Some(0.25)));
}

#[test]
fn planes_below_the_first_station_do_not_count() {
    let both = |curve: Curve| BTreeMap::from([2, 3].map(|k| (PlaneIndex(k), vec![curve.clone()])));
    let options = ALL.from_station(3.0);
    let a = evaluate(&planes(), &both(line(1.0, 0.0)), &both(square(1.0)), &options).unwrap();
    assert_eq!((a.planes_with_truth, a.pieces, a.truth_pieces), (1, 1, 1));
    assert!((a.length - 1.0).abs() < 1e-12);
}

#[test]
fn nothing_has_no_figures() {
    let a = evaluate(&planes(), &BTreeMap::new(), &BTreeMap::new(), &ALL).unwrap();
    assert_eq!(
        (a.median, a.max, a.completeness, a.off, a.duplicated),
        (None, None, None, None, None)
    );
    let a = score(vec![], vec![square(1.0)]);
    assert_eq!((a.completeness, a.off, a.planes_closed_only), (Some(0.0), None, Some(0.0)));
    assert!(a.rows(transect_geometry::LengthUnit::Metre).iter().any(|r| r.value == "none"));
}

#[test]
fn unusable_options_are_refused_with_the_value() {
    let curves = on_plane_0(vec![line(1.0, 0.0)]);
    let run = |tolerance, from| {
        evaluate(&planes(), &curves, &curves, &EvaluateOptions { tolerance, from }).unwrap_err()
    };
    for tolerance in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(run(tolerance, None), EvaluateError::BadTolerance(tolerance));
    }
    assert!(matches!(run(f64::NAN, None), EvaluateError::BadTolerance(_)));
    assert!(matches!(run(0.1, Some(f64::NAN)), EvaluateError::BadFrom(_)));
    assert!(matches!(run(1e-12, None), EvaluateError::TooFine { .. }));
    assert!(duplication(&curves, 0.0).is_err());
}

fn moved(curves: &[Curve], motion: &Isometry2<f64>) -> Vec<Curve> {
    let node = |n: &Node| n.moved_to(motion * n.position);
    let curve =
        |c: &Curve| Curve::new(c.nodes().iter().map(node).collect(), c.is_closed()).unwrap();
    curves.iter().map(curve).collect()
}

fn figures(a: &Accuracy) -> Vec<f64> {
    let shares = [a.completeness, a.off, a.oriented, a.duplicated, a.planes_same_loops];
    let lengths = [a.median, a.p95, a.max, Some(a.length), Some(a.truth_length)];
    shares.iter().chain(&lengths).map(|x| x.unwrap_or(-1.0)).collect()
}

proptest! {
    // Each case takes some ten thousand samples.
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_rigid_motion_changes_nothing(
        curves in curves(), truth in curves(), angle in -3.0..3.0, x in -50.0..50.0, y in -50.0..50.0,
    ) {
        let motion = Isometry2::new(Vector2::new(x, y), angle);
        let still = score(curves.clone(), truth.clone());
        let after = score(moved(&curves, &motion), moved(&truth, &motion));
        for (a, b) in figures(&still).iter().zip(figures(&after)) {
            // Rounding may take one of some thousand samples over a threshold.
            prop_assert!((a - b).abs() < 1e-9 * (1.0 + a) || ((a - b).abs() < 2e-3 && b <= 1.0));
        }
    }

    #[test]
    fn the_number_of_threads_changes_no_bit(
        curves in proptest::collection::vec(curves(), 6), truth in proptest::collection::vec(curves(), 6),
    ) {
        let by_plane = |c: Vec<Vec<Curve>>| (0..).map(PlaneIndex).zip(c).collect::<PlaneCurves>();
        let (curves, truth) = (by_plane(curves), by_plane(truth));
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| evaluate(&planes(), &curves, &truth, &ALL)).unwrap()
        };
        prop_assert_eq!(run(1), run(3));
    }
}
