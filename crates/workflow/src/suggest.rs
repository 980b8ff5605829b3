//! Section planes for a scan that states none, derived from its views.
//!
//! 1. The **normal** is the direction that is up. Turning scanners stand upright: their z axis. For
//!    cameras it is the normal of the level surfaces (floors, tables) near the mean upward
//!    direction of their images. For triangulation scanners it is the direction along which most
//!    images have their rows. Where the views have no common direction, it is the longest side of
//!    the box around all points.
//! 2. The **interval** is a round number: at least [`PIXELS_PER_INTERVAL`] pixels, and at least a
//!    [`MOST_PLANES`]th of the extent along the normal.
//! 3. The **offset** puts a plane within the extent along the normal. It keeps the planes away from
//!    faces that are parallel to them.

use crate::far_away::{far_away, sentence, without};
use crate::survey::{SensorClass, ViewSurvey};
use crate::table::Quantity;
use crate::{OpenScan, PlaneSettings, Settings, WorkflowError};
use transect_device::{Note, median, quantile};
use transect_exchange::PlanesEntry;
use transect_geometry::{LengthUnit, Point3, Vector3};

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
/// the uncertainty of an estimate. Doubled to 6°, a real inclination disappears.
const ON_AXIS: f64 = 0.9986;

/// The same for the mean upward direction of cameras: 10°, as cameras stand upright by no better.
const NEAR_AXIS: f64 = ONE_GROUP;

/// Directions that are tried as the middle of a group. Chosen by hand. Doubled, it takes twice the
/// time.
const TRIED: usize = 400;

/// Places of plane 0 that are tried within an interval, best ones first, in tenths of it.
const PHASES: [u8; 10] = [5, 4, 6, 3, 7, 2, 8, 1, 9, 0];

/// Share of the extent at each end in which a plane does not count as crossing it. Chosen by hand:
/// floors and ceilings end the extent of a room. Doubled, some large intervals take the middle.
const MARGIN: f64 = 0.05;

/// Planes that fit a scan, and the reason for their direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// The planes.
    pub planes: PlanesEntry,
    /// Where the normal comes from; `None` if it was given.
    pub reason: Option<&'static str>,
    /// What to do about views that lie far away from the others, and were left out; `None` if no
    /// view does.
    pub far_away: Option<String>,
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
    /// Whether neither the settings nor the scan state all planes.
    pub fn lacks_planes(&self, settings: &Settings) -> bool {
        self.scan().planes.is_none() && !settings.planes.is_complete()
    }

    /// Gives the scan planes, as far as the settings leave them open. The returned note, which the
    /// scan gets, too, tells the planes, their reason, and how to choose others.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting has no usable value or a view cannot be read.
    pub fn suggest_planes(&mut self, settings: &Settings) -> Result<Note, WorkflowError> {
        let numbers = self.surveyed_for_planes();
        let views: Result<Vec<ViewSurvey>, _> = self.survey(&numbers).into_iter().collect();
        let suggestion = self.suggestion(&views?, &settings.planes)?;
        let reason = suggestion.reason.map_or(String::new(), |r| format!(" The normal is {r}."));
        let note = Note::new(format!(
            "neither the scan nor the options state all planes; suggested planes are used: {}.\
             {reason} Pass {} for others{}",
            suggestion.options(),
            open_options(&settings.planes),
            suggestion.far_away.map_or_else(String::new, |text| format!(". But {text}"))
        ));
        self.set_planes(suggestion.planes, note.clone());
        Ok(note)
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
        let away = far_away(views);
        let far_away = sentence(views, &away, unit);
        let views = &without(views, &away);
        let (normal, reason) = match settings.normal {
            Some(normal) => (normal, None),
            None => upward(views),
        };
        // The run reads the guide again, and tells its notes.
        let guide = settings.guide.as_ref().map(|guide| guide.read(unit)).transpose()?;
        let curved = guide.as_ref().and_then(|(guide, _)| guide.curved()).cloned();
        let along = Vector3::from(normal).try_normalize(0.0).unwrap_or(Vector3::z());
        let [given, interval] = settings.lengths(unit);
        let interval = interval.unwrap_or_else(|| {
            let extent = curved.as_ref().map_or_else(|| extent(views, &along), |g| g.length());
            let spacing = median(views.iter().filter_map(|v| Some(v.spacing?[1])));
            let resolved = PIXELS_PER_INTERVAL * spacing.unwrap_or(0.0);
            round_up(resolved.max(extent / MOST_PLANES))
        });
        let offset = match (given, &curved) {
            (Some(given), _) => given,
            (None, Some(_)) => 0.0,
            (None, None) => offset(views, &along, interval),
        };
        let mut planes = PlanesEntry::new(normal, offset, interval);
        let reason = reason.filter(|_| curved.is_none());
        planes.guide = curved;
        Ok(Suggestion { planes, reason, far_away, unit })
    }
}

