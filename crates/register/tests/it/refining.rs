//! Poses refined together.

use super::common::{
    changed, coarse, real, simulated, simulated_with_noise, simulated_with_seed, turned,
};
use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, Point3};
use transect_device::{RangeImage, SensorPlane, Vector3, View};
use transect_register::{
    CoarseView, PoseOutcome, PosePrior, PoseRefinement, RefineOptions, refine,
};
use transect_scene::Noise;
use transect_sensors::{Intrinsics, Pinhole};

/// Small errors of a few poses, the same in every run: degrees and lengths up to the given ones.
pub fn shaken(views: &[View], degrees: f64, length: f64) -> Vec<View> {
    let shake = |(k, view): (usize, &View)| {
        let wave = |n: usize| ((7 * k + n) as f64 * 2.399).sin();
        let turn = Vector3::new(wave(1), wave(2), wave(3)) * degrees.to_radians();
        let shift = Vector3::new(wave(4), wave(5), wave(6)) * length;
        let pose = view.world_from_sensor() * Isometry3::new(shift, turn);
        view.with_pose(pose).unwrap()
    };
    views.iter().enumerate().map(shake).collect()
}

/// Root of the mean squared distance between where two sets of poses put the views' surfaces, after
/// the motion that all views share.
pub fn apart(views: &[View], poses: &[Isometry3]) -> f64 {
    let first = poses[0] * views[0].world_from_sensor().inverse();
    let mut squares = Vec::new();
    for (view, pose) in views.iter().zip(poses) {
        for (_, patch) in coarse(std::slice::from_ref(view))[0].patches().step_by(50) {
            let there: Point3 = first * view.world_from_sensor() * patch.point();
            squares.push((pose * patch.point() - there).norm_squared());
        }
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

fn refined(views: &[View]) -> Vec<Isometry3> {
    let refinement = refine(&coarse(views), &RefineOptions::default()).unwrap();
    refinement.poses.iter().map(|p| p.world_from_sensor).collect()
}

pub fn given(views: &[View]) -> Vec<Isometry3> {
    views.iter().map(|v| *v.world_from_sensor()).collect()
}

#[test]
fn exact_poses_stay() {
    for scene in ["room", "face_mask", "machined_part", "tunnel"] {
        let views = simulated(scene, "");
        let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
        for (view, pose) in views.iter().zip(&refinement.poses) {
            let noise = view.sigma().unwrap_or(0.0).max(1e-4);
            assert!(pose.translation < 0.1 * noise, "{scene} {}: {pose:?}", view.name());
        }
    }
}

#[test]
fn errors_of_poses_shrink() {
    for (scene, share) in [("room", 0.1), ("face_mask", 0.2), ("machined_part", 0.2)] {
        let views = simulated(scene, "");
        let wrong = shaken(&views, 0.3, 0.005);
        let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &refined(&wrong)));
        assert!(after < share * before, "{scene}: {before} to {after}");
    }
}

/// Four views have six pairs, so each pair that judges takes much of what determines them.
#[test]
fn few_views_are_refined_too() {
    let views = simulated("machined_part", "");
    let views: Vec<View> = views.into_iter().step_by(3).collect();
    assert_eq!(views.len(), 4);
    for (degrees, shift) in [(0.1, 0.1), (0.07, 0.15), (0.13, 0.05), (0.15, 0.15)] {
        let wrong = shaken(&views, degrees, shift);
        let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &refined(&wrong)));
        assert!(after < 0.5 * before, "{degrees} {shift}: {before} to {after}");
    }
}

/// A part on a turntable errs about its middle. Its side walls alone hold the views from above to
/// those from below, and say nothing of heights.
#[test]
fn errors_about_a_part_displace_no_views_where_images_tell_nothing() {
    let views = simulated("machined_part", "");
    let middle = Point3::new(0.0, 0.0, 15.0);
    let about = Isometry3::translation(0.0, 0.0, 15.0);
    for seed in 0..4 {
        let wrong = views.iter().enumerate().map(|(k, view)| {
            let wave = |n: usize| (f64::from(7 * k as u32 + 101 * seed) + n as f64).sin() * 43758.5;
            let vector = |n| Vector3::from_fn(|c, _| 2.0 * wave(n + c).fract() - 1.0);
            let error = Isometry3::new(0.2 * vector(1), 0.2_f64.to_radians() * vector(4));
            view.with_pose(about * error * about.inverse() * view.world_from_sensor()).unwrap()
        });
        let wrong: Vec<View> = wrong.collect();
        // How much higher the views from above put the middle than those from below do.
        let step = |poses: &[Isometry3]| {
            let height = |from_above: bool| {
                let of_view = |(view, pose): (&View, &Isometry3)| {
                    let sensor = view.world_from_sensor();
                    let moved = (pose * sensor.inverse() * middle - middle).z;
                    (from_above == (sensor.translation.z > 0.0)).then_some(moved)
                };
                let heights: Vec<f64> = views.iter().zip(poses).filter_map(of_view).collect();
                heights.iter().sum::<f64>() / heights.len() as f64
            };
            (height(true) - height(false)).abs()
        };
        let (before, after) = (step(&given(&wrong)), step(&refined(&wrong)));
        println!("step between above and below: {before} mm, {after} mm refined");
        assert!(after < before + 0.05, "seed {seed}: {before} to {after}");
    }
}

