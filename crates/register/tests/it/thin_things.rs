//! Thin things: plates and rods that are a few pixels wide, without noise.

use std::f64::consts::TAU;
use std::sync::Arc;
use transect_device::{ImageSize, Isometry3, Point3, Vector3, View};
use transect_register::{CoarseView, Finding, PoseOutcome, RefineOptions, judge, refine};
use transect_scene::{Noise, Scene, Shape, Solid};
use transect_sensors::{Intrinsics, Pinhole};

/// Upright plates in a row, and rods in another row, from thick to thin.
fn plates_and_rods() -> Scene {
    let solids = (0..5).flat_map(|k| {
        let (thickness, y) = (0.08 * 0.5_f64.powi(k), -1.2 + 0.6 * f64::from(k));
        let plate = Shape::cuboid(Vector3::new(thickness, 0.4, 1.6)).unwrap();
        let rod = Shape::cylinder(thickness, 1.6).unwrap();
        let place = |x: f64, turn: f64| {
            Isometry3::new(Vector3::new(x, y, 0.8), Vector3::new(0.0, 0.0, turn))
        };
        [Solid::new(plate, place(0.0, 0.35)).unwrap(), Solid::new(rod, place(0.9, 0.0)).unwrap()]
    });
    Scene::new(solids.collect())
}

/// Twelve cameras around the scene, at three heights.
fn views(start: f64, nearness: f64) -> Vec<View> {
    let (scene, size) = (plates_and_rods(), ImageSize { rows: 240, cols: 320 });
    let middle = Point3::new(0.45, 0.0, 0.8);
    let camera = || {
        let k = Intrinsics { fx: 343.0, fy: 343.0, cx: 159.5, cy: 119.5 };
        Arc::new(Pinhole::new(size, k).unwrap())
    };
    let view = |k: u32| {
        let angle = start + TAU * f64::from(k) / 12.0;
        let [distance, height] = [[4.4, 0.45], [4.3, 1.35], [4.0, 2.15]][k as usize % 3];
        let away = Vector3::new(distance * angle.cos(), distance * angle.sin(), height);
        let eye = middle + away * nearness;
        let pose = Isometry3::look_at_lh(&eye, &middle, &-Vector3::z()).inverse();
        scene.view(format!("{k}"), camera(), pose, &Noise::NONE, u64::from(k)).unwrap()
    };
    (0..12).map(view).collect()
}

#[test]
fn sound_views_around_thin_things_are_not_blamed() {
    for start in 0..10 {
        for nearness in [0.9, 1.0, 1.1] {
            let views = views(0.05 * f64::from(start), nearness);
            for copy in [CoarseView::quick, CoarseView::new] {
                let copies: Vec<CoarseView> = views.iter().map(copy).collect();
                let found = judge(&copies).findings;
                assert!(found.is_empty(), "{start} {nearness}: {found:?}");
            }
        }
    }
}

#[test]
fn sound_views_around_thin_things_are_not_misplaced() {
    for start in [1, 4, 7] {
        for nearness in [0.9, 1.0, 1.1] {
            let views = views(0.05 * f64::from(start), nearness);
            let copies: Vec<CoarseView> = views.iter().map(CoarseView::new).collect();
            let poses = refine(&copies, &RefineOptions::default()).unwrap().poses;
            let misplaced = poses.iter().filter(|pose| pose.outcome == PoseOutcome::Misplaced);
            let misplaced: Vec<&str> = misplaced.map(|pose| &*pose.view).collect();
            assert!(misplaced.is_empty(), "{start} {nearness}: {misplaced:?}");
        }
    }
}

#[test]
fn a_turned_view_of_thin_things_is_named_alone() {
    let views = views(0.1, 1.0);
    let copies = |copy: fn(&View) -> CoarseView| views.iter().map(copy).collect::<Vec<_>>();
    let (quick, full) = (copies(CoarseView::quick), copies(CoarseView::new));
    for wrong in 0..12 {
        for (degrees, copies) in [(1.0_f64, &full), (3.0, &quick), (10.0, &quick)] {
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let mut copies = copies.clone();
                let turn = Isometry3::rotation(axis * degrees.to_radians());
                let pose = copies[wrong].world_from_sensor() * turn;
                copies[wrong] = copies[wrong].clone().with_pose(pose);
                let (found, name) = (judge(&copies).findings, wrong.to_string());
                let alone = match &found[..] {
                    [Finding::Misplaced(misplaced)] => misplaced.view == name,
                    // Its surfaces lie beside all others.
                    [Finding::Apart { view }] => *view == name,
                    _ => false,
                };
                assert!(alone, "{wrong} by {degrees} about {axis}: {found:?}");
            }
        }
    }
}
