//! Reading scans, writing models: every file format of the workspace but the model's own store.
//!
//! The one decision of this crate: **nothing is guessed in silence**. What a file does not say is
//! an error; what it says oddly is repaired and told in a note; what nobody knows is told as well.
//! Every message names the file, and the view, line, row and column where there is one. Data from
//! outside is not believed: announced sizes are compared with the file before memory is taken.
//!
//! It refuses to know algorithms: it neither makes curves nor judges them.
//!
//! Read: [`Scan`] (`scan.json`, Stanford `.conf`, depth folders), [`read_calibration`] (text), [`read_guide`] (CSV, GeoJSON, DXF),
//! [`read_mesh`] (PLY, STL, OBJ), [`read_truth`] (`.npz`), [`read_contours`] (`contours.json`).
//! Written: [`write_contours`], [`write_dxf`], [`ModelSplines`], [`svg`], [`write_manifest`], [`write_truth`],
//! [`write_npy_image`], [`write_npy_stack`], [`write_png_image`], [`write_calibration`]; all into any [`std::io::Write`], or whole files through [`write_file`].
#![deny(clippy::indexing_slicing)]

mod calibration;
mod contours;
mod depth_folder;
mod dxf;
mod error;
mod guide_file;
mod image_file;
mod image_stack;
mod manifest;
mod mesh;
mod npy;
mod npz;
mod ply;
mod png_file;
mod pose;
mod scan;
mod sensor_source;
mod spline_file;
mod stanford;
pub mod svg;
#[cfg(test)]
mod test_data;
mod truth;
mod write_file;

pub use calibration::{read_calibration, write_calibration};
pub use contours::{ContourPlane, Contours, read_contours, write_contours};
pub use depth_folder::{FileNames, depth_folder_manifest};
pub use dxf::{DxfFrame, write_dxf};
pub use error::{Place, ReadError, Unusable, WriteError};
pub use guide_file::read_guide;
pub use image_file::write_npy_image;
pub use image_stack::{Counts, write_npy_stack, write_png_image};
pub use manifest::{
    AnglesEntry, LensEntry, LightStripeEntry, LookupTableEntry, Manifest, PinholeEntry,
    SensorEntry, StripeEntry, ViewEntry, ViewpointsEntry, read_manifest, write_manifest,
};
pub use mesh::{MeshFile, TriangleMesh, read_mesh};
pub use ply::{RangeGrid, read_range_grid};
pub use pose::{pose_of_row_major, row_major};
pub use scan::{PlanesEntry, Scan, ScanView};
pub use spline_file::ModelSplines;
pub use truth::{read_truth, write_truth};
pub use write_file::write_file;
