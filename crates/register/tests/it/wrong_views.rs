//! One wrong view among right ones moves no other.

use super::common::{changed, coarse, simulated};
use transect_device::Isometry3;
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
