use super::*;

fn samples(f: impl Fn(f64) -> f64) -> Vec<Sample> {
    let at = |k: i32| f64::from(k) * 0.25;
    (-8..=8)
        .map(|k| Sample { x: at(k), y: f(at(k)), weight: 1.0, sigma: 0.1, ..Sample::default() })
        .collect()
}

fn limits(reach: f64, threshold: f64) -> Limits {
    Limits { reach, across: f64::INFINITY, threshold }
}

fn parabola(samples: &[Sample], threshold: f64) -> Option<Fit> {
    let mut windows = Windows::new(Steps::default());
    windows.begin(samples.iter().copied(), 0.7);
    windows.fit(&limits(2.0, threshold))
}

#[test]
fn a_parabola_is_found_exactly_and_a_stray_sample_ignored() {
    // So little bent that an arc is no different.
    let mut s = samples(|x| 0.3 - 0.2 * x + 1e-3 * x * x);
    s[3].y += 5.0;
    let fit = parabola(&s, 1.0).unwrap();
    assert!((fit.place - 0.3).abs() < 1e-6, "{fit:?}");
    assert!((fit.slope + 0.2).abs() < 3e-6 && (fit.bend - 1e-3).abs() < 1e-6, "{fit:?}");
}

#[test]
fn an_arc_is_followed_where_a_parabola_leaves_it() {
    // Seen along a tangent and along a chord; half-width 0.6 radii.
    let radius = 2.0 / 0.6;
    for at in [0.0, 0.2] {
        let y = |x: f64| radius - (radius * radius - (x - at) * (x - at)).sqrt();
        let fit = parabola(&samples(y), 10.0).unwrap();
        // A parabola is off by 0.0107 × 0.6³ × 2, an arc's sixth order leaves half of that.
        assert!((fit.place - y(0.0)).abs() < 0.0025, "{at}: {fit:?}");
    }
}

#[test]
fn means_of_places_on_a_bend_do_not_pull_the_curve_inside() {
    // Each sample stands for places of variance 0.04 along y = 0.001 x².
    let spread = |s: Sample| Sample { y: s.y + 4e-5, along_variance: 0.04, ..s };
    let means: Vec<_> = samples(|x| 1e-3 * x * x).into_iter().map(spread).collect();
    let fit = parabola(&means, 10.0).unwrap();
    assert!(fit.place.abs() < 1e-8 && (fit.bend - 1e-3).abs() < 1e-7, "{fit:?}");
}

#[test]
fn the_predicted_spread_of_a_mean_of_line_samples_is_right() {
    // A parabola through n even samples has 9/4 the variance of their mean at its middle.
    let fit = parabola(&samples(|_| 0.0), 1.0).unwrap();
    let expected = 0.1 * (2.25 / 17.0_f64).sqrt();
    assert!((fit.place_sigma / expected - 1.0).abs() < 0.05, "{fit:?}");
}

#[test]
fn one_sided_samples_do_not_make_a_parabola() {
    let right: Vec<_> = samples(|x| x).into_iter().filter(|s| s.x > 0.0).collect();
    assert_eq!(parabola(&right, 1.0), None);
}

#[test]
fn a_sample_on_its_way_out_changes_the_fit_gradually() {
    let place = |off: f64| {
        let mut s = samples(|_| 0.0);
        s[9].y = off;
        parabola(&s, 1.0).unwrap().place
    };
    for k in 0..400 {
        let off = f64::from(k) * 0.005;
        assert!((place(off + 0.005) - place(off)).abs() < 0.005, "{off}");
    }
    assert_eq!(place(5.0), 0.0);
}

/// Uneven samples that share errors over lengths of their own.
fn uneven(count: u32) -> Vec<Sample> {
    let sample = |k: u32| {
        let r = |m: u32| f64::from((k + 1) * m % 101) / 101.0;
        let x = 4.0 * (f64::from(k) + 0.5 * r(37)) / f64::from(count) - 2.1;
        let (weight, sigma, correlation) = (0.2 + r(53), 0.1 + 0.1 * r(71), 0.4 * r(29));
        Sample { x, y: 0.2 * r(19), weight, sigma, along_variance: 0.01 * r(11), correlation }
    };
    (0..count).map(sample).collect()
}

