//! `light_stripe`: a laser sheet turned by a mirror and watched by a camera (SmartEye).
//!
//! | key | meaning |
//! |---|---|
//! | `camera_rows`, `camera_cols` | cells of the camera; its rows are the image's |
//! | `focal_length`, `cell_width`, `cell_height` | lengths |
//! | `x_center`, `y_center` | the optical axis: cells from the array's left edge, and row |
//! | `baseline` | from the mirror's axis to the focal point, a length |
//! | `mirror_axis`, `mirror_face` | the mirror's axis behind the laser's beam, and its face before its axis; lengths, default 0 |
//! | `fan_angle` | full opening of the line lens, radians |
//! | `farthest` | largest depth at which the stripe is seen, a length; default infinite |
//! | `theta0`, `dtheta` | laser angle of column 0 and from one column to the next, radians |
//! | `theta_laser` | instead of these two: a list of all laser angles, radians |
//! | `stripe` | how to find the stripe in a stack; optional, see below |
//!
//! `file` is one of
//!
//! * an image of camera rows × laser angles that holds `x_frame`, in cells from the array's left
//!   edge;
//! * a stack of the camera's intensity images, one per laser angle: a `.npy` of angles × camera
//!   rows × camera columns of type `u1` or `u2`, or a folder of 8- or 16-bit grey `.png` files in the
//!   order of their names. The stripe is then found on loading; rows without one are missing.
//!
//! | key in `stripe` | meaning |
//! |---|---|
//! | `shape` | `triangle` (the default) or `gaussian` |
//! | `width` | base of the triangle, in cells, twice the width at half height; default 8 |
//! | `height` | height over the background, in counts; default half the largest count of the stack, which a note tells |
//! | `least_height` | least height that still is a stripe, in counts; default a quarter of `height` |
//! | `median_rows` | rows of the median filter along the stripe, odd; default 5, none: 1 |
//! | `peak` | `sub_cell` (the default) or `whole_cell` |
//!
//! Stripes of a quarter to twice `height` are found, so half the largest count serves all surfaces
//! but the darkest, unless a reflection is brighter than the stripe.

use super::super::keys::Keys;
use super::super::word;
use crate::ReadError;
use serde::Serialize;
use transect_device::ImageSize;
use transect_sensors::light_stripe::stripe::{Peak, StripeFinder, StripeProfile, StripeShape};
use transect_sensors::{LaserAngles, LightStripeParameters};

/// A light-stripe range finder, as manifests describe it; units as in [`LightStripeParameters`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightStripeEntry {
    /// Rows of the camera, which are the range image's.
    pub camera_rows: usize,
    /// Columns of the camera.
    pub camera_cols: usize,
    /// Distance of the focal point from the array; a length.
    pub focal_length: f64,
    /// From one cell to the next along a row; a length.
    pub cell_width: f64,
    /// From one row to the next; a length.
    pub cell_height: f64,
    /// The optical axis along a row, in cells from the array's left edge.
    pub x_center: f64,
    /// Row of the optical axis.
    pub y_center: f64,
    /// From the mirror's axis to the focal point; a length.
    pub baseline: f64,
    /// Distance of the mirror's axis from the laser's axis; a length.
    pub mirror_axis: f64,
    /// Distance of the mirror's face from its axis; a length.
    pub mirror_face: f64,
    /// Full opening angle of the line lens; radians.
    pub fan_angle: f64,
    /// Largest depth at which the stripe is seen; a length, or infinite, which is not written.
    #[serde(skip_serializing_if = "is_infinite")]
    pub farthest: f64,
    /// The laser's angles, one per column.
    #[serde(flatten)]
    pub angles: AnglesEntry,
    /// How to find the stripe; `None` for the defaults, or for an image of `x_frame`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stripe: Option<StripeEntry>,
}

/// The laser's angles, in radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum AnglesEntry {
    /// Equal steps, as many as the image has columns or the stack has images.
    Steps {
        /// Angle of column 0.
        theta0: f64,
        /// From one column to the next.
        dtheta: f64,
    },
    /// Any angles, one per column.
    Listed {
        /// The angles in the order of the columns.
        theta_laser: Vec<f64>,
    },
}

/// How to find the stripe in intensity images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StripeEntry {
    /// Shape of the template.
    #[serde(serialize_with = "word::write")]
    pub shape: StripeShape,
    /// Base of the triangle, in cells; twice the width at half height for every shape.
    pub width: f64,
    /// Height over the background, in counts; `None` for half the largest count of the stack.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Least height that still is a stripe, in counts; `None` for the finder's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_height: Option<f64>,
    /// Rows of the median filter along the stripe, odd; 1 for none.
    pub median_rows: usize,
    /// Whole cells or parts of them.
    #[serde(serialize_with = "word::write")]
    pub peak: Peak,
}

/// Width of a stripe nobody has described, in cells: wide enough for sub-cell peaks under noise,
/// and stripes of two thirds to half as much again are still found to a hundredth of a cell.
const USUAL_WIDTH: f64 = 8.0;

impl Default for StripeEntry {
    /// A triangle 8 cells wide, its height measured, the rest as [`StripeFinder::new`] has it.
    fn default() -> Self {
        let usual = StripeFinder::new(StripeProfile::triangle(USUAL_WIDTH, 1.0));
        Self { height: None, least_height: None, ..usual.into() }
    }
}

