use super::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// 10 along x, a quarter circle of radius 4 to the left, 10 along y.
fn bend() -> CurvedGuide {
    let points = [(0.0, 0.0), (14.0, 0.0), (14.0, 14.0)];
    let points = points.map(|(x, y)| Point3::new(x, y, 1.0));
    CurvedGuide::polyline(points.to_vec(), Some(4.0)).unwrap()
}

fn helix(points: usize) -> (CurvedGuide, impl Fn(f64) -> Point3) {
    let at = |a: f64| Point3::new(5.0 * a.cos(), 5.0 * a.sin(), 1.5 * a);
    let angle = move |k: usize| 2.0 * TAU * k as f64 / (points - 1) as f64;
    (CurvedGuide::spline((0..points).map(|k| at(angle(k))).collect()).unwrap(), at)
}

/// The nearest of many points of the guide: the slow and obvious way.
fn brute_station(guide: &CurvedGuide, p: &Point3) -> f64 {
    let count = 40_000;
    let station = |k: usize| guide.length() * k as f64 / count as f64;
    let distance = |s: f64| (guide.frame(s).origin() - p).norm();
    (0..=count).map(station).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap()
}

#[test]
fn a_bend_has_the_stations_of_its_lines_and_its_arc() {
    let guide = bend();
    assert!((guide.length() - (20.0 + 4.0 * FRAC_PI_2)).abs() < 1e-12);
    assert!((guide.reach() - 4.0).abs() < 1e-9, "{}", guide.reach());
    assert!((guide.usable_distance() - 3.6).abs() < 1e-9, "{}", guide.usable_distance());
    let middle = guide.frame(10.0 + 2.0 * FRAC_PI_2);
    let half = 0.5_f64.sqrt();
    let wanted = Point3::new(10.0 + 4.0 * half, 4.0 - 4.0 * half, 1.0);
    assert!((middle.origin() - wanted).norm() < 1e-12);
    assert!((middle.normal() - Vector3::new(half, half, 0.0)).norm() < 1e-12);
    let inside = wanted + Vector3::new(-1.0, 1.0, 0.0);
    assert!((guide.station(&inside, None).unwrap() - (10.0 + 2.0 * FRAC_PI_2)).abs() < 1e-12);
    assert!(
        (guide.stretch(10.0 + 2.0 * FRAC_PI_2, &inside) - (1.0 - 2.0 * half / 4.0)).abs() < 1e-12
    );
    assert_eq!(guide.station(&Point3::new(-0.1, 0.0, 1.0), None), Err(NoStation::BeyondEnds));
    assert!(
        (guide.extended_station(&Point3::new(-0.1, 0.5, 1.0), None).unwrap() + 0.1).abs() < 1e-12
    );
    assert_eq!(guide.station(&Point3::new(10.0, 4.0, 1.0), None), Err(NoStation::TooFar));
}

#[test]
fn the_axes_of_a_plane_curve_do_not_turn_about_it() {
    let guide = bend();
    let first = guide.frame(0.0);
    for k in 0..=200 {
        let frame = guide.frame(guide.length() * f64::from(k) / 200.0);
        // In the plane of the curve "up" stays up: its share of both axes is what it was.
        let up = |f: &PlaneFrame| (f.x_axis().z, f.y_axis().z);
        assert!((up(&frame).0 - up(&first).0).abs() < 1e-12, "{k}");
        assert!((up(&frame).1 - up(&first).1).abs() < 1e-12, "{k}");
    }
}

#[test]
fn frames_of_a_helix_turn_by_its_torsion_alone() {
    // A frame that does not turn about a helix turns against its bend by −torsion · length.
    let (guide, _) = helix(49);
    let torsion = 1.5 / (25.0 + 2.25);
    let angle = |s: f64| {
        let (frame, at) = (guide.frame(s), guide.path.at(s));
        at.bend.dot(&frame.y_axis()).atan2(at.bend.dot(&frame.x_axis()))
    };
    // Away from the ends, where a natural spline does not bend.
    let (from, to) = (guide.length() * 0.3, guide.length() * 0.7);
    let turned = (angle(to) - angle(from) - torsion * (to - from)).rem_euclid(TAU);
    let off = turned.min(TAU - turned);
    assert!(off < 1e-3, "{off}");
    // Against steps that are sixteen times as short: the carrying itself.
    let mut at = guide.path.at(0.0);
    let mut x = guide.frame(0.0).x_axis();
    let steps = 16 * (guide.path.starts().len() - 1);
    for k in 1..=steps {
        let next = guide.path.at(guide.length() * k as f64 / steps as f64);
        x = carry(&x, &at, &next);
        at = next;
    }
    let apart = (guide.frame(guide.length()).x_axis() - x).norm();
    assert!(apart < 1e-7, "{apart}");
}

