//! The distance from a curve up to which its perpendicular planes do not cross.
//!
//! Within the *reach* of a curve every point has one nearest point on it, and that point's plane
//! alone (H. Federer, Curvature measures, Transactions of the AMS 93, 1959, Theorem 4.18): the
//! infimum over pairs a, b of `|b − a|² / (2 · distance of b from the tangent at a)`. It is at most
//! the radius of curvature, and at most half the distance between parts that come close.

use super::path::Path;
use super::path_point::{PathPoint, Tightest};

/// Samples whose pairs are compared. Chosen by hand; doubled, building a guide takes four times as
/// long, and narrow passages between its parts are found more exactly.
const SAMPLES: usize = 800;

/// Reach of a curve that goes on straight for a length `beyond` its ends, and where it is least.
pub(super) fn reach(path: &Path, beyond: f64) -> Tightest {
    let (first, last) = (-beyond, path.length() + beyond);
    let station = |k: usize| first + (last - first) * k as f64 / (SAMPLES - 1) as f64;
    let samples: Vec<PathPoint> = (0..SAMPLES).map(|k| path.at(station(k))).collect();
    let mut least = path.sharpest();
    for (k, a) in samples.iter().enumerate() {
        for b in &samples {
            let d = b.point - a.point;
            let aside = (d - a.tangent * d.dot(&a.tangent)).norm();
            // For points in line the quotient is large or infinite, never small.
            let radius = d.norm_squared() / (2.0 * aside);
            let station = station(k).clamp(0.0, path.length());
            least = least.or(Tightest { radius, station });
        }
    }
    least
}
