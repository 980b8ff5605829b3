//! A curved guide: stations, perpendicular planes, and the distance up to which they can be used.
//!
//! Problem: section planes are perpendicular to a curve. For a point, find its plane and its
//! coordinates there.
//!
//! Idea: the station of a point is the arc length of its nearest point on the curve (dissertation
//! 2.4: the plane through the point is perpendicular to the guide there). Within the curve's reach
//! (`reach.rs`) there is one such point. Farther away planes cross, and points have no station.
//!
//! 1. Points make a curve by arc length: straight pieces and arcs (`rounded.rs`) or a cubic spline
//!    (`spline.rs`).
//! 2. In-plane axes: those of [`PlaneFrame::new`] at the first point, carried from piece to piece
//!    without turning (`transport.rs`).
//! 3. The station of a point: Newton's method for `(p − g(s)) · g′(s) = 0`, from the nearest of
//!    equally spaced samples, or from a guess. The foot found from a guess is compared with
//!    samples.
//!
//! Accuracy: stations and frames of straight and circular pieces are exact to rounding. For a
//! spline along a helix with 24 points per turn, the length of two turns (65.6) agrees with that of
//! 200 000 chords within 1e-7. The axes at its end agree with those of steps a sixteenth as long
//! within 1e-7 (tests).
//!
//! Cost of a station: some steps of Newton's method and a search of samples, which hardly grows
//! with the number of points (`samples.rs`). Do not use it for closed guides: points near the ends
//! would have two stations.

mod samples;

use super::GuideError;
use super::path::Path;
use super::reach::reach;
use super::rounded::{Rounded, turns_back};
use super::spline::Spline;
use super::transport::carry;
use crate::{PlaneFrame, Point3, Vector3};
use samples::Samples;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Largest number of points of a guide. Chosen by hand; doubled, the slowest guide takes twice the
/// time to build.
pub const MAX_GUIDE_POINTS: usize = 10_000;

/// Share of the reach that is used. Chosen by hand: at the reach itself planes touch and stations
/// are not defined. Near 1 stations lose digits; smaller values drop more pixels.
const USABLE_SHARE: f64 = 0.9;

/// Distance beyond an end, as a share of the guide's length, up to which points still have an
/// extended station. Chosen by hand. Doubled, more pixels are counted as beyond the ends, fewer as
/// too far away.
const BEYOND: f64 = 0.05;

/// Distance from the plane at a foot, as a share of the guide's length, up to which Newton's method
/// has found the foot. At least the rounding of coordinates is allowed ([`ROUNDINGS`]). Source:
/// rounding, far below any interval of planes. Doubled, nothing changes.
const FOOT: f64 = 1e-9;

/// Distance between the ends of a guide, as a share of the shortest distance between neighbouring
/// points, below which it is closed. Chosen by hand: coordinates are rounded by less. Doubled,
/// wider gaps are refused.
const CLOSED: f64 = 1e-3;

/// Distance that is rounding, as a share of the largest coordinate. No unit. Theory: a point, its
/// pose and the place on the guide each round by about one unit of the last place
/// (`f64::EPSILON`). Doubled, points beyond an end of the guide by 1e-8 m have a station on
/// national grids; nothing else changes.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;

/// The meaning of a guide's points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GuideKind {
    /// Corners of straight pieces, rounded by arcs that are as large as possible, up to the radius
    /// if one is given; in the model's length unit.
    Polyline(Option<f64>),
    /// Points of a cubic spline.
    Spline,
}

/// Why a point has no station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoStation {
    /// It lies before the first station or after the last one.
    #[error("beyond an end of the guide")]
    BeyondEnds,
    /// It is farther from the guide than [`CurvedGuide::usable_distance`]: planes may cross there.
    #[error("too far from the guide, where its planes may cross")]
    TooFar,
}

/// A guide through points, with a first and a last station.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CurvedGuideText", into = "CurvedGuideText")]
pub struct CurvedGuide {
    kind: GuideKind,
    points: Vec<Point3>,
    path: Path,
    /// First in-plane axis at the start of each piece of the path.
    axes: Vec<Vector3>,
    samples: Samples,
    /// Distance from the guide at which planes cross, in the model's length unit.
    reach: f64,
    /// Station at which the reach is least.
    tightest: f64,
    /// Largest coordinate of the points, in the model's length unit.
    size: f64,
}

/// The stored form of a guide.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct CurvedGuideText {
    kind: GuideKind,
    points: Vec<[f64; 3]>,
}

impl From<CurvedGuide> for CurvedGuideText {
    fn from(guide: CurvedGuide) -> Self {
        Self { kind: guide.kind, points: guide.points.iter().map(|p| p.coords.into()).collect() }
    }
}

impl TryFrom<CurvedGuideText> for CurvedGuide {
    type Error = GuideError;

    fn try_from(text: CurvedGuideText) -> Result<Self, GuideError> {
        Self::new(text.kind, text.points.into_iter().map(Point3::from).collect())
    }
}

