//! A piece of surface of second order, fitted to the samples of one cell of pixels.
//!
//! **Problem.** Poses are compared at places where one view's surface meets another's. Single
//! samples are too noisy for that, and their neighbours are too far away.
//!
//! **Idea.** Depth over the image is of second order within a few pixels. The pixels' rays are
//! known and their depths err, so depths are fitted over the rays. A fit in space would take noise
//! along oblique rays for a tilt. Cells do not overlap, so the noise of patches is independent.
//!
//! **Steps.**
//! 1. The base plane lies across the middle ray at the mean depth. Every sample gets the place
//!    `a`, `b` of its ray in it, and `w = h / (1 + γ h)` for its height `h` beyond it. `γ` is the
//!    divergence of the rays, 1 / distance from a common start and 0 for parallel rays. Planes in
//!    space are linear in `a` and `b` then.
//! 2. Least squares of `w = c0 + c1 a + c2 b + c3 a² + c4 a b + c5 b²` over the samples, and of its
//!    linear part where noise explains the rest.
//! 3. What the samples depart from it is compared with their noise; a crease, a jump or texture is
//!    no patch. What noise hardly explains is an error of the patch, which does not average out.
//!
//! **Known bias.** Where noise hides a bend, the patch is a plane, and its point lies behind the
//! surface. Refined views around a part move apart by some hundredths of a sample's noise. Bends
//! from the means of nine patches removed this bias, but sections became no more accurate. Views
//! around thin plates got more false pieces, since the normals of flat surfaces became noisier.

use crate::tuning::{
    FLAT, FOLDED, LEAST_FILLED, MAX_INCIDENCE_DEGREES, ROUGH, SAME_SURFACE, SAMPLING_ROUGH,
};
use nalgebra::{Matrix3, Matrix6, Vector6};
use transect_device::{Point3, Ray, Vector3};

/// A patch of surface, in the sensor frame of its view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// On the middle ray, at the mean depth of the samples.
    center: Point3,
    /// Two directions across the middle ray, and the ray's.
    axes: [Vector3; 3],
    /// Divergence of the rays, in 1 / length.
    divergence: f64,
    /// `w` over the rays: 1, a, b, a², ab, b² with `a` and `b` in units of `radius`.
    depth: [f64; 6],
    radius: f64,
    /// Standard deviation of the samples' mean along the ray.
    sigma: f64,
    /// Whether it is a plane.
    flat: bool,
    /// Slopes of `w` along the first two axes, no units, from the patches around, too.
    steady_slopes: [f64; 2],
}

/// A patch as it is kept. The ray of its cell gives the rest.
///
/// Single precision is enough: depths are fitted relative to the place that is kept, so their
/// rounding is a share of the patch's own relief.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
pub(super) struct StoredPatch {
    mean_depth: f32,
    divergence: f32,
    depth: [f32; 6],
    radius: f32,
    sigma: f32,
    steady_slopes: [f32; 2],
    flat: bool,
}

impl StoredPatch {
    pub fn new(patch: &Patch, ray: &Ray) -> Self {
        Self {
            mean_depth: (patch.center - ray.start).dot(&ray.direction) as f32,
            divergence: patch.divergence as f32,
            depth: patch.depth.map(|c| c as f32),
            radius: patch.radius as f32,
            sigma: patch.sigma as f32,
            steady_slopes: patch.steady_slopes.map(|slope| slope as f32),
            flat: patch.flat,
        }
    }

    /// Whether all its numbers are finite: those of a file may be anything.
    pub fn is_finite(&self) -> bool {
        let Self { mean_depth, divergence, depth, radius, sigma, steady_slopes, .. } = self;
        let all = depth.iter().chain(steady_slopes);
        all.chain([mean_depth, divergence, radius, sigma]).all(|number| number.is_finite())
    }

    /// The patch with depths multiplied by `scale`, and then an offset added to 1 / depth, along
    /// its rays, which have one start.
    pub fn shifted(&self, scale: f32, offset: f32) -> Self {
        // Depths grow by this factor, and their differences by `relief`.
        let factor = 1.0 / (scale.recip() + offset * self.mean_depth);
        let relief = factor * factor / scale;
        Self {
            mean_depth: factor * self.mean_depth,
            divergence: self.divergence / factor,
            depth: self.depth.map(|c| relief * c),
            radius: factor * self.radius,
            sigma: relief * self.sigma,
            steady_slopes: self.steady_slopes.map(|slope| factor / scale * slope),
            flat: self.flat,
        }
    }