#[test]
fn growing_windows_have_the_sums_of_their_samples() {
    let all = uneven(40);
    let mut windows = Windows::new(Steps::default());
    windows.begin(all.iter().copied(), 0.5);
    for reach in [0.5, 0.9, 1.7, 3.0] {
        let inside: Vec<_> = all.iter().filter(|s| s.x.abs() <= reach).copied().collect();
        let found = windows.fit(&limits(reach, 10.0)).unwrap();
        let expected = slow(&inside, reach);
        for (found, expected) in [
            (found.place, expected.place),
            (found.slope, expected.slope),
            (found.bend, expected.bend),
            (found.place_sigma, expected.place_sigma),
            (found.bend_sigma, expected.bend_sigma),
        ] {
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{reach}");
        }
    }
}

#[test]
fn samples_almost_in_one_place_need_no_order() {
    // Gathering sorts by places rounded to 24 bits.
    let mut all = uneven(40);
    let ahead = all.iter().position(|s| s.x > 0.0).unwrap();
    for near in [ahead, ahead - 3] {
        all[near].x = all[near + 1].x + 1e-9;
    }
    let mut windows = Windows::new(Steps::default());
    windows.begin(all.iter().copied(), 0.5);
    let found = windows.fit(&limits(3.0, 10.0)).unwrap();
    let expected = slow(&all, 3.0);
    assert!((found.place_sigma / expected.place_sigma - 1.0).abs() < 1e-6, "{found:?}");
    assert!((found.bend_sigma / expected.bend_sigma - 1.0).abs() < 1e-6, "{found:?}");
}

/// The fit by matrices, with the correlation of every pair written out.
fn slow(samples: &[Sample], reach: f64) -> Fit {
    use nalgebra::{DMatrix, DVector};
    let n = samples.len();
    let row = |k: usize, c: usize| [1.0, samples[k].x, samples[k].square()][c];
    let design = DMatrix::from_fn(n, 3, row);
    let weights = DMatrix::from_diagonal(&DVector::from_fn(n, |k, _| samples[k].weight));
    let places = DVector::from_fn(n, |k, _| samples[k].y);
    let inverse = (design.transpose() * &weights * &design).try_inverse().unwrap();
    let solve = &inverse * design.transpose() * &weights;
    let errors = &solve * covariance(samples) * solve.transpose();
    let bend_sigma = errors[(2, 2)].sqrt();
    let mut fit = &solve * &places;
    let (mut cubic, mut quartic) = (0.0, 0.0);
    for _ in 0..2 {
        let now = Fit { slope: fit[1], bend: fit[2], bend_sigma, ..Fit::default() };
        HigherOrders { cubic, quartic } = beyond_parabola(&now, reach);
        // Even powers from the fourth on are those of the mean square.
        let (mut moments, mut higher) = (design.transpose() * &weights * &places, [0.0; 3]);
        for s in samples {
            let (x, q, w) = (s.x, s.square(), s.weight);
            higher[0] += w * (cubic * x * q + quartic * q * q);
            higher[1] += w * (cubic * q * q + quartic * x * q * q);
            higher[2] += w * (cubic * x * q * q + quartic * q * q * q);
        }
        moments -= DVector::from_row_slice(&higher);
        fit = &inverse * moments;
    }
    Fit {
        place: fit[0],
        slope: fit[1],
        bend: fit[2],
        cubic,
        quartic,
        place_sigma: errors[(0, 0)].sqrt(),
        bend_sigma,
    }
}

fn covariance(samples: &[Sample]) -> nalgebra::DMatrix<f64> {
    let step = |k: usize| {
        let (a, b) = (&samples[k], &samples[k + 1]);
        shared(b.x - a.x, 0.5 * (a.correlation + b.correlation))
    };
    nalgebra::DMatrix::from_fn(samples.len(), samples.len(), |i, j| {
        let between: f64 = (i.min(j)..i.max(j)).map(step).product();
        samples[i].sigma * samples[j].sigma * between
    })
}