#[test]
fn a_view_far_off_is_brought_back() {
    let views = simulated("room", "");
    for (k, degrees) in [(0, 3.0), (1, 10.0), (3, -10.0)] {
        let mut wrong = views.clone();
        wrong[k] = turned(&views[k], 1, degrees);
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
        let poses: Vec<_> = refinement.poses.iter().map(|p| p.world_from_sensor).collect();
        let (before, after) = (apart(&views, &given(&wrong)), apart(&views, &poses));
        assert!(after < 0.02 * before, "view {k} by {degrees}: {before} to {after}");
        assert_eq!(refinement.poses[k].outcome, PoseOutcome::BroughtBack, "{degrees}");
        for pose in refinement.poses.iter().filter(|pose| pose.view != views[k].name()) {
            assert_eq!(pose.outcome, PoseOutcome::Kept, "drawn after view {k}: {pose:?}");
            assert_eq!(pose.rotation, 0.0, "{pose:?}");
        }
    }
}

#[test]
fn a_view_of_another_place_stays_and_is_told() {
    let mut views = simulated("room", "");
    let away = Isometry3::translation(100.0, 0.0, 0.0) * views[2].world_from_sensor();
    views[2] = views[2].with_pose(away).unwrap();
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    assert_eq!(refinement.poses[2].outcome, PoseOutcome::Alone);
    assert_eq!(refinement.poses[2].world_from_sensor, away);
    // The other views' small errors say nothing about it. What was stated of all does.
    assert_eq!(refinement.poses[2].sigma, None);
    assert!(refinement.poses[1].sigma.is_some());
    let prior = Some(PosePrior { rotation: 0.01, translation: 0.05 });
    let stated =
        refine(&coarse(&views), &RefineOptions { prior, ..RefineOptions::default() }).unwrap();
    assert_eq!((stated.poses[2].outcome, stated.poses[2].sigma), (PoseOutcome::Alone, prior));
    assert!(refine(&[], &RefineOptions::default()).unwrap().poses.is_empty());
}

/// Exact images leave errors of nothing but rounding, which must not spoil the equations.
#[test]
fn errors_of_poses_shrink_without_noise() {
    let views = simulated_with_noise("machined_part", |noise| *noise = Noise::default());
    let refinement = refine(&coarse(&shaken(&views, 0.1, 0.1)), &RefineOptions::default()).unwrap();
    assert!(refinement.poses.iter().all(|pose| pose.has_moved()), "{:?}", refinement.poses[0]);
}

/// From twenty views on, a view is taken to err as its neighbours do.
#[test]
fn a_view_of_another_place_stays_among_many_that_err_alike() {
    let of_seed = |seed| {
        let renamed = move |view: View| {
            let (name, sigma) = (format!("{seed} {}", view.name()), view.sigma());
            let (image, frame) = (view.image().clone(), view.shared_frame());
            View::new(name, image, frame, *view.world_from_sensor(), sigma).unwrap()
        };
        simulated_with_seed("room", seed).into_iter().map(renamed)
    };
    let mut views: Vec<View> = (0..6).flat_map(of_seed).collect();
    assert!(views.len() >= 20, "{}", views.len());
    views = shaken(&views, 0.1, 0.005);
    let away = Isometry3::translation(100.0, 0.0, 0.0) * views[9].world_from_sensor();
    views[9] = views[9].with_pose(away).unwrap();
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    assert!(refinement.poses[8].has_moved());
    assert_eq!(refinement.poses[9].outcome, PoseOutcome::Alone);
    assert_eq!(refinement.poses[9].world_from_sensor, away);
}