/// The options that state what the settings leave open. A guide takes the place of a normal.
fn open_options(settings: &PlaneSettings) -> String {
    let has_direction = settings.normal.is_some() || settings.guide.is_some();
    let options = [
        (!has_direction, "--normal X,Y,Z"),
        (settings.offset.is_none(), "--offset LENGTH"),
        (settings.interval.is_none(), "--interval LENGTH"),
    ];
    let options = options.into_iter().filter(|(is_open, _)| *is_open).map(|(_, option)| option);
    let options: Vec<&str> = options.collect();
    match options.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => options.concat(),
    }
}

/// The points and surface normals of all views.
fn surface(views: &[ViewSurvey]) -> impl Iterator<Item = &(Point3, Vector3)> {
    views.iter().flat_map(|view| &view.surface)
}

/// The ends of the points along a direction, without [`TAIL`].
fn ends(views: &[ViewSurvey], along: &Vector3) -> [f64; 2] {
    let stations: Vec<f64> = surface(views).map(|(p, _)| p.coords.dot(along)).collect();
    [TAIL, 1.0 - TAIL].map(|share| quantile(stations.clone(), share).unwrap_or(0.0))
}

/// The extent of the points along a direction, without [`TAIL`].
fn extent(views: &[ViewSurvey], along: &Vector3) -> f64 {
    let [low, high] = ends(views, along);
    high - low
}

/// The direction that is up in the world, and the reason for it.
fn upward(views: &[ViewSurvey]) -> ([f64; 3], Option<&'static str>) {
    let ups: Vec<Vector3> = views.iter().map(|view| view.up).collect();
    let is = |class| 2 * views.iter().filter(|view| view.sensor == class).count() > views.len();
    if let Some(up) = common(&ups) {
        if is(SensorClass::Turning) {
            return (rounded(up, ON_AXIS), Some("the mean z axis of the scanners"));
        }
        if is(SensorClass::Camera) {
            return match level_surfaces(views, &up) {
                Some(normal) => {
                    (rounded(normal, ON_AXIS), Some("that of floors and other level surfaces"))
                }
                None => (rounded(up, NEAR_AXIS), Some("the mean upward direction of the cameras")),
            };
        }
    }
    match group(&ups) {
        Some((mean, count)) if ups.len() > 1 && 2 * count > ups.len() => {
            (rounded(mean, ON_AXIS), Some("the common direction of the rows of most images"))
        }
        _ => (longest_side(views), Some("the longest side of the box around all points")),
    }
}

/// The mean of directions most of which are within 45° of it.
fn common(directions: &[Vector3]) -> Option<Vector3> {
    let mean = directions.iter().sum::<Vector3>().try_normalize(0.0)?;
    let near = directions.iter().filter(|d| d.dot(&mean) > UPWARD).count();
    (2 * near > directions.len()).then_some(mean)
}

