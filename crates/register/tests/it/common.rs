//! What the tests share: simulated scans, real scans, and turns.

use std::io::Write;
use std::path::{Path, PathBuf};
use transect_device::{ImageOrder, Isometry3, RangeImage, Vector3, View};
use transect_exchange::{
    FileNames, LensEntry, OpenOptions, Scan, SensorEntry, depth_sequence_manifest,
};
use transect_register::{CoarseView, Finding, judge};
use transect_scene::{BUNDLED_SCENES, Description, Noise, SensorParameters, Station};
use transect_sensors::Intrinsics;

fn description(name: &str, more: &str) -> Description {
    let (_, text) = BUNDLED_SCENES.iter().find(|(bundled, _)| *bundled == name).unwrap();
    Description::parse(&format!("{text}\n{more}")).unwrap()
}

/// The views of a bundled scene, with its noise; `more` is added to its description.
pub fn simulated(name: &str, more: &str) -> Vec<View> {
    views_of(&description(name, more), 0)
}

/// The same with another draw of noise.
pub fn simulated_with_seed(name: &str, seed: u64) -> Vec<View> {
    views_of(&description(name, ""), seed)
}

/// The views of a bundled scene, with another noise.
pub fn simulated_with_noise(name: &str, change: impl Fn(&mut Noise)) -> Vec<View> {
    let mut description = description(name, "");
    change(&mut description.noise);
    views_of(&description, 0)
}

/// The room from scanners that turn around once. Their images begin and end 25° from the middle.
pub fn full_turns() -> Vec<View> {
    let (_, text) = BUNDLED_SCENES.iter().find(|(bundled, _)| *bundled == "room").unwrap();
    let views = described(&text.replace("theta = [50, -50]", "theta = [25, -335]"));
    assert!(views.iter().all(|view| view.frame().columns_wrap()));
    views
}

/// The views of a scene that is described here.
pub fn described(text: &str) -> Vec<View> {
    views_of(&Description::parse(text).unwrap(), 0)
}

fn views_of(description: &Description, seed: u64) -> Vec<View> {
    let scene = description.scene();
    let view = |(k, s): (usize, &Station)| {
        let frame = s.frame().unwrap();
        let seed = seed + k as u64;
        scene.view(&s.name, frame, s.world_from_sensor, &description.noise, seed).unwrap()
    };
    description.stations.iter().enumerate().map(view).collect()
}

/// A view as a file holds it.
#[derive(Clone)]
pub struct Stored {
    view: View,
    image: RangeImage,
    sensor: SensorParameters,
}

/// The views of a bundled scene as files hold them.
pub fn simulated_files(name: &str) -> Vec<Stored> {
    let sensors = description(name, "").stations.into_iter().map(|s| s.sensor);
    let stored = |(view, sensor): (View, _)| Stored { image: view.image().clone(), view, sensor };
    simulated(name, "").into_iter().zip(sensors).map(stored).collect()
}

/// The images of a folder of real depth images as files hold them.
pub fn real_files(name: &str) -> Option<Vec<Stored>> {
    let views = real(name)?;
    let options = OpenOptions::default();
    let (manifest, _) =
        depth_sequence_manifest(&data(name), FileNames::Relative, &options).unwrap();
    let stored = |(view, sensor): (View, SensorEntry)| {
        let SensorEntry::Pinhole(entry) = sensor else { return None };
        let LensEntry::Intrinsics { intrinsics, .. } = entry.lens else { return None };
        let Intrinsics { fx, fy, cx, cy } = intrinsics;
        let sensor = SensorParameters::Pinhole { fx, fy, cx, cy };
        Some(Stored { image: view.image().clone(), view, sensor })
    };
    let sensors = manifest.views.into_iter().map(|view| view.sensor);
    let files: Option<_> = views.into_iter().zip(sensors).map(stored).collect();
    Some(files.unwrap())
}

impl Stored {
    /// The same view, stored in another order. Each order undoes itself.
    pub fn in_order(&self, order: ImageOrder) -> Self {
        let image = order.apply(self.image.clone()).unwrap();
        let sensor = match (order, self.sensor.clone()) {
            (ImageOrder::SwappedCamera, SensorParameters::Pinhole { fx, fy, cx, cy }) => {
                SensorParameters::Pinhole { fx: fy, fy: fx, cx: cy, cy: cx }
            }
            (_, sensor) => sensor,
        };
        Self { image, sensor, view: self.view.clone() }
    }

    /// The view as a program reads it.
    pub fn read(&self) -> Option<View> {
        let frame = self.sensor.frame(self.image.size()).ok()?;
        let (pose, sigma) = (*self.view.world_from_sensor(), self.view.sigma());
        Some(View::new(self.view.name(), self.image.clone(), frame, pose, sigma).unwrap())
    }

    /// Whether an order changes what is read.
    pub fn differs(&self, order: ImageOrder) -> bool {
        order != ImageOrder::SwappedCamera || self.in_order(order).sensor != self.sensor
    }
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name)
}

/// The views of a real scan; tells that the test is skipped where there is none.
pub fn real(name: &str) -> Option<Vec<View>> {
    let folder = data(name);
    if folder.exists() {
        let scan = Scan::open(&folder).unwrap();
        return Some(scan.views.iter().map(|view| view.load().unwrap().0).collect());
    }
    let reason = format!("skipped: ../shared/data is absent ({} is not there)", folder.display());
    // Written past the capture of passing tests' output, so that a skipped test is seen.
    let mut stderr = std::io::stderr();
    writeln!(stderr, "{reason}").unwrap();
    None
}

/// The coarse copies of views.
pub fn coarse(views: &[View]) -> Vec<CoarseView> {
    views.iter().map(CoarseView::new).collect()
}

/// The view, turned about one of its sensor's axes, which passes through the sensor.
pub fn turned(view: &View, axis: usize, degrees: f64) -> View {
    let axis = Vector3::ith(axis, degrees.to_radians());
    view.with_pose(view.world_from_sensor() * Isometry3::rotation(axis)).unwrap()
}

/// The view with other values at some pixels.
pub fn changed(view: &View, value: impl Fn(usize, usize, f32) -> f32) -> View {
    let image = view.image();
    let size = image.size();
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |col| (row, col)));
    let values = pixels.map(|(row, col)| value(row, col, image.row(row)[col])).collect();
    view.with_image(RangeImage::from_values(size, values).unwrap()).unwrap()
}

/// What is found in views.
pub fn findings(views: &[View]) -> Vec<Finding> {
    judge(&coarse(views)).findings
}

/// The name of the view that is named as wrong as a whole, if it is the only finding.
pub fn alone(findings: &[Finding]) -> Option<&str> {
    match findings {
        [Finding::Misplaced(found)] => Some(&found.view),
        [Finding::Apart { view }] => Some(view),
        _ => None,
    }
}
