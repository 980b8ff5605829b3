//! The reading of the poses, or of the images, under which all views agree.
//!
//! **Idea.** Under the right reading most patches of a view lie on a surface of another view, and
//! few lie in front of what another view measured. Under a wrong one it is the other way round.

use super::PoseReading;
use super::accord::{Accord, accord, accord_of, probes_of};
use super::distances::best_factor;
use crate::coarse::CoarseView;
use crate::judge::pair::{Placing, Probe};
use std::fmt;
use transect_device::{ImageOrder, Isometry3, PinholeScale, Vector3};

/// Share of agreeing patches, and of contradicting ones, with which poses need no other reading. No
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// The poses are written by another convention.
    Pose(PoseReading),
    /// The poses are right as the file states them. A convention that the user gave changed them.
    AsStated,
    /// The pixels of the images are stored in another order.
    Image(ImageOrder),
    /// The pixels of all images hold this length, where they were read as the other one.
    PixelsHold(PinholeScale),
    /// The distances of all images, times this factor, fit the positions of the poses.
    Distances(f64),
}

impl Reading {
    /// The assumption of the reading about the scan, as a sentence without a full stop.
    pub fn meaning(self) -> String {
        match self {
            Self::Pose(reading) => reading.meaning().to_owned(),
            Self::AsStated => "the poses are as the file states them".to_owned(),
            Self::Image(order) => order.meaning().to_owned(),
            Self::PixelsHold(scale) => scale.meaning().to_owned(),
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
            Self::AsStated => f.write_str("no setting `pose_convention`"),
            Self::Image(order) => write!(f, "the setting `image_order` {order}"),
            Self::PixelsHold(scale) => write!(f, "the setting `pixels_hold` {scale}"),
            Self::Distances(factor) => write!(f, "distances times {factor}"),
        }
    }
}

impl serde::Serialize for Reading {
    fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Pose(reading) => reading.serialize(out),
            Self::AsStated => out.serialize_str("as-stated"),
            Self::Image(order) => order.serialize(out),
            Self::PixelsHold(scale) => out.serialize_str(scale.name()),
            Self::Distances(factor) => out.serialize_f64(*factor),
        }
    }
}

/// A convention that the user gave, and the poses of all views before it was applied.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedPoses {
    /// The convention.
    pub reading: PoseReading,
    /// World from sensor, as the file states it, in the order of the views. A list of another
    /// length is not used.
    pub poses: Vec<Isometry3>,
}

/// A reading under which the views agree.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FoundReading {
    /// The reading.
    pub reading: Reading,
    /// How far the views agree at the poses as given.
    pub given: Accord,
    /// The same under the reading.
    pub read: Accord,
}

impl FoundReading {
    /// Whether views that have been refined agree about as well as under the reading. If they do
    /// not, the refinement did not find what the reading explains.
    ///
    /// Refinement takes the wrong meaning of pixels for an error of the camera, and bends the poses
    /// to the rest. It never matches a reading of that kind.
    pub fn is_matched_by(&self, refined: &[CoarseView]) -> bool {
        if matches!(self.reading, Reading::PixelsHold(_)) {
            return false;
        }
        let all: Vec<&CoarseView> = refined.iter().collect();
        let found = accord(&all, &probes_of(&all), Placing::given);
        BETTER * found.score() >= self.read.score()
    }
}

