//! Tests of the rounds of a refinement, before its result.

use super::camera::Freed;
use super::observations::{CameraSlopes, Observation};
use super::outcome::medians;
use super::*;
use crate::scrambled::scrambled;
use crate::tuning::{CAMERA_GRID, PARTNERS, SHARED};
use transect_device::{DepthOffsets, RangeImage, View};
use transect_scene::{BUNDLED_SCENES, Description, Noise};

/// Frames of a depth camera that errs by 2 %.
fn depth_camera() -> Vec<View> {
    frames(|noise| noise.depth_camera.distortion = 0.02)
}

/// Frames of the kitchen, with another noise.
fn frames(change: impl Fn(&mut Noise)) -> Vec<View> {
    let (_, text) = BUNDLED_SCENES.iter().find(|(name, _)| *name == "kitchen").unwrap();
    let mut description = Description::parse(text).unwrap();
    change(&mut description.noise);
    let (scene, noise) = (description.scene(), description.noise);
    let stations = description.stations.iter().step_by(4).zip(0..);
    let view = stations.map(|(station, k)| {
        let (frame, pose) = (station.frame().unwrap(), station.world_from_sensor);
        scene.view(&station.name, frame, pose, &noise, k).unwrap()
    });
    view.collect()
}

#[test]
fn a_small_prior_hides_no_contradictions() {
    let copies: Vec<CoarseView> = depth_camera().iter().map(CoarseView::new).collect();
    let views: Vec<&CoarseView> = copies.iter().collect();
    let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
    let scene = scene(views, &given);
    let mut rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
    let mut observe = |prior| {
        rounds.observe(prior, OBSERVATIONS, Spread::Narrow);
        rounds.pairs.iter().map(|pair| pair.observations.len()).sum::<usize>()
    };
    let first = observe(PosePrior { rotation: 0.01, translation: 0.03 });
    let tiny = PosePrior { rotation: 1e-6, translation: 1e-6 };
    let again: Vec<usize> = (0..8).map(|_| observe(tiny)).collect();
    assert!(again[7] * 10 > first * 8, "{first} patches met, then {again:?}");
}

#[test]
fn views_without_pairs_take_no_numbers_out() {
    let copies: Vec<CoarseView> = depth_camera().iter().map(CoarseView::new).collect();
    let views: Vec<&CoarseView> = copies.iter().collect();
    let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
    let scene = scene(views.clone(), &given);
    let mut rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
    rounds.observe(PosePrior { rotation: 0.01, translation: 0.03 }, OBSERVATIONS, Spread::Narrow);
    let share = independent_share(&views, &rounds.pairs);
    let with_others: Vec<&CoarseView> = views.iter().chain(&views).copied().collect();
    assert_eq!(independent_share(&with_others, &rounds.pairs), share);
}

/// Few frames hardly tell an offset of the whole image from other poses. One that is not clear is
/// held near zero, and a large one stays.
#[test]
fn a_level_is_held_unless_it_is_clearly_wrong() {
    for (added, least, most) in [(0.0, 0.0, 0.8), (0.03, 1.0, 1.0)] {
        let offset = DepthOffsets::new(2, 2, vec![added; 4]).unwrap();
        let copies = depth_camera().into_iter().map(|view| {
            let image = offset.correct(view.frame(), view.image()).unwrap();
            CoarseView::new(&view.with_image(image).unwrap())
        });
        let copies: Vec<CoarseView> = copies.collect();
        let views: Vec<&CoarseView> = copies.iter().collect();
        let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
        let scene = scene(views, &given);
        let mut rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
        rounds.first_rounds().unwrap();
        rounds.cameras.release();
        rounds.run_rounds();
        let nodes = CAMERA_GRID.0 * CAMERA_GRID.1;
        let level = |rounds: &Rounds<'_>| rounds.cameras.list[0].errors.rows(0, nodes).mean();
        let free = level(&rounds);
        rounds.hold_levels();
        let left = level(&rounds) / free;
        println!("added {added}: {free} freely, {left} of it held");
        assert!((free + added).abs() < 0.01, "{free}");
        assert!(least <= left && left <= most, "{left} of {free}");
    }
}

