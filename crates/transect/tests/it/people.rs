//! People in a room, each there while one scanner measures: the others looked through them.

use transect::{Grower, Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_exchange::write_contours;
use transect_geometry::Point3;
use transect_model::Model;
use transect_model::store::{Store, ViewId};
use transect_scene::{BUNDLED_ROOM, Description, Station};

/// Places of two people, while the first and the third station measure.
const PEOPLE: [(usize, [f64; 2]); 2] = [(0, [1.5, 1.1]), (2, [3.9, 3.0])];

fn room() -> Description {
    let person = |(station, [x, y]): (usize, [f64; 2])| {
        format!(
            "\n[[solid]]\nshape = \"cylinder\"\nradius = 0.22\nheight = 1.7\nat = [{x}, {y}, 0.85]\n\
             stations = [{station}]\n"
        )
    };
    let people: String = PEOPLE.map(person).concat();
    // A quarter of the planes.
    let text = BUNDLED_ROOM.replace("interval = 0.05", "interval = 0.2");
    Description::parse(&(text + &people)).unwrap()
}

fn views(room: &Description) -> Vec<View> {
    let view = |(k, station): (usize, &Station)| {
        let scene = room.visited_scene(k).unwrap_or_else(|| room.scene());
        let (name, frame) = (station.name.clone(), station.frame().unwrap());
        scene.view(name, frame, station.world_from_sensor, &room.noise, k as u64).unwrap()
    };
    room.stations.iter().enumerate().map(view).collect()
}

/// Nodes beside one of the people.
fn of_people(model: &Model) -> usize {
    let beside = |p: &Point3| {
        PEOPLE.iter().any(|(_, [x, y])| (p.x - x).hypot(p.y - y) < 0.3 && p.z > 0.1 && p.z < 1.6)
    };
    let places = model.sections().flat_map(|(plane, section)| {
        let frame = model.planes().frame(plane);
        let nodes = section.curves().flat_map(|curve| curve.nodes().to_vec());
        nodes.map(|node| frame.world_from_plane(&node.position)).collect::<Vec<_>>()
    });
    places.filter(beside).count()
}

fn contours(model: &Model) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_contours(model, &mut bytes).unwrap();
    bytes
}

#[test]
fn people_whom_other_views_looked_through_are_left_out() {
    let room = room();
    let views = views(&room);
    let setup = Setup::new(room.unit, room.planes.clone());
    let mut keeping = setup.clone();
    keeping.free_space = false;
    let [without, with] =
        [&setup, &keeping].map(|setup| reconstruct(&views, setup, &Unwatched).unwrap());
    let kept = of_people(&with.model);
    assert!(kept > 400, "{kept}");
    // Two of the three others must have looked through a place. People hide others from them.
    let left = of_people(&without.model);
    assert!(10 * left < 6 * kept, "{left} of {kept}");
    assert!(without.report.fusion.seen_through >= kept - left);
    assert_eq!(with.report.fusion.seen_through, 0);
    // Nothing else is left out.
    let nodes = |model: &Model| {
        let curves =
            model.sections().flat_map(|(_, section)| section.curves().cloned().collect::<Vec<_>>());
        curves.map(|curve| curve.nodes().len()).sum::<usize>() - of_people(model)
    };
    let [a, b] = [&without, &with].map(|run| nodes(&run.model) as f64);
    assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
}

#[test]
fn a_view_that_comes_twice_looks_through_once() {
    let room = room();
    // Of the person before the first station there is one view, and one that looked through.
    let mut views = views(&room);
    views.truncate(2);
    let setup = Setup::new(room.unit, room.planes.clone());
    let seen_through = |views: &[View]| {
        let run = reconstruct(views, &setup, &Unwatched).unwrap();
        (run.report.fusion.seen_through, contours(&run.model))
    };
    let once = seen_through(&views);
    views.push(views[1].clone());
    assert!(seen_through(&views) == once, "the same nodes are left out");
}

#[test]
fn a_store_leaves_out_what_one_run_leaves_out() {
    let room = room();
    let views = views(&room);
    let setup = Setup::new(room.unit, room.planes.clone());
    let mut sorted = views.clone();
    sorted.sort_by(|a, b| a.name().cmp(b.name()));
    let run = reconstruct(&sorted, &setup, &Unwatched).unwrap();
    assert!(run.report.fusion.seen_through > 200);
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::create(folder.path().join("room"), &setup.store_header()).unwrap();
    let contours_of = |store: &Store| contours(&store.read().unwrap().model().unwrap());
    {
        let grower = Grower::new(&store, &setup).unwrap();
        for k in [2, 0, 1] {
            grower.add_view(&views[k]).unwrap().unwrap();
        }
        let growth = grower.add_views(&views, &Unwatched).unwrap();
        assert_eq!(growth.present.len(), 3);
        assert!(growth.report.fusion.seen_through > 200);
    }
    assert!(contours_of(&store) == contours(&run.model));
    {
        let grower = Grower::new(&store, &setup).unwrap();
        assert_eq!(grower.stale_planes().unwrap(), []);
        // Without two views that looked through her, a person stays.
        for k in [1, 3] {
            grower.remove_view(&ViewId::from(views[k].name())).unwrap();
        }
        let two = [&views[2], &views[0]].map(Clone::clone);
        let run = reconstruct(&two, &setup, &Unwatched).unwrap();
        assert!(contours_of(&store) == contours(&run.model));
        assert!(of_people(&run.model) > 400);
        grower.add_views(&views, &Unwatched).unwrap();
    }
    assert!(contours_of(&store) == contours(&run.model));
    assert_eq!(store.verify().unwrap().pending, 0);
}