#[test]
fn a_spline_passes_its_points_and_has_their_curves_length() {
    let (guide, at) = helix(49);
    let exact = 2.0 * TAU * 5.0_f64.hypot(1.5);
    assert!((guide.length() - exact).abs() < 5e-3, "{} {exact}", guide.length());
    let p = at(TAU * 1.25);
    let station = guide.station(&p, None).unwrap();
    assert!((guide.frame(station).origin() - p).norm() < 1e-9);
    // Length by the obvious sum of chords.
    let count = 200_000;
    let points: Vec<_> = (0..=count)
        .map(|k| guide.frame(guide.length() * k as f64 / count as f64).origin())
        .collect();
    let sum: f64 = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    assert!((guide.length() - sum).abs() < 1e-7, "{} {sum}", guide.length());
}

#[test]
fn corners_are_rounded_off_by_what_their_radius_asks_for() {
    let corner = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)].map(|(x, y)| Point3::new(x, y, 0.0));
    for radius in [4.0, 20.0] {
        let guide = CurvedGuide::polyline(corner.to_vec(), Some(radius)).unwrap();
        let expected = radius * (2f64.sqrt() - 1.0);
        assert!((guide.distance_from_points() - expected).abs() < 1e-9, "{radius}");
    }
    let spline = CurvedGuide::spline(corner.to_vec()).unwrap();
    assert!(spline.distance_from_points() < 1e-9);
}

#[test]
fn parts_that_come_close_limit_the_reach() {
    let points = [(0.0, 0.0), (20.0, 0.0), (20.0, 6.0), (0.0, 6.0)];
    let points = points.map(|(x, y)| Point3::new(x, y, 0.0)).to_vec();
    let guide = CurvedGuide::polyline(points, None).unwrap();
    // Arms six apart, arcs of radius three.
    assert!((guide.reach() - 3.0).abs() < 1e-6, "{}", guide.reach());
    assert_eq!(guide.require_usable_distance(2.0), Ok(()));
    let error = guide.require_usable_distance(2.8).unwrap_err();
    let GuideError::TooCurved { reach, usable, needed, .. } = error else { panic!("{error}") };
    assert_eq!((reach, usable, needed), (guide.reach(), guide.usable_distance(), 2.8));
}

#[test]
fn the_message_on_a_sharp_bend_tells_where_planes_cross_and_what_is_used() {
    let error = GuideError::TooCurved { station: 12.0, reach: 4.0, usable: 3.6, needed: 5.0 };
    assert_eq!(
        error.to_string(),
        "planes along the guide cross 4 away from it at station 12. Up to 3.6 (0.9 of that) can be \
         used, and 5 is needed. Let the guide bend less sharply there, keep its parts farther \
         apart, or ask for a smaller distance"
    );
}

