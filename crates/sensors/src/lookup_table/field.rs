//! The digitised sensing field: beams, the scale on each, and both mappings between them.

use nalgebra::{Point2, Vector2};

/// How far outside the outermost depth line a value may lie, relative to `p`: the rounding of a
/// stored `f32`. Doubling it would accept that much more of the undigitised space.
const ROUNDING: f64 = f32::EPSILON as f64;

/// How far from a beam's line a point counts as on it, relative to the beam's length.
const ON_BEAM: f64 = 1e-10;

/// A line `a u + b v + c = 0` with `a² + b² = 1` in the local frame (Eq. 4.17, which writes x, z).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamLine {
    /// Coefficient of `u`.
    pub a: f64,
    /// Coefficient of `v`.
    pub b: f64,
    /// Signed distance of the line from the local origin is `-c` along (a, b); a length.
    pub c: f64,
}

impl BeamLine {
    /// Signed distance of a point from the line; positive on the side (a, b) points to.
    pub fn distance(&self, p: &Point2<f64>) -> f64 {
        self.a * p.x + self.b * p.y + self.c
    }
}

/// An entry of both tables: the point where a beam crosses a depth line, and the detector's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridNode {
    /// Image position of the spot, in the detector's unit.
    pub p: f64,
    /// The spot in the local frame (u, v), on the beam's line; lengths.
    pub at: Point2<f64>,
}

/// One column of both tables: a straight beam with a piecewise linear scale `p` on it.
#[derive(Debug, Clone)]
pub struct Beam {
    /// Where the nearest depth line crosses the beam.
    near_end: Point2<f64>,
    /// Unit direction, away from the sensor.
    direction: Vector2<f64>,
    /// Distance from the near end and `p` at every depth line; both strictly rising, two or more.
    scale: Vec<(f64, f64)>,
}

impl Beam {
    /// A beam along a line through `foot`, from nodes as (distance from the foot, p), both rising.
    pub(super) fn new(foot: Point2<f64>, direction: Vector2<f64>, nodes: &[(f64, f64)]) -> Self {
        let first = nodes.first().map_or(0.0, |n| n.0);
        let scale = nodes.iter().map(|(t, p)| (t - first, *p)).collect();
        Self { near_end: foot + direction * first, direction, scale }
    }

    /// Where the nearest depth line crosses the beam.
    pub fn near_end(&self) -> Point2<f64> {
        self.near_end
    }

    /// Unit direction, away from the sensor.
    pub fn direction(&self) -> Vector2<f64> {
        self.direction
    }

    /// The beam's line (Eq. 4.17); (a, b) lies a quarter turn from u towards v off the direction.
    pub fn line(&self) -> BeamLine {
        let (a, b) = (-self.direction.y, self.direction.x);
        BeamLine { a, b, c: -(a * self.near_end.x + b * self.near_end.y) }
    }

    /// The table's entries, nearest first.
    pub fn nodes(&self) -> impl Iterator<Item = GridNode> {
        self.scale.iter().map(|&(t, p)| GridNode { p, at: self.at(t) })
    }

    /// Smallest and largest digitised `p`.
    pub fn p_range(&self) -> (f64, f64) {
        let end = |node: Option<&(f64, f64)>| node.map_or(f64::NAN, |n| n.1);
        (end(self.scale.first()), end(self.scale.last()))
    }

    /// The point at a distance from the near end.
    pub(super) fn at(&self, distance: f64) -> Point2<f64> {
        self.near_end + self.direction * distance
    }

    /// Distance from the near end of a value, interpolated between its two depth lines; `None`
    /// outside the digitised field.
    pub(super) fn distance_of(&self, p: f64) -> Option<f64> {
        let (low, high) = self.p_range();
        let inside = p >= low * (1.0 - ROUNDING) && p <= high * (1.0 + ROUNDING);
        inside.then(|| self.interpolated(p, |n| n.1, |n| n.0))
    }

    /// `p` at a distance from the near end; `None` outside the digitised field.
    pub(super) fn p_of(&self, distance: f64) -> Option<f64> {
        let p = self.interpolated(distance, |n| n.0, |n| n.1);
        // One rounding more than `distance_of`, so that whatever that accepts comes back.
        let (low, high) = self.p_range();
        let inside = p >= low * (1.0 - 1.01 * ROUNDING) && p <= high * (1.0 + 1.01 * ROUNDING);
        inside.then_some(p)
    }

    /// The part of the beam with values from `nearest` to `farthest`, as distances; `None` if the
    /// digitised field has no such values.
    pub(super) fn span(&self, nearest: f64, farthest: f64) -> Option<(f64, f64)> {
        let (low, high) = self.p_range();
        let near = nearest.max(low * (1.0 - ROUNDING));
        let far = farthest.min(high * (1.0 + ROUNDING));
        if near > far {
            return None;
        }
        Some((self.distance_of(near)?, self.distance_of(far)?))
    }

    /// One of a node's two numbers from the other, linear between nodes and just beyond the ends.
    fn interpolated(
        &self,
        value: f64,
        from: impl Fn(&(f64, f64)) -> f64,
        to: impl Fn(&(f64, f64)) -> f64,
    ) -> f64 {
        let next = self.scale.partition_point(|n| from(n) < value);
        let low = next.saturating_sub(1).min(self.scale.len().saturating_sub(2));
        let (Some(a), Some(b)) = (self.scale.get(low), self.scale.get(low + 1)) else {
            return f64::NAN;
        };
        let part = (value - from(a)) / (from(b) - from(a));
        // Exact at both nodes, so that a node goes there and back unchanged.
        to(a) * (1.0 - part) + to(b) * part
    }
}