/// The rigid motion that takes points to others best (Kabsch, 1976).
fn rigid_fit(from: &[Point3], to: &[Point3]) -> Isometry3 {
    let mean = |list: &[Point3]| list.iter().map(|p| p.coords).sum::<Vector3>() / list.len() as f64;
    let means = [mean(from), mean(to)];
    let scatter: nalgebra::Matrix3<f64> = (from.iter().zip(to))
        .map(|(a, b)| (b.coords - means[1]) * (a.coords - means[0]).transpose())
        .sum();
    let start = nalgebra::UnitQuaternion::identity();
    let turn = nalgebra::UnitQuaternion::from_matrix_eps(&scatter, 1e-14, 1000, start);
    Isometry3::from_parts((means[1] - turn * means[0]).into(), turn)
}

/// The errors of refined poses over their standard deviations, after the rigid fit to the exact
/// ones: of the sensors' places and of angles, as root mean squares over the axes, and of the
/// views' surfaces along their normals.
fn errors_over_sigma(exact: &[View], refinement: &PoseRefinement) -> [Vec<f64>; 3] {
    let (mut from, mut to, mut normals, mut of_view) = (vec![], vec![], vec![], vec![]);
    for (view, pose) in exact.iter().zip(&refinement.poses) {
        let first = from.len();
        for (_, patch) in coarse(std::slice::from_ref(view))[0].patches().step_by(40) {
            from.push(pose.world_from_sensor * patch.point());
            to.push(view.world_from_sensor() * patch.point());
            normals.push(view.world_from_sensor() * patch.normal());
        }
        of_view.push(first..from.len());
    }
    let fit = rigid_fit(&from, &to);
    let mut ratios = [Vec::new(), Vec::new(), Vec::new()];
    for (points, pose) in of_view.into_iter().zip(&refinement.poses) {
        let count = points.len() as f64;
        let squares: f64 = points.map(|k| (fit * from[k] - to[k]).dot(&normals[k]).powi(2)).sum();
        ratios[2].push((squares / count).sqrt() / pose.surface_sigma.unwrap());
    }
    for (view, pose) in exact.iter().zip(&refinement.poses) {
        let (there, exact) = (fit * pose.world_from_sensor, view.world_from_sensor());
        let shift = (there.translation.vector - exact.translation.vector).norm();
        let turn = there.rotation.angle_to(&exact.rotation);
        let PosePrior { rotation: of_angle, translation: of_place } = pose.sigma.unwrap();
        ratios[0].push(shift / of_place / 3.0_f64.sqrt());
        ratios[1].push(turn / of_angle / 3.0_f64.sqrt());
    }
    ratios
}

/// The median is 0.67 for normal errors along one axis, and 0.89 for errors alike along three. A
/// factor of two is allowed: a scan has one draw of noise for all its views.
#[test]
fn errors_are_as_large_as_their_standard_deviations() {
    for (scene, unit) in [("room", 0.02), ("face_mask", 1.0), ("machined_part", 1.0)] {
        let mut ratios = [Vec::new(), Vec::new(), Vec::new()];
        for (seed, degrees) in [(0, 0.02), (100, 0.1), (200, -0.3), (300, 0.1), (400, -0.02)] {
            let views = simulated_with_seed(scene, seed);
            let wrong = shaken(&views, degrees, unit * degrees);
            let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
            let found = errors_over_sigma(&views, &refinement);
            ratios.iter_mut().zip(found).for_each(|(all, found)| all.extend(found));
        }
        for (mut of, what) in ratios.into_iter().zip(["places", "angles", "surfaces"]) {
            of.sort_by(f64::total_cmp);
            let median = of[of.len() / 2];
            println!("{scene}: errors of {what} over their standard deviations: {median}");
            assert!((0.33..1.8).contains(&median), "{scene}, {what}: {median}");
        }
    }
}

/// The view of a camera between walls without ends: a floor z = 0 and walls y = 0 and y = 2.
fn in_corridor(name: &str, eye: Point3, target: Point3) -> View {
    let size = ImageSize { rows: 240, cols: 320 };
    let camera = Pinhole::new(size, Intrinsics { fx: 300.0, fy: 300.0, cx: 159.5, cy: 119.5 });
    let camera = camera.unwrap();
    let pose = Isometry3::face_towards(&eye, &target, &-Vector3::z());
    let wall = |normal: Vector3, offset: f64| SensorPlane {
        normal: pose.inverse_transform_vector(&normal),
        offset: offset - normal.dot(&eye.coords),
    };
    let walls = [wall(Vector3::z(), 0.0), wall(Vector3::y(), 0.0), wall(-Vector3::y(), -2.0)];
    let depth = |pixel| {
        let mut seen: Vec<f64> =
            walls.iter().filter_map(|wall| camera.plane_value(pixel, wall)).collect();
        seen.sort_by(f64::total_cmp);
        // Patches over the edges between walls would pass for ends of the corridor.
        let is_clear = seen[0] < 6.0 && seen.get(1).is_none_or(|next| *next > 1.15 * seen[0]);
        if is_clear { seen[0] as f32 } else { f32::NAN }
    };
    let image = RangeImage::from_values(size, size.all_pixels().map(depth).collect()).unwrap();
    View::new(name, image, Arc::new(camera), pose, Some(0.001)).unwrap()
}

