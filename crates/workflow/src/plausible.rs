//! Plausibility: input that is valid, but in a wrong unit or of a wrong kind, stops the run.
//!
//! Such input otherwise fills the memory, or gives a model that looks right. Every check has a name
//! with which a user can accept the input after all.

use crate::WorkflowError;
use crate::camera::{Camera, misfit};
use crate::samples::{Sample, pixel_spacing, reach, samples};
use crate::selection::Limits;
use rayon::prelude::*;
use std::f64::consts::TAU;
use transect::register::PoseReading;
use transect_device::{Note, Pixel, Vector3, View, median};
use transect_exchange::{Scan, ScanView};
use transect_geometry::{Isometry3, LengthUnit};

/// Most planes between two neighbouring pixels. Interpolation between pixels resolves a tenth of
/// their distance at best, so denser planes show nothing new. Doubled, a depth image in millimetres
/// that is declared as metres passes where planes are 50 pixels apart; now where they are 100.
const PLANES_PER_PIXEL: f64 = 10.0;

/// Fewest valid pixels of a view, as a share. Real scans of small objects have 5 % and more
/// (measured on the Stanford bunny: 15 %). Doubled, views of an object that fills an eighth of the
/// image in each direction are refused.
const LEAST_VALID: f64 = 0.01;

/// Largest median distance of neighbouring pixels, in metres. Chosen by hand: lidars with 0.2°
/// between rays have 0.35 m at 100 m. Doubled, a depth image in millimetres that is declared as
/// metres passes if its camera was nearer than 0.6 m.
const FARTHEST_PIXELS: f64 = 0.5;

/// Largest factor between the pixel distances of two views of a scan. Chosen by hand between the
/// factor 10 of a near and a far view and the factor 1000 of metres and millimetres. Doubled,
/// centimetres among metres pass.
const BETWEEN_VIEWS: f64 = 50.0;

/// Sine of the smallest angle between a row and a column of pixels, as rays see them. Theory: they
/// cross at 90°; read in the wrong order, both run along one row, at 0°. Doubled, every view is
/// refused.
const CROSSING: f64 = 0.5;

/// Largest angle between the rays of neighbouring pixels, as their distance on the unit sphere;
/// 29°. Chosen by hand: rotating lidars have 3° at most, and scans of a full circle that are read
/// in the wrong order have up to 180°. Doubled, coarse scans of that kind pass.
const FARTHEST_RAYS: f64 = 0.5;

/// Where each kind of scan states the unit of its images.
const UNIT_OF_IMAGES: &str = "Check the unit of the image: \"unit\" and \"scale\" in scan.json, the setting `depth_scale` \
     for a folder of depth images, the setting `unit` for PTX, PCD and PLY files.";

/// Most pixels of a view that is kept from the look at a scan until its turn in the run. Chosen by
/// hand: such a view takes some ten megabytes, and reading it again takes longer than anything else
/// of the look. Doubled, runs of large views take more memory.
const KEPT_PIXELS: usize = 1 << 20;

/// A view that was read, and the notes on its file.
pub(crate) type ReadView = (View, Vec<Note>);

/// A look at a few views of a scan.
pub(crate) struct Looked<T> {
    /// The small views with their places in the scan, so that they are not read again.
    pub kept: Vec<(usize, ReadView)>,
    /// The findings of the caller in all of them.
    pub found: Vec<T>,
}

/// The numbers of the views that are looked at before a run: the first, the middle and the last
/// one. The median of three survives a wrong view.
pub(crate) fn looked_numbers(views: usize) -> Vec<usize> {
    let last = views.saturating_sub(1);
    let mut numbers = vec![0, last / 2, last];
    numbers.dedup();
    numbers
}

/// The facts of a view that the checks of a whole scan compare.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Look {
    /// Median distance of neighbouring pixels within the limits.
    spacing: Option<f64>,
    /// Largest distance of a point from the sensor's origin.
    reach: f64,
    /// The camera, if it is a pinhole.
    camera: Option<Camera>,
}

impl Look {
    /// The facts of a view within the limits of the user, whose whole has a reach.
    pub(crate) fn of(within: &View, reach: f64) -> Self {
        let spacing = pixel_spacing(within).map(|[denser, _]| denser);
        Self { spacing, reach, camera: Camera::of(within) }
    }
}

/// A check of plausibility.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Check {
    /// No more planes than pixels can tell apart.
    Planes,
    /// Enough valid pixels in every view.
    ValidPixels,
    /// Coordinates that their number type resolves.
    Resolution,
    /// Views that can overlap.
    Distance,
    /// Pixels as far apart as those of a scanner are, and those of the other views.
    Extent,
    /// Angles within a full circle.
    Angles,
    /// Rows and columns in the order of the sensor.
    Order,
    /// Cameras that belong to images of the size of their images.
    Camera,
}