    /// The patch of the cell with this ray; `None` for a ray without a direction.
    pub fn patch(&self, ray: &Ray) -> Option<Patch> {
        Some(Patch {
            center: ray.start + ray.direction * f64::from(self.mean_depth),
            axes: axes(&ray.direction)?,
            divergence: f64::from(self.divergence),
            depth: self.depth.map(f64::from),
            radius: f64::from(self.radius),
            sigma: f64::from(self.sigma),
            flat: self.flat,
            steady_slopes: self.steady_slopes.map(f64::from),
        })
    }
}

/// Root mean square of the departures of samples from a patch, over their noise, up to which noise
/// explains them, with so many samples to spare: the quantile of χ² (Wilson and Hilferty, 1931).
pub(super) fn largest_rough(spare: f64) -> f64 {
    let variance = 2.0 / (9.0 * spare);
    (1.0 - variance + FOLDED * variance.sqrt()).powi(3).sqrt()
}

/// The inputs of the fit of a cell's patch.
pub(super) struct Cell<'a> {
    /// The valid samples, in the sensor frame.
    pub samples: &'a [Point3],
    /// How many pixels the cell has.
    pub pixels: usize,
    /// Its middle ray.
    pub ray: Ray,
    /// A ray at its rim.
    pub rim: Ray,
    /// Range noise of its pixels along the ray, as a length.
    pub sigma: f64,
    /// The same at the view's median pixel.
    pub median_sigma: f64,
    /// Whether what noise does not explain of the samples is an error of the patch. Where
    /// neighbours share most of the noise, it is a part of the noise.
    pub folds: bool,
}

impl Patch {
    /// The patch through a cell's samples; `None` if they are too few or no smooth surface.
    pub(super) fn fit(cell: &Cell<'_>) -> Option<Self> {
        let n = cell.samples.len();
        if n < 8 || (n as f64) < LEAST_FILLED * cell.pixels as f64 {
            return None;
        }
        let mut patch = Self::before_fit(cell)?;
        let mut points: Vec<[f64; 3]> = cell.samples.iter().map(|p| patch.over_rays(p)).collect();
        let radius = points.iter().map(|[a, b, _]| a.abs().max(b.abs())).fold(0.0, f64::max);
        patch.radius = kept(radius);
        for [a, b, _] in &mut points {
            (*a, *b) = (*a / patch.radius, *b / patch.radius);
        }
        let sums = Sums::of(&points);
        let bent = sums.second_order()?;
        let spare = n.checked_sub(6).filter(|n| *n > 0)? as f64;
        let squares_bent = squares(&points, &bent);
        let rough = (squares_bent / spare).sqrt();
        let spacing = 2.0 * patch.radius / (n as f64).sqrt();
        // Neighbours share noise, of which near cells have more than their own noise tells.
        let noise = cell.sigma.max(cell.median_sigma);
        if rough > ROUGH * noise + SAMPLING_ROUGH * spacing {
            return None;
        }
        let variance = rough.max(cell.sigma).powi(2);
        let flat = sums.first_order()?;
        patch.flat = squares(&points, &flat) - squares_bent < FLAT * variance;
        patch.depth = if patch.flat { flat } else { bent };
        // What noise does not explain is no noise, and does not average out.
        let explained = largest_rough(spare) * noise + SAMPLING_ROUGH * spacing;
        let folded = if cell.folds { rough.powi(2) - explained.powi(2) } else { 0.0 };
        patch.sigma = (variance / n as f64 + folded.max(0.0)).sqrt();
        let incidence = -patch.normal().dot(&cell.ray.direction);
        patch.steady_slopes = patch.slopes();
        let seen = incidence >= MAX_INCIDENCE_DEGREES.to_radians().cos();
        (seen && patch.sigma.is_finite()).then_some(patch)
    }

    /// The frame of a patch whose depths are not yet known.
    fn before_fit(cell: &Cell<'_>) -> Option<Self> {
        let Ray { start, direction } = cell.ray;
        let depths = cell.samples.iter().map(|p| (p - start).dot(&direction));
        let mean = depths.sum::<f64>() / cell.samples.len() as f64;
        let center = start + direction * kept(mean);
        Some(Self {
            center,
            axes: axes(&direction)?,
            divergence: kept(divergence(&cell.ray, &cell.rim, &center)),
            depth: [0.0; 6],
            radius: 1.0,
            sigma: 0.0,
            flat: false,
            steady_slopes: [0.0; 2],
        })
    }