impl From<StripeFinder> for StripeEntry {
    /// Everything stated.
    fn from(finder: StripeFinder) -> Self {
        let StripeFinder { profile, least_height, median_rows, peak } = finder;
        let StripeProfile { shape, width, height } = profile;
        let (height, least_height) = (Some(height), Some(least_height));
        Self { shape, width, height, least_height, median_rows, peak }
    }
}

fn is_infinite(farthest: &f64) -> bool {
    *farthest == f64::INFINITY
}

impl LightStripeEntry {
    /// The entry of a range finder, with its angles listed.
    pub fn new(parameters: &LightStripeParameters, stripe: Option<StripeEntry>) -> Self {
        let ImageSize { rows, cols } = parameters.camera;
        let theta_laser = parameters.theta_laser.as_radians().to_vec();
        Self {
            camera_rows: rows,
            camera_cols: cols,
            focal_length: parameters.focal_length,
            cell_width: parameters.cell_width,
            cell_height: parameters.cell_height,
            x_center: parameters.x_center,
            y_center: parameters.y_center,
            baseline: parameters.baseline,
            mirror_axis: parameters.mirror_axis,
            mirror_face: parameters.mirror_face,
            fan_angle: parameters.fan_angle,
            farthest: parameters.farthest,
            angles: AnglesEntry::Listed { theta_laser },
            stripe,
        }
    }

    /// The range finder's parameters for an image of `columns` laser angles.
    pub(crate) fn parameters(&self, columns: usize) -> LightStripeParameters {
        let radians = match &self.angles {
            AnglesEntry::Steps { theta0, dtheta } => {
                (0..columns).map(|j| theta0 + j as f64 * dtheta).collect()
            }
            AnglesEntry::Listed { theta_laser } => theta_laser.clone(),
        };
        LightStripeParameters {
            camera: ImageSize { rows: self.camera_rows, cols: self.camera_cols },
            focal_length: self.focal_length,
            cell_width: self.cell_width,
            cell_height: self.cell_height,
            x_center: self.x_center,
            y_center: self.y_center,
            baseline: self.baseline,
            mirror_axis: self.mirror_axis,
            mirror_face: self.mirror_face,
            fan_angle: self.fan_angle,
            farthest: self.farthest,
            theta_laser: LaserAngles::from_radians(radians),
        }
    }

    pub(super) fn read(keys: &Keys<'_>, notes: &mut Vec<String>) -> Result<Self, ReadError> {
        let stripe = keys.object("stripe", "stripe.")?;
        let stripe = stripe.map(|keys| StripeEntry::read(&keys, notes)).transpose()?;
        Ok(Self {
            camera_rows: keys.required_count("camera_rows")?,
            camera_cols: keys.required_count("camera_cols")?,
            focal_length: keys.required_number("focal_length")?,
            cell_width: keys.required_number("cell_width")?,
            cell_height: keys.required_number("cell_height")?,
            x_center: keys.required_number("x_center")?,
            y_center: keys.required_number("y_center")?,
            baseline: keys.required_number("baseline")?,
            mirror_axis: keys.number("mirror_axis")?.unwrap_or(0.0),
            mirror_face: keys.number("mirror_face")?.unwrap_or(0.0),
            fan_angle: keys.required_number("fan_angle")?,
            farthest: keys.number("farthest")?.unwrap_or(f64::INFINITY),
            angles: AnglesEntry::read(keys)?,
            stripe,
        })
    }
}

impl AnglesEntry {
    fn read(keys: &Keys<'_>) -> Result<Self, ReadError> {
        if let Some(theta_laser) = keys.number_list("theta_laser")? {
            return Ok(Self::Listed { theta_laser });
        }
        let (theta0, dtheta) = (keys.number("theta0")?, keys.number("dtheta")?);
        let wanted = "a number of radians, unless \"theta_laser\" lists all angles";
        Ok(Self::Steps {
            theta0: theta0.ok_or_else(|| keys.wrong("theta0", wanted))?,
            dtheta: dtheta.ok_or_else(|| keys.wrong("dtheta", wanted))?,
        })
    }
}

impl StripeEntry {
    fn read(keys: &Keys<'_>, notes: &mut Vec<String>) -> Result<Self, ReadError> {
        let usual = Self::default();
        let entry = Self {
            shape: keys.word("shape")?.unwrap_or(usual.shape),
            width: keys.number("width")?.unwrap_or(usual.width),
            height: keys.number("height")?,
            least_height: keys.number("least_height")?,
            median_rows: keys.count("median_rows")?.unwrap_or(usual.median_rows),
            peak: keys.word("peak")?.unwrap_or(usual.peak),
        };
        notes.extend(keys.unknown());
        Ok(entry)
    }

    /// The finder, once the height is known.
    pub(crate) fn finder(&self, height: f64) -> StripeFinder {
        let profile = StripeProfile { shape: self.shape, width: self.width, height };
        let usual = StripeFinder::new(profile);
        StripeFinder {
            least_height: self.least_height.unwrap_or(usual.least_height),
            median_rows: self.median_rows,
            peak: self.peak,
            ..usual
        }
    }
}
