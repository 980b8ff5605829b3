//! From traces to curves: subpixel places, direction, and the nodes' errors and normals.

use super::code::Surface;
use super::crossing::Crossing;
use super::orient::Orient;
use super::samples::Samples;
use super::trace::{Border, Trace};
use crate::PartialCurve;
use crate::node_values::{LARGEST_SIGMA_FACTOR, sigma_between, sine_between, tan_incidence};
use crate::repeats::drop_repeats;
use crate::subpixel::{PairLine, Solver};
use transect_device::{Neighbour, Pixel, Point3, Vector3};
use transect_geometry::{Node, Vector2};
use transect_image::PreparedView;

/// Smallest factor between range noise and the error across the curve: oblique surfaces would claim
/// an accuracy that their normal does not support.
const SMALLEST_SIGMA_FACTOR: f64 = 0.25;

/// Nodes on each side over which the pixels along the curve are counted.
const COUNTED_NODES: usize = 6;

/// Makes the curves of one plane.
pub(super) struct Maker<'a> {
    pub samples: &'a Samples<'a>,
    pub surface: &'a Surface<'a>,
    pub orient: Orient<'a>,
    pub level: i32,
    pub solver: Solver<'a>,
    pub prepared: &'a PreparedView<'a>,
}

impl Maker<'_> {
    /// The curve of a trace; `None` if it is too short for one.
    pub fn curve(&self, trace: &Trace) -> Option<PartialCurve> {
        self.directed(trace, self.crossings(trace))
    }

    /// The curve of a trace through its crossings, with its solid on the left.
    pub fn directed(&self, trace: &Trace, mut crossings: Vec<Crossing>) -> Option<PartialCurve> {
        let closed = trace.ends.is_none();
        let mut ends = trace.ends;
        if !self.orient.solid_on_left(&crossings, closed, trace.high_on_left) {
            reverse(&mut crossings, closed);
            ends = ends.map(|[a, b]| [b, a]);
        }
        let node = |k: usize| self.node(&crossings, k, closed);
        let nodes = (0..crossings.len()).map(node).collect();
        let pixels = crossings.iter().map(|c| c.nearest).collect();
        PartialCurve::new((nodes, closed), pixels, ends)
    }

    /// The nodes' places, in the order of the trace.
    pub fn crossings(&self, trace: &Trace) -> Vec<Crossing> {
        let mut found: Vec<Crossing> = Vec::with_capacity(trace.borders.len());
        for border in &trace.borders {
            match self.crossing(border) {
                Some(crossing) => found.push(crossing),
                // Where thinning moved a border, the plane does not pass between its samples.
                None => {
                    if let Some(last) = found.last_mut() {
                        last.bridged_after |= border.bridged_after;
                    }
                }
            }
        }
        drop_repeats(&mut found, trace.ends.is_none());
        found
    }

    fn crossing(&self, border: &Border) -> Option<Crossing> {
        let (second, neighbour) = (border.pixel, border.neighbour);
        let first = self.samples.grid.before(second, neighbour)?;
        let high = |p| Some(self.samples.level(p)? > f64::from(self.level));
        if high(first)? == high(second)? {
            return None;
        }
        let meeting = self.solver.meet(&self.line(first, second, neighbour))?;
        let points = [self.point(first)?, self.point(second)?];
        Some(Crossing {
            first,
            second,
            neighbour,
            position: self.samples.axes.in_plane(&meeting.point),
            parameter: meeting.parameter,
            nearest: if meeting.parameter < 0.5 { first } else { second },
            pair_length: (points[1] - points[0]).norm(),
            bridged_after: border.bridged_after,
        })
    }

    fn point(&self, p: Pixel) -> Option<Point3> {
        self.samples.view.point_in_sensor(p)
    }

    /// The pair with its next pixels on the same surface.
    fn line(&self, first: Pixel, second: Pixel, neighbour: Neighbour) -> PairLine {
        let grid = &self.samples.grid;
        let before = grid.before(first, neighbour);
        let (rows, cols) = if neighbour == Neighbour::Up { (1, 0) } else { (0, 1) };
        let after = grid.step(second, rows, cols);
        PairLine {
            before: before.filter(|_| self.surface.joined(first, neighbour)),
            first,
            second,
            after: after.filter(|after| self.surface.joined(*after, neighbour)),
        }
    }

    /// Outward unit normal of the surface in plane coordinates; `None` where unknown.
    ///
    /// From the pair itself and the differences across it at both its pixels.
    fn normal(&self, crossing: &Crossing) -> Option<Vector3> {
        let along = self.point(crossing.second)? - self.point(crossing.first)?;
        let other = match crossing.neighbour {
            Neighbour::Up => Neighbour::Left,
            Neighbour::Left => Neighbour::Up,
        };
        let differences = [crossing.first, crossing.second].map(|p| self.difference(p, other));
        let across: Vector3 = differences.into_iter().flatten().sum();
        let normal = along.cross(&across).try_normalize(0.0)?;
        let ray = self.samples.view.frame().ray(crossing.nearest)?.direction;
        let outward = if normal.dot(&ray) > 0.0 { -normal } else { normal };
        Some(self.samples.axes.turn(&outward))
    }

    /// Change of the surface point along rows or columns at a pixel, from either side.
    fn difference(&self, p: Pixel, neighbour: Neighbour) -> Option<Vector3> {
        let grid = &self.samples.grid;
        let (rows, cols) = if neighbour == Neighbour::Up { (1, 0) } else { (0, 1) };
        let before = grid.before(p, neighbour).filter(|_| self.surface.joined(p, neighbour));
        let after = grid.step(p, rows, cols).filter(|a| self.surface.joined(*a, neighbour));
        let (from, to) = (before.unwrap_or(p), after.unwrap_or(p));
        (from != to).then(|| Some(self.point(to)? - self.point(from)?)).flatten()
    }

    fn node(&self, crossings: &[Crossing], k: usize, closed: bool) -> Node {
        let Crossing { nearest: pixel, parameter, bridged_after, .. } = crossings[k];
        let normal = self.normal(&crossings[k]);
        let ray = self.samples.view.frame().ray(pixel);
        let ray = self.samples.axes.turn(&ray.map_or(Vector3::z(), |r| r.direction));
        let sigma = sigma_between(self.prepared, pixel, parameter);
        let footprint = footprint(crossings, k, closed, normal.as_ref(), &ray);
        let factor = normal.map_or(LARGEST_SIGMA_FACTOR, |normal| sigma_factor(&normal, &ray));
        Node::at(crossings[k].position)
            .with_sigma((sigma * factor) as f32)
            .with_footprint(footprint as f32)
            .with_correlation((footprint * self.prepared.shared_pixels(pixel)) as f32)
            .with_tan_incidence(normal.map(|normal| tan_incidence(&normal, &ray)))
            .with_normal(normal.map(|normal| normal.cast()))
            .with_bridged(bridged_after)
    }
}

