//! One wrong view among right ones moves no other.

use super::common::{changed, coarse, simulated, turned};
use super::refining::shaken;
use transect_device::{Isometry3, Point3, Vector3, View};
use transect_register::{PoseOutcome, RefineOptions, refine};

/// Of a part that is seen from all around, a view with larger lengths could be moved away instead.
#[test]
fn a_view_with_a_wrong_scale_keeps_its_pose_and_moves_no_other() {
    let mut views = simulated("machined_part", "");
    views[2] = changed(&views[2], |_, _, range| range * 1.01);
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    for (k, pose) in refinement.poses.iter().enumerate() {
        let expected = if k == 2 { PoseOutcome::Misplaced } else { PoseOutcome::Kept };
        assert_eq!(pose.outcome, expected, "{k}: {refinement:?}");
    }
}

/// The part is round, so hardly anything but its given pose holds a view about its axis.
#[test]
fn one_wrong_view_does_not_loosen_the_others() {
    let mut views = simulated("machined_part", "");
    let away = views[2].world_from_sensor() * Isometry3::translation(0.0, 0.0, 3.0);
    views[2] = views[2].with_pose(away).unwrap();
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    for (k, pose) in refinement.poses.iter().enumerate() {
        let degrees = pose.rotation.to_degrees();
        let [most_degrees, most] = if k == 2 { [0.5, 3.2] } else { [0.02, 0.02] };
        let near = degrees < most_degrees && pose.translation < most;
        assert!(near, "{k}: {degrees} degrees and {} mm", pose.translation);
    }
    assert!((refinement.poses[2].translation - 3.0).abs() < 0.2);
}

/// Views that meet nothing do not move. They are no measure of how far others move.
#[test]
fn views_that_meet_no_other_do_not_make_others_seem_far_off() {
    let exact = simulated("room", "");
    let mut views = shaken(&exact, 0.3, 0.005);
    for k in 1..7 {
        let mut pose = *exact[0].world_from_sensor();
        pose.translation.vector.x += 100.0 * f64::from(k);
        views.push(exact[0].with_pose(pose).unwrap());
    }
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    let outcomes: Vec<_> = refinement.poses.iter().map(|pose| pose.outcome).collect();
    assert_eq!(outcomes[..4], [PoseOutcome::Refined; 4]);
    assert_eq!(outcomes[4..], [PoseOutcome::Alone; 6]);
}

/// In a survey in world coordinates, a station without a pose lies thousands of kilometres away.
#[test]
fn a_view_without_a_pose_leaves_the_others_their_standard_deviations() {
    let world = Isometry3::translation(4.5e5, 5.2e6, 300.0);
    let mut views: Vec<View> = simulated("room", "")
        .iter()
        .map(|view| view.with_pose(world * view.world_from_sensor()).unwrap())
        .collect();
    views[1] = views[1].with_pose(Isometry3::identity()).unwrap();
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    for (k, pose) in refinement.poses.iter().enumerate().filter(|(k, _)| *k != 1) {
        let sigma = pose.surface_sigma.unwrap();
        assert!(sigma < 1e-3, "{k}: {sigma} m");
    }
    assert_eq!(refinement.poses[1].outcome, PoseOutcome::Alone);
}

/// The bore's floor and the flange agree wherever such a view slides along them.
#[test]
fn a_view_into_a_bore_comes_back_by_the_few_patches_of_its_wall() {
    let mut views = simulated("machined_part", "");
    let truth = *views[9].world_from_sensor();
    assert_eq!(views[9].name(), "bore from above");
    let turned = truth * Isometry3::rotation(Vector3::x() * 3_f64.to_radians());
    views[9] = views[9].with_pose(turned).unwrap();
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    let back = refinement.poses[9].world_from_sensor * truth.inverse();
    // About its axis the part is round, so its middle tells the view's place.
    let middle = Point3::new(0.0, 0.0, 15.0);
    let off = (back * middle - middle).norm();
    assert!(off < 0.03, "{off} mm");
}

/// Rays of such a view meet other sides of the tunnel.
#[test]
fn a_view_turned_by_30_degrees_comes_back() {
    let exact = simulated("tunnel", "");
    for view in [0, 2] {
        let mut views = exact.clone();
        views[view] = turned(&exact[view], 1, 30.0);
        let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
        for (k, pose) in refinement.poses.iter().enumerate() {
            let off = pose.world_from_sensor * exact[k].world_from_sensor().inverse();
            let degrees = off.rotation.angle().to_degrees();
            assert!(degrees < 0.03, "{view} turned: {k} is {degrees} degrees off");
        }
        assert_eq!(refinement.poses[view].outcome, PoseOutcome::BroughtBack);
    }
}

/// More of the tunnel agrees farther along it, where it sees more of what the others saw.
#[test]
fn a_view_that_comes_back_does_not_slide_along_a_tunnel() {
    let exact = simulated("tunnel", "");
    let mut views = exact.clone();
    views[1] = turned(&exact[1], 1, 10.0);
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    let place = |pose: &Isometry3| pose.translation.vector;
    for (k, (pose, exact)) in refinement.poses.iter().zip(&exact).enumerate() {
        let off = (place(&pose.world_from_sensor) - place(exact.world_from_sensor())).norm();
        assert!(off < 0.02, "{k} is {off} m off");
    }
    assert_eq!(refinement.poses[1].outcome, PoseOutcome::BroughtBack);
}

/// All other views err, too, and tell where it belongs once they are refined without it.
#[test]
fn a_view_far_off_comes_back_among_views_that_err() {
    let exact = simulated("face_mask", "");
    let turned_far = turned(&exact[1], 1, 10.0);
    let aside = exact[1].world_from_sensor() * Isometry3::translation(40.0, 30.0, 0.0);
    for wrong in [turned_far, exact[1].with_pose(aside).unwrap()] {
        let err = |(k, view): (usize, &View)| {
            if k == 1 { wrong.clone() } else { turned(view, k % 3, 0.1) }
        };
        let views: Vec<View> = exact.iter().enumerate().map(err).collect();
        let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
        assert_eq!(refinement.poses[1].outcome, PoseOutcome::BroughtBack, "{refinement:?}");
        let pose = |k: usize| refinement.poses[k].world_from_sensor;
        let truth = |k: usize| exact[k].world_from_sensor();
        for k in [0, 2, 3] {
            let between = pose(1).inverse() * pose(k);
            let wanted = truth(1).inverse() * truth(k);
            let degrees = between.rotation.angle_to(&wanted.rotation).to_degrees();
            assert!(degrees < 0.05, "{k} and 1 are {degrees} degrees off each other");
        }
    }
}

/// Its lengths are wrong, unevenly, so no pose agrees.
#[test]
fn a_view_that_nothing_brings_back_is_named_and_stays() {
    let mut views = simulated("room", "");
    let wrong = views[1].world_from_sensor() * Isometry3::translation(0.0, 0.0, -4.0);
    views[1] =
        changed(&views[1], |row, col, range| range * (1.0 + 0.002 * ((row + col) % 50) as f32));
    views[1] = views[1].with_pose(wrong).unwrap();
    let refinement = refine(&coarse(&views), &RefineOptions::default()).unwrap();
    assert_eq!(refinement.poses[1].world_from_sensor, wrong);
    assert!(!refinement.poses[1].has_moved());
    for k in [0, 2, 3] {
        assert!(refinement.poses[k].rotation.to_degrees() < 0.01, "{k}: {refinement:?}");
    }
}
