//! A model store: two views come, one leaves, and points are asked about.
//!
//! Run it with `cargo run --example store_and_query`.

use transect_geometry::{
    Curve, Isometry3, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, Point3, StraightGuide,
    Vector3,
};
use transect_model::Location;
use transect_model::store::{SpaceQuery, Store, StoreHeader, ViewDescription, ViewId};

/// The fused curves of a plane are a function of the views' own curves. Here: all of them.
fn fuse(_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
    partials.iter().flat_map(|(_, curves)| curves.clone()).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Horizontal planes every 0.5 m.
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 0.25, 0.5)?;
    let header = StoreHeader {
        unit: LengthUnit::Metre,
        planes,
        options: String::new(),
        tool: "example".to_owned(),
    };
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("blocks.transect");
    let store = Store::create(&path, &header)?;

    // Each view saw a block, 2 m × 2 m × 2 m, on four planes. The blocks are 5 m apart.
    for (id, x) in [("west", 0.0), ("east", 5.0)] {
        let corners = [(x, 0.0), (x + 2.0, 0.0), (x + 2.0, 2.0), (x, 2.0)];
        let nodes = corners.map(|(x, y)| Node::at(Point2::new(x, y)));
        let block = Curve::new(nodes.to_vec(), true)?;
        let mut view = store.begin_view(ViewDescription {
            id: id.into(),
            name: id.to_owned(),
            sensor: "none".to_owned(),
            source: "example".to_owned(),
            source_hash: String::new(),
            world_from_sensor: Isometry3::identity(),
            sigma: None,
        })?;
        view.add_planes((0..4).map(|k| (PlaneIndex(k), vec![block.clone()])), &fuse)?;
        view.commit()?;
    }
    store.close()?;

    // Another program opens the file.
    let mut store = Store::open(&path)?;
    assert_eq!(store.verify()?.views, 2);
    let volume = store.read()?.volume()?.solid.bracket.estimate;
    assert!((volume - 2.0 * 8.0).abs() < 1e-9, "two blocks of 2 m × 2 m × 2 m: {volume} m³");

    let in_west = Point3::new(1.0, 1.0, 0.7);
    let in_east = Point3::new(6.0, 1.0, 0.7);
    let mut query = SpaceQuery::new(store.read()?, SpaceQuery::DEFAULT_CAPACITY);
    assert_eq!(query.locate(&in_west)?.location, Location::Inside);
    assert_eq!(query.locate(&in_east)?.location, Location::Inside);
    assert_eq!(query.locate(&Point3::new(3.5, 1.0, 0.7))?.location, Location::Outside);

    // The eastern view turns out wrong. It leaves no trace.
    store.remove_view(&"east".into(), &fuse)?;
    let mut query = SpaceQuery::new(store.read()?, SpaceQuery::DEFAULT_CAPACITY);
    assert_eq!(query.locate(&in_west)?.location, Location::Inside);
    assert_eq!(query.locate(&in_east)?.location, Location::Outside);
    Ok(())
}
