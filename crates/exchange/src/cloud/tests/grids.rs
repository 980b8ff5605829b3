//! Rows and columns of rotating lidars.

use super::*;
use arrange::arrange;

/// A cloud as a grid, with the notes; or the error's text.
fn grid(
    points: Vec<Point3>,
    rings: Option<Vec<u16>>,
    stated: Option<usize>,
) -> Result<(ImageSize, Vec<Point3>, Vec<String>), String> {
    let mut notes = Vec::new();
    let cloud = Cloud { points, rings, ..Cloud::default() };
    let (size, points) = arrange(cloud, None, stated, &mut notes).map_err(|p| p.text)?;
    Ok((size, points, notes))
}

/// The grid that the simulation stands for, with its firings in their order.
fn truth(returns: &[Return], firings: usize) -> Vec<Option<[f64; 3]>> {
    let mut order: Vec<usize> = (0..LASERS.len()).collect();
    order.sort_by(|a, b| LASERS[*b].total_cmp(&LASERS[*a]));
    let mut cells = vec![None; firings * LASERS.len()];
    for r in returns {
        let row = order.iter().position(|l| *l == usize::from(r.laser)).unwrap();
        cells[row * firings + r.firing] = Some(r.point.into());
    }
    cells
}

/// The same by azimuth: clockwise, while the simulation turns the other way round, and from the
/// firing in the first column of `found`.
fn turned(returns: &[Return], firings: usize, found: &[Point3]) -> Vec<Option<[f64; 3]>> {
    let mut column = found.iter().step_by(firings).filter(|p| !p.x.is_nan());
    let point = column.next().unwrap();
    let first = returns.iter().find(|r| r.point == *point).unwrap().firing;
    let turn = |r: &Return| Return { firing: (first + firings - r.firing) % firings, ..*r };
    truth(&returns.iter().map(turn).collect::<Vec<_>>(), firings)
}

fn cells(points: &[Point3]) -> Vec<Option<[f64; 3]>> {
    points.iter().map(|p| (!p.x.is_nan()).then_some((*p).into())).collect()
}

#[test]
fn firings_are_found_without_any_field() {
    let mut returns = sweep(90, 0.1);
    returns.iter_mut().skip(3).step_by(7).for_each(|r| r.point = Point3::origin());
    let (size, points, notes) = grid(points(&returns), None, None).unwrap();
    assert_eq!((size.rows, size.cols), (8, 90));
    let zero = |c: Option<[f64; 3]>| c.filter(|p| *p != [0.0; 3]);
    let (found, wanted) = (cells(&points), truth(&returns, 90));
    assert!(found.into_iter().map(zero).eq(wanted.into_iter().map(zero)));
    assert!(notes[0].starts_with("90 firings of 8 lasers found: point k is laser k mod 8"));
    assert!(notes[1].starts_with("8 rows are the rings from 10.00° down to -20.00°"), "{notes:?}");
}

#[test]
fn lasers_one_after_the_other_are_found_too() {
    let mut returns = sweep(90, 0.0);
    returns.sort_by_key(|r| r.laser);
    let (size, found, notes) = grid(points(&returns), None, None).unwrap();
    assert_eq!((size.rows, size.cols), (8, 90));
    assert!(cells(&found) == truth(&returns, 90));
    assert!(notes[0].contains("point k is firing k mod 90 of laser k / 90"), "{notes:?}");
}

#[test]
fn points_in_another_order_are_refused_with_the_ways_out() {
    let mut returns = sweep(90, 0.0);
    returns.swap(5, 6);
    let error = grid(points(&returns), None, None).unwrap_err();
    assert!(error.contains("the 720 points have no rows and columns"), "{error}");
    let plane = (0..400).map(|k| Point3::new(f64::from(k % 20), f64::from(k / 20), -1.7));
    assert!(grid(plane.collect(), None, None).is_err(), "a plane shows no lasers");
}

/// A sweep without a third of its returns, in an order that tells nothing.
fn sparse(stagger: f64) -> Vec<Return> {
    let mut returns = sweep(360, stagger);
    let mut number = 0;
    returns.retain(|_| {
        number = (number * 69 + 1) % 1031;
        number % 3 > 0
    });
    returns.sort_by_key(|r| (r.firing * 97 + usize::from(r.laser) * 31) % 1009);
    returns
}