impl Check {
    /// All checks.
    pub const ALL: [Self; 8] = [
        Self::Planes,
        Self::ValidPixels,
        Self::Resolution,
        Self::Distance,
        Self::Extent,
        Self::Angles,
        Self::Order,
        Self::Camera,
    ];

    /// The name that accepts the input after all.
    pub fn name(self) -> &'static str {
        match self {
            Self::Planes => "planes",
            Self::ValidPixels => "valid-pixels",
            Self::Resolution => "resolution",
            Self::Distance => "distance",
            Self::Extent => "extent",
            Self::Angles => "angles",
            Self::Order => "order",
            Self::Camera => "camera",
        }
    }

    fn refuse(self, problem: String) -> Result<(), WorkflowError> {
        Err(WorkflowError::Implausible { problem, check: self.name() })
    }
}

/// The checks of a run, and what they compare the views with.
#[derive(Debug, Clone)]
pub(crate) struct Plausibility {
    /// Distance between neighbouring planes.
    pub interval: f64,
    /// Unit of all lengths, for messages.
    pub unit: LengthUnit,
    /// Checks that the user turned off.
    pub accepted: Vec<Check>,
    /// Median pixel distance of a few views of the scan; `None` without another view.
    pub usual_spacing: Option<f64>,
}

impl Plausibility {
    /// The checks of a run without section planes.
    pub(crate) fn without_planes(unit: LengthUnit, accepted: &[Check]) -> Self {
        let interval = f64::INFINITY;
        Self { interval, unit, accepted: accepted.to_vec(), usual_spacing: None }
    }

    /// Checks that a view has enough valid pixels. Limits of the user leave pixels out, so this
    /// check comes before them.
    pub(crate) fn check_valid_pixels(&self, whole: &View) -> Result<(), WorkflowError> {
        let (valid, pixels) = (whole.image().valid_count(), whole.image().size().pixels());
        let is_enough = valid as f64 >= LEAST_VALID * pixels as f64;
        if is_enough || self.accepted.contains(&Check::ValidPixels) {
            return Ok(());
        }
        Check::ValidPixels.refuse(format!(
            "only {valid} of {pixels} pixels are valid; at least {:.0} % are plausible. Check the \
             file, its number type and the value for missing pixels.",
            100.0 * LEAST_VALID
        ))
    }

    /// Checks everything else of a view, within the limits of the user.
    pub(crate) fn check_view(&self, view: &View) -> Result<(), WorkflowError> {
        let spacing = pixel_spacing(view);
        Check::ALL.into_iter().filter(|check| !self.accepted.contains(check)).try_for_each(
            |check| match check {
                Check::Planes => self.check_planes(spacing),
                Check::Resolution => self.check_resolution(view, spacing),
                Check::ValidPixels | Check::Distance | Check::Camera => Ok(()),
                Check::Extent => self.check_extent(spacing),
                Check::Angles => check_angles(view),
                Check::Order => check_order(view),
            },
        )
    }

    fn check_planes(&self, spacing: Option<[f64; 2]>) -> Result<(), WorkflowError> {
        let Some([spacing, _]) = spacing else { return Ok(()) };
        let (interval, unit, planes) = (self.interval, self.unit, spacing / self.interval);
        if planes <= PLANES_PER_PIXEL {
            return Ok(());
        }
        Check::Planes.refuse(format!(
            "{planes:.0} planes lie between neighbouring pixels: pixels are {spacing:.4} {unit} \
             apart, planes {interval} {unit}. At most {PLANES_PER_PIXEL} planes between pixels are \
             plausible. {UNIT_OF_IMAGES} If that is right, is the interval in the right unit?"
        ))
    }

    fn check_resolution(
        &self,
        view: &View,
        spacing: Option<[f64; 2]>,
    ) -> Result<(), WorkflowError> {
        let is_single = |c: &f64| f64::from(*c as f32) == *c;
        if !samples(view).all(|sample| sample.point.iter().all(is_single)) {
            return Ok(());
        }
        let largest = samples(view).map(|sample| sample.point.coords.amax()).fold(0.0, f64::max);
        let step = largest * f64::from(f32::EPSILON);
        let half = 0.5 * spacing.map_or(f64::INFINITY, |[denser, _]| denser);
        let limit = half.max(view.sigma().unwrap_or(0.0));
        if step <= limit {
            return Ok(());
        }
        let unit = self.unit;
        Check::Resolution.refuse(format!(
            "coordinates up to {largest:.0} {unit} are stored as 32-bit numbers, whose steps are \
             {step:.4} {unit} there; the noise and half the distance of pixels allow {limit:.4} \
             {unit}. Store 64-bit numbers, or subtract an offset and put it into the pose."
        ))
    }

