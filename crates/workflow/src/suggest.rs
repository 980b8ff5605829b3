//! Section planes for a scan that states none, derived from its views.
//!
//! 1. The **normal** is the direction that is up. Turning scanners stand upright: their z axis. For
//!    cameras it is the normal of the level surfaces (floors, tables) near the mean upward direction
//!    of their images. For triangulation scanners it is the direction along which most images have
//!    their rows. Where the views have no common direction, it is the longest side of the box
//!    around all points.
//! 2. The **interval** is a round number: at least [`PIXELS_PER_INTERVAL`] pixels, and at least a
//!    [`MOST_PLANES`]th of the extent along the normal.
//! 3. The **offset** keeps the planes away from faces that are parallel to them.

use crate::samples::{median, quantile};
use crate::survey::{SensorKind, ViewSurvey};
use crate::table::Quantity;
use crate::{OpenScan, PlaneSettings, Settings, WorkflowError};
use transect_exchange::PlanesEntry;
use transect_geometry::{Guide, LengthUnit, Vector3};

/// Most views that are looked at. Chosen by hand: views of one scan are alike, and the second
/// reading of these views delays a run. Doubled, the delay doubles.
const MOST_VIEWS: usize = 16;

/// Most planes. Chosen by hand: an overview with a hundred sections is readable. Doubled, a run
/// takes twice the time.
const MOST_PLANES: f64 = 100.0;

/// Fewest pixels between two planes. Theory: a section changes from plane to plane as the surface
/// does, and two samples are needed for each change. Doubled, half the detail is lost.
const PIXELS_PER_INTERVAL: f64 = 2.0;

/// Share of the points at each end of the extent that is left out. Chosen by hand: outliers and
/// distant background. Doubled, low rooms lose their floor's share.
const TAIL: f64 = 0.01;

/// Cosine of the largest angle between directions of one group: 10°. Chosen by hand: normals of a
/// floor in a depth image scatter by so much. Doubled to 20°, ramps join the floor.
const ONE_GROUP: f64 = 0.985;

/// Cosine of the largest angle between up in the images and in the world: 45°. Theory: a camera
/// that is inclined further looks at the ground rather than around. Doubled, walls pass for floors.
const UPWARD: f64 = 0.7;

/// Least share of the normals that makes a group level surfaces. Chosen by hand: floor and tables
/// have 20 % and more. Doubled, cluttered rooms fall back on the cameras.
const LEVEL_SHARE: f64 = 0.1;

/// Cosine of the angle to a world axis within which the axis itself is taken: 3°. Chosen by hand:
/// the uncertainty of the estimate. Doubled to 6°, a real inclination disappears.
const ON_AXIS: f64 = 0.9986;

/// Directions that are tried as the middle of a group. Chosen by hand. Doubled, it takes twice the
/// time.
const TRIED: usize = 400;

/// Places of plane 0 that are tried within an interval, best ones first, in tenths of it.
const PHASES: [u8; 10] = [5, 4, 6, 3, 7, 2, 8, 1, 9, 0];

/// Planes that fit a scan, and the reason for their direction.
#[derive(Debug, Clone)]
pub struct Suggestion {
    /// The planes.
    pub planes: PlanesEntry,
    /// Where the normal comes from; `None` if it was given.
    pub reason: Option<&'static str>,
    unit: LengthUnit,
}

impl Suggestion {
    /// The options of the command line that ask for these planes; those of a guide without it.
    pub fn options(&self) -> String {
        let PlanesEntry { normal: [x, y, z], offset, interval, guide, .. } = &self.planes;
        let length = |value| plain_length(value, self.unit);
        let lengths = format!("--offset {} --interval {}", length(*offset), length(*interval));
        if guide.is_some() { lengths } else { format!("--normal {x},{y},{z} {lengths}") }
    }
}

/// A length in a readable unit as the command line takes it, without rounding's last digits.
fn plain_length(value: f64, unit: LengthUnit) -> String {
    let quantity = Quantity::new(value, unit, 1);
    let readable = if value == 0.0 { unit } else { quantity.readable_unit() };
    let number = (quantity.in_unit(readable) * 1e6).round() / 1e6;
    format!("{number}{readable}")
}