/// One view moves a thousand times as far as the others, and still far less than its noise.
#[test]
fn a_motion_within_the_noise_is_not_far_off() {
    let prior = |size: f64| Some(PosePrior { rotation: size, translation: size });
    let sizes = [1e-9, 1e-5, 1e-9, 1e-9];
    let copies = depth_camera().into_iter().zip(sizes);
    let copies: Vec<CoarseView> = copies
        .map(|(view, size)| CoarseView::new(&view).with_prior(prior(size)).unwrap())
        .collect();
    let views: Vec<&CoarseView> = copies.iter().collect();
    let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
    let scene = scene(views, &given);
    let mut rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
    rounds.run();
    let turned: Vec<f64> = rounds.motions().iter().map(|m| m.fixed_rows::<3>(3).norm()).collect();
    assert!(turned[1] > 100.0 * turned[0], "{turned:?}");
    let system = System::sum(&rounds.systems());
    assert_eq!(rounds.far_off(|| system), [false; 4]);
}

/// The slopes over the unknowns of a camera are those of small changes.
#[test]
fn distances_change_with_the_errors_of_a_camera_as_their_slopes_say() {
    // Distances run along the normals of patches, and slopes along steadier ones: without noise
    // both are alike.
    let exact = frames(|noise| *noise = Noise::NONE);
    let copies: Vec<CoarseView> = exact.iter().map(CoarseView::new).collect();
    let views: Vec<&CoarseView> = copies.iter().collect();
    let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
    let scene = scene(views, &given);
    let mut rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
    rounds.cameras = rounds.cameras.freed(Freed::ScaleAndFocal, |_| true);
    let wide = PosePrior { rotation: 0.01, translation: 0.03 };
    for unknown in [31, 63, 64, 65] {
        let step = 1e-5;
        let mut observed = |error: f64| {
            let mut change = DVector::zeros(rounds.cameras.unknowns());
            change[unknown] = error;
            rounds.cameras.change(&change.rows_range(..));
            rounds.observe(wide, OBSERVATIONS, Spread::Narrow);
            let patches = rounds.pairs.iter().filter(|pair| pair.of == Pieces::Patches);
            patches.cloned().collect::<Vec<Pair>>()
        };
        let (before, after) = (observed(0.0), observed(step));
        let (mut products, mut squares, mut count) = (0.0, 0.0, 0);
        for (one, other) in before.iter().zip(&after) {
            for o in &one.observations {
                let same = other.observations.iter().find(|p| p.cells == o.cells);
                let Some(same) = same else { continue };
                let (terms, _) = one.camera_terms(o, &rounds.cameras);
                let slopes = terms.iter().filter(|(k, _)| *k == unknown).map(|(_, slope)| slope);
                let slope = slopes.sum::<f64>();
                products += slope * (same.distance - o.distance) / step;
                squares += slope * slope;
                count += usize::from(slope != 0.0);
            }
        }
        let ratio = products / squares;
        assert!(count > 100 && (ratio - 1.0).abs() < 0.05, "unknown {unknown}: {ratio}, {count}");
    }
}

/// The depths of a sound camera are suspected, and acquitted.
#[test]
fn everything_stays_where_no_scale_is_wrong() {
    let sound = frames(|noise| noise.depth_camera.distortion = 0.0);
    let copies: Vec<CoarseView> = sound.iter().map(CoarseView::new).collect();
    let views: Vec<&CoarseView> = copies.iter().collect();
    let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
    let scene = scene(views, &given);
    let mut rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
    rounds.run();
    let before = rounds.clone();
    rounds.free_cameras(vec![true]);
    let numbers = |rounds: &Rounds<'_>| {
        let solution = System::sum(&rounds.systems()).unwrap();
        let solution = solution
            .solve(rounds.independent, &rounds.known_before(&rounds.priors(), &rounds.motions()));
        (rounds.poses.clone(), rounds.cameras.list[0].errors.clone(), solution.unwrap().unknowns)
    };
    assert_eq!(numbers(&rounds), numbers(&before));
    assert!(rounds.cameras.of_view(0).is_none_or(|offsets| offsets.scale() == 1.0));
}

#[test]
fn residuals_before_and_after_are_of_one_scale() {
    let copies: Vec<CoarseView> = depth_camera().iter().map(CoarseView::new).collect();
    let views: Vec<&CoarseView> = copies.iter().collect();
    let given: Vec<Isometry3> = views.iter().map(|view| *view.world_from_sensor()).collect();
    let scene = scene(views, &given);
    let mut rounds = Rounds::new(&scene, given.clone(), &RefineOptions::default(), &[]);
    rounds.run();
    let [before, after] = rounds.residuals();
    assert_ne!(before, after);
    // Without any motion nothing changes, however close the rounds looked.
    (rounds.poses, rounds.cameras) = (given, rounds.cameras.without_errors());
    let [again, stayed] = rounds.residuals();
    assert!(again.iter().all(Option::is_some) && again == before && stayed == before);
}

