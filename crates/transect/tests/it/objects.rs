//! The scene of `fixtures/objects.scene.toml`, a block and a ball, as its four sensors see it.

use std::sync::Arc;
use transect::Setup;
use transect_device::{DeviceFrame, View};
use transect_geometry::LengthUnit;
use transect_scene::{Description, Noise, Station};

/// What is in the scene.
pub fn description() -> Description {
    Description::parse(include_str!("../../../../fixtures/objects.scene.toml")).unwrap()
}

/// The views of all stations.
pub fn views(noise: &Noise) -> Vec<View> {
    let description = description();
    let scene = description.scene();
    let view = |(k, s): (usize, &Station)| {
        scene
            .view(s.name.clone(), s.frame().unwrap(), s.world_from_sensor, noise, k as u64)
            .unwrap()
    };
    description.stations.iter().enumerate().map(view).collect()
}

/// The views with the scene's own noise.
pub fn noisy_views() -> Vec<View> {
    views(&description().noise)
}

/// Its planes, with default options.
pub fn setup() -> Setup {
    Setup::new(LengthUnit::Metre, description().planes)
}

/// The sensor of the station of a name.
pub fn frame_of(name: &str) -> Arc<dyn DeviceFrame> {
    description().stations.iter().find(|s| s.name == name).unwrap().frame().unwrap()
}