/// Turns a curve round; what lies after a node lies before it then.
fn reverse(crossings: &mut [Crossing], closed: bool) {
    crossings.reverse();
    let n = crossings.len();
    let after: Vec<bool> = crossings.iter().map(|c| c.bridged_after).collect();
    for (k, crossing) in crossings.iter_mut().enumerate() {
        let next = if closed { (k + 1) % n } else { k + 1 };
        crossing.bridged_after = after.get(next).copied().unwrap_or(false);
    }
}

/// Error across the curve per error along the ray.
///
/// A sample displaced by δ along the ray d moves the surface by δ (d · N) along its normal N. It
/// moves the section by that over the sine of the angle between surface and plane.
fn sigma_factor(normal: &Vector3, ray: &Vector3) -> f64 {
    let factor = ray.dot(normal).abs() / normal.x.hypot(normal.y);
    if factor.is_nan() {
        LARGEST_SIGMA_FACTOR
    } else {
        factor.clamp(SMALLEST_SIGMA_FACTOR, LARGEST_SIGMA_FACTOR)
    }
}

/// Length along the curve that one pixel covers. It is the larger of the samples' spacing along the
/// curve and the curve's length per pixel of the kind it crosses more often.
fn footprint(
    crossings: &[Crossing],
    k: usize,
    closed: bool,
    normal: Option<&Vector3>,
    ray: &Vector3,
) -> f64 {
    let n = crossings.len();
    let reach = COUNTED_NODES.min((n - 1) / 2);
    let at = |steps: i64| {
        let place = k as i64 + steps;
        &crossings[place.rem_euclid(n as i64) as usize]
    };
    let (before, behind) =
        if closed { (reach, reach) } else { (reach.min(k), reach.min(n - 1 - k)) };
    let (from, to) = (-(before as i64), behind as i64);
    let rows = (from..to).filter(|s| at(*s).neighbour == Neighbour::Up).count();
    let pixels = rows.max(before + behind - rows);
    let chords = [(from, 0), (0, to)].map(|(a, b)| (at(b).position - at(a).position).norm());
    let tangent = normal.and_then(|normal| Vector2::new(-normal.y, normal.x).try_normalize(0.0));
    let tangent = tangent.unwrap_or_else(Vector2::x);
    let across_ray = normal.map_or(1.0, |normal| ray_sine(normal, ray));
    let spacing = crossings[k].pair_length * across_ray / sine_between(&tangent, ray);
    if pixels < 3 { spacing } else { spacing.max((chords[0] + chords[1]) / pixels as f64) }
}

/// Cosine of the incidence: samples of an oblique surface lie this much closer across the ray.
fn ray_sine(normal: &Vector3, ray: &Vector3) -> f64 {
    let cos = normal.dot(ray).abs();
    if cos > 0.0 { cos } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_across_the_curve_follows_the_angles() {
        let head_on = sigma_factor(&Vector3::new(0.0, -1.0, 0.0), &Vector3::y());
        assert!((head_on - 1.0).abs() < 1e-12);
        let slope = Vector3::new(0.0, -0.6, 0.8);
        let from_above = sigma_factor(&slope, &-Vector3::z());
        assert!((from_above - 0.8 / 0.6).abs() < 1e-12, "{from_above}");
        assert_eq!(sigma_factor(&Vector3::z(), &-Vector3::z()), LARGEST_SIGMA_FACTOR, "a floor");
    }
}
