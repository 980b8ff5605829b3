//! What the tests share: simulated scans, real scans, and turns.

use std::io::Write;
use std::path::Path;
use transect_device::{Isometry3, RangeImage, Vector3, View};
use transect_exchange::Scan;
use transect_register::{CoarseView, Finding, judge};
use transect_scene::{BUNDLED_SCENES, Description, Station};

/// The views of a bundled scene, with its noise; `more` is added to its description.
pub fn simulated(name: &str, more: &str) -> Vec<View> {
    let (_, text) = BUNDLED_SCENES.iter().find(|(bundled, _)| *bundled == name).unwrap();
    let description = Description::parse(&format!("{text}\n{more}")).unwrap();
    let scene = description.scene();
    let view = |(k, s): (usize, &Station)| {
        scene
            .view(&s.name, s.frame().unwrap(), s.world_from_sensor, &description.noise, k as u64)
            .unwrap()
    };
    description.stations.iter().enumerate().map(view).collect()
}

/// The views of a real scan; tells that the test is skipped where there is none.
pub fn real(name: &str) -> Option<Vec<View>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
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