impl OpenScan {
    /// Gives the scan planes if neither the settings nor the scan state them all. The note, which
    /// the scan gets, too, tells the planes, their reason, and how to choose others.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting has no usable value or a view cannot be read.
    pub fn suggest_planes(&mut self, settings: &Settings) -> Result<Option<String>, WorkflowError> {
        if self.scan().planes.is_some() || settings.planes.is_complete() {
            return Ok(None);
        }
        let numbers = self.surveyed_for_planes();
        let views: Result<Vec<ViewSurvey>, _> = self.survey(&numbers).into_iter().collect();
        let suggestion = self.suggestion(&views?, &settings.planes)?;
        let reason = suggestion.reason.map_or(String::new(), |r| format!(" The normal is {r}."));
        let note = format!(
            "neither the scan nor the options state all planes; suggested planes are used: {}.\
             {reason} Pass --normal X,Y,Z, --offset LENGTH and --interval LENGTH for others",
            suggestion.options()
        );
        self.set_planes(suggestion.planes, note.clone());
        Ok(Some(note))
    }

    /// The numbers of the views that a suggestion looks at.
    pub fn surveyed_for_planes(&self) -> Vec<usize> {
        let views = self.scan().views.len();
        (0..views).step_by(views.div_ceil(MOST_VIEWS).max(1)).collect()
    }

    /// Planes that fit these views of the scan, as far as the settings leave them open.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting has no usable value.
    pub fn suggestion(
        &self,
        views: &[ViewSurvey],
        settings: &PlaneSettings,
    ) -> Result<Suggestion, WorkflowError> {
        let unit = self.scan().unit;
        let (normal, reason) = match settings.normal {
            Some(normal) => (normal, None),
            None => upward(views),
        };
        let guide = settings.guide.as_ref().map(|guide| guide.read(unit)).transpose()?;
        let curved = guide.as_ref().and_then(Guide::curved).cloned();
        let along = Vector3::from(normal).try_normalize(0.0).unwrap_or(Vector3::z());
        let stations = || points(views).map(|(p, _)| p.coords.dot(&along)).collect::<Vec<f64>>();
        let extent = match &curved {
            Some(guide) => guide.length(),
            None => {
                let [low, high] = [TAIL, 1.0 - TAIL].map(|share| quantile(stations(), share));
                high.unwrap_or(0.0) - low.unwrap_or(0.0)
            }
        };
        let spacing = median(views.iter().filter_map(|v| Some(v.spacing?[1])).collect());
        let wanted = (extent / MOST_PLANES).max(PIXELS_PER_INTERVAL * spacing.unwrap_or(0.0));
        let interval = settings.interval(unit)?.unwrap_or_else(|| round_up(wanted));
        let offset = if curved.is_some() { 0.0 } else { offset(views, &along, interval) };
        let mut planes = PlanesEntry::new(normal, offset, interval);
        let reason = reason.filter(|_| curved.is_none());
        planes.guide = curved;
        Ok(Suggestion { planes, reason, unit })
    }
}

fn points(
    views: &[ViewSurvey],
) -> impl Iterator<Item = &(transect_geometry::Point3, Vector3)> + Clone {
    views.iter().flat_map(|view| &view.surface)
}

/// The direction that is up in the world, and the reason for it.
fn upward(views: &[ViewSurvey]) -> ([f64; 3], Option<&'static str>) {
    let ups: Vec<Vector3> = views.iter().map(|view| view.up).collect();
    let is = |kind| 2 * views.iter().filter(|view| view.sensor == kind).count() > views.len();
    if is(SensorKind::Turning) {
        let mean = ups.iter().sum();
        return (rounded(mean), Some("the mean z axis of the scanners"));
    }
    if is(SensorKind::Camera)
        && let Some(up) = ups.iter().sum::<Vector3>().try_normalize(0.0)
        && 2 * ups.iter().filter(|u| u.dot(&up) > UPWARD).count() > ups.len()
    {
        let normals = points(views).map(|(_, n)| n * n.dot(&up).signum());
        let all: Vec<Vector3> = normals.collect();
        let upward: Vec<Vector3> = all.iter().filter(|n| n.dot(&up) > UPWARD).copied().collect();
        return match group(&upward) {
            Some((mean, count)) if count as f64 > LEVEL_SHARE * all.len() as f64 => {
                (rounded(mean), Some("that of the largest level surfaces, as the cameras stand"))
            }
            _ => (rounded(up), Some("the mean upward direction of the cameras")),
        };
    }
    if let Some((mean, count)) = group(&ups)
        && 2 * count > ups.len()
        && ups.len() > 1
    {
        return (rounded(mean), Some("the common direction of the rows of most images"));
    }
    (longest_side(views), Some("the longest side of the box around all points"))
}