impl CurvedGuide {
    /// A guide through points, in the model's length unit.
    ///
    /// # Errors
    /// [`GuideError`] if there are too few or too many points, or a point is not finite or repeats
    /// the one before it. Also if the guide turns back on itself, or ends where it begins.
    pub fn new(kind: GuideKind, points: Vec<Point3>) -> Result<Self, GuideError> {
        check(&points)?;
        let path = match kind {
            GuideKind::Polyline(Some(radius)) if !(radius.is_finite() && radius > 0.0) => {
                return Err(GuideError::BadRadius(radius));
            }
            GuideKind::Polyline(radius) => Path::Rounded(Rounded::new(&points, radius)?),
            GuideKind::Spline => match turns_back(&points) {
                Some(point) => {
                    return Err(GuideError::TurnsBack { point, at: points[point] });
                }
                None => Path::Spline(Spline::new(&points)),
            },
        };
        let tightest = reach(&path, BEYOND * path.length());
        let (axes, samples) = (carried_axes(&path), Samples::of(&path));
        let size = largest_coordinate(&points);
        let (reach, tightest) = (tightest.radius, tightest.station);
        Ok(Self { kind, points, path, axes, samples, reach, tightest, size })
    }

    /// Straight pieces with rounded corners; see [`GuideKind::Polyline`].
    ///
    /// # Errors
    /// As [`CurvedGuide::new`].
    pub fn polyline(points: Vec<Point3>, radius: Option<f64>) -> Result<Self, GuideError> {
        Self::new(GuideKind::Polyline(radius), points)
    }

    /// A natural cubic spline through points.
    ///
    /// # Errors
    /// As [`CurvedGuide::new`].
    pub fn spline(points: Vec<Point3>) -> Result<Self, GuideError> {
        Self::new(GuideKind::Spline, points)
    }

    /// The meaning of the points.
    pub fn kind(&self) -> GuideKind {
        self.kind
    }

    /// The points from which it was made.
    pub fn points(&self) -> &[Point3] {
        &self.points
    }

    /// The last station, in the model's length unit; the first is 0.
    pub fn length(&self) -> f64 {
        self.path.length()
    }

    /// The curve's reach, in the model's length unit: the distance from the guide at which planes
    /// cross. It is at most the smallest bend radius. Infinite for a guide that does not bend.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Distance from the guide up to which points have stations, in the model's length unit: 0.9 ×
    /// its [reach](CurvedGuide::reach). Infinite for a guide that does not bend.
    pub fn usable_distance(&self) -> f64 {
        USABLE_SHARE * self.reach
    }

    /// The largest distance of its points from the guide, in the model's length unit. It rounds the
    /// corners of a polyline off; a spline passes through its points.
    pub fn distance_from_points(&self) -> f64 {
        let distance = |p: &Point3| self.foot_near(p, self.samples.nearest(p)).1;
        self.points.iter().map(distance).fold(0.0, f64::max)
    }

    /// Largest coordinate of its points, in the model's length unit.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// Distance by which the station of a point may be off through rounding, in the model's length
    /// unit. It grows with the distance from the world's origin.
    fn rounding(&self, p: &Point3) -> f64 {
        ROUNDINGS * self.size.max(p.coords.amax())
    }

    /// Checks that points up to a distance from the guide have stations, in the model's length
    /// unit.
    ///
    /// # Errors
    /// [`GuideError::TooCurved`] with the station where planes cross nearest to the guide.
    pub fn require_usable_distance(&self, needed: f64) -> Result<(), GuideError> {
        let (station, reach, usable) = (self.tightest, self.reach, self.usable_distance());
        if usable >= needed {
            return Ok(());
        }
        Err(GuideError::TooCurved { station, reach, usable, needed })
    }

    /// The frame of the plane at a station: origin on the guide, normal along it. Beyond its ends
    /// the guide continues straight.
    pub fn frame(&self, station: f64) -> PlaneFrame {
        let at = self.path.at(station);
        let piece = self.path.piece_at(station.clamp(0.0, self.length()));
        let start = self.path.at(self.path.starts()[piece]);
        let x_axis = carry(&self.axes[piece], &start, &at);
        PlaneFrame::carried(at.point, at.tangent, x_axis)
    }

    /// The station of a point: the arc length of its nearest point on the guide.
    ///
    /// `hint` is a guess, such as a neighbour's station. It saves time and does not change the
    /// result.
    ///
    /// # Errors
    /// [`NoStation`] beyond the ends and beyond [`CurvedGuide::usable_distance`].
    pub fn station(&self, in_world: &Point3, hint: Option<f64>) -> Result<f64, NoStation> {
        let station = self.extended_station(in_world, hint)?;
        // Points on the first or last plane must not be lost to rounding.
        let slack = self.rounding(in_world).max(1e-12 * self.length());
        let on_guide = station >= -slack && station <= self.length() + slack;
        if on_guide { Ok(station) } else { Err(NoStation::BeyondEnds) }
    }

