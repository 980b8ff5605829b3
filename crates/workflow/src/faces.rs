//! A note on planes that lie in a face of the scan, such as a floor at the height of plane 0.
//!
//! The section of a solid jumps there, and curves follow the noise of the face.

use crate::samples::{coarse_samples, pixel_spacing};
use crate::table::digits;
use crate::views::FileView;
use std::collections::BTreeMap;
use transect_device::View;
use transect_geometry::{PlaneFamily, PlaneIndex};

/// Cosine of the largest angle between a face and a plane in it: 10°. Chosen by hand: normals of
/// samples 1/64 of an image apart scatter by so much. Doubled, ramps count as faces.
const PARALLEL: f64 = 0.985;

/// Half the thickness of a face without stated noise, over the distance of its pixels. Chosen by
/// hand: scanners sample a few times coarser than they measure. Doubled, planes just above a floor
/// are told of.
const THICKNESS: f64 = 0.1;

/// Standard deviations of stated noise that are half the thickness of a face. Theory: all but one
/// point in 400.
const DEVIATIONS: f64 = 3.0;

/// Least distance of planes, over half the thickness of a face. Chosen by hand: denser planes meet
/// every face that is parallel to them, wherever they begin.
const LEAST_INTERVAL: f64 = 10.0;

/// Least share of a view's samples in a face. Chosen by hand: the top of a table has 2 % and more.
/// Doubled, table tops are not told of.
const LEAST_SHARE: f64 = 0.02;

/// The note on planes in faces, from the views that have been read already; `None` without such
/// planes.
pub(crate) fn in_faces(views: &[FileView<'_>], planes: &PlaneFamily) -> Option<String> {
    let mut found: BTreeMap<PlaneIndex, (f64, &str)> = BTreeMap::new();
    for view in views {
        let read = view.read.lock().ok();
        let Some((read, _)) = read.as_ref().and_then(|read| read.as_ref()) else { continue };
        for (plane, share) in shares(read, planes) {
            let largest = found.entry(plane).or_insert((share, view.view.name()));
            if share > largest.0 {
                *largest = (share, view.view.name());
            }
        }
    }
    let (plane, (share, view)) = found.iter().max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0))?;
    let all: Vec<String> = found.keys().map(ToString::to_string).collect();
    Some(format!(
        "planes lie in faces of the scan, where the section jumps and curves follow the noise: {}. \
         {} % of the surface that view {view} sees lies in plane {plane}. Move the planes, such as \
         by --offset {}",
        all.join(", "),
        digits(100.0 * share),
        digits(planes.offset() + 0.5 * planes.interval())
    ))
}

/// The planes in faces of a view, and the share of its samples in each.
fn shares(view: &View, planes: &PlaneFamily) -> Vec<(PlaneIndex, f64)> {
    let (Some([spacing, _]), Some(guide)) = (pixel_spacing(view), planes.guide().straight()) else {
        return Vec::new();
    };
    let half = view.sigma().map_or(THICKNESS * spacing, |sigma| DEVIATIONS * sigma);
    if planes.interval() < LEAST_INTERVAL * half {
        return Vec::new();
    }
    let pose = view.world_from_sensor();
    let direction = pose.rotation.inverse_transform_vector(&guide.direction());
    let (mut counts, mut all) = (BTreeMap::new(), 0_usize);
    for sample in coarse_samples(view) {
        all += 1;
        let normal = sample.right.cross(&sample.below).try_normalize(0.0);
        let is_parallel = normal.is_some_and(|normal| normal.dot(&direction).abs() >= PARALLEL);
        let level = planes.level(&(pose * sample.point));
        let off = (level - level.round()).abs() * planes.interval();
        if is_parallel && off <= half {
            *counts.entry(PlaneIndex(level.round() as i64)).or_insert(0_usize) += 1;
        }
    }
    let shares = counts.into_iter().map(|(plane, count)| (plane, count as f64 / all as f64));
    shares.filter(|(_, share)| *share >= LEAST_SHARE).collect()
}
