//! Gaps and next views on a simulated room: what is promised is worth following.
//!
//! The room of `fixtures/room.scene.toml` is scanned from one of its corners. The view that is
//! proposed next must close more than views from most other places in the same free space.

use std::sync::Arc;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::{ImageSize, Isometry3, Pixel, View};
use transect_geometry::{LengthUnit, PlaneFamily, Point3, StraightGuide, Vector3};
use transect_model::Model;
use transect_model::gaps::{KnownSpace, NextViewOptions, UnseenPatch, next_views};
use transect_scene::{Description, Noise, Scene};
use transect_sensors::{AngularScan, ImagingRadar};

const INTERVAL: f64 = 0.2;

/// A scan of the whole sphere from a place in the room.
fn scan(scene: &Scene, at: Point3) -> View {
    let size = ImageSize { rows: 150, cols: 300 };
    let degrees =
        |first: f64, step: f64| AngularScan::from_radians(first.to_radians(), step.to_radians());
    let frame = ImagingRadar::new(size, degrees(180.0, -1.2), degrees(74.5, -1.0)).unwrap();
    let pose = Isometry3::translation(at.x, at.y, at.z);
    scene.view(format!("{at}"), Arc::new(frame), pose, &Noise::default(), 0).unwrap()
}

fn model(views: &[View]) -> Model {
    let guide = StraightGuide::along(Vector3::z()).unwrap();
    let planes = PlaneFamily::new(guide, 0.0337, INTERVAL).unwrap();
    reconstruct(views, &Setup::new(LengthUnit::Metre, planes), &Unwatched).unwrap().model
}

fn unseen(model: &Model) -> Vec<UnseenPatch> {
    let patches = |(plane, section): (_, &transect_model::Section)| -> Vec<UnseenPatch> {
        let frame = model.planes().frame(plane);
        section.gaps().iter().flat_map(|g| g.patches(&frame, 0.1, INTERVAL)).collect()
    };
    model.sections().flat_map(patches).collect()
}

fn rays(view: &View) -> Vec<(Point3, Point3)> {
    let size = view.image().size();
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |col| Pixel::new(row, col)));
    let sensor = Point3::from(view.world_from_sensor().translation.vector);
    let seen = |pixel| Some(view.world_from_sensor() * view.point_in_sensor(pixel)?);
    pixels.filter_map(|pixel| Some((sensor, seen(pixel)?))).collect()
}

/// Length of curves of the model with one more view.
fn length_with(scene: &Scene, first: &View, place: Point3) -> f64 {
    let both = model(&[first.clone(), scan(scene, place)]);
    both.sections().map(|(_, section)| section.length()).sum()
}

#[test]
fn the_proposed_view_closes_more_than_most_places_would() {
    let scene =
        Description::parse(include_str!("../../../../fixtures/room.scene.toml")).unwrap().scene();
    let first = scan(&scene, Point3::new(0.4, 0.4, 1.4));
    let patches = unseen(&model(std::slice::from_ref(&first)));
    let space = KnownSpace::from_rays(&rays(&first)).unwrap();
    let options = NextViewOptions::new(3, 1.3, 8.0);
    let views = next_views(&patches, &space, &options);
    assert!(!views.is_empty());
    assert!(views.windows(2).all(|v| v[0].area >= v[1].area), "{views:?}");
    let best = length_with(&scene, &first, views[0].position);
    let places = space.free_places(24);
    let lengths: Vec<f64> = places.iter().map(|&p| length_with(&scene, &first, p)).collect();
    let beaten = lengths.iter().filter(|&&l| l < best).count();
    println!("{best:.1} m against {lengths:.1?}, {views:?}");
    assert!(beaten * 4 >= places.len() * 3, "{best} beats {beaten} of {}", places.len());
}