    /// Place of a point's ray, in lengths, and `w`.
    fn over_rays(&self, p: &Point3) -> [f64; 3] {
        let d = p - self.center;
        let scale = 1.0 / (1.0 + self.divergence * d.dot(&self.axes[2]));
        self.axes.map(|axis| d.dot(&axis) * scale)
    }

    /// The point of the surface on the middle ray.
    pub fn point(&self) -> Point3 {
        let [w, ..] = self.depth;
        self.center + self.axes[2] * (w / (1.0 - self.divergence * w))
    }

    /// The unit normal there, on the sensor's side.
    pub fn normal(&self) -> Vector3 {
        self.normal_at(0.0, 0.0)
    }

    /// Standard deviation of the point along the normal from noise alone, in the model's unit.
    pub fn sigma(&self) -> f64 {
        self.sigma_at(0.0, 0.0) * -self.normal().dot(&self.axes[2])
    }

    /// The unit normal from a plane through the points of the patches around this one, and from the
    /// tilt of this one.
    ///
    /// The tilt of a single patch is noisy. As a direction in which two views are compared, it
    /// would let noise pass for knowledge about motions along the surface. The patch's own depth
    /// has no part in it: at the rim of an image it would tilt the normal, and the same noise would
    /// be in the distance. Views that slide along a wall are drawn together by such a product.
    pub fn steady_normal(&self) -> Vector3 {
        let ([first, second, along_ray], [a, b]) = (self.axes, self.steady_slopes);
        (first * a + second * b - along_ray).normalize()
    }

    /// Finds the steady normal from the patches around.
    pub(super) fn steady<'a>(&mut self, around: impl Iterator<Item = &'a Patch>) {
        let near = around.filter_map(|other| {
            let [a, b, w] = self.over_rays(&other.point());
            let (a, b) = (a / self.radius, b / self.radius);
            let tolerance = SAME_SURFACE
                * (self.sigma_at(a, b).powi(2) + other.sigma_at(0.0, 0.0).powi(2)).sqrt();
            ((w - at(&self.depth, a, b)).abs() <= tolerance).then_some([a, b, w])
        });
        let points: Vec<[f64; 3]> = near.collect();
        if points.len() < 3 {
            return;
        }
        let [_, along_a, along_b, ..] = self.depth;
        let plane = Sums::of(&points).first_order_with([along_a, along_b], SLOPE);
        let Some(plane) = plane else { return };
        self.steady_slopes = Self { depth: plane, ..*self }.slopes();
    }

    /// The slopes of the surface on the middle ray along the first two axes.
    fn slopes(&self) -> [f64; 2] {
        let [w, along_a, along_b, ..] = self.depth;
        let shrink = self.radius * (1.0 - self.divergence * w);
        [along_a / shrink, along_b / shrink]
    }

    /// Half the side of the square that its rays fill, in the model's length unit.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Signed distance of a point from the surface, positive on the sensor's side, with the
    /// standard deviation there; `None` beyond the rays of the samples.
    pub fn distance(&self, p: &Point3) -> Option<(f64, f64)> {
        let [a, b, w] = self.over_rays(p);
        let (a, b) = (a / self.radius, b / self.radius);
        if a.abs().max(b.abs()) > 1.0 {
            return None;
        }
        let normal = self.normal_at(a, b);
        let incidence = -normal.dot(&self.axes[2]);
        let scale = 1.0 / (1.0 - self.divergence * w);
        let behind = (w - at(&self.depth, a, b)) * scale * scale;
        Some((-behind * incidence, self.sigma_at(a, b) * incidence))
    }

    /// The gradient of `w - c(a, b)` in space, turned to the sensor.
    fn normal_at(&self, a: f64, b: f64) -> Vector3 {
        let [_, c1, c2, c3, c4, c5] = self.depth;
        let along_a = (c1 + 2.0 * c3 * a + c4 * b) / self.radius;
        let along_b = (c2 + c4 * a + 2.0 * c5 * b) / self.radius;
        let shrink = 1.0 - self.divergence * at(&self.depth, a, b);
        let turned = self.divergence * self.radius * (along_a * a + along_b * b);
        let along_ray = shrink + turned;
        let outward = self.axes[0] * along_a + self.axes[1] * along_b - self.axes[2] * along_ray;
        outward.normalize()
    }

    /// The standard deviation along the ray, for samples that are spread evenly over the square: a
    /// sum of squares of Legendre's polynomials up to the patch's order.
    fn sigma_at(&self, a: f64, b: f64) -> f64 {
        let (aa, bb) = (a * a, b * b);
        let plane = 1.0 + 3.0 * (aa + bb);
        let second = |x: f64| 5.0 * (1.5 * x - 0.5).powi(2);
        let bent = second(aa) + second(bb) + 9.0 * aa * bb;
        self.sigma * if self.flat { plane } else { plane + bent }.sqrt()
    }
}

