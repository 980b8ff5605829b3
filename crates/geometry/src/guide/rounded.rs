//! A polyline whose corners are rounded by circular arcs.
//!
//! Problem: planes perpendicular to the two sides of a sharp corner cross close to it.
//!
//! Idea: as in road and tunnel alignments, an arc tangent to both sides replaces the corner. It
//! takes at most half of a side with two corners, so neighbouring arcs never overlap. The curve
//! then consists of straight and circular pieces, whose arc lengths, nearest points and frames have
//! closed forms.
//!
//! A polyline with many points on a smooth curve becomes a smooth curve. It passes each of its
//! points at a distance of about a²/8R, for sides of length a and a radius R.

use super::GuideError;
use super::path_point::{PathPoint, Tightest};
use crate::{Point3, Vector3};

/// Sides whose directions differ by less than this many radians count as one. Chosen by hand, above
/// rounding and far below any measured angle; the same holds for twice or half of it.
const STRAIGHT: f64 = 1e-9;

/// Corners that turn by a half-turn, to within this many radians, are refused. Chosen by hand:
/// their arcs would have a radius of less than a two-thousandth of what they take off a side.
/// Doubled, corners with twice that radius are refused, too.
const HALF_TURN: f64 = 1e-3;

/// Turns within this many radians of a half-turn lead back over the same points. Chosen by hand,
/// far above rounding: a spline that passes beside itself has a reach that leaves points out.
/// Doubled, nothing changes.
const ON_ITSELF: f64 = 1e-6;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rounded {
    /// Stations where pieces begin, and the end of the last one.
    pub starts: Vec<f64>,
    pieces: Vec<Piece>,
}

/// A straight piece, or an arc if it bends; from its beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start: Point3,
    tangent: Vector3,
    /// Towards the centre, one over the radius long; zero for a straight piece.
    bend: Vector3,
}

impl Piece {
    fn at(&self, way: f64) -> PathPoint {
        let Self { start, tangent, bend } = *self;
        let curvature = bend.norm();
        if curvature == 0.0 {
            return PathPoint { point: start + tangent * way, tangent, bend };
        }
        let (sin, cos) = (way * curvature).sin_cos();
        let inward = bend / curvature;
        // 1 − cos without cancellation on shallow arcs.
        let rise = 2.0 * (0.5 * way * curvature).sin().powi(2);
        PathPoint {
            point: start + (tangent * sin + inward * rise) / curvature,
            tangent: tangent * cos + inward * sin,
            bend: (inward * cos - tangent * sin) * curvature,
        }
    }
}

/// An arc in place of a corner.
struct Corner {
    /// Length that it takes off each side.
    cut: f64,
    /// Its length.
    length: f64,
    bend: Vector3,
}

impl Rounded {
    /// The curve along points, whose neighbours must differ. Arcs are as large as possible, up to
    /// `radius`.
    pub fn new(points: &[Point3], radius: Option<f64>) -> Result<Self, GuideError> {
        let sides: Vec<Vector3> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut path = Self { starts: vec![0.0], pieces: Vec::with_capacity(2 * sides.len()) };
        let turned = |point: usize| GuideError::TurnsBack { point, at: points[point] };
        let mut cut_before = 0.0;
        for (k, side) in sides.iter().enumerate() {
            let length = side.norm();
            let direction = side / length;
            let corner = match sides.get(k + 1) {
                Some(next) => {
                    // The first and the last side have one corner, the others have two.
                    let room =
                        |side: &Vector3, whole: bool| side.norm() * if whole { 1.0 } else { 0.5 };
                    let room = room(side, k == 0).min(room(next, k + 2 == sides.len()));
                    corner(side, next, room, radius).map_err(|TurnsBack| turned(k + 1))?
                }
                None => None,
            };
            let cut = corner.as_ref().map_or(0.0, |c| c.cut);
            let start = points[k] + direction * cut_before;
            let straight = Piece { start, tangent: direction, bend: Vector3::zeros() };
            path.push(straight, length - cut_before - cut);
            if let Some(corner) = corner {
                let start = points[k + 1] - direction * corner.cut;
                path.push(Piece { start, tangent: direction, bend: corner.bend }, corner.length);
            }
            cut_before = cut;
        }
        Ok(path)
    }

    fn push(&mut self, piece: Piece, length: f64) {
        let start = self.starts.last().copied().unwrap_or(0.0);
        // Between two arcs that share a side, only rounding may remain.
        if start + length > start {
            self.starts.push(start + length);
            self.pieces.push(piece);
        }
    }

    pub fn at(&self, piece: usize, station: f64) -> PathPoint {
        self.pieces[piece].at(station - self.starts[piece])
    }

    /// The middle of the arc with the smallest radius.
    pub fn sharpest(&self) -> Tightest {
        let middles = self.starts.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
        let arcs = self.pieces.iter().zip(middles);
        let places = arcs.map(|(p, station)| Tightest { radius: 1.0 / p.bend.norm(), station });
        places.fold(Tightest::NOWHERE, Tightest::or)
    }
}

/// The angle between two unit vectors, exact near 0 and a half-turn.
fn angle(a: &Vector3, b: &Vector3) -> f64 {
    2.0 * (b - a).norm().atan2((a + b).norm())
}

/// The first point at which the guide goes back over itself. Neighbouring points must differ.
pub(super) fn turns_back(points: &[Point3]) -> Option<usize> {
    let sides: Vec<Vector3> = points.windows(2).map(|p| (p[1] - p[0]).normalize()).collect();
    let is_back = |both: &[Vector3]| angle(&both[0], &both[1]) > std::f64::consts::PI - ON_ITSELF;
    let at = sides.windows(2).position(is_back)?;
    Some(at + 1)
}

/// Two sides that no arc can join.
struct TurnsBack;

/// The arc at the corner between two sides, which takes at most `room` off each; `None` if the
/// sides are in line.
fn corner(
    before: &Vector3,
    after: &Vector3,
    room: f64,
    radius: Option<f64>,
) -> Result<Option<Corner>, TurnsBack> {
    let (a, b) = (before.normalize(), after.normalize());
    let turn = angle(&a, &b);
    if turn < STRAIGHT {
        return Ok(None);
    }
    if turn > std::f64::consts::PI - HALF_TURN {
        return Err(TurnsBack);
    }
    let half_tan = (0.5 * turn).tan();
    let radius = radius.unwrap_or(f64::INFINITY).min(room / half_tan);
    // Perpendicular to the side before, in the plane of both.
    let inward = (b - a * a.dot(&b)).normalize();
    Ok(Some(Corner { cut: radius * half_tan, length: radius * turn, bend: inward / radius }))
}