#[test]
fn a_view_brought_back_in_part_says_how_far_it_may_be_off() {
    let eye = |k: usize| Point3::new(0.3 * k as f64, 0.8 + 0.1 * k as f64, 1.2);
    let target = |k: usize| Point3::new(3.0, 0.6 + 0.2 * k as f64, 0.3);
    let name = |k: usize| format!("view {k}");
    let exact: Vec<View> = (0..4).map(|k| in_corridor(&name(k), eye(k), target(k))).collect();
    let mut wrong = exact.clone();
    let off =
        Isometry3::translation(0.25, 0.0, 0.0) * turned(&exact[1], 1, 5.0).world_from_sensor();
    wrong[1] = exact[1].with_pose(off).unwrap();
    let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
    let pose = &refinement.poses[1];
    assert!(pose.has_moved() && pose.residual_after < pose.residual_before, "{pose:?}");
    let left = pose.world_from_sensor.translation.x - exact[1].world_from_sensor().translation.x;
    // Nothing along the corridor tells its place.
    let sigma = |k: usize| refinement.poses[k].sigma.unwrap().translation;
    assert!(left.abs() > 0.05 && left.abs() < 5.0 * sigma(1), "{left}: {pose:?}");
    assert!(sigma(1) > sigma(2), "{refinement:?}");
}

#[test]
fn two_views_and_chains_are_judged_by_halves_of_their_images() {
    let views = simulated("room", "");
    for pair in [[0, 1], [1, 2], [2, 3]] {
        let exact = pair.map(|k| views[k].clone());
        let wrong = shaken(&exact, 0.3, 0.005);
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
        assert!(refinement.left_out_pairs.unwrap() < -0.5, "{pair:?}: {refinement:?}");
        let poses: Vec<_> = refinement.poses.iter().map(|p| p.world_from_sensor).collect();
        let (before, after) = (apart(&exact, &given(&wrong)), apart(&exact, &poses));
        assert!(after < before, "{pair:?}: {before} to {after}");
        let refinement = refine(&coarse(&exact), &RefineOptions::default()).unwrap();
        assert!(refinement.left_out_pairs.is_some());
        assert!(refinement.poses.iter().all(|p| !p.has_moved()), "{pair:?}: {refinement:?}");
    }
}

/// The view without what lies outside an interval of angles about the middle of all sensors.
fn within(view: &View, middle: &Point3, degrees: std::ops::Range<f64>) -> View {
    let is_inside = |pixel| {
        let point = view.point_in_sensor(pixel)?;
        let from_middle = view.world_from_sensor() * point - middle;
        let angle = from_middle.y.atan2(from_middle.x).to_degrees().rem_euclid(360.0);
        Some(degrees.contains(&angle))
    };
    changed(view, |row, col, value| match is_inside(Pixel::new(row, col)) {
        Some(true) => value,
        _ => f32::NAN,
    })
}

#[test]
fn a_chain_of_views_is_judged_by_halves_of_its_pairs() {
    let views = simulated("room", "");
    let places = views.iter().map(|view| view.world_from_sensor().translation.vector);
    let middle = Point3::from(places.sum::<Vector3>() / views.len() as f64);
    let sectors = [0.0..150.0, 90.0..240.0, 180.0..330.0, 270.0..360.0];
    let exact: Vec<View> =
        views.iter().zip(sectors).map(|(view, sector)| within(view, &middle, sector)).collect();
    for end in [0, 3] {
        let mut wrong = exact.clone();
        let turn = turned(&exact[end], 1, 0.3);
        let moved = Isometry3::translation(0.003, -0.004, 0.005) * turn.world_from_sensor();
        wrong[end] = exact[end].with_pose(moved).unwrap();
        let refinement = refine(&coarse(&wrong), &RefineOptions::default()).unwrap();
        let poses: Vec<_> = refinement.poses.iter().map(|p| p.world_from_sensor).collect();
        let (before, after) = (apart(&exact, &given(&wrong)), apart(&exact, &poses));
        assert!(refinement.left_out_pairs.unwrap() < -0.5, "end {end}: {refinement:?}");
        assert!(after < 0.5 * before, "end {end}: {before} to {after}");
    }
}

