//! `scan.json`: the manifest of a scan.
//!
//! ```json
//! { "name": "room", "unit": "m", "sigma": 0.004,
//!   "planes": { "normal": [0, 0, 1], "offset": 0.05, "interval": 0.05 },
//!   "views": [
//!     { "file": "range_000.npy", "sensor": "spherical", "rows": 512, "cols": 1024,
//!       "theta0": -3.14, "dtheta": 0.006, "phi0": -1.3, "dphi": 0.005,
//!       "pose": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1] } ] }
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `unit` | length unit of all lengths: `m dm cm mm um in ft`; no default |
//! | `sigma` | standard deviation of a range along its ray; optional |
//! | `planes` | plane k is normal · p = offset + k · interval; optional |
//! | `planes.guide` | a curve instead of the normal: `{"kind": "spline", "points": [[x, y, z], …]}`; `"kind": {"polyline": RADIUS}` is straight pieces with corners rounded by arcs up to that radius |
//! | `file` | the image, relative to the manifest |
//! | `name` | the view's name in tables and reports; the file if it is not stated |
//! | `pose` | 16 numbers, row-major, or 4 rows of 4; sensor to world |
//! | `pose_sigma` | how far `pose` may be wrong, as standard deviations: `{"rotation": 0.005, "translation": 0.01}` in radians and the length unit; optional, for the refinement of poses |
//! | `surface_sigma` | standard deviation of the view's surface along its normals with `pose`; optional. Registration writes it, and fused nodes hold it |
//! | `pose_true` | the true pose, if it is known; modelling never uses it |
//! | `scale` | length units per count, for images of integers; `depth_scale` is its older name |
//! | `missing` | the value of pixels without a return in the file, before the scale: a number, or `[x, y, z]` for a grid; in a view, or at the top for all views |
//! | `image_order` | of a view of a depth camera or an angular scan whose file holds the pixels in another order. `transposed`, `mirrored` (columns run to the left), `upside-down` (rows run up), or `swapped-camera` (the image is right, and fx, fy and cx, cy are exchanged) |
//! | `rows`, `cols` | size of the range image; optional, checked against the file |
//! | `sensor` | one of the following, each with its own keys |
//!
//! | sensor | keys and image |
//! |---|---|
//! | `spherical` | `theta0 dtheta phi0 dphi` in radians: column j looks along theta0 + j · dtheta, row i along phi0 + i · dphi; pixels hold the range |
//! | `pinhole` | `fx fy cx cy` in pixels, `distortion` or `rays`, `holds`; pixels hold the depth along z or the ray's length; see `sensor/pinhole.rs` |
//! | `light_stripe` | camera, base line, mirror, laser angles, `stripe`; pixels hold the stripe's place in its camera row, or are found in a stack of intensity images; see `sensor/light_stripe.rs` |
//! | `lookup_table` | `calibration`, scanning angles, linear axis, mounting; pixels hold the place on the detector; see `sensor/lookup_table.rs` |
//! | `grid` | `viewpoint` [x, y, z], where all rays start; a `.npy` of rows × cols × 3 points |
//!
//! Images are `.npy`, NaN or 0 = missing, in the unit of the sensor's pixels (the length unit for
//! ranges and depths). Integers need a `scale`, also those of 16-bit grey `.png`, `.pgm` and `.tif`
//! (0 and 65535 = missing). A `.tif` may hold floating-point numbers.
//! Other values that mean "no return" are stated by `missing`, or found; see `missing.rs`. Files
//! that keys name are relative to the manifest. Notes by other programs (`scene`, `size`, `truth`,
//! `seed`, `comment`, `description`, `tool`) are accepted. Any other key becomes a note, also one
//! of another sensor. JSON has no `NaN` and `Infinity`, but some programs write them. They are
//! accepted for `missing`, where they state nothing, and for `pose_true`. Elsewhere they are errors
//! that name the key.

mod entry;
mod keys;
mod read;
mod sensor;
#[cfg(test)]
mod tests;
mod to_scan;
mod unique;

pub use entry::{Manifest, ViewEntry, write_manifest};
pub(crate) use entry::{tool_of, write_key, write_list};
pub use sensor::{
    AnglesEntry, LensEntry, LightStripeEntry, LookupTableEntry, PinholeEntry, SensorEntry,
    StripeEntry, ViewpointsEntry,
};
pub(crate) use to_scan::{no_order, to_scan};

use crate::{OpenOptions, ReadError, Scan};
use std::path::Path;
use transect_device::Note;

/// The name of the manifest in a scan folder.
pub const MANIFEST_FILE: &str = "scan.json";

/// Whether a folder holds a manifest.
pub(crate) fn is_in(folder: &Path) -> bool {
    folder.join(MANIFEST_FILE).is_file()
}

/// Opens a manifest as a scan.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    let (manifest, notes) = read_manifest(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut scan = to_scan(path, &folder, &manifest, options.unit)?;
    scan.notes.splice(0..0, notes);
    scan.inputs.insert(0, path.to_owned());
    Ok(scan)
}

/// Reads a manifest, with a note for every unknown key.
///
/// # Errors
/// [`ReadError`] naming file, view and key if something is missing or wrong.
pub fn read_manifest(path: &Path) -> Result<(Manifest, Vec<Note>), ReadError> {
    let text = crate::input::read_text(path)?;
    read::manifest(path, &text)
}