    /// Checks the distance between neighbouring pixels, by itself and beside other views.
    pub(crate) fn check_extent(&self, spacing: Option<[f64; 2]>) -> Result<(), WorkflowError> {
        let Some([spacing, _]) = spacing else { return Ok(()) };
        let (unit, limit) = (self.unit, FARTHEST_PIXELS / self.unit.in_metres());
        let cause =
            format!("{UNIT_OF_IMAGES} Millimetres that are declared as metres look like this.");
        if spacing > limit {
            return Check::Extent.refuse(format!(
                "neighbouring pixels are {spacing:.4} {unit} apart (median); at most {limit} \
                 {unit} are plausible. {cause}"
            ));
        }
        let Some(usual) = self.usual_spacing else { return Ok(()) };
        let factor = (spacing / usual).max(usual / spacing);
        if factor <= BETWEEN_VIEWS {
            return Ok(());
        }
        Check::Extent.refuse(format!(
            "neighbouring pixels are {spacing:.3e} {unit} apart (median), those of other views \
             {usual:.3e} {unit}: the scales differ by a factor of {factor:.0}, and at most \
             {BETWEEN_VIEWS} is plausible. {cause}"
        ))
    }

    /// Looks at a few views of a scan, with which every view is compared later, and checks the scan
    /// as a whole. `reading` is the convention of the poses, if the user stated one. `of_view` is
    /// the caller's own look at the points within the limits.
    pub(crate) fn look_at<T: Send>(
        &mut self,
        scan: &Scan,
        reading: Option<PoseReading>,
        limits: &Limits,
        of_view: impl Fn(&View) -> T + Sync,
    ) -> Result<Looked<T>, WorkflowError> {
        // A view that cannot be loaded is reported later.
        let seen: Vec<_> = looked_numbers(scan.views.len())
            .par_iter()
            .filter_map(|&k| {
                let read = scan.views.get(k)?.load().ok()?;
                let is_small = read.0.image().size().pixels() <= KEPT_PIXELS;
                let reach = reach(&read.0);
                let within = limits.apply(read.0.clone()).ok()?;
                let (look, found) = (Look::of(&within, reach), of_view(&within));
                Some((look, (found, is_small.then_some((k, read)))))
            })
            .collect();
        let (looks, seen): (Vec<Look>, Vec<_>) = seen.into_iter().unzip();
        self.check_scan(scan, reading, &looks)?;
        let (found, kept): (_, Vec<_>) = seen.into_iter().unzip();
        Ok(Looked { kept: kept.into_iter().flatten().collect(), found })
    }

    /// Checks that the sensors of a scan are near enough to each other to see one surface. A camera
    /// that all of them share must belong to images of their size. `looks` are those at the views
    /// of [`looked_numbers`]; they tell the pixel distance with which every view is compared later.
    pub(crate) fn check_scan(
        &mut self,
        scan: &Scan,
        reading: Option<PoseReading>,
        looks: &[Look],
    ) -> Result<(), WorkflowError> {
        let spacings: Vec<f64> = looks.iter().filter_map(|look| look.spacing).collect();
        self.usual_spacing = if spacings.len() > 1 { median(spacings) } else { None };
        let farthest = looks.iter().map(|look| look.reach).fold(0.0, f64::max);
        self.check_distances(&scan.views, reading, farthest)?;
        let cameras: Option<Vec<Camera>> = looks.iter().map(|look| look.camera).collect();
        match cameras {
            Some(cameras) if !self.accepted.contains(&Check::Camera) => {
                misfit(&cameras).map_or(Ok(()), |problem| Check::Camera.refuse(problem))
            }
            _ => Ok(()),
        }
    }

    /// Checks that two sensors of a scan are within each other's reach; that of some views is
    /// known.
    fn check_distances(
        &self,
        views: &[ScanView],
        reading: Option<PoseReading>,
        known: f64,
    ) -> Result<(), WorkflowError> {
        let Some((nearest, pair)) = nearest_pair(views) else { return Ok(()) };
        // Views share a surface only if both sensors reach it. One view is enough to pass, so the
        // others are rarely loaded. A view that cannot be loaded is reported later.
        // Views without neighbouring pixels have no known reach.
        let mut farthest = known;
        if self.accepted.contains(&Check::Distance) || farthest == 0.0 {
            return Ok(());
        }
        let mut others = views.iter();
        while nearest > 2.0 * farthest {
            let Some(view) = others.next() else { break };
            farthest = farthest.max(view.load().map_or(f64::MAX, |(view, _)| reach(&view)));
        }
        if nearest <= 2.0 * farthest {
            return Ok(());
        }
        let (unit, [first, second]) = (self.unit, pair.map(ScanView::name));
        Check::Distance.refuse(format!(
            "the two nearest of the {} sensors are {nearest:.4} {unit} apart: those of views {first} \
             and {second}. No view reaches farther than {farthest:.4} {unit}, so no surface is seen \
             twice. {}",
            views.len(),
            distance_advice(pair, reading, unit)
        ))
    }
}

