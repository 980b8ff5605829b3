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
//! * a stack of the camera's intensity images, one per laser angle. It is a `.npy` of angles ×
//!   camera rows × camera columns of type `u1` or `u2`, or a folder of grey `.png` files. These
//!   have 8 or 16 bits, and are read in the order of their names. The stripe is found on loading;
//!   rows without one are missing.

use super::super::keys::{Keys, UnknownKey};
use super::Sensor;
use super::shared::Shared;
use super::stripe::StripeEntry;
use crate::ReadError;
use crate::image_stack::ImageStack;
use crate::scan::FramedImage;
use crate::view_file::ViewFile;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{ImageSize, RangeImage};
use transect_sensors::light_stripe::stripe::StripeStack;
use transect_sensors::{LaserAngles, LightStripe, LightStripeParameters};

/// A light-stripe range finder, as manifests describe it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightStripeEntry {
    /// Camera, optics and mirror. Its own angles are not used; `angles` has them.
    #[serde(flatten)]
    pub parameters: LightStripeParameters,
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

impl LightStripeEntry {
    /// The entry of a range finder, with its angles listed.
    pub fn new(parameters: &LightStripeParameters, stripe: Option<StripeEntry>) -> Self {
        let theta_laser = parameters.theta_laser.as_radians().to_vec();
        let parameters =
            LightStripeParameters { theta_laser: LaserAngles::default(), ..parameters.clone() };
        Self { parameters, angles: AnglesEntry::Listed { theta_laser }, stripe }
    }

    /// The range finder's parameters for an image of `columns` laser angles.
    pub(super) fn parameters(&self, columns: usize) -> LightStripeParameters {
        let radians = match &self.angles {
            AnglesEntry::Steps { theta0, dtheta } => {
                (0..columns).map(|j| theta0 + j as f64 * dtheta).collect()
            }
            AnglesEntry::Listed { theta_laser } => theta_laser.clone(),
        };
        let theta_laser = LaserAngles::from_radians(radians);
        LightStripeParameters { theta_laser, ..self.parameters.clone() }
    }

    /// The range finder. Its frame is made when the number of columns is known.
    pub(super) fn sensor(&self) -> LightStripeSensor {
        LightStripeSensor { entry: self.clone(), frames: Shared::default() }
    }

    pub(super) fn read(keys: &Keys<'_>, unknown: &mut Vec<UnknownKey>) -> Result<Self, ReadError> {
        let parameters = keys.fields()?;
        let stripe = keys.object("stripe", "stripe.")?;
        let read = |keys: Keys<'_>| {
            let stripe = keys.fields()?;
            unknown.extend(keys.unknown());
            Ok(stripe)
        };
        let wanted = "a number of radians, unless \"theta_laser\" lists all angles";
        let angles = match keys.optional("theta_laser")? {
            Some(theta_laser) => AnglesEntry::Listed { theta_laser },
            None => AnglesEntry::Steps {
                theta0: keys.required("theta0", wanted)?,
                dtheta: keys.required("dtheta", wanted)?,
            },
        };
        Ok(Self { parameters, angles, stripe: stripe.map(read).transpose()? })
    }
}

#[derive(Debug)]
pub(super) struct LightStripeSensor {
    entry: LightStripeEntry,
    frames: Shared<LightStripe>,
}

impl Sensor for LightStripeSensor {
    fn image_files(&self, path: &Path) -> Result<Vec<PathBuf>, ReadError> {
        if path.is_dir() { ImageStack::files_of_folder(path) } else { Ok(vec![path.to_owned()]) }
    }

    fn load(&self, file: &ViewFile, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        match ImageStack::open(&file.path, self.entry.parameters.camera(), notes)? {
            Some(stack) => self.load_stack(file, &stack, notes),
            None => self.load_places(file, notes),
        }
    }
}

impl LightStripeSensor {
    /// Finds the stripe in a stack of the camera's images.
    fn load_stack(
        &self,
        file: &ViewFile,
        stack: &ImageStack,
        notes: &mut Vec<String>,
    ) -> Result<FramedImage, ReadError> {
        let (rows, steps) = (self.entry.parameters.camera_rows, stack.steps());
        self.check_columns(file, "the stack", "images", steps)?;
        file.check_size(ImageSize { rows, cols: steps })?;
        let frame = self.frame(file, steps)?;
        let image = self.extract(file, stack, &frame, notes)?;
        Ok(FramedImage { frame, image })
    }

    /// Reads an image that holds the stripe's places.
    fn load_places(
        &self,
        file: &ViewFile,
        notes: &mut Vec<String>,
    ) -> Result<FramedImage, ReadError> {
        let image = file.load_image(notes)?;
        let (ImageSize { rows, cols }, wanted) = (image.size(), self.entry.parameters.camera_rows);
        self.check_columns(file, "the image", "columns", cols)?;
        if rows != wanted {
            let problem = format!("the image has {rows} rows, but \"camera_rows\" is {wanted}");
            return Err(file.damaged(problem));
        }
        if self.entry.stripe.is_some() {
            notes.push("\"stripe\" is not used: the image is no stack".to_owned());
        }
        Ok(FramedImage { frame: self.frame(file, cols)?, image })
    }

    /// Refuses a number of columns that differs from the number of listed angles.
    fn check_columns(
        &self,
        file: &ViewFile,
        what: &str,
        parts: &str,
        found: usize,
    ) -> Result<(), ReadError> {
        match &self.entry.angles {
            AnglesEntry::Listed { theta_laser } if theta_laser.len() != found => {
                let angles = theta_laser.len();
                Err(file.damaged(format!(
                    "{what} has {found} {parts}, but \"theta_laser\" has {angles} angles"
                )))
            }
            _ => Ok(()),
        }
    }

    fn frame(&self, file: &ViewFile, columns: usize) -> Result<Arc<LightStripe>, ReadError> {
        let size = ImageSize { rows: self.entry.parameters.camera_rows, cols: columns };
        self.frames.get_or_make(size, || {
            LightStripe::new(self.entry.parameters(columns)).map_err(|e| file.bad_sensor(e))
        })
    }

    fn extract(
        &self,
        file: &ViewFile,
        stack: &ImageStack,
        frame: &LightStripe,
        notes: &mut Vec<String>,
    ) -> Result<RangeImage, ReadError> {
        let bad = |e| file.unusable("\"stripe\"", e);
        let stripe = self.entry.stripe.unwrap_or_default();
        let finder =
            stripe.bounded(self.entry.parameters.camera()).map_err(bad)?.measured(stack, notes)?;
        let mut found = StripeStack::new(frame, finder).map_err(bad)?;
        stack.for_each(|at, image| {
            found.push(&image).map_err(|e| ReadError::unusable(at.path, at.place, "the image", e))
        })?;
        found.finish().map_err(bad)
    }
}
