//! The file formats of the workspace, except the model store: scans in, models out.
//!
//! The one decision of this crate: **it never guesses in silence**. Missing information is an
//! error. Repairs and ignored content become notes. Every message names the file, and the view,
//! line, row and column where there is one. Sizes that a file announces are compared with the file
//! before memory is taken.
//!
//! The crate contains no algorithms: it neither makes curves nor judges them.
//!
//! # Scan formats
//!
//! [`Scan::open`] recognises:
//!
//! | scan | path | unit |
//! |---|---|---|
//! | manifest | a folder with `scan.json`, or any `*.json` | stated, or the caller's |
//! | list of poses | a `*.json` that names a scan of another format | as that scan |
//! | Stanford configuration | `*.conf`, with PLY range grids, or a folder with one | metres by convention |
//! | depth sequence | a folder as TUM RGB-D, ICL-NUIM, ScanNet, 7-Scenes or Open3D lay it out | metres |
//! | E57 | `*.e57`, structured scans | metres |
//! | PTX | `*.ptx` | metres by convention |
//! | cloud of a structured scan or a lidar | `*.pcd`, `*.ply`, `*.bin`, or a folder of them | metres |
//!
//! # Other files
//!
//! | content | functions |
//! |---|---|
//! | manifest | [`read_manifest`], [`write_manifest`], [`depth_sequence_manifest`] |
//! | scan with other poses | [`Scan::posed`], [`PosedScan`] |
//! | range images, image stacks | [`write_npy_image`], [`write_npy_stack`], [`write_png_image`] |
//! | calibration sweeps | [`read_calibration`], [`write_calibration`] |
//! | guide curve (CSV, GeoJSON, DXF) | [`read_guide`] |
//! | mesh (PLY, STL, OBJ), range grid (PLY) | [`read_mesh`], [`read_range_grid`] |
//! | true surface of a simulation (`.npz`) | [`read_truth`], [`write_truth`] |
//! | sections (`contours.json`, DXF) | [`write_contours`], [`write_dxf`] |
//! | splines (DXF, JSON) | [`ModelSplines`] |
//! | pictures | [`svg`] |
//! | any text file | [`read_text`] |
//!
//! Every writer takes any [`std::io::Write`]. [`write_file`] writes a whole file or nothing.
#![deny(clippy::indexing_slicing)]

mod calibration;
mod cloud;
mod contours;
mod depth_sequence;
mod dxf;
mod dxf_groups;
mod e57;
mod error;
mod guide_file;
mod image_file;
mod image_stack;
mod input;
mod manifest;
mod mesh;
mod missing;
mod npy;
mod npz;
mod open;
mod open_options;
mod pgm_file;
mod ply;
mod png_file;
mod point_table;
mod points;
mod pose;
mod posed_scan;
mod ptx;
mod scalar;
mod scan;
mod spline_file;
mod stanford;
mod survey;
pub mod svg;
#[cfg(test)]
mod test_data;
mod tiff_file;
mod trajectory;
mod triangle_mesh;
mod truth;
mod view_file;
mod write_file;

pub use calibration::{read_calibration, write_calibration};
pub use contours::write_contours;
pub use depth_sequence::{FileNames, depth_sequence_manifest};
pub use dxf::{DxfFrame, write_dxf};
pub use error::{Place, ReadError, Unusable, WriteError};
pub use guide_file::read_guide;
pub use image_file::write_npy_image;
pub use image_stack::{Counts, write_npy_stack, write_png_image};
pub use input::read_text;
pub use manifest::{
    AnglesEntry, LensEntry, LightStripeEntry, LookupTableEntry, MANIFEST_FILE, Manifest,
    PinholeEntry, SensorEntry, StripeEntry, ViewEntry, ViewpointsEntry, read_manifest,
    write_manifest,
};
pub use mesh::read_mesh;
pub use missing::MissingValue;
pub use open_options::{CameraOption, OpenOptions};
pub use ply::{RangeGrid, read_range_grid};
pub use pose::{pose_of_row_major, row_major};
pub use posed_scan::{PoseList, PosedScan, ViewPose};
pub use scan::{FramedImage, LoadView, PlanesEntry, PoseSigma, Scan, ScanView};
pub use spline_file::ModelSplines;
pub use triangle_mesh::{MeshFile, TriangleMesh};
pub use truth::{TRUTH_FILE, read_truth, write_truth};
pub use write_file::write_file;