/// The two views whose sensors are nearest to each other, and the distance; `None` for one view.
fn nearest_pair(views: &[ScanView]) -> Option<(f64, [&ScanView; 2])> {
    let place = |view: &ScanView| view.world_from_sensor().translation.vector;
    let places: Vec<Vector3> = views.iter().map(place).collect();
    let pairs = (0..views.len()).flat_map(|k| (k + 1..views.len()).map(move |other| (k, other)));
    let distances = pairs.map(|(a, b)| ((places[a] - places[b]).norm(), [&views[a], &views[b]]));
    distances.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The likely causes of sensors that are too far from each other. `reading` is the convention of
/// the poses, if the user stated one.
fn distance_advice(pair: [&ScanView; 2], reading: Option<PoseReading>, unit: LengthUnit) -> String {
    let is_unposed = |view: &&ScanView| *view.world_from_sensor() == Isometry3::identity();
    let check = pair.into_iter().find(is_unposed).map_or_else(|| "Check".to_owned(), |view| {
        let name = view.name();
        format!(
            "View {name} has no pose, it seems, since its pose is the identity. Register it, or \
             leave it out by the setting `views`. Else check"
        )
    });
    let convention = match (reading, unit) {
        (None, LengthUnit::Metre) => {
            ": the setting `pose_convention` millimetres reads positions in millimetres beside \
             images in metres"
        }
        _ => "",
    };
    format!("{check} that poses and images are in the same unit{convention}.")
}

fn check_angles(view: &View) -> Result<(), WorkflowError> {
    let frame = view.frame();
    match frame.largest_angle() {
        Some(angle) if angle.abs() > TAU => Check::Angles.refuse(format!(
            "{} = {angle} rad is more than a full circle, 2π = 6.283. Angles are radians: if the \
             value means degrees, multiply it by π/180.",
            key_of_angle(frame.kind())
        )),
        _ => Ok(()),
    }
}

/// The key in manifests of the largest angle of a kind of sensor.
fn key_of_angle(kind: &str) -> &'static str {
    match kind {
        "ImagingRadar" => "theta0",
        "LookupTable" => "tilt",
        _ => "an angle of the sensor",
    }
}

fn check_order(view: &View) -> Result<(), WorkflowError> {
    let [mut crossing, mut beside] = [0_usize; 2];
    for sample in samples(view) {
        match rays_cross(view, &sample) {
            Some(true) => crossing += 1,
            Some(false) => beside += 1,
            None => (),
        }
    }
    if beside <= crossing {
        return Ok(());
    }
    let (size, pixels) = (view.image().size(), crossing + beside);
    Check::Order.refuse(format!(
        "rows and columns are not those of a scanner: at {beside} of {pixels} pixels looked at, \
         the next pixels of the row and of the column lie in one direction, or far away. Check \
         whether {size} should be {} rows and {} columns, in the file's header or in --grid.",
        size.cols, size.rows
    ))
}

/// Whether the next pixels of the row and of the column are in different directions, as the rays
/// see them; `None` where two pixels see one place. Rays that begin in one point must be near each
/// other, too. Others, such as parallel ones, are told apart by where they pass.
fn rays_cross(view: &View, sample: &Sample) -> Option<bool> {
    let Pixel { row, col } = sample.pixel;
    let ray = |row, col| view.frame().ray(Pixel { row, col });
    let [here, right, below] = [ray(row, col)?, ray(row, col + 1)?, ray(row + 1, col)?];
    let from_one = right.start == here.start && below.start == here.start;
    let [right, below] = if from_one {
        [right, below].map(|ray| ray.direction - here.direction)
    } else {
        let across = |step: &Vector3| step - here.direction * step.dot(&here.direction);
        [across(&sample.right), across(&sample.below)]
    };
    let (across, both) = (right.cross(&below).norm(), right.norm() * below.norm());
    let near = !from_one || right.norm().max(below.norm()) <= FARTHEST_RAYS;
    (both > 0.0).then_some(across >= CROSSING * both && near)
}