/// The normal of the largest group of surfaces that are about level.
fn level_surfaces(views: &[ViewSurvey], up: &Vector3) -> Option<Vector3> {
    let normals = surface(views).map(|(_, normal)| normal * normal.dot(up).signum());
    let upward: Vec<Vector3> = normals.filter(|normal| normal.dot(up) > UPWARD).collect();
    let (normal, count) = group(&upward)?;
    (count as f64 > LEVEL_SHARE * surface(views).count() as f64).then_some(normal)
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

/// A direction as few digits: a world axis if the cosine to it exceeds a limit, otherwise
/// thousandths.
fn rounded(direction: Vector3, limit: f64) -> [f64; 3] {
    let unit = direction.try_normalize(0.0).unwrap_or(Vector3::z());
    let axis = unit.iamax();
    let mut rounded = [0.0; 3];
    if unit[axis].abs() > limit {
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

/// The place of plane 0, in tenths of the interval. A plane crosses the extent there, and planes
/// hit the fewest points of faces that are parallel to them. A large interval may have no such
/// tenth. Then the place is the middle of the extent.
fn offset(views: &[ViewSurvey], along: &Vector3, interval: f64) -> f64 {
    let [low, high] = ends(views, along);
    // Without an extent, any place will do.
    let crosses = |phase: &u8| high <= low || is_crossed([low, high], tenths(*phase), interval);
    let hits = hits(views, along, interval);
    // A face within a tenth of the interval counts for the places on both sides.
    let cost = |phase: &u8| {
        let k = usize::from(*phase);
        hits[k] + hits[(k + 1) % 10] + hits[(k + 9) % 10]
    };
    let best = PHASES.into_iter().filter(crosses).min_by_key(cost);
    best.map_or_else(|| middle(low, high), |phase| interval * tenths(phase))
}

/// A place within an interval, as a share of it.
fn tenths(phase: u8) -> f64 {
    f64::from(phase) / 10.0
}

/// For each tenth of the interval, the points there of faces that are parallel to the planes.
fn hits(views: &[ViewSurvey], along: &Vector3, interval: f64) -> [usize; 10] {
    let level = surface(views).filter(|(_, normal)| normal.dot(along).abs() > ONE_GROUP);
    let mut hits = [0_usize; 10];
    for (point, _) in level {
        let tenth = (10.0 * (point.coords.dot(along) / interval).rem_euclid(1.0)).round();
        hits[tenth as usize % 10] += 1;
    }
    hits
}

/// Whether a plane lies between two stations and not near them, where faces often are. `part` is
/// the place of plane 0 as a share of the interval.
fn is_crossed([low, high]: [f64; 2], part: f64, interval: f64) -> bool {
    let margin = MARGIN * (high - low);
    let first = ((low + margin) / interval - part).ceil() + part;
    first * interval <= high - margin
}

/// The middle between two stations as few digits.
fn middle(low: f64, high: f64) -> f64 {
    let step = round_up((high - low) / 20.0);
    ((low + high) / (2.0 * step)).round() * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{DeviceFrame, ImageSize, Isometry3, RangeImage, SensorPlane, View};
    use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

    const SIZE: ImageSize = ImageSize { rows: 90, cols: 120 };

    /// A view inside a room of 6 × 5 × 2.5 m, whose floor is at 0, turned into the world. `looking`
    /// is room from sensor.
    fn in_room(
        frame: impl DeviceFrame + 'static,
        looking: Isometry3,
        world: Isometry3,
    ) -> ViewSurvey {
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let walls = [(x, 3.0), (-x, 3.0), (y, 2.5), (-y, 2.5), (z, 2.5), (-z, 0.0)];
        let value = |pixel| {
            let of_wall = |(normal, offset): &(Vector3, f64)| {
                let offset = offset - normal.dot(&looking.translation.vector);
                let normal = looking.rotation.inverse_transform_vector(normal);
                frame.plane_value(pixel, &SensorPlane { normal, offset })
            };
            walls.iter().filter_map(of_wall).fold(f64::INFINITY, f64::min) as f32
        };
        let values = frame.size().all_pixels().map(value).collect();
        let image = RangeImage::from_values(frame.size(), values).unwrap();
        let pose = world * looking;
        let view = View::new("room", image, Arc::new(frame), pose, Some(0.0)).unwrap();
        ViewSurvey::of(&view, Vec::new())
    }

    /// The world of a room whose floor is inclined by an angle about x.
    fn inclined(degrees: f64) -> Isometry3 {
        Isometry3::rotation(Vector3::x() * degrees.to_radians())
    }

    fn camera(heading_degrees: f64, world: Isometry3) -> ViewSurvey {
        let intrinsics = Intrinsics { fx: 80.0, fy: 80.0, cx: 59.5, cy: 44.5 };
        let eye = Point3::new(0.3, -0.2, 1.5);
        let (sin, cos) = heading_degrees.to_radians().sin_cos();
        // Looking about 20° down; y of the camera runs down.
        let target = eye + Vector3::new(cos, sin, -0.35);
        let looking = Isometry3::face_towards(&eye, &target, &-Vector3::z());
        in_room(Pinhole::new(SIZE, intrinsics).unwrap(), looking, world)
    }

    fn scanner(world: Isometry3) -> ViewSurvey {
        let (theta, phi) =
            (AngularScan::from_degrees(0.0, 3.0), AngularScan::from_degrees(-50.0, 1.5));
        let standing = Isometry3::translation(0.4, 0.3, 1.6);
        in_room(ImagingRadar::new(SIZE, theta, phi).unwrap(), standing, world)
    }

    fn angle_to(normal: [f64; 3], world: Isometry3) -> f64 {
        Vector3::from(normal).angle(&(world * Vector3::z())).to_degrees()
    }

    #[test]
    fn scanners_stand_upright() {
        let (normal, reason) = upward(&[scanner(inclined(0.0))]);
        assert_eq!((normal, reason), ([0.0, 0.0, 1.0], Some("the mean z axis of the scanners")));
        // A world in which y is up.
        let (normal, _) = upward(&[scanner(inclined(-90.0)), scanner(inclined(-88.0))]);
        assert_eq!(normal, [0.0, 1.0, 0.0]);
    }

    /// All cameras look the same way, so their mean upward direction leans by 20°.
    #[test]
    fn cameras_find_the_floor_of_an_inclined_world() {
        for degrees in [0.0, 27.0, 120.0] {
            let world = inclined(degrees);
            let views: Vec<_> = (0..5).map(|k| camera(12.0 * f64::from(k), world)).collect();
            let (normal, reason) = upward(&views);
            assert_eq!(reason, Some("that of floors and other level surfaces"));
            assert!(angle_to(normal, world) < 0.5, "{degrees}: {normal:?}");
        }
    }

    #[test]
    fn planes_keep_away_from_the_floor_and_are_resolved() {
        let views = [scanner(inclined(0.0))];
        let up = Vector3::z();
        assert!((extent(&views, &up) - 2.5).abs() < 0.2);
        let offset = offset(&views, &up, 0.1);
        assert!(
            (0.019..0.081).contains(&offset),
            "the floor is at 0, the ceiling at 2.5: {offset}"
        );
    }

    #[test]
    fn a_few_views_of_another_kind_do_not_count() {
        let turned = |up| ViewSurvey {
            up,
            sensor: SensorClass::Triangulation,
            ..camera(0.0, inclined(0.0))
        };
        let (x, y) = (Vector3::x(), Vector3::y());
        let (normal, reason) = upward(&[turned(y), turned(x), turned(y), turned(y)]);
        assert_eq!(normal, [0.0, 1.0, 0.0], "{reason:?}");
        // One image is no majority. The room is widest along y there.
        let (normal, reason) = upward(&[turned(x)]);
        assert_eq!(normal, [0.0, 1.0, 0.0]);
        assert!(reason.unwrap().starts_with("the longest side"), "{reason:?}");
    }

    /// The room is 2.5 m high.
    #[test]
    fn a_plane_crosses_the_scan_whatever_the_interval() {
        for height in [0.0, 310.0, -7.3] {
            let world = Isometry3::translation(0.0, 0.0, height);
            let views = [scanner(world)];
            for interval in [0.1, 1.0, 3.0, 5.0, 10.0, 20.0, 25.0, 100.0, 1e6] {
                let offset = offset(&views, &Vector3::z(), interval);
                let first = offset + ((height + 0.02 - offset) / interval).ceil() * interval;
                let told = format!("{height}, {interval}: {offset}, {first}");
                assert!(first < height + 2.48, "{told}");
            }
        }
        // Far larger than the room: its middle, as few digits.
        let far = [scanner(Isometry3::translation(0.0, 0.0, 311.0))];
        assert_eq!(plain_length(offset(&far, &Vector3::z(), 1e4), LengthUnit::Metre), "312.2m");
    }

    #[test]
    fn advice_names_the_open_settings_only() {
        let options = |normal: Option<[f64; 3]>, interval: Option<&str>| {
            let interval = interval.map(|text| text.parse().unwrap());
            open_options(&PlaneSettings { normal, interval, ..PlaneSettings::default() })
        };
        let all = "--normal X,Y,Z, --offset LENGTH and --interval LENGTH";
        assert_eq!(options(None, None), all);
        assert_eq!(options(None, Some("1m")), "--normal X,Y,Z and --offset LENGTH");
        assert_eq!(options(Some([0.0, 0.0, 1.0]), None), "--offset LENGTH and --interval LENGTH");
        let (path, radius, reach) = ("axis.csv".into(), None, None);
        let guide = Some(crate::GuideSettings { path, polyline: false, radius, reach });
        let guided = PlaneSettings { guide, offset: "1m".parse().ok(), ..PlaneSettings::default() };
        assert_eq!(open_options(&guided), "--interval LENGTH");
    }

    #[test]
    fn intervals_are_round_numbers() {
        let round = [0.00165, 0.002, 0.0021, 0.051, 1.0, 30.0, 700.0].map(round_up);
        assert_eq!(round, [0.002, 0.002, 0.005, 0.1, 1.0, 50.0, 1000.0]);
        assert_eq!([0.0, f64::NAN, f64::INFINITY].map(round_up), [1.0; 3]);
        let shown = [(0.002, "2mm"), (0.5, "0.5m"), (0.015, "15mm"), (0.0, "0m")];
        for (length, text) in shown {
            assert_eq!(plain_length(length, LengthUnit::Metre), text);
        }
    }
}