#[test]
fn bad_points_are_named() {
    let p = |x: f64| Point3::new(x, 0.0, 0.0);
    let error = |points: Vec<Point3>| CurvedGuide::polyline(points, None).unwrap_err();
    assert_eq!(error(vec![p(1.0)]), GuideError::PointCount(1));
    let wild = error(vec![p(1.0), p(f64::NAN), p(2.0)]).to_string();
    assert!(wild.starts_with("point 1 of the guide (from 0) is at (NaN, 0, 0); "), "{wild}");
    let repeated = error(vec![p(1.0), p(2.0), p(2.0)]);
    assert_eq!(repeated, GuideError::Repeated { point: 2, at: p(2.0) });
    let corners = |last: f64| {
        [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (last, 0.0)].map(|(x, y)| Point3::new(x, y, 0.0))
    };
    for last in [0.0, 0.005] {
        let closed = error(corners(last).to_vec());
        assert!(matches!(closed, GuideError::Closed { gap } if (gap - last).abs() < 1e-12));
    }
    assert!(CurvedGuide::spline(corners(1.0).to_vec()).is_ok());
    assert!(repeated.to_string().contains("(from 0), at (2, 0, 0), repeats"), "{repeated}");
    let back = error(vec![p(1.0), p(2.0), p(0.5)]);
    assert_eq!(back, GuideError::TurnsBack { point: 1, at: p(2.0) });
    assert!(back.to_string().contains("at point 1 (from 0), at (2, 0, 0): "), "{back}");
    let back = CurvedGuide::spline(vec![p(0.0), p(1.0), p(2.0), p(0.5)]).unwrap_err();
    assert_eq!(back, GuideError::TurnsBack { point: 2, at: p(2.0) });
    assert_eq!(
        CurvedGuide::polyline(vec![p(1.0), p(2.0)], Some(0.0)).unwrap_err(),
        GuideError::BadRadius(0.0)
    );
    assert_eq!(error(vec![p(0.0); MAX_GUIDE_POINTS + 1]), GuideError::PointCount(10_001));
}

#[test]
fn a_guess_does_not_hide_a_nearer_place() {
    let points = [(0.0, 0.0), (50.0, 0.0), (50.0, 10.0), (0.0, 10.0)];
    let points = points.map(|(x, y)| Point3::new(x, y, 0.0)).to_vec();
    let mut guide = CurvedGuide::polyline(points, Some(4.0)).unwrap();
    let p = Point3::new(10.0, 7.0, 0.0);
    // Perpendiculars of both legs pass the point. A narrow passage can be missed, so that the reach
    // is too large.
    guide.reach = 8.0 / USABLE_SHARE;
    let expected = guide.length() - 10.0;
    for guess in [0.0, 10.0, 60.0, expected] {
        let station = guide.station(&p, Some(guess)).unwrap();
        assert!((station - expected).abs() < 1e-9, "{station} from {guess}");
    }
}

#[test]
fn a_guess_beyond_an_end_does_not_hide_a_nearer_place() {
    // Beyond its end the guide goes on across its first piece.
    let points = [(0.0, 0.0), (50.0, 0.0), (50.0, 30.0), (20.0, 30.0), (20.0, 10.0)];
    let points = points.map(|(x, y)| Point3::new(x, y, 0.0)).to_vec();
    let guide = CurvedGuide::polyline(points, Some(2.0)).unwrap();
    let p = Point3::new(20.5, 0.6, 0.0);
    for guess in [20.0, guide.length(), guide.length() + 6.0, f64::NAN] {
        let station = guide.station(&p, Some(guess)).unwrap();
        assert!((station - 20.5).abs() < 1e-9, "{station} from {guess}");
    }
}

#[test]
fn a_straight_guide_needs_no_search() {
    let ends = [Point3::origin(), Point3::new(0.0, 0.0, 3.0)];
    let guide = CurvedGuide::polyline(ends.to_vec(), None).unwrap();
    assert_eq!(guide.reach(), f64::INFINITY);
    for (height, guess) in [(1.0, 1.2), (0.0, 0.1), (3.1, 3.0)] {
        let p = Point3::new(40.0, -7.0, height);
        let stations = [None, Some(guess)].map(|guess| guide.extended_station(&p, guess).unwrap());
        assert!(stations.iter().all(|station| (station - height).abs() < 1e-12), "{stations:?}");
        assert!(guide.nearest_foot(&p, guess).is_some());
    }
}