#[test]
fn columns_by_azimuth_are_the_firings() {
    let returns = sparse(0.0);
    let (size, found, notes) = grid(points(&returns), Some(rings(&returns)), None).unwrap();
    assert_eq!((size.rows, size.cols), (8, 360), "{notes:?}");
    assert!(cells(&found) == turned(&returns, 360, &found));
}

/// Lasers that fire one after the other: a column may begin with any of them.
#[test]
fn columns_of_staggered_lasers_hold_one_turn_of_all() {
    let returns = sparse(0.1);
    let (size, found, notes) = grid(points(&returns), Some(rings(&returns)), None).unwrap();
    assert!(size.cols.abs_diff(360) <= 10, "{notes:?}");
    assert_eq!(cells(&found).iter().flatten().count(), returns.len(), "no point is lost");
    // Azimuths from the first point of the first column.
    let clockwise = |p: &Point3| (-p.y).atan2(p.x);
    let column = found.iter().step_by(size.cols).filter(|p| !p.x.is_nan());
    let column: Vec<f64> = column.map(clockwise).collect();
    let least = column
        .iter()
        .copied()
        .min_by(|a, b| (a - column[0]).sin().total_cmp(&(b - column[0]).sin()));
    let azimuth =
        |p: &Point3| (clockwise(p) - least.unwrap() + 1e-9).rem_euclid(std::f64::consts::TAU);
    for col in 1..size.cols {
        let column = found.iter().skip(col).step_by(size.cols).filter(|p| !p.x.is_nan());
        let (low, high) = column
            .map(azimuth)
            .fold((7.0_f64, 0.0_f64), |(low, high), a| (low.min(a), high.max(a)));
        assert!(high - low < 0.023, "column {col}: {low} to {high}");
    }
    for row in found.chunks(size.cols) {
        let azimuths: Vec<f64> = row.iter().filter(|p| !p.x.is_nan()).map(azimuth).collect();
        assert!(azimuths.is_sorted());
    }
}

#[test]
fn rings_are_found_by_elevation_or_by_laps() {
    let mut returns = sweep(90, 0.0);
    returns.retain(|r| (r.firing * 7 + usize::from(r.laser)) % 5 > 0);
    let (_, found, notes) = grid(points(&returns), None, Some(8)).unwrap();
    assert!(cells(&found) == turned(&returns, 90, &found));
    assert!(notes[0].contains("8 rings by the gaps between elevations"), "{notes:?}");
    let error = grid(points(&returns), None, Some(9)).unwrap_err();
    assert!(
        error.contains("the setting `rings` 9: neither the elevations nor the order"),
        "{error}"
    );

    // Elevations that vary within a ring leave no gaps; ring after ring the order remains.
    let mut laps = sweep(90, 0.0);
    laps.sort_by(|a, b| LASERS[usize::from(b.laser)].total_cmp(&LASERS[usize::from(a.laser)]));
    laps.iter_mut()
        .for_each(|r| r.point.z += 0.02 * (r.firing % 13) as f64 * r.point.x.hypot(r.point.y));
    let (size, _, notes) = grid(points(&laps), None, Some(8)).unwrap();
    assert_eq!((size.rows, size.cols), (8, 90));
    assert!(notes[0].contains("8 rings by order"), "{notes:?}");
}

#[test]
fn of_two_returns_of_a_pulse_the_nearer_one_stays() {
    let returns = sweep(90, 0.0);
    let mut points = points(&returns);
    let mut rings = rings(&returns);
    for k in [100, 200, 300] {
        points.insert(0, points[points.len() - k] * 1.5);
        rings.insert(0, rings[rings.len() - k]);
    }
    let (_, found, notes) = grid(points, Some(rings), None).unwrap();
    assert!(cells(&found) == turned(&returns, 90, &found));
    assert!(notes.iter().any(|n| n.starts_with("3 points left out: a nearer return")), "{notes:?}");
}

#[test]
fn contradictions_are_refused() {
    let returns = sweep(90, 0.0);
    let error = grid(points(&returns), Some(rings(&returns)), Some(4)).unwrap_err();
    assert!(
        error.contains("the field of rings has 8 values; the setting `rings` states 4"),
        "{error}"
    );
    let error = grid(points(&returns), Some(vec![7; returns.len()]), None);
    assert!(error.is_err() || error.unwrap().0.rows == 1);
    let many: Vec<u16> = (0..).take(returns.len() * 2).collect();
    let twice = [points(&returns), points(&returns)].concat();
    let error = grid(twice, Some(many), None).unwrap_err();
    assert!(error.contains("1440 different rings; expected at most 1024"), "{error}");
}