#[test]
fn an_observation_represents_three_samples_at_most() {
    let view = CoarseView::new(&depth_camera().swap_remove(0));
    let views = vec![&view; 3];
    let given = vec![*view.world_from_sensor(); 3];
    let scene = scene(views, &given);
    let rounds = Rounds::new(&scene, given.clone(), &RefineOptions::default(), &[]);
    let state = State { poses: &given, cameras: &rounds.cameras };
    let reach = Reach { rotation: 0.01, translation: 0.03, unexplained: 0.0 };
    let shares = |most: usize| {
        let (of, pairs) = ((Pieces::Patches, most), &rounds.candidates);
        let pairs = scene.observe_pieces(of, pairs, state, reach, Spread::Narrow);
        let shares = pairs.iter().flat_map(|pair| &pair.observations).map(|o| o.share);
        let shares: Vec<f64> = shares.collect();
        assert!(shares.len() > 100, "{} observations", shares.len());
        shares
    };
    // All three views see each surface.
    assert!(shares(usize::MAX).iter().all(|share| *share == 1.0 / 3.0));
    // The views are alike, so the same tenth of their cells is taken. The observation of the other
    // view counts ten times.
    let tenth = scene.samples[0].len() / 10;
    let all = shares(tenth);
    assert!(all.iter().all(|share| (0.05..0.1).contains(share)), "{all:?}");
    // An observation that is alone in its cell counts three times.
    let two: Vec<(usize, usize)> =
        rounds.candidates.iter().copied().filter(|(a, b)| a.max(b) < &2).collect();
    let of = (Pieces::Patches, tenth);
    let pairs = scene.observe_pieces(of, &two, state, reach, Spread::Narrow);
    let alone: Vec<_> = pairs.iter().flat_map(|pair| &pair.observations).collect();
    assert!(alone.len() > 100 && alone.iter().all(|o| o.share == 0.25), "{}", alone.len());
}

#[test]
fn a_view_has_a_limited_number_of_partners() {
    let view = depth_camera().swap_remove(0);
    let size = view.image().size();
    let upper = size.all_pixels().map(|p| match p.row < size.rows / 2 {
        true => view.image().row(p.row)[p.col],
        false => f32::NAN,
    });
    let half = view.with_image(RangeImage::from_values(size, upper.collect()).unwrap()).unwrap();
    let (whole, half) = (CoarseView::new(&view), CoarseView::new(&half));
    // View 0 shares less with each of the others than they share with each other.
    let views: Vec<&CoarseView> = [&half].into_iter().chain([&whole; PARTNERS + 2]).collect();
    let given = vec![*view.world_from_sensor(); views.len()];
    let scene = scene(views, &given);
    let rounds = Rounds::new(&scene, given, &RefineOptions::default(), &[]);
    let is_pair = |a: usize, b: usize| rounds.candidates.contains(&(a, b));
    assert!(is_pair(0, PARTNERS) && is_pair(PARTNERS, 0));
    for view in [PARTNERS + 1, PARTNERS + 2] {
        assert!(!is_pair(0, view) && !is_pair(view, 0), "{view}");
        assert!(is_pair(1, view) && is_pair(view, 1), "{view}");
    }
    assert!(!is_pair(PARTNERS + 1, PARTNERS + 2));
}

/// Numbers of mean 0 and variance 1, nearly normal, the same in every run.
fn draws(seed: u32) -> impl Iterator<Item = f64> {
    let uniform = |k: u32| f64::from(scrambled(k)) / f64::from(u32::MAX) - 0.5;
    (0..).map(move |k| (0..12).map(|j| uniform(1 + seed * 100_000 + 12 * k + j)).sum())
}

#[test]
fn waves_along_the_views_are_those_of_a_walk() {
    const VIEWS: usize = 25;
    let mut drift = Drift::of(VIEWS);
    drift.release();
    let share = drift.share();
    let walk = DMatrix::from_fn(VIEWS, VIEWS, |i, j| i.min(j) as f64);
    let about_mean = DMatrix::identity(VIEWS, VIEWS).add_scalar(-1.0 / VIEWS as f64);
    let walk = &about_mean * walk * &about_mean;
    let walk = &walk * (VIEWS as f64 / walk.trace());
    let correlations =
        (DMatrix::identity(VIEWS, VIEWS) * (1.0 - share) + walk * share).add_scalar(SHARED);
    let off = drift.precision() * correlations - DMatrix::identity(VIEWS, VIEWS);
    assert!(off.amax() < 1e-9, "{}", off.amax());

    let all = drift.precision().clone();
    drift.leave_out(&[3, 24]);
    let left = drift.precision();
    assert!((left.column(3) - DMatrix::identity(VIEWS, VIEWS).column(3)).amax() < 1e-12);
    assert!((left.column(24) - DMatrix::identity(VIEWS, VIEWS).column(24)).amax() < 1e-12);
    let mut fewer = Drift::of(VIEWS - 2);
    fewer.release();
    let rest = left.clone().remove_columns_at(&[3, 24]).remove_rows_at(&[3, 24]);
    assert!((rest - fewer.precision()).amax() < 1e-12);
    assert!((left - all).amax() > 0.1);
}

