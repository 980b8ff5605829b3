//! The motion that all views share, which no comparison of views can find.
//!
//! **Problem.** Refined poses fit each other, but all of them may have moved together. Wanted: the
//! rigid motion that takes the refined surfaces back to where the given poses put them. A view that
//! was far off must not draw the others after it.
//!
//! **Idea.** The rigid motion of least squares (Kabsch, 1976). A view that stays farther away than
//! most loses weight, more quickly than by Huber (1964), and stays to be seen.
//!
//! **Steps.**
//! 1. Fit. Of few views, one that was far off draws the fit so much that no view stands out. So the
//!    motions that put single views where they were given are tried, too. One of them is taken if
//!    the roots of the distances of all views add up to clearly less: few views off rather than
//!    all.
//! 2. Weigh every view by its distance; fit again.

use crate::tuning::{CLEARLY_LESS, COMMON_CUT, COMMON_ROUNDS};
use nalgebra::{Matrix3, UnitQuaternion};
use transect_device::{Isometry3, Point3, Vector3, median};

/// Points of one view's surface in the world.
pub(super) struct OfView {
    /// At the refined pose.
    pub from: Vec<Point3>,
    /// The same points at the given pose.
    pub to: Vec<Point3>,
}

impl OfView {
    /// Root mean square distance that a motion leaves.
    fn distance(&self, motion: &Isometry3) -> f64 {
        let pairs = self.from.iter().zip(&self.to);
        let sum: f64 = pairs.map(|(a, b)| (motion * a - b).norm_squared()).sum();
        (sum / self.from.len().max(1) as f64).sqrt()
    }
}

/// The motion that takes the refined surfaces of most views to the given ones, and the weights of
/// the views.
pub(super) fn common_motion(views: &[OfView]) -> (Isometry3, Vec<f64>) {
    let mut weights = vec![1.0; views.len()];
    let mut motion = first_motion(views, rigid_fit(views, &weights));
    for _ in 0..COMMON_ROUNDS {
        let distances: Vec<f64> = views.iter().map(|view| view.distance(&motion)).collect();
        let limit = COMMON_CUT * median(distances.iter().copied()).unwrap_or(0.0);
        if distances.iter().all(|&distance| distance <= limit) {
            break;
        }
        let weight = |&d: &f64| if d > limit { (limit / d).powi(2) } else { 1.0 };
        weights = distances.iter().map(weight).collect();
        motion = rigid_fit(views, &weights);
    }
    (motion, weights)
}

/// The motion of all views together, or one that puts a single view where it was given.
fn first_motion(views: &[OfView], of_all: Isometry3) -> Isometry3 {
    let sum =
        |motion: &Isometry3| views.iter().map(|view| view.distance(motion).sqrt()).sum::<f64>();
    let alone = |k: usize| {
        let weights: Vec<f64> = (0..views.len()).map(|j| f64::from(u8::from(j == k))).collect();
        rigid_fit(views, &weights)
    };
    let motions = (0..views.len()).map(alone).map(|motion| (sum(&motion), motion));
    let best = motions.min_by(|(a, _), (b, _)| a.total_cmp(b));
    best.filter(|(left, _)| *left < CLEARLY_LESS * sum(&of_all))
        .map_or(of_all, |(_, motion)| motion)
}

/// The rigid motion of least squares.
fn rigid_fit(views: &[OfView], weights: &[f64]) -> Isometry3 {
    let pairs = || {
        let weighted = views.iter().zip(weights);
        weighted.flat_map(|(view, &w)| view.from.iter().zip(&view.to).map(move |(a, b)| (a, b, w)))
    };
    let total: f64 = pairs().map(|(_, _, w)| w).sum();
    if total <= 0.0 {
        return Isometry3::identity();
    }
    let from_mean = pairs().map(|(a, _, w)| a.coords * w).sum::<Vector3>() / total;
    let to_mean = pairs().map(|(_, b, w)| b.coords * w).sum::<Vector3>() / total;
    let scatter = pairs().fold(Matrix3::zeros(), |sum, (a, b, w)| {
        sum + (b.coords - to_mean) * (a.coords - from_mean).transpose() * w
    });
    let rotation = UnitQuaternion::from_matrix(&rotation_of(&scatter));
    Isometry3::from_parts((to_mean - rotation * from_mean).into(), rotation)
}

/// The rotation nearest to a scatter matrix.
fn rotation_of(scatter: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = scatter.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let mut mirror = Matrix3::identity();
    mirror[(2, 2)] = (u * v_t).determinant().signum();
    u * mirror * v_t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Views of 20 points each, whose refined surfaces are the given ones, moved by a motion of
    /// their own and then by a common one.
    fn views(own: &[Isometry3], common: &Isometry3) -> Vec<OfView> {
        let wave = |k: usize, j: usize| (1.0 + (7 * k + 3 * j) as f64 * 1.7).sin();
        let point = |k: usize, j: usize| Point3::new(wave(k, j), wave(k + 5, j), wave(k, j + 9));
        let view = |(k, own): (usize, &Isometry3)| {
            let to: Vec<Point3> = (0..20).map(|j| point(k, j)).collect();
            OfView { from: to.iter().map(|p| common * (own * p)).collect(), to }
        };
        own.iter().enumerate().map(view).collect()
    }

    #[test]
    fn a_view_far_off_does_not_draw_the_others() {
        let common = Isometry3::new(Vector3::new(0.02, -0.01, 0.03), Vector3::new(0.0, 0.01, 0.02));
        let small = |k: usize| Isometry3::translation(1e-4 * (k as f64).sin(), 1e-4, 0.0);
        let mut own: Vec<Isometry3> = (0..12).map(small).collect();
        let mean = common_motion(&views(&own, &common)).0 * common;
        assert!(mean.translation.vector.norm() < 3e-4, "{mean}");
        own[5] = Isometry3::new(Vector3::new(0.5, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.2));
        let left = common_motion(&views(&own, &common)).0 * common;
        assert!(left.translation.vector.norm() < 1e-3, "{left}");
        assert!(left.rotation.angle() < 1e-3, "{left}");
    }

    /// Three stations of a survey, of which one is off: the fit of all turns the whole.
    #[test]
    fn of_three_views_the_one_that_was_off_moves_alone() {
        let common = Isometry3::new(Vector3::new(0.02, -0.01, 0.03), Vector3::new(0.0, 0.01, 0.02));
        let small = |k: usize| Isometry3::translation(1e-4 * (k as f64).sin(), 1e-4, 0.0);
        let off = Isometry3::translation(0.02, 0.0, 0.0);
        let own = [small(1), off, small(2)];
        let all = views(&own, &common);
        let fit = rigid_fit(&all, &[1.0; 3]) * common;
        let (motion, weights) = common_motion(&all);
        let left = motion * common;
        assert!(fit.translation.vector.norm() > 5e-3, "{fit}");
        assert!(left.rotation.angle() < 1e-3, "{left}");
        assert!(left.translation.vector.norm() < 5e-4, "{left}");
        assert!(weights[1] < 0.01 && weights[0] == 1.0, "{weights:?}");
    }
}
