//! Priors: how far poses may be wrong, as the user or the views state it.

use super::common::{coarse, described, simulated};
use super::narrow_things::street;
use super::refining::shaken;
use transect_device::{Isometry3, Vector3, View};
use transect_register::{PoseOutcome, PosePrior, RefineOptions, RefinedPose, refine};

#[test]
fn a_stated_prior_holds_the_poses() {
    let views = shaken(&simulated("room", ""), 0.3, 0.005);
    let options = RefineOptions {
        prior: Some(PosePrior { rotation: 1e-7, translation: 1e-7 }),
        ..RefineOptions::default()
    };
    let refinement = refine(&coarse(&views), &options).unwrap();
    assert!(refinement.poses.iter().all(|p| p.translation < 1e-4), "{refinement:?}");
    // And hides neither which views meet, nor how far apart they are.
    assert!(refinement.poses.iter().all(|p| p.outcome == PoseOutcome::Kept), "{refinement:?}");
    let residual = |p: &RefinedPose| p.residual_before.unwrap();
    assert!(refinement.poses.iter().all(|p| residual(p) > 0.005), "{refinement:?}");
}

/// Poses that err by far more than is stated stay, and no standard deviation is told of them.
#[test]
fn a_stated_prior_that_the_images_contradict_is_told() {
    let exact = simulated("room", "");
    let told = |views: &[View], rotation: f64, translation: f64| {
        let prior = Some(PosePrior { rotation: rotation.to_radians(), translation });
        let options = RefineOptions { prior, ..RefineOptions::default() };
        let refinement = refine(&coarse(views), &options).unwrap();
        let known = refinement.poses.iter().all(|pose| pose.surface_sigma.is_some());
        assert_eq!(refinement.prior_by_images.is_none(), known, "{refinement:?}");
        refinement.prior_by_images
    };
    let by_images = told(&shaken(&exact, 0.3, 0.005), 1e-4, 1e-6).unwrap();
    assert!(by_images.rotation.to_degrees() > 0.01, "{by_images:?}");
    assert_eq!(told(&shaken(&exact, 0.3, 0.005), 0.3, 0.005), None);
    assert_eq!(told(&exact, 1e-4, 1e-6), None);
}

/// What the scan states of each view is judged as what is stated of all.
#[test]
fn own_priors_that_the_images_contradict_are_told() {
    let own = Some(PosePrior { rotation: 1e-6, translation: 1e-6 });
    let copies = coarse(&shaken(&simulated("room", ""), 0.3, 0.005)).into_iter();
    let copies: Vec<_> = copies.map(|copy| copy.with_prior(own).unwrap()).collect();
    let refinement = refine(&copies, &RefineOptions::default()).unwrap();
    assert!(refinement.prior_by_images.is_some(), "{refinement:?}");
}

#[test]
fn views_that_do_not_meet_keep_what_is_stated_of_their_poses() {
    let views = simulated("room", "");
    let away = views[1].world_from_sensor().translation.vector + Vector3::new(100.0, 0.0, 0.0);
    let turn = views[1].world_from_sensor().rotation;
    let away = views[1].with_pose(Isometry3::from_parts(away.into(), turn)).unwrap();
    let prior = PosePrior { rotation: 1e-3, translation: 2e-3 };
    let options = RefineOptions { prior: Some(prior), ..RefineOptions::default() };
    let refinement = refine(&coarse(&[views[0].clone(), away]), &options).unwrap();
    assert_eq!(refinement.prior, prior);
    for pose in &refinement.poses {
        assert_eq!(pose.outcome, PoseOutcome::Alone);
        let sigma = pose.sigma.unwrap();
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
        assert!(near(sigma.rotation, 1e-3) && near(sigma.translation, 2e-3), "{sigma:?}");
    }
}

#[test]
fn views_whose_own_priors_are_small_hold_the_others() {
    let exact = simulated("room", "");
    let mut views = shaken(&exact, 0.3, 0.005);
    views[2] = exact[2].clone();
    let own = Some(PosePrior { rotation: 1e-7, translation: 1e-7 });
    let priors = [None, None, own, None];
    let copies = coarse(&views).into_iter().zip(priors);
    let copies: Vec<_> = copies.map(|(copy, prior)| copy.with_prior(prior).unwrap()).collect();
    let refinement = refine(&copies, &RefineOptions::default()).unwrap();
    assert!(refinement.poses[2].translation < 1e-4, "{:?}", refinement.poses[2]);
    // No common motion is left: the view that was right tells where the others are.
    for (view, pose) in exact.iter().zip(&refinement.poses) {
        let off = view.world_from_sensor().inverse() * pose.world_from_sensor;
        let off = (off.translation.vector.norm(), off.rotation.angle());
        assert!(off.0 < 2e-3 && off.1 < 1e-4, "{}: {off:?}", view.name());
    }
}

#[test]
fn a_prior_that_is_no_standard_deviation_is_an_error() {
    let copies = coarse(&simulated("room", "")[..1]);
    for (wrong, found) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (-0.1, "-0.1"), (0.0, "0")] {
        for (prior, found) in [
            (PosePrior { rotation: 0.01, translation: wrong }, format!("0.01 rad and of {found}")),
            (PosePrior { rotation: wrong, translation: 0.02 }, format!("{found} rad and of 0.02")),
        ] {
            let of_view = copies[0].clone().with_prior(Some(prior)).unwrap_err().to_string();
            let name = format!("view {}: ", copies[0].name());
            let expected = "expected finite numbers of 1e-12 or more";
            assert!(of_view.starts_with(&name) && of_view.contains(expected), "{of_view}");
            assert!(of_view.contains(&found), "{of_view}");
            let options = RefineOptions { prior: Some(prior), ..RefineOptions::default() };
            let of_all = refine(&copies, &options).unwrap_err().to_string();
            assert!(of_all.contains(&found) && of_all.contains(expected), "{of_all}");
        }
    }
}

/// Held by what is stated, poses stay away from the best fit, and patches beside each other err
/// alike. They seemed to say too little to move anything.
#[test]
fn what_is_stated_of_poses_does_not_hold_them_where_images_tell_better() {
    let views = described(&street([0.2, 1.2, 0.1]));
    let wrong = shaken(&views, 0.06, 0.03);
    let prior = PosePrior { rotation: 0.03_f64.to_radians(), translation: 0.015 };
    let options = RefineOptions { prior: Some(prior), ..Default::default() };
    let refinement = refine(&coarse(&wrong), &options).unwrap();
    for pose in &refinement.poses {
        assert!(pose.residual_after.unwrap() < 0.001, "{refinement:?}");
    }
}