#[test]
fn errors_tell_whether_poses_drift() {
    const VIEWS: usize = 40;
    let exact = DMatrix::identity(6 * VIEWS, 6 * VIEWS) * 1e-9;
    let learned = |errors: &[Motion]| {
        let mut drift = Drift::of(VIEWS);
        drift.release();
        let mut prior = PosePrior { rotation: 1.0, translation: 1.0 };
        for _ in 0..PRIOR_ROUNDS {
            let before = Before {
                priors: &[prior; VIEWS],
                moved: errors,
                drift: &drift,
                pivots: &Pivots::of_arms(&[]),
                cameras: &Cameras::of(&[], 1.0),
            };
            let errors = Errors::new(errors, &exact, |k| before.in_units(k));
            prior = estimated_prior(&prior, &drift.size(&errors, |_| true));
            drift.learn(&errors);
        }
        drift.share()
    };
    for seed in 0..10 {
        let mut numbers = draws(seed);
        let alone: Vec<Motion> =
            (0..VIEWS).map(|_| Motion::from_fn(|_, _| numbers.next().unwrap())).collect();
        let walk = alone.iter().scan(Motion::zeros(), |sum, step| {
            *sum += step;
            Some(*sum)
        });
        // The walk starts at the first view, so all views share most of it.
        let walk: Vec<Motion> = walk.collect();
        let (alone, walk) = (learned(&alone), learned(&walk));
        assert!(
            alone < 0.2 && walk > 0.8,
            "seed {seed}: {alone} of single errors, {walk} of a walk"
        );
    }
}

#[test]
fn errors_tell_about_which_point_they_are() {
    const VIEWS: usize = 12;
    let exact = DMatrix::identity(6 * VIEWS, 6 * VIEWS) * 1e-9;
    let drift = Drift::of(VIEWS);
    for seed in 0..10 {
        for at in [0.0, 0.5, 1.0] {
            let mut numbers = draws(seed);
            let arms =
                [(); VIEWS].map(|()| 40.0 * Vector3::from_fn(|_, _| numbers.next().unwrap()));
            let motions: Vec<Motion> = arms
                .iter()
                .map(|arm| {
                    let shift = Vector3::from_fn(|_, _| numbers.next().unwrap());
                    let turn = 0.1 * Vector3::from_fn(|_, _| numbers.next().unwrap());
                    let at_sensor = shift - turn.cross(&(at * arm));
                    Motion::from_fn(|c, _| if c < 3 { at_sensor[c] } else { turn[c - 3] })
                })
                .collect();
            let mut pivots = Pivots::of_arms(&arms);
            let prior = PosePrior { rotation: 0.1, translation: 1.0 };
            pivots.learn(&motions, &exact, &[prior; VIEWS], drift.precision());
            assert!((pivots.share - at).abs() < 0.1, "seed {seed}: {}, not {at}", pivots.share);
        }
    }
}

/// One plate hides another one from view 1. Most patches of view 0 lie on the hidden plate.
#[test]
fn what_a_surface_hides_is_no_residual() {
    let observation = |distance: f64| Observation {
        cells: [0, 0],
        gradient: Motion::zeros(),
        distance,
        slopes: CameraSlopes::default(),
        variance: 1e-6,
        share: 1.0,
        turned: 0.0,
        arm: [0.0; 3],
    };
    let pair = |distances: &[f64]| Pair {
        of: Pieces::Patches,
        a: 0,
        b: 1,
        observations: distances.iter().map(|d| observation(*d)).collect(),
        excess: 0.0,
        turned: 0.0,
    };
    let hidden = [-0.2, -0.2, -0.2, -0.2, 0.001, -0.001, 0.002];
    assert_eq!(medians(&[pair(&hidden)], 2), [Some(0.002); 2]);
    // If view 1 sees the patches of the other direction in front, the views contradict each other.
    assert_eq!(medians(&[pair(&hidden), pair(&hidden.map(|d| -d))], 2), [Some(0.2); 2]);
}
