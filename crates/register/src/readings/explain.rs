//! The reading of the poses, or of the images, under which all views agree.
//!
//! **Idea.** Under the right reading most patches of a view lie on a surface of another view, and
//! few lie in front of what another view measured. Under a wrong one it is the other way round.

use super::PoseReading;
use super::accord::{Accord, accord, probes_of};
use super::distances::best_factor;
use crate::coarse::CoarseView;
use crate::judge::pair::{Placing, Probe};
use std::fmt;
use transect_device::{ImageOrder, Isometry3, Vector3};

/// Share of agreeing patches, and of contradicting ones, with which poses need no explanation. No
/// unit. Measured on the bundled scenes and on real scans: sound poses have 0.6 and 0.05. Doubled,
/// the first never holds, and the second lets wrong readings of a symmetric room pass.
const SOUND: [f64; 2] = [0.5, 0.1];

/// The factor by which a reading must raise the share of agreeing patches, contradictions taken
/// off. No unit. Chosen by hand: wrong readings leave a tenth of it, in symmetric rooms two thirds.
/// Doubled, such rooms stay unexplained.
const BETTER: f64 = 1.25;

/// Largest share of contradicting patches under the reading. No unit. Chosen by hand: sound scans
/// have less than 0.1. Doubled, readings pass under which some views still contradict.
const CONTRADICTS: f64 = 0.2;

/// Least share of agreeing patches under the reading. No unit. Chosen by hand: half of what sound
/// scans have. Halved, two views that have nothing in common find a reading.
const AGREES: f64 = 0.25;

/// Distance between two sensors whose positions may be read in a unit a thousand times too large,
/// over the longest distance of a patch. No unit. Theory: stations share surface within twice that
/// distance. Doubled, views of hand-held cameras that move little stay unexplained.
const FAR_APART: f64 = 10.0;

/// Share of the distances between sensors that a reading leaves, below which it brings them
/// together. No unit. Theory: views from around a thing that look at its middle all stand in one
/// place where their poses are inverted, up to how their distances from it differ. Round things
/// agree there. Doubled, readings of views that stand close together are no longer tried where
/// nothing contradicts.
const TOGETHER: f64 = 0.2;

/// A part of a scan that may have been read wrongly.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Reading {
    /// The poses are written by another convention.
    Pose(PoseReading),
    /// The pixels of the images are stored in another order.
    Image(ImageOrder),
    /// The distances of all images, times this factor, fit the positions of the poses.
    Distances(f64),
}

impl Reading {
    /// The assumption of the reading about the scan, as a sentence without a full stop.
    pub fn meaning(self) -> String {
        match self {
            Self::Pose(reading) => reading.meaning().to_owned(),
            Self::Image(order) => order.meaning().to_owned(),
            Self::Distances(factor) => {
                format!("the distances in all images are {factor} times as large")
            }
        }
    }
}

impl fmt::Display for Reading {
    /// The setting that applies it, if there is one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pose(reading) => write!(f, "the setting `pose_convention` {reading}"),
            Self::Image(order) => write!(f, "the setting `image_order` {order}"),
            Self::Distances(factor) => write!(f, "distances times {factor}"),
        }
    }
}

/// A reading under which the views agree.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Explanation {
    /// The reading.
    pub reading: Reading,
    /// How far the views agree at the poses as given.
    pub given: Accord,
    /// The same under the reading.
    pub read: Accord,
}

impl Explanation {
    /// Whether views that have been refined agree about as well as under the reading. If they do
    /// not, the refinement did not find what the reading explains.
    pub fn is_matched_by(&self, refined: &[CoarseView]) -> bool {
        let all: Vec<&CoarseView> = refined.iter().collect();
        let found = accord(&all, &probes_of(&all), Placing::given);
        BETTER * found.score() >= self.read.score()
    }
}

/// The reading under which the views agree far better than as given; `None` if they agree as given,
/// or under no reading.
///
/// `reread` makes copies of all views whose images are read in another order; `None` where the
/// sensors have one order only. It is called only where the views contradict each other.
pub fn explain(
    views: &[CoarseView],
    reread: impl Fn(ImageOrder) -> Option<Vec<CoarseView>>,
) -> Option<Explanation> {
    let all: Vec<&CoarseView> = views.iter().collect();
    let probes = probes_of(&all);
    let given = accord(&all, &probes, Placing::given);
    if given.agreeing >= SOUND[0] && given.contradicting <= SOUND[1] {
        return None;
    }
    // Only cameras have a y axis that may point up; a room between floor and ceiling is nearly the
    // same upside down.
    let cameras = views.iter().all(CoarseView::looks_forward);
    let far_apart = is_far_apart(&all, &probes);
    let of_all = |reading: &PoseReading| match reading {
        PoseReading::CameraYUp => cameras,
        PoseReading::Millimetres => far_apart,
        reading => far_apart || given.contradicting > SOUND[1] || !brings_together(*reading, &all),
    };
    let of_poses = PoseReading::ALL.into_iter().filter(of_all).map(|reading| {
        let read = accord(&all, &probes, |view| Placing {
            world_from_sensor: reading.apply(view.world_from_sensor()),
            scale: 1.0,
        });
        (Reading::Pose(reading), read)
    });
    let of_images = ImageOrder::ALL.into_iter().filter_map(|order| {
        let views = reread(order)?;
        let views: Vec<&CoarseView> = views.iter().collect();
        Some((Reading::Image(order), accord(&views, &probes_of(&views), Placing::given)))
    });
    let of_distances =
        best_factor(&all, &probes, BETTER).map(|(factor, read)| (Reading::Distances(factor), read));
    let explains = |(_, read): &(Reading, Accord)| {
        let sound = read.agreeing >= AGREES && read.contradicting <= CONTRADICTS;
        sound && read.score() > BETTER * given.score()
    };
    let readings = of_poses.chain(of_images).chain(of_distances).filter(explains);
    // Of equal ones the first.
    let best =
        readings.reduce(|best, next| if next.1.score() > best.1.score() { next } else { best });
    best.map(|(reading, read)| Explanation { reading, given, read })
}

/// Whether a reading brings the sensors [`TOGETHER`].
fn brings_together(reading: PoseReading, views: &[&CoarseView]) -> bool {
    let size = |of: &dyn Fn(&Isometry3) -> Isometry3| {
        let places = views.iter().map(|view| of(view.world_from_sensor()).translation.vector);
        let places: Vec<Vector3> = places.collect();
        let middle = places.iter().sum::<Vector3>() / places.len().max(1) as f64;
        places.iter().map(|place| (place - middle).norm_squared()).sum::<f64>().sqrt()
    };
    size(&|pose| reading.apply(pose)) < TOGETHER * size(&|pose| *pose)
}

/// Whether any two sensors are [`FAR_APART`]. If not, positions a thousand times smaller put all
/// sensors into one place, where tunnels agree whatever their poses are.
fn is_far_apart(views: &[&CoarseView], probes: &[Vec<Probe>]) -> bool {
    let reach = probes.iter().flatten().map(|probe| probe.point.coords.norm()).fold(0.0, f64::max);
    let places = || views.iter().map(|view| view.world_from_sensor().translation.vector);
    places().any(|a| places().any(|b| (a - b).norm() > FAR_APART * reach))
}
