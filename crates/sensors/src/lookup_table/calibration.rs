//! From calibration sweeps to both lookup tables (dissertation, section 4.7.2).
//!
//! The scanner sweeps a flat table at several depths and reports `p, θ, u, v` of every spot. From
//! nearest to farthest depth, the steps are
//!
//! 1. sort the samples of each sweep into θ columns;
//! 2. median filter `p`, `u` and `v` along each sweep;
//! 3. per column, a line through every two neighbouring depths, normalised to a² + b² = 1 and one
//!    sign (errata). The a's, b's and c's are sorted, and the means of their middle thirds make the
//!    beam (Eq. 4.17);
//! 4. move the column's entries onto their beam, and keep those that rise in `p` and in distance.
//!
//! Departures: the median filter follows slopes (see the filter's page). Lines are normalised about
//! the column's mean point rather than the local origin, which lies far off. There, an error of a
//! tilts the line and must be undone by one of c, but the two come from different pairs once they
//! are sorted apart. Entries on their beam make `f` and `F` exact inverses of each other. Small
//! holes in a sweep, up to half a window, are filled by the filter; larger ones leave the column
//! without that depth. [`DepthPairs::HalfApart`] draws the lines of step 3 through depths farther
//! apart. Neighbours are so close that noise tilts their lines. What it adds at one depth no longer
//! cancels once the estimates are sorted.
//!
//! Cost: sweeps × columns × window². Not for beams that bend: a lens that bends them needs more
//! than one line per column.

use super::field::{Beam, DigitizedField};
use super::filter::{Series, median, middle_third_mean};
use crate::error::{SensorError, require};
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

/// One spot of a calibration sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationSample {
    /// Scanning angle, in radians.
    pub theta_rad: f64,
    /// Image position of the spot, in the detector's unit; positive, larger for farther spots.
    pub p: f64,
    /// The spot across the sensor, a length in the local frame.
    pub u: f64,
    /// The spot away from the sensor, a length in the local frame.
    pub v: f64,
}

/// One sweep over the flat table at one depth, θ rising; columns without a return are left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CalibrationSweep {
    /// The spots, by rising θ.
    pub samples: Vec<CalibrationSample>,
}

/// Equal steps of the scanning angle: column `j` looks along `first + j · step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThetaSteps {
    first_rad: f64,
    step_rad: f64,
    count: usize,
}

impl ThetaSteps {
    /// Angles in radians; the step is positive.
    pub fn from_radians(first: f64, step: f64, count: usize) -> Self {
        Self { first_rad: first, step_rad: step, count }
    }

    /// Angles in degrees; the step is positive.
    pub fn from_degrees(first: f64, step: f64, count: usize) -> Self {
        Self::from_radians(first.to_radians(), step.to_radians(), count)
    }

    /// The same angles from first to last in another number of steps, two at least.
    pub fn with_count(self, count: usize) -> Self {
        let (first, count) = (self.first_rad, count.max(2));
        let span = self.angle(self.count.saturating_sub(1)) - first;
        Self::from_radians(first, span / (count - 1) as f64, count)
    }

    /// Angle of a column, in radians.
    pub fn angle(&self, column: usize) -> f64 {
        self.first_rad + column as f64 * self.step_rad
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The column an angle belongs to, at most a quarter step from it.
    fn column(&self, theta_rad: f64) -> Option<usize> {
        let column = (theta_rad - self.first_rad) / self.step_rad;
        let nearest = column.round();
        let belongs = (column - nearest).abs() <= 0.25 && nearest >= 0.0;
        let column = nearest as usize;
        (belongs && column < self.count).then_some(column)
    }
}

/// How calibration data are treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CalibrationOptions {
    /// Samples in the median filter's window, odd; 1 leaves the data as they are. Seven samples
    /// stand two outliers among them; larger windows stand more, and cut deeper into bends.
    pub median_window: usize,
    /// Which two depths give an estimate of a beam.
    pub pairs: DepthPairs,
}

impl CalibrationOptions {
    /// Data taken as they are, for sweeps without noise.
    pub const EXACT: Self = Self { median_window: 1, pairs: DepthPairs::Neighbours };
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self { median_window: 7, pairs: DepthPairs::Neighbours }
    }
}

