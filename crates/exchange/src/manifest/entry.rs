//! The content of a manifest as data.

use super::sensor::SensorEntry;
use crate::missing::MissingValue;
use crate::{PlanesEntry, PoseSigma};
use serde::Serialize;
use std::io::{self, Write};
use transect_device::ImageOrder;
use transect_geometry::LengthUnit;

/// The content of a manifest. No image has been read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Manifest {
    /// The name that reports show.
    pub name: String,
    /// The unit of every length; `None` if the manifest does not state it.
    pub unit: Option<LengthUnit>,
    /// Standard deviation of a range along its ray, in the length unit, if known.
    pub sigma: Option<f64>,
    /// The section planes, if the scan asks for some.
    pub planes: Option<PlanesEntry>,
    /// Longest side of the box around a simulated scene, in the length unit. The reader does not
    /// use it; programs that score models relative to the scene's size do.
    pub size: Option<f64>,
    /// The views in order.
    pub views: Vec<ViewEntry>,
}

impl Manifest {
    /// A manifest of views. The unit, σ, planes and size are not stated.
    pub fn new(name: String, views: Vec<ViewEntry>) -> Self {
        Self { name, unit: None, sigma: None, planes: None, size: None, views }
    }
}

/// One view of a manifest.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ViewEntry {
    /// The image's file, relative to the manifest or absolute.
    pub file: String,
    /// The view's name, if it is not the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Kind of sensor and its parameters.
    #[serde(flatten)]
    pub sensor: SensorEntry,
    /// Rows of the image. The reader compares them with the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<usize>,
    /// Columns of the image. The reader compares them with the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cols: Option<usize>,
    /// Length units per count, for images of integers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// The value of pixels without a return: a number, or a point in grids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<MissingValue>,
    /// The order of the pixels in the file, if it is another than the sensor's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image_order: Option<ImageOrder>,
    /// `world_from_sensor`, row-major homogeneous; see [`row_major`](crate::row_major).
    pub pose: [f64; 16],
    /// How far the pose may be wrong, if it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_sigma: Option<PoseSigma>,
    /// By how much the view's surface may be off along its normals with this pose, as a standard
    /// deviation in the length unit, if registration told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_sigma: Option<f64>,
    /// The true pose, if it is known and differs from `pose`. Modelling never uses it; it is for
    /// programs that compare poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_true: Option<[f64; 16]>,
}

impl ViewEntry {
    /// A view without stated size, scale and true pose.
    pub fn new(file: String, sensor: SensorEntry, pose: [f64; 16]) -> Self {
        Self {
            file,
            name: None,
            sensor,
            rows: None,
            cols: None,
            scale: None,
            missing: None,
            image_order: None,
            pose,
            pose_sigma: None,
            surface_sigma: None,
            pose_true: None,
        }
    }
}

/// Writes a manifest that [`Scan::open`](crate::Scan::open) reads, one view per line. Its key
/// `tool` names this program and its command that writes the manifest, such as `register`. Other
/// commands do not replace it then.
///
/// # Errors
/// An error of `out`.
pub fn write_manifest(manifest: &Manifest, command: &str, out: &mut dyn Write) -> io::Result<()> {
    let Manifest { name, unit, sigma, planes, size, views } = manifest;
    writeln!(out, "{{ \"name\": {},", serde_json::to_string(name)?)?;
    write_key(out, "tool", Some(&tool_of(command)))?;
    write_key(out, "unit", unit.as_ref())?;
    write_key(out, "sigma", sigma.as_ref())?;
    write_key(out, "planes", planes.as_ref())?;
    write_key(out, "size", size.as_ref())?;
    write_list(out, "views", views)
}

/// The value of the key `tool`: this program, its version and the command.
pub(crate) fn tool_of(command: &str) -> String {
    format!("transect {} {command}", env!("CARGO_PKG_VERSION"))
}

/// Writes a list, one item per line, and ends the file.
pub(crate) fn write_list(
    out: &mut dyn Write,
    key: &str,
    items: &[impl Serialize],
) -> io::Result<()> {
    write!(out, "  \"{key}\": [")?;
    for (number, item) in items.iter().enumerate() {
        let separator = if number > 0 { "," } else { "" };
        write!(out, "{separator}\n    {}", serde_json::to_string(item)?)?;
    }
    writeln!(out, " ] }}")
}

/// Writes a key, if it has a value.
pub(crate) fn write_key(
    out: &mut dyn Write,
    key: &str,
    value: Option<&impl Serialize>,
) -> io::Result<()> {
    match value {
        Some(value) => writeln!(out, "  \"{key}\": {},", serde_json::to_string(value)?),
        None => Ok(()),
    }
}
