//! A note on planes that lie in a face of the scan, such as a floor at the height of plane 0.
//!
//! The section of a solid jumps there, and curves follow the noise of the face.

use crate::samples::{coarse_samples, pixel_spacing};
use crate::table::digits;
use std::collections::{BTreeMap, BTreeSet};
use transect_device::{Note, View};
use transect_geometry::{PlaneFamily, PlaneIndex};

/// Cosine of the largest angle between a face and a plane in it: 10°. Chosen by hand: normals of
/// samples 1/64 of an image apart scatter by so much. Doubled, ramps count as faces.
const PARALLEL: f64 = 0.985;

/// Half the thickness of a face without stated noise, over the distance of its pixels. Chosen by
/// hand: at this share the floor of a room with 2 mm of noise and pixels 26 mm apart is found.
/// Doubled, planes just above a floor are told of.
const THICKNESS: f64 = 0.1;

/// Standard deviations of stated noise that are half the thickness of a face. Theory: all but one
/// point in 400.
const DEVIATIONS: f64 = 3.0;

/// Least distance of planes, over half the thickness of a face. Chosen by hand: denser planes meet
/// every face that is parallel to them, wherever they begin. Doubled, planes 5 cm apart in a scan
/// with 1 mm of noise are not looked at.
const LEAST_INTERVAL: f64 = 10.0;

/// Least share of a view's samples in a face. Chosen by hand: the top of a table has 2 % and more.
/// Doubled, table tops are not told of.
const LEAST_SHARE: f64 = 0.02;

/// Parts of the interval by which planes are moved on trial, best ones first behind 0.
const MOVES: [f64; 4] = [0.0, 0.5, 0.25, 0.75];

/// The planes in faces of a view.
pub(crate) struct InFaces {
    view: String,
    /// For planes moved by each of [`MOVES`]: the planes, and the share of the view's samples in
    /// each.
    moved: [BTreeMap<PlaneIndex, f64>; 4],
}

impl InFaces {
    /// Those of a view; none along curved guides.
    pub fn of(view: &View, planes: &PlaneFamily) -> Self {
        let moved = MOVES.map(|part| shares(view, planes, part));
        Self { view: view.name().to_owned(), moved }
    }
}

/// The note on planes in faces of some views; `None` without such planes.
pub(crate) fn in_faces(views: &[InFaces], planes: &PlaneFamily) -> Option<Note> {
    let own = views.iter().flat_map(|v| v.moved[0].iter().map(|(k, share)| (*k, *share, &v.view)));
    let (plane, share, view) = own.clone().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let others: BTreeSet<PlaneIndex> = own.map(|(k, ..)| k).filter(|k| *k != plane).collect();
    let others: Vec<String> = others.iter().map(ToString::to_string).collect();
    let others = match others.is_empty() {
        true => String::new(),
        false => format!(" (others in faces: {})", others.join(", ")),
    };
    let is_free = |k: &usize| views.iter().all(|v| v.moved[*k].is_empty());
    let advice = (1..MOVES.len()).find(is_free).map_or_else(String::new, |k| {
        let interval = planes.interval();
        let decimals = (2.0 - interval.log10().floor()).clamp(0.0, 12.0) as usize;
        let offset = planes.offset() + MOVES[k] * interval;
        format!(", such as by the setting `offset` {offset:.decimals$}")
    });
    Some(Note::new(format!(
        "plane {plane} lies in a face, {} % of the surface that view {view} sees{others}. The \
         section jumps there, and its curves follow the noise. Move the planes{advice}",
        digits(100.0 * share),
    )))
}

/// The planes in faces of a view, moved by a part of the interval, and the share of its samples in
/// each.
fn shares(view: &View, planes: &PlaneFamily, part: f64) -> BTreeMap<PlaneIndex, f64> {
    let (Some([spacing, _]), Some(guide)) = (pixel_spacing(view), planes.guide().straight()) else {
        return BTreeMap::new();
    };
    let half = view.sigma().map_or(THICKNESS * spacing, |sigma| DEVIATIONS * sigma);
    if planes.interval() < LEAST_INTERVAL * half {
        return BTreeMap::new();
    }
    let pose = view.world_from_sensor();
    let direction = pose.rotation.inverse_transform_vector(&guide.direction());
    let (mut counts, mut all) = (BTreeMap::new(), 0_usize);
    for sample in coarse_samples(view) {
        all += 1;
        let normal = sample.right.cross(&sample.below).try_normalize(0.0);
        let is_parallel = normal.is_some_and(|normal| normal.dot(&direction).abs() >= PARALLEL);
        let level = planes.level(&(pose * sample.point)) - part;
        let off = (level - level.round()).abs() * planes.interval();
        if is_parallel && off <= half {
            *counts.entry(PlaneIndex(level.round() as i64)).or_insert(0_usize) += 1;
        }
    }
    let shares = counts.into_iter().map(|(plane, count)| (plane, count as f64 / all as f64));
    shares.filter(|(_, share)| *share >= LEAST_SHARE).collect()
}
