//! Files of earlier versions: a store of layout 7 and a model file of version 6, both written by
//! transect 0.1.0 for the two views of `version_7/dot.scene.toml`.

use transect::{Grower, Setup, Unwatched};
use transect_device::{Isometry3, View};
use transect_exchange::write_contours;
use transect_geometry::Node;
use transect_model::Model;
use transect_model::store::Store;
use transect_scene::Description;

const STORE: &[u8] = include_bytes!("version_7/store.transect");
const MODEL: &[u8] = include_bytes!("version_7/model.transect");
/// The curves of both files, written by the same program.
const CONTOURS: &str = include_str!("version_7/contours.json");

fn description() -> Description {
    Description::parse(include_str!("version_7/dot.scene.toml")).unwrap()
}

/// The views that a store holds, simulated again.
fn views(store: &Store) -> Vec<View> {
    let description = description();
    let (scene, stored) = (description.scene(), store.views().unwrap());
    let stations = description.stations.iter().enumerate();
    let view = stations.map(|(k, s)| {
        let name = format!("range_{k:03}.npy");
        let pose = stored[k].entry.world_from_sensor;
        // The poses went through a file, which rounded them.
        assert!((pose.inverse() * s.world_from_sensor).translation.vector.norm() < 1e-12);
        let view =
            scene.view(name, s.frame().unwrap(), s.world_from_sensor, &description.noise, k as u64);
        view.unwrap().with_pose(pose).unwrap()
    });
    view.collect()
}

fn contours(model: &Model) -> String {
    let mut bytes = Vec::new();
    write_contours(model, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn with_store(check: impl FnOnce(&mut Store)) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dot.transect");
    std::fs::write(&path, STORE).unwrap();
    check(&mut Store::open(path).unwrap());
}

#[test]
fn a_model_file_of_version_6_is_read_and_written_again_as_it_was() {
    let model = Model::from_reader(MODEL).unwrap();
    assert_eq!(contours(&model), CONTOURS);
    let mut again = Vec::new();
    model.to_writer(&mut again).unwrap();
    assert!(again == MODEL);
    let nodes = || model.sections().flat_map(|(_, s)| s.curves()).flat_map(|c| c.nodes());
    assert!(nodes().any(|node| node.views.is_none() && node.normal.is_none()));
    assert!(nodes().any(|node| node.views.is_some() && node.normal.is_some()));
    assert!(nodes().all(|node: &Node| node.tan_incidence.is_none()));
}

#[test]
fn a_store_of_layout_7_is_verified_and_read() {
    with_store(|store| {
        assert_eq!(store.verify().unwrap().pending, 0);
        let snapshot = store.read().unwrap();
        assert_eq!(contours(&snapshot.model().unwrap()), CONTOURS);
        let partials = snapshot.partials(transect_geometry::PlaneIndex(2)).unwrap();
        let incidences = partials.iter().flat_map(|(_, curves)| curves).flat_map(|c| c.nodes());
        assert!(incidences.into_iter().all(|node| node.tan_incidence.is_some_and(|t| t > 0.0)));
        let expected = Setup::new(description().unit, description().planes);
        assert_eq!(Setup::of_store(snapshot.header()).unwrap(), expected);
    });
}

#[test]
fn a_store_of_layout_7_grows() {
    with_store(|store| {
        let setup = Setup::new(description().unit, description().planes);
        let (mut views, by) = (views(store), Isometry3::translation(0.0, 0.01, 0.0));
        let third = &views[1];
        let pose = by * third.world_from_sensor();
        let (image, sensor) = (third.image().clone(), description().stations[1].frame().unwrap());
        views.push(View::new("third", image, sensor, pose, third.sigma()).unwrap());
        let grower = Grower::new(store, &setup).unwrap();
        let growth = grower.add_views(&views, &Unwatched).unwrap();
        assert_eq!(growth.present, ["range_000.npy", "range_001.npy"]);
        assert_eq!(growth.report.views.len(), 1);
        grower.remove_view(&"range_000.npy".into()).unwrap();
        store.verify().unwrap();
        assert_eq!(store.views().unwrap().len(), 2);
    });
}