/// Both lookup tables of a scanner: one beam per column, over the local frame (u, v).
///
/// Built by [`super::digitize`]. Between two beams, a point with value `p` lies on the segment that
/// joins the two beams' points of that value: bilinear in the device coordinates.
#[derive(Debug, Clone)]
pub struct DigitizedField {
    columns: usize,
    /// Usable beams with their columns, columns rising; two or more.
    beams: Vec<(usize, Beam)>,
    /// +1 if the next column's beam lies on the side to which its line's (a, b) points, otherwise
    /// −1.
    turn: f64,
}

impl DigitizedField {
    /// A field from beams that do not cross, or the column from which on they do.
    pub(super) fn new(columns: usize, beams: Vec<(usize, Beam)>) -> Result<Self, usize> {
        let mut turn = 0.0;
        for (here, next) in beams.iter().zip(beams.iter().skip(1)) {
            let side = side_of_next(&here.1, &next.1).ok_or(here.0)?;
            if turn * side < 0.0 {
                return Err(here.0);
            }
            turn = side;
        }
        Ok(Self { columns, beams, turn })
    }

    /// Number of columns, with and without a usable beam.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// A column's beam; `None` where the sweeps left none.
    pub fn beam(&self, column: usize) -> Option<&Beam> {
        let place = self.beams.binary_search_by_key(&column, |b| b.0).ok()?;
        self.beams.get(place).map(|b| &b.1)
    }

    /// The usable beams with their columns.
    pub fn beams(&self) -> impl Iterator<Item = (usize, &Beam)> {
        self.beams.iter().map(|(column, beam)| (*column, beam))
    }

    /// +1 if columns run to the side a beam line's (a, b) points to, −1 if to the other.
    pub(super) fn turn(&self) -> f64 {
        self.turn
    }

    /// `f` of the local frame: the point of a value on a column that may lie between two beams;
    /// `None` outside the digitised field.
    pub fn forward(&self, column: f64, p: f64) -> Option<Point2<f64>> {
        let low = column.floor();
        let part = column - low;
        if !(low >= 0.0 && low < self.columns as f64) {
            return None;
        }
        let on = |column: usize| self.beam(column).and_then(|b| Some(b.at(b.distance_of(p)?)));
        let left = on(low as usize)?;
        if part == 0.0 {
            return Some(left);
        }
        Some(left + (on(low as usize + 1)? - left) * part)
    }

    /// `F` of the local frame: column and `p` of a point; `None` outside the digitised field.
    pub fn inverse(&self, at: &Point2<f64>) -> Option<(f64, f64)> {
        let passed = |b: &(usize, Beam)| self.turn * b.1.line().distance(at) >= 0.0;
        let cell = self.beams.partition_point(passed).saturating_sub(1);
        let cell = cell.min(self.beams.len().saturating_sub(2));
        let (left, right) = (self.beams.get(cell)?, self.beams.get(cell + 1)?);
        let on_one = on_beam(left, at).or_else(|| on_beam(right, at));
        if on_one.is_some() || left.0 + 1 != right.0 {
            return on_one;
        }
        let (part, p) = between(&left.1, &right.1, at)?;
        Some((left.0 as f64 + part, p))
    }
}

/// The side of a beam the next one runs on, if it stays there over their common values.
fn side_of_next(here: &Beam, next: &Beam) -> Option<f64> {
    let (low, high) = common_range(here, next)?;
    let line = here.line();
    let side = |p: f64| Some(line.distance(&next.at(next.distance_of(p)?)));
    let (near, far) = (side(low)?, side(high)?);
    (near * far > 0.0).then(|| near.signum())
}

fn common_range(a: &Beam, b: &Beam) -> Option<(f64, f64)> {
    let (a, b) = (a.p_range(), b.p_range());
    let common = (a.0.max(b.0), a.1.min(b.1));
    (common.0 < common.1).then_some(common)
}

/// Column and `p` of a point on a beam's own line.
fn on_beam((column, beam): &(usize, Beam), at: &Point2<f64>) -> Option<(f64, f64)> {
    let scale = beam.scale.last()?.0 + at.coords.norm();
    let near = beam.line().distance(at).abs() <= ON_BEAM * scale;
    let p = near.then(|| beam.p_of(beam.direction.dot(&(at - beam.near_end))))?;
    Some((*column as f64, p?))
}

/// The place of a point between two beams, from 0 to 1, and its `p`.
///
/// The segment between the beams' points of one value sweeps over the cell once as the value grows.
/// So bisection on the side of the point finds it; 2⁻⁵² of the range is rounding.
fn between(left: &Beam, right: &Beam, at: &Point2<f64>) -> Option<(f64, f64)> {
    let (mut low, mut high) = common_range(left, right)?;
    let ends = |p: f64| Some((left.at(left.distance_of(p)?), right.at(right.distance_of(p)?)));
    let side = |p: f64| ends(p).map(|(a, b)| (b - a).perp(&(at - a)));
    let (at_low, at_high) = (side(low)?, side(high)?);
    if at_low * at_high > 0.0 {
        return None;
    }
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if side(middle)? * at_high > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    let p = 0.5 * (low + high);
    let (a, b) = ends(p)?;
    let part = (at - a).dot(&(b - a)) / (b - a).norm_squared();
    (0.0..=1.0).contains(&part).then_some((part, p))
}
