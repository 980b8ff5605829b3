//! Refinement on simulated scans: which planes are asked for, and that their curves are those of
//! all planes.

use crate::objects::{noisy_views, setup};
use std::collections::BTreeMap;
use transect::{
    GrowError, Grower, Reconstruction, Refinement, RefinementReport, Setup, Unwatched, reconstruct,
};
use transect_device::View;
use transect_geometry::{Curve, CurvedGuide, PlaneFamily, PlaneIndex, Point3};
use transect_model::Model;
use transect_model::store::Store;
use transect_scene::{Description, Station};

fn refined_setup() -> Setup {
    let mut setup = setup();
    setup.refinement = Some(Refinement::new(0.03, 2).unwrap());
    setup
}

fn curves(model: &Model) -> BTreeMap<PlaneIndex, Vec<Curve>> {
    model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect()
}

fn report(result: &Reconstruction) -> &RefinementReport {
    result.report.refinement.as_ref().unwrap()
}

#[test]
fn curves_are_those_of_all_planes_on_the_planes_that_were_asked_for() {
    let (views, setup) = (noisy_views(), refined_setup());
    let refined = reconstruct(&views, &setup, &Unwatched).unwrap();
    let mut every = setup.clone();
    every.planes = setup.refinement.unwrap().family(&setup.planes).unwrap();
    every.refinement = None;
    let every = reconstruct(&views, &every, &Unwatched).unwrap();
    let selected = refined.model.selected().unwrap();
    let (mut of_every, of_refined) = (curves(&every.model), curves(&refined.model));
    let all = of_every.len();
    of_every.retain(|k, _| selected.contains(k));
    assert!(of_every == of_refined, "other curves on the same planes");
    let report = report(&refined);
    assert_eq!(report.planes, selected.len());
    assert!(report.planes_inserted > 4 && of_refined.len() < all, "{} of {all}", of_refined.len());
    // Half-way up both solids nothing changes much.
    let inserted = |low: f64, high: f64| {
        let stations =
            selected.iter().filter(|k| k.0 % 4 != 0).map(|k| refined.model.planes().station(*k));
        stations.filter(|z| (low..high).contains(z)).count()
    };
    assert!(inserted(0.45, 0.55) < inserted(0.75, 0.95), "{selected:?}");
    assert_eq!(refined.model.check(), Ok(()));
    assert!(every.report.refinement.is_none());
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let (views, setup) = (noisy_views(), refined_setup());
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| reconstruct(&views, &setup, &Unwatched).unwrap())
    };
    let (one, three) = (with_threads(1), with_threads(3));
    assert!(one.model == three.model && report(&one) == report(&three));
}

#[test]
fn a_store_says_that_it_has_one_interval() {
    let (folder, setup) = (tempfile::tempdir().unwrap(), refined_setup());
    let store = Store::create(folder.path().join("s.transect"), &setup.store_header()).unwrap();
    assert!(matches!(Grower::new(&store, &setup), Err(GrowError::Refinement)));
}

/// A plane without a neighbour on the guide is a section, too.
#[test]
fn a_guide_with_room_for_one_plane_has_that_plane() {
    let mut setup = refined_setup();
    let interval = setup.planes.interval();
    let length = 1.5 * interval;
    let ends = [0.2, 0.2 + length].map(|z| Point3::new(0.0, 0.0, z)).to_vec();
    let guide = CurvedGuide::polyline(ends, None).unwrap();
    setup.planes = PlaneFamily::new(guide, 0.7 * interval, interval).unwrap();
    let refined = reconstruct(&noisy_views(), &setup, &Unwatched).unwrap();
    assert_eq!(report(&refined).planes, 1);
    assert!(refined.model.sections().any(|(_, section)| section.curves().len() > 0));
}

/// The bend tunnel, seen with a sixth of its rows and columns.
#[test]
fn planes_are_inserted_along_a_bend() {
    let description = Description::parse(transect_scene::BUNDLED_BEND_TUNNEL).unwrap();
    let scene = description.scene();
    let view = |(k, s): (usize, &Station)| {
        let mut coarse = s.clone();
        (coarse.size.rows, coarse.size.cols) = (s.size.rows / 6, s.size.cols / 6);
        let transect_scene::SensorParameters::Spherical { dtheta, dphi, .. } = &mut coarse.sensor
        else {
            panic!("the tunnels are seen by scanners")
        };
        (*dtheta, *dphi) = (6.0 * *dtheta, 6.0 * *dphi);
        let pose = s.world_from_sensor;
        scene
            .view(s.name.clone(), coarse.frame().unwrap(), pose, &description.noise, k as u64)
            .unwrap()
    };
    let views: Vec<View> = description.stations.iter().enumerate().map(view).collect();
    let mut setup = Setup::new(description.unit, description.planes.clone());
    setup.refinement = Some(Refinement::new(0.2, 1).unwrap());
    let refined = reconstruct(&views, &setup, &Unwatched).unwrap();
    let report = report(&refined);
    let (inserted, all) = (report.planes_inserted, report.planes);
    assert!(inserted > 0 && inserted < all / 2, "{inserted} of {all}");
    for gap in &report.gaps {
        let length = description.planes.guide().curved().unwrap().length();
        assert!(gap.from_station >= 0.0 && gap.to_station <= length + 1e-9, "{gap:?}");
    }
}
