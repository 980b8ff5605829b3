//! A model that grows view by view in a file, and lets a view leave again.
//!
//! Run it with `cargo run --example growing_store`.

use std::sync::Arc;
use transect::device::DeviceFrame;
use transect::geometry::Point3;
use transect::model::Location;
use transect::model::store::{SpaceQuery, Store};
use transect::sensors::{Intrinsics, Pinhole};
use transect::{
    Grower, ImageSize, Isometry3, LengthUnit, PlaneFamily, RangeImage, Setup, StraightGuide,
    Unwatched, Vector3, View,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A depth camera looks straight down on a floor at z = 7 m, from three places in a row.
    let size = ImageSize { rows: 48, cols: 64 };
    let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 })?;
    let camera: Arc<dyn DeviceFrame> = Arc::new(camera);
    let image = RangeImage::from_values(size, vec![2.0; size.pixels()])?;
    let view = |name: &str, x: f64| {
        let world_from_sensor = Isometry3::translation(x, 0.0, 5.0);
        View::new(name, image.clone(), camera.clone(), world_from_sensor, None)
    };
    let (first, second, third) = (view("first", 0.0)?, view("second", 1.5)?, view("third", 3.0)?);

    // The planes, the unit and the options are fixed when the store is made.
    let guide = StraightGuide::along(Vector3::x())?;
    let setup = Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.05, 0.1)?);
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("floor.transect");
    let store = Store::create(&path, &setup.store_header())?;
    let grower = Grower::new(&store, &setup)?;
    let growth = grower.add_views(&[first, second], &Unwatched)?;
    assert_eq!((growth.present.len(), growth.report.views.len()), (0, 2));
    store.close()?;

    // Later, another program continues with the settings that are in the file.
    let store = Store::open(&path)?;
    let setup = Setup::of_store(store.read()?.header())?;
    let grower = Grower::new(&store, &setup)?;
    grower.add_view(&third)?;
    assert_eq!(store.views()?.len(), 3);

    // The camera is on the free side of the floor; below the floor is solid.
    let mut query = SpaceQuery::new(store.read()?, SpaceQuery::DEFAULT_CAPACITY);
    let location = |query: &mut SpaceQuery, x, z| query.locate(&Point3::new(x, 0.0, z));
    assert_eq!(location(&mut query, 3.5, 6.9)?.location, Location::Outside);
    assert_eq!(location(&mut query, 3.5, 7.1)?.location, Location::Inside);

    // Without the third view, that part of the floor is unknown again.
    grower.remove_view(&"third".into())?;
    let mut query = SpaceQuery::new(store.read()?, SpaceQuery::DEFAULT_CAPACITY);
    assert_eq!(location(&mut query, 3.5, 7.1)?.location, Location::Unknown);
    assert_eq!(location(&mut query, 0.5, 7.1)?.location, Location::Inside);
    Ok(())
}
