//! A note on planes that lie in a face of the scan, such as a floor at the height of plane 0.
//!
//! The section of a solid jumps there, and curves follow the noise of the face.

use crate::samples::{Sample, coarse_samples, pixel_spacing};
use crate::table::digits;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use transect_device::{Note, View, quantile};
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

/// Share of a view's samples at each end of its extent that is left out. Chosen by hand: outliers
/// and distant background. Doubled, low rooms lose their floor's share.
const TAIL: f64 = 0.01;

/// Layers of the extent among which a place far from faces is sought. Chosen by hand: the place is
/// 5 % of the extent from the best one at most. Doubled, a noisy face has several layers.
const LAYERS: usize = 20;

/// The planes in faces of a view.
pub(crate) struct InFaces {
    view: String,
    /// For planes moved by each of [`MOVES`]: the planes, and the share of the view's samples in
    /// each.
    moved: [BTreeMap<PlaneIndex, f64>; 4],
    /// Lowest and highest level of the samples, without [`TAIL`]; `None` without samples.
    extent: Option<[f64; 2]>,
    /// For each sample that is parallel to the planes, its level and its share of the samples.
    parallel: Vec<(f64, f64)>,
}

impl InFaces {
    /// Those of a view; none along curved guides.
    pub fn of(view: &View, planes: &PlaneFamily) -> Self {
        let levels = levels(view, planes);
        let moved = MOVES.map(|part| shares(view, planes, &levels, part));
        let all: Vec<f64> = levels.iter().map(|(level, _)| *level).collect();
        let end = |share| quantile(all.clone(), share);
        let extent = end(TAIL).zip(end(1.0 - TAIL)).map(<[f64; 2]>::from);
        let share = 1.0 / all.len().max(1) as f64;
        let parallel = levels.iter().filter(|(_, is_parallel)| *is_parallel);
        let parallel = parallel.map(|(level, _)| (*level, share)).collect();
        Self { view: view.name().to_owned(), moved, extent, parallel }
    }
}

/// The note on planes in faces of some views; `None` without such planes.
pub(crate) fn in_faces(views: &[InFaces], planes: &PlaneFamily) -> Option<Note> {
    let own = views.iter().flat_map(|v| v.moved[0].iter().map(|(k, share)| (*k, *share, &v.view)));
    let (plane, share, view) = own.clone().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let others: BTreeSet<PlaneIndex> = own.map(|(k, ..)| k).filter(|k| *k != plane).collect();
    let others: Vec<String> = others.iter().map(ToString::to_string).collect();
    let others = match others.as_slice() {
        [] => String::new(),
        [other] => format!(" So does plane {other}."),
        _ => format!(" So do the planes {}.", others.join(", ")),
    };
    let advice = clear_offset(views, planes)
        .map_or_else(String::new, |offset| format!(", such as by the setting `offset` {offset}"));
    Some(Note::new(format!(
        "plane {plane} lies in a face, {} % of the surface that view {view} sees.{others} The \
         section jumps there, and its curves follow the noise. Move the planes{advice}",
        digits(100.0 * share),
    )))
}

/// An offset at which a plane crosses the views and none lies in a face, as few digits; `None`
/// without samples.
fn clear_offset(views: &[InFaces], planes: &PlaneFamily) -> Option<String> {
    let extents = views.iter().filter_map(|v| v.extent);
    let [low, high] = extents.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    // Plane k is moved to the level k + part.
    let crosses = |part: f64| (low - part).floor() + 1.0 + part < high;
    let is_clear = |k: &usize| crosses(MOVES[*k]) && views.iter().all(|v| v.moved[*k].is_empty());
    let (level, step) = match (1..MOVES.len()).find(is_clear) {
        Some(k) => (MOVES[k], 1.0),
        None if low < high => (far_from_faces(views, [low, high]), high - low),
        None => return None,
    };
    let step = step * planes.interval();
    let decimals = (2.0 - step.log10().floor()).clamp(0.0, 12.0) as usize;
    Some(format!("{:.decimals$}", planes.offset() + level * planes.interval()))
}

/// The level within an extent that is farthest from faces and from the ends; of equal ones, the
/// nearest to the middle.
fn far_from_faces(views: &[InFaces], [low, high]: [f64; 2]) -> f64 {
    let thickness = (high - low) / LAYERS as f64;
    // The layers beyond the ends count as faces.
    let mut has_face = [false; LAYERS + 2];
    [has_face[0], has_face[LAYERS + 1]] = [true; 2];
    for view in views {
        let mut shares = [0.0; LAYERS + 2];
        for (level, share) in &view.parallel {
            let layer = ((level - low) / thickness).floor() + 1.0;
            shares[layer.clamp(0.0, LAYERS as f64 + 1.0) as usize] += share;
        }
        let found = shares.iter().map(|share| *share >= LEAST_SHARE);
        has_face.iter_mut().zip(found).for_each(|(layer, found)| *layer |= found);
    }
    let distance = |layer: &usize| {
        let faces = (0..has_face.len()).filter(|k| has_face[*k]);
        let nearest = faces.map(|k| k.abs_diff(*layer)).min().unwrap_or(0);
        (nearest, Reverse((2 * layer).abs_diff(LAYERS + 1)))
    };
    let layer = (1..=LAYERS).max_by_key(distance).unwrap_or(1);
    low + (layer as f64 - 0.5) * thickness
}

/// The level of each sample of a view, and whether its surface is parallel to the planes; none
/// along curved guides.
fn levels(view: &View, planes: &PlaneFamily) -> Vec<(f64, bool)> {
    let Some(guide) = planes.guide().straight() else { return Vec::new() };
    let pose = view.world_from_sensor();
    let direction = pose.rotation.inverse_transform_vector(&guide.direction());
    let of_sample = |sample: Sample| {
        let normal = sample.right.cross(&sample.below).try_normalize(0.0);
        let is_parallel = normal.is_some_and(|normal| normal.dot(&direction).abs() >= PARALLEL);
        (planes.level(&(pose * sample.point)), is_parallel)
    };
    coarse_samples(view).map(of_sample).collect()
}

/// The planes in faces of a view, moved by a part of the interval, and the share of its samples in
/// each. `levels` are those of its samples.
fn shares(
    view: &View,
    planes: &PlaneFamily,
    levels: &[(f64, bool)],
    part: f64,
) -> BTreeMap<PlaneIndex, f64> {
    let Some([spacing, _]) = pixel_spacing(view) else { return BTreeMap::new() };
    let half = view.sigma().map_or(THICKNESS * spacing, |sigma| DEVIATIONS * sigma);
    if planes.interval() < LEAST_INTERVAL * half {
        return BTreeMap::new();
    }
    let mut counts = BTreeMap::new();
    for (level, _) in levels.iter().filter(|(_, is_parallel)| *is_parallel) {
        let level = level - part;
        let off = (level - level.round()).abs() * planes.interval();
        if off <= half {
            *counts.entry(PlaneIndex(level.round() as i64)).or_insert(0_usize) += 1;
        }
    }
    let all = levels.len() as f64;
    let shares = counts.into_iter().map(|(plane, count)| (plane, count as f64 / all));
    shares.filter(|(_, share)| *share >= LEAST_SHARE).collect()
}