#[test]
fn points_on_the_first_and_the_last_plane_have_stations_far_from_the_origin() {
    let bend = [(0.0, 0.0), (6.0, 2.0), (8.0, 7.0)];
    let points = bend.map(|(x, y)| Point3::new(500_000.0 + x, 5_400_000.0 + y, 80.0)).to_vec();
    for kind in [GuideKind::Spline, GuideKind::Polyline(None)] {
        let guide = CurvedGuide::new(kind, points.clone()).unwrap();
        let near = 0.5 * guide.usable_distance().min(2.0);
        for end in [0.0, guide.length()] {
            let frame = guide.frame(end);
            for k in 0..400 {
                let (x, y) = (0.1 * f64::from(k)).sin_cos();
                let p = frame.origin() + near * (frame.x_axis() * x + frame.y_axis() * y);
                for hint in [None, Some(end)] {
                    let station = guide.station(&p, hint);
                    assert!(station.is_ok_and(|s| (s - end).abs() < 1e-8), "{station:?} at {p}");
                }
                let outward = if end == 0.0 { -1e-7 } else { 1e-7 };
                let beyond = p + frame.normal() * outward;
                assert_eq!(guide.station(&beyond, None), Err(NoStation::BeyondEnds), "{p}");
            }
        }
    }
}

#[test]
fn a_foot_is_recognised_far_from_the_origin() {
    // A short guide, of which 1e-9 is less than its coordinates round by.
    let start = Point3::new(500_000.1, 5_400_000.3, 80.0);
    let ends = vec![start, start + Vector3::new(0.06, 0.08, 0.0)];
    let guide = CurvedGuide::polyline(ends, None).unwrap();
    for k in 0..200 {
        let (x, y) = (0.1 * f64::from(k)).sin_cos();
        let station = 0.0005 * f64::from(k);
        let p = guide.frame(station).origin() + Vector3::new(x, y, 0.3) * 1e-3;
        assert!(guide.nearest_foot(&p, station).is_some(), "{p}");
    }
}

/// Points of a smooth random curve.
fn guides() -> impl Strategy<Value = CurvedGuide> {
    let turns = prop::collection::vec((-0.5..0.5f64, -0.4..0.4f64), 3..9);
    (turns, any::<bool>(), -1.0..1.0f64).prop_map(|(turns, spline, far)| {
        let mut at = Point3::new(5e5 * far, 5.4e6 * far, 300.0);
        let (mut heading, mut climb) = (0.3, 0.0);
        let mut points = vec![at];
        for (left, up) in turns {
            heading += left;
            climb += up * 0.3;
            let direction = Vector3::new(heading.cos(), heading.sin(), climb).normalize();
            at += direction * 10.0;
            points.push(at);
        }
        let kind = if spline { GuideKind::Spline } else { GuideKind::Polyline(None) };
        CurvedGuide::new(kind, points).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_plane_at_a_points_station_holds_the_point(
        guide in guides(), share in 0.02..0.98f64, x in -1.0..1.0f64, y in -1.0..1.0f64,
        hint in 0.0..1.0f64,
    ) {
        let far = guide.usable_distance().min(3.0) * 0.7;
        let frame = guide.frame(share * guide.length());
        let p = frame.origin() + (frame.x_axis() * x + frame.y_axis() * y) * far;
        let station = guide.station(&p, None).unwrap();
        prop_assert!((station - share * guide.length()).abs() < 1e-6, "{station}");
        prop_assert!(guide.frame(station).height(&p).abs() < 1e-7);
        let hinted = guide.station(&p, Some(hint * guide.length())).unwrap();
        prop_assert!((hinted - station).abs() < 1e-9);
        prop_assert!((brute_station(&guide, &p) - station).abs() < 1e-2);
    }

    #[test]
    fn frames_are_orthonormal_and_follow_the_guide(guide in guides(), share in 0.0..1.0f64) {
        let s = share * guide.length();
        let frame = guide.frame(s);
        prop_assert!((frame.x_axis().cross(&frame.y_axis()) - frame.normal()).norm() < 1e-12);
        prop_assert!(frame.x_axis().dot(&frame.normal()).abs() < 1e-12);
        let h = 1e-3;
        let along = (guide.frame(s + h).origin() - guide.frame(s - h).origin()) / (2.0 * h);
        prop_assert!((along - frame.normal()).norm() < 1e-4, "{along} {}", frame.normal());
        let next = guide.frame(s + h);
        // No turn about the guide: the change of an axis lies along the tangent.
        let change = (next.x_axis() - frame.x_axis()) / h;
        prop_assert!(change.dot(&frame.y_axis()).abs() < 1e-3, "{change}");
    }
}
