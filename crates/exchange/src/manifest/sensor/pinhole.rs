//! `pinhole`: a depth camera, with or without lens distortion.
//!
//! | key | meaning |
//! |---|---|
//! | `fx`, `fy`, `cx`, `cy` | focal lengths and principal point, in pixels |
//! | `distortion` | `[k1, k2, p1, p2, k3]`, radial and tangential (Brown, Conrady); optional |
//! | `rays` | instead of all these: a `.npy` of rows × cols × 3, the direction of every pixel's ray, NaN where there is none |
//! | `holds` | what pixels hold: `depth` along z (the default) or `ray_length` |
//!
//! Column j, row i without distortion: the ray ((j − cx)/fx, (i − cy)/fy, 1), y down. With it, that
//! is where the lens puts the ray; see the inversion's page for the equations.

use super::super::keys::Keys;
use super::super::word;
use crate::ReadError;
use serde::Serialize;
use transect_sensors::PinholeScale;

/// A depth camera, as manifests describe it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PinholeEntry {
    /// Where its pixels look.
    #[serde(flatten)]
    pub lens: LensEntry,
    /// What its pixels hold, in the length unit.
    #[serde(serialize_with = "word::write", skip_serializing_if = "is_usual")]
    pub holds: PinholeScale,
}

/// Where a camera's pixels look.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum LensEntry {
    /// A lens by its parameters; all but the distortion in pixels.
    Intrinsics {
        /// Focal length along columns.
        fx: f64,
        /// Focal length along rows.
        fy: f64,
        /// Column of the optical axis.
        cx: f64,
        /// Row of the optical axis.
        cy: f64,
        /// `[k1, k2, p1, p2, k3]` for image places in focal lengths; `None` for a straight lens.
        #[serde(skip_serializing_if = "Option::is_none")]
        distortion: Option<[f64; 5]>,
    },
    /// A ray per pixel.
    Rays {
        /// The `.npy` file with the rays, relative to the manifest or absolute.
        rays: String,
    },
}

/// The default, which need not be written.
fn is_usual(holds: &PinholeScale) -> bool {
    *holds == PinholeScale::default()
}

impl PinholeEntry {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, ReadError> {
        let lens = match keys.text("rays")? {
            Some(rays) => LensEntry::Rays { rays: rays.to_owned() },
            None => LensEntry::Intrinsics {
                fx: keys.required_number("fx")?,
                fy: keys.required_number("fy")?,
                cx: keys.required_number("cx")?,
                cy: keys.required_number("cy")?,
                distortion: distortion(keys)?,
            },
        };
        Ok(Self { lens, holds: keys.word("holds")?.unwrap_or_default() })
    }
}

fn distortion(keys: &Keys<'_>) -> Result<Option<[f64; 5]>, ReadError> {
    match keys.numbers::<5>("distortion")? {
        Some(k) if !k.iter().all(|k| k.is_finite()) => {
            Err(keys.wrong("distortion", "a list of 5 finite numbers"))
        }
        distortion => Ok(distortion),
    }
}
