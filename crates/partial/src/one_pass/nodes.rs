//! The nodes of a curve: place, errors, footprint, normal and incidence.

use super::crossing::Crossing;
use crate::node_values::{LARGEST_SIGMA_FACTOR, sigma_between, sine_between, tan_incidence};
use transect_device::Vector3;
use transect_geometry::{Node, Vector2};
use transect_image::PreparedView;

/// Nodes on each side that give a node its direction; pixels alternate between two kinds of pairs,
/// so fewer would see their zigzag.
const TANGENT_NODES: usize = 3;

/// Makes the nodes of curves.
pub(super) struct NodeMaker<'a> {
    pub prepared: &'a PreparedView<'a>,
    /// Smallest factor between range noise and the error across the curve.
    pub least_sigma_factor: f64,
    /// The crossings of one curve, in order.
    pub crossings: Vec<Crossing>,
    /// How many of the crossings before each are across rows; see [`NodeMaker::count_upward`].
    pub upward: Vec<u32>,
}

impl NodeMaker<'_> {
    /// To be called when there are other crossings.
    pub fn count_upward(&mut self) {
        self.upward.clear();
        self.upward.push(0);
        let mut count = 0;
        for crossing in &self.crossings {
            count += u32::from(crossing.across_rows);
            self.upward.push(count);
        }
    }

    /// The node at a crossing.
    pub fn node(&self, k: usize, closed: bool) -> Node {
        let crossing = &self.crossings[k];
        let tangent = self.tangent(k, closed);
        let across = self.across(k, closed, &tangent);
        let ray = crossing.ray;
        let footprint = self.footprint(k, closed, &tangent, &ray);
        let factor = sigma_factor(&tangent, &across, &ray).max(self.least_sigma_factor);
        let along_ray = sigma_between(self.prepared, crossing.pixel, f64::from(crossing.share));
        let sigma = (along_ray * factor).hypot(off_chord(crossing, &tangent, &across));
        let normal = surface_normal(&tangent, &across, &ray);
        let shared = self.prepared.shared_pixels(crossing.pixel);
        Node::at(crossing.position)
            .with_sigma(sigma as f32)
            .with_footprint(footprint as f32)
            .with_correlation((footprint * shared) as f32)
            .with_tan_incidence(normal.map(|normal| tan_incidence(&normal, &ray)))
            .with_normal(normal.map(|normal| normal.cast()))
            .with_bridged(crossing.bridged_after)
    }

    /// A step on the surface across the curve, to its high side, from all crossings around a node:
    /// a single pair's direction is as noisy as its two samples.
    fn across(&self, k: usize, closed: bool, tangent: &Vector2) -> Vector3 {
        let n = self.crossings.len();
        let (before, after) = self.neighbours(k, closed, TANGENT_NODES);
        let span = if after < before { after + n - before } else { after - before };
        // With the solid on the left, the way along the curve, the way up and the outward normal
        // are right-handed, and the normal is against the ray. A step's own height would not do: it
        // is as often wrong as right where the pair lies along the curve.
        let aside = self.crossings[k].ray.cross(&Vector3::new(tangent.x, tangent.y, 0.0));
        let (to_end, from_start) = (&self.crossings[before..], &self.crossings[..before]);
        let mut sum = Vector3::zeros();
        for crossing in to_end.iter().chain(from_start).take(span + 1) {
            let step = crossing.across;
            sum += if aside.dot(&step) > 0.0 { -step } else { step };
        }
        sum
    }

    /// Length along the curve that one pixel covers there: the coarser of two measures.
    ///
    /// One is the spacing of the two rays between which the plane passes, seen along the curve. The
    /// other counts: a curve along a row crosses one upward pair per column, one along a column one
    /// sideways pair per row. So the more frequent kind counts the pixels. They differ where rows
    /// and columns are spaced differently; the coarser one limits what is known of the curve.
    fn footprint(&self, k: usize, closed: bool, tangent: &Vector2, ray: &Vector3) -> f64 {
        let spacing = f64::from(self.crossings[k].spacing) / sine_between(tangent, ray);
        let (before, after) = self.neighbours(k, closed, 2 * TANGENT_NODES);
        // Each side by itself, since a corner between them changes the kind; and two chords rather
        // than the way from node to node, which noise makes longer.
        let pixels = self.pixels_between(before, k) + self.pixels_between(k, after);
        let place = |k: usize| self.crossings[k].position;
        let length = (place(after) - place(k)).norm() + (place(k) - place(before)).norm();
        if pixels < TANGENT_NODES { spacing } else { spacing.max(length / pixels as f64) }
    }

    /// Crossings of the more frequent kind on the way from one node to a later one.
    fn pixels_between(&self, from: usize, to: usize) -> usize {
        let n = self.crossings.len();
        // Running counts, since a walk per node would cost more than all the rest.
        let before = |k: usize| self.upward.get(k).map_or(0, |count| *count as usize);
        let (span, upward) = if to >= from {
            (to - from, before(to + 1) - before(from + 1))
        } else {
            (to + n - from, before(n) - before(from + 1) + before(to + 1))
        };
        upward.max(span - upward)
    }

    /// Unit direction of the curve at a node, from nodes [`TANGENT_NODES`] away on both sides.
    fn tangent(&self, k: usize, closed: bool) -> Vector2 {
        let (before, after) = self.neighbours(k, closed, TANGENT_NODES);
        let d = self.crossings[after].position - self.crossings[before].position;
        d.try_normalize(0.0).unwrap_or_else(Vector2::x)
    }

    /// The nodes that are `reach` before and after a node, nearer at open ends and on small rings.
    fn neighbours(&self, k: usize, closed: bool, reach: usize) -> (usize, usize) {
        let n = self.crossings.len();
        if closed {
            let reach = reach.min((n - 1) / 2);
            let around = |k: usize| if k < n { k } else { k - n };
            (around(k + n - reach), around(k + reach))
        } else {
            (k.saturating_sub(reach), (k + reach).min(n - 1))
        }
    }
}

