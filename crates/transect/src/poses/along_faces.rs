//! Planes that run along a face of the scan, such as a floor just below a plane.
//!
//! **Problem.** An edge between the face and a surface that stands on it lies between two pixels,
//! one on each. A curve beside the face is found in such pairs. It cuts the corner, in each view by
//! another length. So views with right poses seem to err.
//!
//! **Idea.** A plane runs along a face if it is nearer to it than the pixels are apart there. Such
//! planes say nothing of poses.

use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_register::CoarseView;

/// Cosine of the largest angle between a face and a plane along it: 10°. Chosen by hand, as normals
/// of noisy patches scatter by so much. Doubled, ramps count as faces.
const PARALLEL: f64 = 0.985;

/// Least share of a view's patches in a face. Chosen by hand: the top of a table has 2 % and more.
/// Doubled, planes along table tops count as others.
const LEAST_SHARE: f64 = 0.02;

/// The planes along faces of some views; none along curved guides.
pub(crate) fn along_faces(copies: &[CoarseView], planes: &PlaneFamily) -> BTreeSet<PlaneIndex> {
    copies.iter().flat_map(|copy| along_faces_of(copy, planes)).collect()
}

fn along_faces_of(copy: &CoarseView, planes: &PlaneFamily) -> Vec<PlaneIndex> {
    let Some(guide) = planes.guide().straight() else { return Vec::new() };
    let pose = copy.world_from_sensor();
    let direction = pose.rotation.inverse_transform_vector(&guide.direction());
    let (mut counts, mut all) = (BTreeMap::new(), 0_usize);
    for (_, patch) in copy.patches() {
        all += 1;
        if patch.steady_normal().dot(&direction).abs() < PARALLEL {
            continue;
        }
        let spacing = 2.0 * patch.radius() / copy.step() as f64;
        let level = planes.level(&(pose * patch.point()));
        for plane in BTreeSet::from([level.floor() as i64, level.ceil() as i64]) {
            if (level - plane as f64).abs() * planes.interval() <= spacing {
                *counts.entry(PlaneIndex(plane)).or_insert(0_usize) += 1;
            }
        }
    }
    let least = LEAST_SHARE * all as f64;
    counts.into_iter().filter(|(_, count)| *count as f64 >= least).map(|(plane, _)| plane).collect()
}