    /// As [`CurvedGuide::station`], for a guide that is longer by a twentieth at both ends. So
    /// points just beyond the first or the last plane have a station, too.
    ///
    /// # Errors
    /// As [`CurvedGuide::station`].
    pub fn extended_station(&self, p: &Point3, hint: Option<f64>) -> Result<f64, NoStation> {
        if !p.coords.iter().all(|c| c.is_finite()) {
            return Err(NoStation::TooFar);
        }
        let guessed = hint.and_then(|hint| self.nearest_foot(p, hint));
        let (station, distance) =
            guessed.unwrap_or_else(|| self.foot_near(p, self.samples.nearest(p)));
        let length = self.length();
        if station < -BEYOND * length || station > (1.0 + BEYOND) * length {
            return Err(NoStation::BeyondEnds);
        }
        if distance <= self.usable_distance() { Ok(station) } else { Err(NoStation::TooFar) }
    }

    /// Spacing of the planes at a point over their spacing on the guide: 1 − the bend towards the
    /// point.
    pub fn stretch(&self, station: f64, in_world: &Point3) -> f64 {
        let at = self.path.at(station);
        1.0 - at.bend.dot(&(in_world - at.point))
    }

    /// The foot of the perpendicular near a guess, if it is the nearest place of the guide.
    ///
    /// Let R be no larger than any bend radius. Over a quarter of a turn of radius R, the guide
    /// stays outside the ball of radius R that touches it at the foot. Its direction turns by at
    /// most s / R over a length s. So it goes at least R sin(s / R) along, and at most
    /// R (1 − cos(s / R)) aside. Farther along, samples tell.
    fn nearest_foot(&self, p: &Point3, guess: f64) -> Option<(f64, f64)> {
        let (station, distance) = self.foot_near(p, guess);
        let (at, length) = (self.path.at(station), self.length());
        let is_foot = at.tangent.dot(&(p - at.point)).abs() <= self.rounding(p).max(FOOT * length);
        let is_near = (-BEYOND * length..=(1.0 + BEYOND) * length).contains(&station);
        if !(is_foot && is_near && distance <= self.usable_distance()) {
            return None;
        }
        let quarter = FRAC_PI_2 * self.usable_distance();
        let around = [station - quarter, station + quarter];
        (!self.samples.is_any_within(distance, p, around)).then_some((station, distance))
    }

    /// The foot of the perpendicular near a station: its station, and the distance.
    fn foot_near(&self, p: &Point3, start: f64) -> (f64, f64) {
        let spacing = self.samples.spacing();
        let enough = self.rounding(p).max(1e-14 * self.length());
        let mut station = start;
        for _ in 0..30 {
            let at = self.path.at(station);
            let d = p - at.point;
            let along = at.tangent.dot(&d);
            // Where planes cross there is no foot; the distance then exceeds the reach.
            let stretch = (1.0 - at.bend.dot(&d)).max(0.05);
            let beyond = station <= 0.0 && along < 0.0 || station >= self.length() && along > 0.0;
            let step = if beyond { along } else { (along / stretch).clamp(-spacing, spacing) };
            station += step;
            if step.abs() <= enough {
                break;
            }
        }
        (station, (p - self.path.at(station).point).norm())
    }
}

fn check(points: &[Point3]) -> Result<(), GuideError> {
    if points.len() < 2 || points.len() > MAX_GUIDE_POINTS {
        return Err(GuideError::PointCount(points.len()));
    }
    if let Some(k) = points.iter().position(|p| !p.coords.iter().all(|c| c.abs() < 1e150)) {
        return Err(GuideError::NotFinite { point: k, at: points[k] });
    }
    let size = largest_coordinate(points);
    let repeats = |pair: &[Point3]| (pair[1] - pair[0]).norm() <= 1e-12 * size;
    if let Some(k) = points.windows(2).position(repeats) {
        return Err(GuideError::Repeated { point: k + 1, at: points[k + 1] });
    }
    let steps = points.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    let gap = (points[points.len() - 1] - points[0]).norm();
    if gap <= CLOSED * steps.fold(f64::INFINITY, f64::min) {
        Err(GuideError::Closed { gap })
    } else {
        Ok(())
    }
}

fn largest_coordinate(points: &[Point3]) -> f64 {
    points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max)
}

/// First in-plane axis at the start of each piece.
fn carried_axes(path: &Path) -> Vec<Vector3> {
    let mut at = path.at(0.0);
    let first = PlaneFrame::new(at.point, at.tangent).unwrap_or(PlaneFrame::WORLD);
    let mut axes = vec![first.x_axis()];
    let mut x = first.x_axis();
    for start in path.starts().iter().skip(1) {
        let next = path.at(*start);
        x = carry(&x, &at, &next);
        axes.push(x);
        at = next;
    }
    axes
}

#[cfg(test)]
mod tests;
