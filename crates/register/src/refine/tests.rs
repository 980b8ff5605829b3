//! How far patches are looked for.

use super::*;
use transect_device::View;
use transect_scene::{BUNDLED_SCENES, Description};

/// Frames of a depth camera that errs by 2 %.
fn depth_camera() -> Vec<View> {
    let (_, text) = BUNDLED_SCENES.iter().find(|(name, _)| *name == "kitchen").unwrap();
    let mut description = Description::parse(text).unwrap();
    description.noise.depth_camera.distortion = 0.02;
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
