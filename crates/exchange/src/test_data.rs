//! Data that the tests of several modules need.

use std::io::Write;
use std::path::{Path, PathBuf};
use transect_device::Note;
use transect_geometry::{
    Curve, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, StraightGuide, Vector3,
};
use transect_model::Model;

pub(crate) const IDENTITY_POSE: &str = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

/// A folder of the shared data sets; tells that the test is skipped where it is absent.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    skipped(&format!("../shared/data is absent ({} is not there)", folder.display()));
    None
}

/// Tells that a test is skipped, and why. It is written past the capture of passing tests' output:
/// a skipped test must not look like one that ran.
pub(crate) fn skipped(reason: &str) {
    writeln!(std::io::stderr(), "skipped: {reason}").unwrap();
}

/// Notes as they are printed, one on each line.
pub(crate) fn lines(notes: &[Note]) -> String {
    notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// A Python interpreter that can import a module; tells that the test is skipped without one.
/// The environment variable `TRANSECT_PYTHON` names the interpreter.
pub(crate) fn python_with(module: &str) -> Option<String> {
    let python = std::env::var("TRANSECT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let import = format!("import {module}");
    let tried = std::process::Command::new(&python).args(["-c", &import]).output();
    if tried.is_ok_and(|o| o.status.success()) {
        return Some(python);
    }
    skipped(&format!("{python} with the module {module} is not there; set TRANSECT_PYTHON"));
    None
}

pub(crate) fn curve(points: &[(f64, f64)], closed: bool) -> Curve {
    let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, closed).unwrap()
}

/// A model in millimetres, plane k at station k / 4.
pub(crate) fn model(normal: [f64; 3], planes: &[(i64, Vec<Curve>)]) -> Model {
    let guide = StraightGuide::along(Vector3::from(normal)).unwrap();
    let family = PlaneFamily::new(guide, 0.0, 0.25).unwrap();
    let mut model = Model::new(LengthUnit::Millimetre, family);
    for (index, curves) in planes {
        model.set_curves(PlaneIndex(*index), curves.clone());
    }
    model
}

/// A file in a folder of its own, which goes when the first value is dropped.
pub(crate) fn write_to_folder(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    (folder, path)
}

/// Options with a unit.
pub(crate) fn in_unit(unit: LengthUnit) -> crate::OpenOptions {
    crate::OpenOptions { unit: Some(unit), ..crate::OpenOptions::default() }
}

/// A 16-bit grey image.
pub(crate) fn write_png(path: &Path, cols: usize, counts: &[u16]) {
    let file = std::fs::File::create(path).unwrap();
    let mut encoder = png::Encoder::new(file, cols as u32, (counts.len() / cols) as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let samples: Vec<u8> = counts.iter().flat_map(|c| c.to_be_bytes()).collect();
    encoder.write_header().unwrap().write_image_data(&samples).unwrap();
}

/// A scan in millimetres whose views are JSON keys without their pose, in a folder of its own.
pub(crate) fn scan_folder(views: &[&str]) -> tempfile::TempDir {
    let pose = r#""pose": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]"#;
    let views: Vec<String> = views.iter().map(|keys| format!("{{ {keys}, {pose} }}")).collect();
    let folder = tempfile::tempdir().unwrap();
    let text = format!(r#"{{ "unit": "mm", "views": [ {} ] }}"#, views.join(",\n"));
    std::fs::write(folder.path().join("scan.json"), text).unwrap();
    folder
}

/// Row-major values as a `.npy` of float32, of any shape.
pub(crate) fn write_npy(path: &Path, shape: &[usize], values: &[f32]) {
    let mut bytes = Vec::new();
    crate::npy::write_header(&mut bytes, "<f4", shape).unwrap();
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(path, bytes).unwrap();
}

/// An error with all its causes, as a program prints it.
pub(crate) fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |e| e.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}