/// The reading under which the views agree far better than as given; `None` if they agree as given,
/// or under no reading.
///
/// `stated` is the convention by which the poses of the views were read; `None` if they were read
/// as the file states them. Other conventions are then applied to the poses of the file, and the
/// poses of the file are a reading, too.
///
/// `reread` makes copies of all views whose images are read by [`Reading::Image`] or
/// [`Reading::PixelsHold`]; `None` where the sensors allow no such reading. It is called only where
/// the views contradict each other.
pub fn find_reading(
    views: &[CoarseView],
    stated: Option<&StatedPoses>,
    reread: impl Fn(Reading) -> Option<Vec<CoarseView>>,
) -> Option<FoundReading> {
    let all: Vec<&CoarseView> = views.iter().collect();
    let probes = probes_of(&all);
    let given = accord(&all, &probes, Placing::given);
    if given.agreeing >= SOUND[0] && given.contradicting <= SOUND[1] {
        return None;
    }
    let stated = stated.filter(|stated| stated.poses.len() == views.len());
    let of_poses = of_poses(&all, &probes, given, stated);
    let orders = ImageOrder::ALL.into_iter().map(Reading::Image);
    let of_images = orders.chain(PinholeScale::ALL.map(Reading::PixelsHold));
    let of_images = of_images.filter_map(|reading| {
        let views = reread(reading)?;
        let views: Vec<&CoarseView> = views.iter().collect();
        Some((reading, accord(&views, &probes_of(&views), Placing::given)))
    });
    let of_distances =
        best_factor(&all, &probes, BETTER).map(|(factor, read)| (Reading::Distances(factor), read));
    let explains = |(_, read): &(Reading, Accord)| {
        let sound = read.agreeing >= AGREES && read.contradicting <= CONTRADICTS;
        sound && read.score() > BETTER * given.score()
    };
    let readings = of_poses.into_iter().chain(of_images).chain(of_distances).filter(explains);
    // Of equal ones the first. The poses of the file give way as given poses do.
    let better = |best: (Reading, Accord), next: (Reading, Accord)| {
        let factor = if best.0 == Reading::AsStated { BETTER } else { 1.0 };
        if next.1.score() > factor * best.1.score() { next } else { best }
    };
    let best = readings.reduce(better);
    best.map(|(reading, read)| FoundReading { reading, given, read })
}

/// How far the views agree under each reading of their poses. A reading that the user gave is left
/// out: it is what contradicts.
fn of_poses(
    views: &[&CoarseView],
    probes: &[Vec<Probe>],
    given: Accord,
    stated: Option<&StatedPoses>,
) -> Vec<(Reading, Accord)> {
    let own = || views.iter().map(|view| *view.world_from_sensor()).collect();
    let poses: Vec<Isometry3> = stated.map_or_else(own, |stated| stated.poses.clone());
    let accord_at = |of: &dyn Fn(&Isometry3) -> Isometry3| {
        let place = |pose| Placing { world_from_sensor: of(pose), scale: 1.0 };
        accord_of(views, probes, poses.iter().map(place).collect())
    };
    // Only cameras have a y axis that may point up; a room between floor and ceiling is nearly the
    // same upside down.
    let cameras = views.iter().all(|view| view.looks_forward());
    let far_apart = is_far_apart(&poses, probes);
    let is_tried = |reading: &PoseReading| match reading {
        reading if stated.is_some_and(|stated| stated.reading == *reading) => false,
        PoseReading::CameraYUp => cameras,
        PoseReading::Millimetres => far_apart,
        reading => {
            far_apart || given.contradicting > SOUND[1] || !brings_together(*reading, &poses)
        }
    };
    let as_stated = stated.map(|_| (Reading::AsStated, accord_at(&|pose| *pose)));
    let others = PoseReading::ALL.into_iter().filter(is_tried);
    let others = others.map(|r| (Reading::Pose(r), accord_at(&|pose| r.apply(pose))));
    as_stated.into_iter().chain(others).collect()
}

/// Whether a reading brings the sensors [`TOGETHER`].
fn brings_together(reading: PoseReading, poses: &[Isometry3]) -> bool {
    let size = |of: &dyn Fn(&Isometry3) -> Isometry3| {
        let places: Vec<Vector3> = poses.iter().map(|pose| of(pose).translation.vector).collect();
        let middle = places.iter().sum::<Vector3>() / places.len().max(1) as f64;
        places.iter().map(|place| (place - middle).norm_squared()).sum::<f64>().sqrt()
    };
    size(&|pose| reading.apply(pose)) < TOGETHER * size(&|pose| *pose)
}

/// Whether any two sensors are [`FAR_APART`]. If not, positions a thousand times smaller put all
/// sensors into one place, where tunnels agree whatever their poses are.
fn is_far_apart(poses: &[Isometry3], probes: &[Vec<Probe>]) -> bool {
    let reach = probes.iter().flatten().map(|probe| probe.point.coords.norm()).fold(0.0, f64::max);
    let places = || poses.iter().map(|pose| pose.translation.vector);
    places().any(|a| places().any(|b| (a - b).norm() > FAR_APART * reach))
}
