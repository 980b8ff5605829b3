//! One wrong view among right ones moves no other.

use super::common::{changed, coarse, simulated};
use transect_device::{Isometry3, Point3, Vector3};
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