/// Error across the curve per error along the ray.
///
/// A sample displaced by δ along the ray `d` moves the surface by δ (d · N) along its normal. It
/// moves the section by that over (m · N), with `m` across the curve in the plane. The normal is N
/// = t × e with the curve's direction t and a step e across it, both on the surface; then m · N is
/// −e's height.
fn sigma_factor(tangent: &Vector2, across: &Vector3, ray: &Vector3) -> f64 {
    let normal = Vector3::new(tangent.x, tangent.y, 0.0).cross(across);
    let factor = (ray.dot(&normal) / across.z).abs();
    if factor.is_nan() { LARGEST_SIGMA_FACTOR } else { factor.min(LARGEST_SIGMA_FACTOR) }
}

/// Error across the curve because the surface may lie off the pair's chord.
///
/// The same angles as for noise; no crossing is off by more than its pair is long.
fn off_chord(crossing: &Crossing, tangent: &Vector2, across: &Vector3) -> f64 {
    let normal = Vector3::new(tangent.x, tangent.y, 0.0).cross(across);
    let off = crossing.bend.along(&normal, &crossing.ray) / across.z.abs();
    if off.is_nan() { 0.0 } else { off.min(crossing.pair.norm()) }
}

/// Unit normal of the surface that holds the curve's direction and a step across it, on the
/// sensor's side; `None` where the two do not span a surface.
fn surface_normal(tangent: &Vector2, across: &Vector3, ray: &Vector3) -> Option<Vector3> {
    let normal = Vector3::new(tangent.x, tangent.y, 0.0).cross(across).try_normalize(0.0);
    let outward = normal.map(|n| if n.dot(ray) > 0.0 { -n } else { n });
    outward.filter(|n| n.iter().all(|c| c.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_across_the_curve_follows_the_angles() {
        let (east, toward) = (Vector2::x(), Vector3::new(0.0, -1.0, 0.0));
        let upright = sigma_factor(&east, &Vector3::new(0.0, 0.0, 1.0), &toward);
        assert!((upright - 1.0).abs() < 1e-12, "a wall seen head-on: {upright}");
        let sloped = sigma_factor(&east, &Vector3::new(0.0, 1.0, 1.0), &toward);
        assert!((sloped - 1.0).abs() < 1e-12, "the section moves along the ray: {sloped}");
        let from_above = sigma_factor(&east, &Vector3::new(0.0, 1.0, 1.0), &-Vector3::z());
        assert!((from_above - 1.0).abs() < 1e-12, "45° slope seen from above: {from_above}");
        let flat = sigma_factor(&east, &Vector3::new(0.0, 1.0, 0.0), &-Vector3::z());
        assert_eq!(flat, LARGEST_SIGMA_FACTOR, "a floor in its own plane");
    }
}