/// The mean of the largest group of directions, and its size.
fn group(directions: &[Vector3]) -> Option<(Vector3, usize)> {
    let near = |middle: &Vector3| {
        let middle = *middle;
        directions.iter().filter(move |d| d.dot(&middle) > ONE_GROUP)
    };
    let tried = directions.iter().step_by(directions.len().div_ceil(TRIED).max(1));
    // Of equally large groups the first one is taken.
    let sizes = tried.map(|middle| (near(middle).count(), middle));
    let (_, middle) = sizes.reduce(|best, other| if other.0 > best.0 { other } else { best })?;
    let mean = near(middle).sum::<Vector3>().try_normalize(0.0)?;
    Some((near(&mean).sum(), near(&mean).count()))
}

/// A direction as few digits: a world axis if it is near one, otherwise thousandths.
fn rounded(direction: Vector3) -> [f64; 3] {
    let unit = direction.try_normalize(0.0).unwrap_or(Vector3::z());
    let axis = unit.iamax();
    let mut rounded = [0.0; 3];
    if unit[axis].abs() > ON_AXIS {
        rounded[axis] = unit[axis].signum();
        return rounded;
    }
    // Adding 0 makes a negative zero positive.
    <[f64; 3]>::from(unit).map(|c| (1000.0 * c).round() / 1000.0 + 0.0)
}

/// The world axis along which the points extend farthest; of equal ones the last.
fn longest_side(views: &[ViewSurvey]) -> [f64; 3] {
    let corners = views.iter().map(|v| v.corners);
    let extent =
        corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))).map(|(low, high)| high - low);
    let [x, y, z] = extent.map_or([0.0; 3], Into::into);
    match () {
        () if z >= x && z >= y => [0.0, 0.0, 1.0],
        () if y >= x => [0.0, 1.0, 0.0],
        () => [1.0, 0.0, 0.0],
    }
}

/// The smallest number 1, 2 or 5 times a power of ten that is not below a length.
fn round_up(length: f64) -> f64 {
    if !(length.is_finite() && length > 0.0) {
        return 1.0;
    }
    let exponent = length.log10().floor() as i32;
    let candidates = [(1.0, 0), (2.0, 0), (5.0, 0), (1.0, 1)];
    // Powers of ten are exact; dividing by one rounds once, as reading the printed number does.
    let number = |(digit, more): (f64, i32)| match exponent + more {
        power @ 0.. => digit * 10_f64.powi(power),
        power => digit / 10_f64.powi(-power),
    };
    let fits = |number: &f64| *number >= length * (1.0 - 1e-9);
    candidates.into_iter().map(number).find(fits).unwrap_or(length)
}

/// The place of plane 0, in tenths of the interval, at which planes hit the fewest points of faces
/// that are parallel to them.
fn offset(views: &[ViewSurvey], along: &Vector3, interval: f64) -> f64 {
    let level = points(views).filter(|(_, normal)| normal.dot(along).abs() > ONE_GROUP);
    let mut hits = [0_usize; 10];
    for (point, _) in level {
        let tenth = (10.0 * (point.coords.dot(along) / interval).rem_euclid(1.0)).round();
        hits[tenth as usize % 10] += 1;
    }
    // A face within a tenth of the interval counts for the places on both sides.
    let cost = |phase: u8| {
        let k = usize::from(phase);
        hits[k] + hits[(k + 1) % 10] + hits[(k + 9) % 10]
    };
    let best = PHASES.into_iter().min_by_key(|phase| cost(*phase)).unwrap_or(5);
    interval * f64::from(best) / 10.0
}
