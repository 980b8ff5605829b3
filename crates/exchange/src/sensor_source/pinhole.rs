//! Depth cameras: straight ones, distorted ones, and those given by a ray per pixel.

use super::shared::Shared;
use super::{Loaded, distortion};
use crate::manifest::{LensEntry, PinholeEntry};
use crate::{Place, ReadError, ScanView, image_file};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{ImageSize, Vector3};
use transect_sensors::{Intrinsics, Pinhole, PinholeScale, RayTable};

#[derive(Debug)]
pub(crate) struct PinholeSource {
    lens: Lens,
    holds: PinholeScale,
    tables: Shared<RayTable>,
}

#[derive(Debug)]
enum Lens {
    Straight(Intrinsics),
    Distorted(Intrinsics, [f64; 5]),
    Rays(PathBuf),
}

impl PinholeSource {
    pub(super) fn new(folder: &Path, entry: &PinholeEntry) -> Self {
        let lens = match &entry.lens {
            LensEntry::Rays { rays } => Lens::Rays(folder.join(rays)),
            &LensEntry::Intrinsics { fx, fy, cx, cy, distortion } => {
                let intrinsics = Intrinsics { fx, fy, cx, cy };
                // Without distortion, the closed form is faster and finds pixels between rays.
                match distortion.filter(|k| k.iter().any(|k| *k != 0.0)) {
                    Some(distortion) => Lens::Distorted(intrinsics, distortion),
                    None => Lens::Straight(intrinsics),
                }
            }
        };
        Self { lens, holds: entry.holds, tables: Shared::new() }
    }

    /// The file with the rays, if there is one.
    pub(super) fn file(&self) -> Option<&Path> {
        match &self.lens {
            Lens::Rays(path) => Some(path),
            _ => None,
        }
    }

    pub(super) fn load(
        &self,
        view: &ScanView,
        notes: &mut Vec<String>,
    ) -> Result<Loaded, ReadError> {
        let image = view.load_image(notes)?;
        let size = image.size();
        let straight = |intrinsics| {
            let camera = Pinhole::new(size, intrinsics).map_err(|e| view.bad_sensor(e))?;
            Ok(camera.with_scale(self.holds))
        };
        match &self.lens {
            Lens::Straight(intrinsics) => Ok((Arc::new(straight(*intrinsics)?), image)),
            Lens::Distorted(intrinsics, distortion) => {
                straight(*intrinsics)?;
                let make = || self.distorted(view, size, *intrinsics, *distortion);
                Ok((self.tables.get_or_make(size, make)?, image))
            }
            Lens::Rays(path) => {
                let make = || self.by_rays(view, size, path);
                Ok((self.tables.get_or_make(size, make)?, image))
            }
        }
    }

    fn distorted(
        &self,
        view: &ScanView,
        size: ImageSize,
        intrinsics: Intrinsics,
        distortion: [f64; 5],
    ) -> Result<RayTable, ReadError> {
        let rays = distortion::rays(size, intrinsics, distortion).map_err(|pixel| {
            let problem = "\"distortion\" cannot be inverted here: no ray, or more than one, is \
                           bent onto this pixel";
            ReadError::damaged(view.path(), Place::Pixel(pixel), problem)
        })?;
        RayTable::new(size, rays, self.holds).map_err(|e| view.bad_sensor(e))
    }

    fn by_rays(
        &self,
        view: &ScanView,
        size: ImageSize,
        path: &Path,
    ) -> Result<RayTable, ReadError> {
        let (found, rays) = image_file::read_points(path)?;
        if found != size {
            let image = view.path().display();
            let problem = format!("\"rays\" has {found}, but the image {image} has {size}");
            return Err(ReadError::damaged(path, Place::Whole, problem));
        }
        let rays: Vec<Vector3> = rays.into_iter().map(|r| r.coords).collect();
        RayTable::new(size, rays, self.holds)
            .map_err(|e| ReadError::unusable(path, Place::Whole, "\"rays\"", e))
    }
}