/// Which two depths give an estimate of a beam's line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DepthPairs {
    /// A depth and the next: n − 1 estimates, the dissertation's.
    #[default]
    Neighbours,
    /// Depths half the sweeps apart: n / 2 estimates whose slopes are some n / 2 times surer.
    HalfApart,
}

impl DepthPairs {
    fn apart(self, depths: usize) -> usize {
        match self {
            Self::Neighbours => 1,
            Self::HalfApart => (depths / 2).max(1),
        }
    }
}

/// A column's place at one depth, after the filter.
#[derive(Debug, Clone, Copy)]
struct Entry {
    p: f64,
    at: Point2<f64>,
}

/// Both lookup tables from sweeps given from the nearest to the farthest depth.
///
/// # Errors
/// [`SensorError::BadParameter`] naming `sweeps` for fewer than two depths or for depths out of
/// order, and `samples` for an empty sweep. It names `theta` for angles that do not rise, are no
/// steps of `columns`, or whose beams cross. It names `p`, `u` or `v` for values that are not
/// finite or a `p` that is not positive. It names `dtheta` and `columns` for impossible steps,
/// `median_window` for an even window.
pub fn digitize(
    sweeps: &[CalibrationSweep],
    columns: &ThetaSteps,
    options: CalibrationOptions,
) -> Result<DigitizedField, SensorError> {
    let window = options.median_window;
    require("median_window", window as f64, window % 2 == 1, "an odd number of samples")?;
    require("theta0", columns.first_rad, true, "an angle")?;
    require("dtheta", columns.step_rad, columns.step_rad > 0.0, "a positive step")?;
    require("columns", columns.count as f64, columns.count >= 2, "at least two columns")?;
    require("sweeps", sweeps.len() as f64, sweeps.len() >= 2, "at least two depths")?;
    let depths: Vec<Vec<Option<Entry>>> = sweeps
        .iter()
        .map(|sweep| filtered_sweep(sweep, columns, window))
        .collect::<Result<_, _>>()?;
    check_order(&depths)?;
    let beam = |column: usize| {
        let entries = depths.iter().filter_map(|d| *d.get(column)?);
        Some((column, beam_of(&entries.collect::<Vec<_>>(), options.pairs)?))
    };
    let beams: Vec<(usize, Beam)> = (0..columns.count).filter_map(beam).collect();
    let usable = beams.len();
    require("columns", usable as f64, usable >= 2, "two columns seen at two depths each")?;
    DigitizedField::new(columns.count, beams).map_err(|column| SensorError::BadParameter {
        key: "theta",
        value: columns.angle(column),
        wanted: "beams that share depths and do not cross",
    })
}

/// Steps 1 and 2: one entry per column the sweep covers.
fn filtered_sweep(
    sweep: &CalibrationSweep,
    steps: &ThetaSteps,
    window: usize,
) -> Result<Vec<Option<Entry>>, SensorError> {
    let count = sweep.samples.len();
    require("samples", count as f64, count > 0, "a sweep with samples")?;
    let columns = sample_columns(sweep, steps)?;
    // A hole of up to half a window lies between samples which the filter's line joins.
    let widest = (window / 2 + 1) as f64;
    let covered = |at: &f64| {
        let next = columns.partition_point(|c| c < at);
        let after = columns.get(next);
        let before = next.checked_sub(1).and_then(|n| columns.get(n));
        after == Some(at) || matches!((before, after), (Some(b), Some(a)) if a - b <= widest)
    };
    let targets: Vec<f64> = (0..steps.count).map(|c| c as f64).filter(covered).collect();
    let filtered = |of: fn(&CalibrationSample) -> f64| {
        let values: Vec<f64> = sweep.samples.iter().map(of).collect();
        Series { columns: &columns, values: &values }.filtered_at(&targets, window)
    };
    let (p, u, v) = (filtered(|s| s.p), filtered(|s| s.u), filtered(|s| s.v));
    let mut entries = vec![None; steps.count];
    for (((column, p), u), v) in targets.iter().zip(p).zip(u).zip(v) {
        if let Some(entry) = entries.get_mut(*column as usize) {
            *entry = Some(Entry { p, at: Point2::new(u, v) });
        }
    }
    Ok(entries)
}