#[test]
fn exact_poses_of_two_stations_stay_in_every_draw_of_noise() {
    for seed in [100, 200, 300] {
        let views = simulated_with_seed("room", seed);
        for pair in [[0, 1], [1, 2], [2, 3], [0, 3]] {
            let exact = pair.map(|k| views[k].clone());
            let refinement = refine(&coarse(&exact), &RefineOptions::default()).unwrap();
            let moved = refinement.poses.iter().any(|pose| pose.has_moved());
            assert!(!moved, "{pair:?} with seed {seed}: {refinement:?}");
        }
    }
}

#[test]
fn refined_poses_are_not_refined_again() {
    for (scene, length) in [("room", 0.005), ("machined_part", 0.2)] {
        let wrong = shaken(&simulated(scene, ""), 0.2, length);
        let copies: Vec<CoarseView> = coarse(&wrong);
        let first = refine(&copies, &RefineOptions::default()).unwrap();
        assert!(first.poses.iter().all(|pose| pose.outcome == PoseOutcome::Refined));
        let poses = first.poses.iter().map(|pose| pose.world_from_sensor);
        let copies: Vec<_> =
            copies.into_iter().zip(poses).map(|(copy, pose)| copy.with_pose(pose)).collect();
        let second = refine(&copies, &RefineOptions::default()).unwrap();
        for (copy, pose) in copies.iter().zip(&second.poses) {
            assert_eq!(pose.outcome, PoseOutcome::Kept, "{scene}: {pose:?}");
            assert_eq!(pose.world_from_sensor, *copy.world_from_sensor());
        }
    }
}

/// Median distance of all patches from the other views' surfaces, in metres.
fn residual(views: &[View], poses: &[Isometry3]) -> f64 {
    let copies = coarse(views);
    let mut distances = Vec::new();
    for (a, (from, pose)) in copies.iter().zip(poses).enumerate() {
        let others = copies.iter().zip(poses).enumerate().filter(|(b, _)| *b != a);
        for (_, (to, other)) in others {
            let motion = other.inverse() * pose;
            let met = from.patches().filter_map(|(_, patch)| {
                let meeting = to.meeting(&(motion * patch.point()))?;
                let alike = meeting.normal.dot(&(motion * patch.normal())) > 0.9;
                Some(meeting.distance.abs()).filter(|d| alike && *d < 1.5e-3)
            });
            distances.extend(met);
        }
    }
    let middle = distances.len() / 2;
    *distances.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The published poses come from an estimate as well, so two starts and the residuals judge.
#[test]
fn perturbed_poses_of_a_turntable_scan_come_back() {
    let Some(views) = real("stanford_bunny") else { return };
    let free = PosePrior { rotation: 3.0_f64.to_radians(), translation: 0.01 };
    let refined = |views: &[View]| -> Vec<Isometry3> {
        let refinement = refine(
            &coarse(views),
            &RefineOptions { prior: Some(free), ..RefineOptions::default() },
        )
        .unwrap();
        refinement.poses.iter().map(|p| p.world_from_sensor).collect()
    };
    let (one, other) = (shaken(&views, 0.3, 0.0005), shaken(&views, -0.3, 0.0005));
    let (first, second) = (refined(&one), refined(&other));
    let with_first: Vec<View> =
        views.iter().zip(&first).map(|(view, pose)| view.with_pose(*pose).unwrap()).collect();
    let (before, after) = (apart(&views, &given(&one)), apart(&views, &first));
    let starts = apart(&with_first, &second);
    let residuals = [residual(&views, &given(&views)), residual(&views, &first)];
    println!("{before} m from the published poses, {after} m after refinement");
    println!("{starts} m between two starts; residuals {residuals:?} m, published and refined");
    assert!(after < 0.2 * before, "{before} to {after}");
    assert!(starts < 5e-5, "{starts}");
    assert!(residuals[1] < residuals[0], "{residuals:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// The same poses, bit by bit.
    #[test]
    fn the_order_of_views_does_not_matter(
        order in Just(vec![0, 1, 2, 3]).prop_shuffle(), degrees in 0.0..1.0,
    ) {
        let views = shaken(&simulated("room", ""), degrees, 0.01);
        let shuffled: Vec<View> = order.iter().map(|k| views[*k].clone()).collect();
        let (poses, again) = (refined(&views), refined(&shuffled));
        for (k, pose) in order.iter().zip(&again) {
            prop_assert_eq!(pose, &poses[*k]);
        }
    }
}
