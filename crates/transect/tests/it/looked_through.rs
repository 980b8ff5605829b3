//! Queries of a store know what its views looked through.

use transect::{Grower, Setup, Unwatched, correct_by_free_space};
use transect_device::View;
use transect_geometry::{PlaneFamily, Point2, Point3};
use transect_model::store::{SpaceQuery, Store};
use transect_model::{Location, Section, SectionIndex};
use transect_scene::{Description, Station};

const POST: &str = include_str!("../../../../fixtures/post.scene.toml");

/// A store of some stations of a scene, at the poses that they state.
fn store(
    description: &Description,
    stations: &[Station],
    planes: &PlaneFamily,
    folder: &tempfile::TempDir,
) -> Store {
    let (scene, noise) = (description.scene(), &description.noise);
    let view = |(k, station): (usize, &Station)| {
        let (name, pose) = (station.name.clone(), station.world_from_sensor);
        let view = scene.view(name, station.frame().unwrap(), pose, noise, k as u64).unwrap();
        view.with_pose(noise.stated_pose(&pose, k as u64)).unwrap()
    };
    let views: Vec<View> = stations.iter().enumerate().map(view).collect();
    let setup = Setup::new(description.unit, planes.clone());
    let store = Store::create(folder.path().join("s.transect"), &setup.store_header()).unwrap();
    Grower::new(&store, &setup).unwrap().add_views(&views, &Unwatched).unwrap();
    store
}

/// The locations by the nearest curves alone, and with what the views looked through.
fn locations(store: &Store, points: &[Point3]) -> [Vec<Location>; 2] {
    let mut query = SpaceQuery::new(store.read().unwrap(), SpaceQuery::DEFAULT_CAPACITY);
    let mut answers: Vec<_> = points.iter().map(|p| query.locate(p).unwrap()).collect();
    let by_curves: Vec<Location> = answers.iter().map(|answer| answer.location).collect();
    let corrected = correct_by_free_space(&store.read().unwrap(), points, &mut answers).unwrap();
    let corrected_too: Vec<Location> = answers.iter().map(|answer| answer.location).collect();
    let changed = by_curves.iter().zip(&corrected_too).filter(|(a, b)| a != b).count();
    assert_eq!(corrected, changed);
    [by_curves, corrected_too]
}

#[test]
fn a_point_behind_a_post_is_not_inside_if_other_views_looked_past_the_post() {
    let description = Description::parse(POST).unwrap();
    let points = [Point3::new(0.0, 0.9, 0.113), Point3::new(0.0, -0.1, 0.113)];
    for (views, expected) in [(1, Location::Inside), (2, Location::Unknown), (3, Location::Outside)]
    {
        let (stations, folder) = (&description.stations[..views], tempfile::tempdir().unwrap());
        let store = store(&description, stations, &description.planes, &folder);
        let [by_curves, corrected] = locations(&store, &points);
        assert_eq!(by_curves, [Location::Inside; 2], "{views}");
        assert_eq!(corrected, [expected, Location::Inside], "{views}");
    }
}

/// A kitchen whose poses err by 4 mm and 0.2 degrees. Points on every fifth plane are compared with
/// the exact sections, those within 10 cm of the exact curves apart.
#[test]
fn no_point_inside_is_lost_and_most_false_ones_far_from_curves_are_found() {
    let description = Description::parse(transect_scene::BUNDLED_KITCHEN).unwrap();
    let own = &description.planes;
    let interval = 5.0 * own.interval();
    let planes = PlaneFamily::new(own.guide().clone(), own.offset(), interval).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let store = store(&description, &description.stations, &planes, &folder);
    let (mut points, mut truth) = (Vec::new(), Vec::new());
    for (plane, curves) in description.scene().sections(&planes, 1e-4).unwrap() {
        let section = SectionIndex::new(Section::new(curves).unwrap());
        let around = section.section().envelope();
        let step = around.size() / 80.0;
        for k in 0..6400 {
            let (i, j) = (f64::from(k % 80) + 0.5, f64::from(k / 80) + 0.5);
            let p = Point2::new(around.min.x + i * step.x, around.min.y + j * step.y);
            points.push(planes.frame(plane).world_from_plane(&p));
            truth.push(section.locate(&p));
        }
    }
    let [by_curves, corrected] = locations(&store, &points);
    let is_far = |k: &usize| truth[*k].distance_to_nearest_curve > Some(0.1);
    let of = |found: &[Location], location: Location| {
        let inside = (0..found.len()).filter(|k| found[*k] == Location::Inside);
        inside.filter(|k| truth[*k].location == location).collect::<Vec<usize>>()
    };
    assert_eq!(of(&by_curves, Location::Inside), of(&corrected, Location::Inside));
    let [before, after] = [by_curves, corrected]
        .map(|l| of(&l, Location::Outside).iter().filter(|k| is_far(k)).count());
    assert!(before > 20 && 5 * after < before, "{before} {after}");
}