/// Checks a sweep's samples and finds the column of each.
fn sample_columns(sweep: &CalibrationSweep, steps: &ThetaSteps) -> Result<Vec<f64>, SensorError> {
    let mut columns: Vec<f64> = Vec::with_capacity(sweep.samples.len());
    for s in &sweep.samples {
        require("p", s.p, s.p > 0.0, "positive image positions")?;
        require("u", s.u, true, "finite coordinates")?;
        require("v", s.v, true, "finite coordinates")?;
        let bad = |wanted| SensorError::BadParameter { key: "theta", value: s.theta_rad, wanted };
        let column = steps.column(s.theta_rad).ok_or_else(|| bad("an angle of the columns"))?;
        if columns.last().is_some_and(|last| column as f64 <= *last) {
            return Err(bad("angles that rise along the sweep"));
        }
        columns.push(column as f64);
    }
    Ok(columns)
}

/// Refuses sweeps that do not go from near to far; the median over columns stands outliers.
fn check_order(depths: &[Vec<Option<Entry>>]) -> Result<(), SensorError> {
    for (number, (near, far)) in depths.iter().zip(depths.iter().skip(1)).enumerate() {
        let growth = near.iter().zip(far).filter_map(|(n, f)| Some((*f)?.p - (*n)?.p));
        let growth: Vec<f64> = growth.collect();
        let ordered = growth.is_empty() || median(growth) > 0.0;
        let wanted = "sweeps from the nearest depth to the farthest, with p growing";
        require("sweeps", (number + 1) as f64, ordered, wanted)?;
    }
    Ok(())
}

/// Steps 3 and 4: the beam of a column; `None` with fewer than two depths.
fn beam_of(entries: &[Entry], pairs: DepthPairs) -> Option<Beam> {
    let rising = rising(entries, |e| e.p);
    if rising.len() < 2 {
        return None;
    }
    let sum: Vector2<f64> = rising.iter().map(|e| e.at.coords).sum();
    let middle = Point2::from(sum / rising.len() as f64);
    let (foot, direction) = middle_third_line(&rising, &middle, pairs.apart(rising.len()))?;
    let along = |e: &Entry| (direction.dot(&(e.at - foot)), e.p);
    let nodes: Vec<(f64, f64)> = rising.iter().map(along).collect();
    let nodes = self::rising(&nodes, |n| n.0);
    (nodes.len() >= 2).then(|| Beam::new(foot, direction, &nodes))
}

/// The line `a u + b v + c = 0` of the middle thirds, as a point on it and its direction outwards.
///
/// Each estimate runs from a depth to one `apart` farther, so that all have one sign.
fn middle_third_line(
    entries: &[Entry],
    middle: &Point2<f64>,
    apart: usize,
) -> Option<(Point2<f64>, Vector2<f64>)> {
    let (mut a, mut b, mut c) = (Vec::new(), Vec::new(), Vec::new());
    for (near, far) in entries.iter().zip(entries.iter().skip(apart)) {
        let Some(d) = (far.at - near.at).try_normalize(0.0) else { continue };
        a.push(-d.y);
        b.push(d.x);
        let halfway = nalgebra::center(&near.at, &far.at) - middle;
        c.push(d.y * halfway.x - d.x * halfway.y);
    }
    let c = middle_third_mean(c);
    let normal = Vector2::new(middle_third_mean(a), middle_third_mean(b));
    let length = normal.norm();
    let normal = normal.try_normalize(0.0)?;
    // (a, b) is the direction turned a quarter from u to v.
    Some((middle - normal * (c / length), Vector2::new(normal.y, -normal.x)))
}

/// The longest run of items, in order, whose keys strictly rise.
fn rising<T: Copy>(items: &[T], key: impl Fn(&T) -> f64) -> Vec<T> {
    let mut best: Vec<Vec<T>> = Vec::with_capacity(items.len());
    for item in items {
        let fits = |run: &&Vec<T>| run.last().is_some_and(|last| key(last) < key(item));
        let longest = best.iter().filter(fits).max_by_key(|run| run.len());
        let mut run = longest.cloned().unwrap_or_default();
        run.push(*item);
        best.push(run);
    }
    best.into_iter().max_by_key(Vec::len).unwrap_or_default()
}
