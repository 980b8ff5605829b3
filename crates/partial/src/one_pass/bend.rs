//! How far the chord of a pair may lie off the surface between its samples.
//!
//! **Problem.** A crossing is linear between two samples. Where the surface has an edge between
//! them, or a rib, the chord cuts the corner. From far away such a chord is long, and passes
//! through space that nearer views looked through. It is no more noisy than other chords, so fusion
//! takes it for another wall.
//!
//! **Idea.** The next samples on the same line tell how much the surface bends. An edge between the
//! samples of a pair bends the parabolas on both sides; one beyond it bends only one of them. So
//! the smaller bend counts.
//!
//! **Steps.**
//! 1. A parabola through the pair and the sample before it, and one with the sample after it. Their
//!    distances from the chord at the crossing are second differences of three samples.
//! 2. The one nearer to the chord counts, or the only one where the surface ends on one side.
//! 3. What noise makes of that distance is taken off.
//! 4. The rest across the curve, times [`EDGE`], is a standard deviation of the node.
//!
//! **Worth.** A hall of 200 m, eight scans: the 95 % distance falls from 30 to 4.5 mm, and no false
//! piece is left of five. A tunnel: from 9.8 to 6.2 mm. The median of parts falls by 16 % without
//! noise, and by 1 % with it. If the larger bend counts, medians of rooms and of a face are 2 %
//! larger. A run takes 2 to 4 % longer.
//!
//! **Known bias.** The subpixel solution `four_point` follows smooth bends, and errs less than this
//! tells.
//!
//! **Source.** Not in the dissertation. The error of linear interpolation is that of textbooks.

use crate::subpixel::PairLine;
use transect_device::{PairGeometry, Pixel, Point3, Vector3};
use transect_image::{BreakRule, PreparedView};

/// Distance of the surface from the chord, in that of the nearer parabola. Theory: smooth surfaces
/// have 1, an edge midway between the samples has 4 at a crossing there and 2 close to a sample.
/// Doubled: corners of a coarse block are cut by more than half a footprint, and the tunnel errs by
/// a tenth less.
const EDGE: f64 = 2.0;

/// The bend of the surface at a crossing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bend {
    /// From the chord to the parabola, in plane coordinates with the height third.
    off: [f32; 3],
    /// Variance of its length by the noise of the samples, along the ray.
    variance: f32,
}

impl Bend {
    /// The bend at a share of the way between the samples of a pair.
    ///
    /// `chord` leads from the first sample to the second, and `ray` is the direction of either.
    /// `line` holds the next samples, whether they are on the pair's surface or not. `step` leads
    /// from one of these to one of the pair. All are in plane coordinates.
    ///
    /// The next samples count as they were given, since those far from all planes are not smoothed.
    pub fn at(
        share: f64,
        [chord, ray]: [&Vector3; 2],
        line: &PairLine,
        (prepared, rule): (&PreparedView<'_>, &BreakRule),
        step: impl Fn(Pixel, Pixel) -> Option<Vector3>,
    ) -> Self {
        let PairLine { before, first, second, after } = *line;
        // The pair's own ray will do for its neighbours, and saves theirs.
        let side = |beyond: Pixel, near: Pixel, chord: Vector3| {
            let step = step(beyond, near)?;
            let jump = PairGeometry::between(&Point3::origin(), &step.into(), ray);
            rule.holds(&jump).then(|| (chord - step, near, beyond))
        };
        let before = before.and_then(|beyond| side(beyond, first, *chord));
        let after = after.and_then(|beyond| side(beyond, second, -chord));
        let [size_before, size_after] =
            [before, after].map(|side| side.map_or(f64::INFINITY, |(bend, ..)| bend.norm()));
        let smaller = if size_after < size_before { after } else { before };
        let Some((bend, middle, beyond)) = smaller else { return Self::default() };
        let other = if middle == first { second } else { first };
        let variance = |pixel| prepared.sigma_of_group(pixel).powi(2);
        let given = prepared.given_sigma_of_group(beyond).powi(2);
        let noise = given + 4.0 * variance(middle) + variance(other);
        let parabola = 0.5 * share * (1.0 - share);
        Self {
            off: (bend * parabola).map(|c| c as f32).into(),
            variance: (noise * parabola * parabola) as f32,
        }
    }

    /// Standard deviation of the chord along a surface's normal of any length, in this length.
    pub fn along(&self, normal: &Vector3, ray: &Vector3) -> f64 {
        let noise = f64::from(self.variance) * ray.dot(normal).powi(2);
        let off = Vector3::from(self.off.map(f64::from)).dot(normal);
        EDGE * (off * off - noise).max(0.0).sqrt()
    }
}