/// How fast a cell's rays run apart at a distance, in 1 / length: by a ray at its rim.
fn divergence(middle: &Ray, rim: &Ray, at: &Point3) -> f64 {
    let along = rim.direction.dot(&middle.direction);
    if along <= 0.0 {
        return 0.0;
    }
    let slope = rim.direction / along - middle.direction;
    let depth = (at - rim.start).dot(&middle.direction);
    let place = rim.start + rim.direction / along * depth - at;
    let square = place.norm_squared();
    if square > 0.0 { slope.dot(&place) / square } else { 0.0 }
}

/// A number as a [`StoredPatch`] keeps it.
fn kept(number: f64) -> f64 {
    f64::from(number as f32)
}

/// Two directions across a ray's, and the ray's.
pub(super) fn axes(direction: &Vector3) -> Option<[Vector3; 3]> {
    let first = direction.cross(&least_axis(direction)).try_normalize(0.0)?;
    Some([first, direction.cross(&first), *direction])
}

/// The coordinate axis that a direction is least along.
fn least_axis(direction: &Vector3) -> Vector3 {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}

/// Powers of `a` and `b` in each term of a patch's depth.
const POWERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

/// Weight of a patch's slope beside that of its depth: the variance of the depth of a plane over
/// that of its slope, for samples that are spread evenly over the square.
const SLOPE: f64 = 1.0 / 3.0;

/// Sums over points, from which the fits of both orders follow.
#[derive(Debug, Default)]
struct Sums {
    /// `Σ aᵐ bⁿ` at `[m][n]`, m + n ≤ 4.
    powers: [[f64; 5]; 5],
    /// `Σ w` times each term.
    depths: [f64; 6],
}

impl Sums {
    fn of(points: &[[f64; 3]]) -> Self {
        let mut sums = Self::default();
        for [a, b, w] in points {
            let powers = |x: f64| [1.0, x, x * x, x * x * x, x * x * x * x];
            let (of_a, of_b) = (powers(*a), powers(*b));
            for (m, row) in sums.powers.iter_mut().enumerate() {
                for n in 0..5 - m {
                    row[n] += of_a[m] * of_b[n];
                }
            }
            for (sum, term) in sums.depths.iter_mut().zip(terms(*a, *b)) {
                *sum += w * term;
            }
        }
        sums
    }

    /// The sum of the products of two terms.
    fn product(&self, i: usize, j: usize) -> f64 {
        let ((mi, ni), (mj, nj)) = (POWERS[i], POWERS[j]);
        self.powers[mi + mj][ni + nj]
    }

    /// The depths of second order that fit the points best.
    fn second_order(&self) -> Option<[f64; 6]> {
        let normal = Matrix6::from_fn(|i, j| self.product(i, j));
        Some(normal.cholesky()?.solve(&Vector6::from(self.depths)).into())
    }

    /// The linear depths that fit the points best.
    fn first_order(&self) -> Option<[f64; 6]> {
        self.first_order_with([0.0; 2], 0.0)
    }

    /// The linear depths that fit the points best, and these slopes with a weight.
    fn first_order_with(&self, slopes: [f64; 2], weight: f64) -> Option<[f64; 6]> {
        let weights = Matrix3::from_diagonal(&Vector3::new(0.0, weight, weight));
        let normal = Matrix3::from_fn(|i, j| self.product(i, j)) + weights;
        let [w, along_a, along_b, ..] = self.depths;
        let [of_a, of_b] = slopes.map(|slope| weight * slope);
        let right = Vector3::new(w, along_a + of_a, along_b + of_b);
        let [c0, c1, c2]: [f64; 3] = normal.cholesky()?.solve(&right).into();
        Some([c0, c1, c2, 0.0, 0.0, 0.0])
    }
}

/// Sum of the squares of what points depart from depths.
fn squares(points: &[[f64; 3]], depth: &[f64; 6]) -> f64 {
    points.iter().map(|[a, b, w]| (w - at(depth, *a, *b)).powi(2)).sum()
}

fn terms(a: f64, b: f64) -> [f64; 6] {
    [1.0, a, b, a * a, a * b, b * b]
}

fn at(depth: &[f64; 6], a: f64, b: f64) -> f64 {
    terms(a, b).iter().zip(depth).map(|(t, c)| t * c).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stored_patch_is_the_fitted_one() {
        let ray = |a: f64, b: f64| Ray {
            start: Point3::origin(),
            direction: Vector3::new(0.3 + 0.01 * a, 0.2 + 0.01 * b, 1.0).normalize(),
        };
        // A bend of 50 mm radius, 3 m away, seen obliquely.
        let depth = |a: f64, b: f64| 3.0 + 0.02 * a - 0.01 * b + 0.009 * a * a;
        let at = |k: i32| f64::from(k % 8) / 3.5 - 1.0;
        let samples: Vec<Point3> = (0..64)
            .map(|k| (at(k), at(k / 8)))
            .map(|(a, b)| ray(a, b).start + ray(a, b).direction * depth(a, b))
            .collect();
        let (middle, rim) = (ray(0.0, 0.0), ray(1.0, 1.0));
        let cell = Cell {
            samples: &samples,
            pixels: 64,
            ray: middle,
            rim,
            sigma: 1e-4,
            median_sigma: 1e-4,
            folds: true,
        };
        let fitted = Patch::fit(&cell).unwrap();
        let kept = StoredPatch::new(&fitted, &middle).patch(&middle).unwrap();
        assert!(!fitted.flat && !kept.flat);
        let normals = [(fitted.normal(), kept.normal())];
        let steady = [(fitted.steady_normal(), kept.steady_normal())];
        for (fitted, kept) in normals.iter().chain(&steady) {
            assert!((fitted - kept).norm() < 1e-6, "{fitted} {kept}");
        }
        for point in &samples {
            let [fitted, kept] = [&fitted, &kept].map(|p| p.distance(point));
            let (Some(fitted), Some(kept)) = (fitted, kept) else { continue };
            // Single precision of 3 m would be 2e-7.
            assert!((fitted.0 - kept.0).abs() < 2e-9, "{fitted:?} {kept:?}");
            assert!((fitted.1 - kept.1).abs() < 1e-6 * fitted.1, "{fitted:?} {kept:?}");
        }
    }

    #[test]
    fn the_noise_of_a_depth_does_not_tilt_its_steady_normal() {
        let ray = |a: f64, b: f64| Ray {
            start: Point3::origin(),
            direction: Vector3::new(0.01 * a, 0.01 * b, 1.0).normalize(),
        };
        // Two columns of three cells: the first column is at the rim of the image.
        let patch = |col: i32, row: i32, depth: f64| {
            let at = |k: i32| f64::from(k) / 3.5 - 1.0;
            let place =
                |k: i32| (at(k % 8) + 2.0 * f64::from(col), at(k / 8) + 2.0 * f64::from(row));
            let samples: Vec<Point3> = (0..64)
                .map(|k| ray(place(k).0, place(k).1).direction)
                .map(|direction| Point3::from(direction * (depth / direction.z)))
                .collect();
            let middle = ray(2.0 * f64::from(col), 2.0 * f64::from(row));
            let rim = ray(2.0 * f64::from(col) + 1.0, 2.0 * f64::from(row) + 1.0);
            let cell = Cell {
                samples: &samples,
                pixels: 64,
                ray: middle,
                rim,
                sigma: 0.01,
                median_sigma: 0.01,
                folds: true,
            };
            Patch::fit(&cell).unwrap()
        };
        let around = [(0, -1), (0, 1), (1, -1), (1, 0), (1, 1)].map(|(c, r)| patch(c, r, 2.0));
        let tilt = |own_depth: f64| {
            let mut own = patch(0, 0, own_depth);
            own.steady(around.iter());
            own.steady_normal().x
        };
        // A plane through the depth of the patch itself turns by a third of 1 mm / 40 mm.
        assert!((tilt(2.001) - tilt(2.0)).abs() < 1e-4, "{} {}", tilt(2.001), tilt(2.0));
    }

    #[test]
    fn a_cell_is_small() {
        // Refining 50 views keeps 50 × 8192 cells: 4 MB for every ten bytes.
        assert!(size_of::<super::super::Cell>() <= 68, "{}", size_of::<super::super::Cell>());
    }
}
