//! A piece of surface of second order, fitted to the samples of one cell of pixels.
//!
//! **Problem.** Poses are compared at places where one view's surface meets another's. Single
//! samples are too noisy for that, and their neighbours are too far away.
//!
//! **Idea.** A small piece of a surface is a height of second order over its tangent plane (moving
//! least squares; Levin, 1998). Cells do not overlap, so the noise of patches is independent.
//!
//! **Steps.**
//! 1. A plane through the samples gives the local axes: mean, normal towards the sensor.
//! 2. Least squares of `h = c0 + c1 a + c2 b + c3 a² + c4 a b + c5 b²` over the samples.
//! 3. What the samples depart from it is compared with their noise; a crease, a jump or texture is
//!    no patch.

use crate::tuning::{FLAT, LEAST_FILLED, MAX_INCIDENCE_DEGREES, ROUGH, SAMPLING_ROUGH};
use nalgebra::{Matrix3, Matrix6, SymmetricEigen, Vector6};
use transect_device::{Point3, Vector3};

/// A patch of surface, in the sensor frame of its view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    center: Point3,
    /// Local axes: two in the tangent plane, and the normal that points to the sensor's side.
    axes: [Vector3; 3],
    /// Height along the normal over the tangent plane: 1, a, b, a², ab, b² with `a` and `b` in
    /// units of `radius`; heights in the model's length unit.
    height: [f64; 6],
    radius: f64,
    /// Standard deviation of the mean of its samples.
    sigma: f64,
    /// Whether it is a plane.
    flat: bool,
}

/// What one cell's samples are fitted from.
pub(super) struct Cell<'a> {
    /// The valid samples, in the sensor frame.
    pub samples: &'a [Point3],
    /// How many pixels the cell has.
    pub pixels: usize,
    /// Direction of its middle ray, away from the sensor.
    pub ray: Vector3,
    /// Range noise of its pixels along the ray, as a length.
    pub sigma: f64,
}

impl Patch {
    /// The patch through a cell's samples; `None` if they are too few or no smooth surface.
    pub(super) fn fit(cell: &Cell<'_>) -> Option<Self> {
        let n = cell.samples.len();
        if n < 8 || (n as f64) < LEAST_FILLED * cell.pixels as f64 {
            return None;
        }
        let (mean, axes) = tangent(cell)?;
        let incidence = -axes[2].dot(&cell.ray);
        if incidence < MAX_INCIDENCE_DEGREES.to_radians().cos() {
            return None;
        }
        let local = |p: &Point3| {
            let d = p - mean;
            (d.dot(&axes[0]), d.dot(&axes[1]), d.dot(&axes[2]))
        };
        let reach = |p: &Point3| local(p).0.abs().max(local(p).1.abs());
        let radius = cell.samples.iter().map(reach).fold(0.0, f64::max);
        let points: Vec<(f64, f64, f64)> = cell.samples.iter().map(local).collect();
        let points: Vec<_> = points.iter().map(|(a, b, h)| (a / radius, b / radius, *h)).collect();
        let height = second_order(&points)?;
        let spare = n.checked_sub(6).filter(|n| *n > 0)? as f64;
        let bent = squares(&points, &height);
        let rough = (bent / spare).sqrt();
        // The range noise moves a sample off its surface by its share across the surface.
        let noise = cell.sigma * incidence;
        let spacing = 2.0 * radius / (n as f64).sqrt();
        if rough > ROUGH * noise + SAMPLING_ROUGH * spacing {
            return None;
        }
        let variance = rough.max(noise).powi(2);
        let flat = squares(&points, &[0.0; 6]) - bent < FLAT * variance;
        let height = if flat { [0.0; 6] } else { height };
        let sigma = (variance / n as f64).sqrt();
        let patch = Self { center: mean, axes, height, radius, sigma, flat };
        sigma.is_finite().then_some(patch)
    }

    /// The point of the surface over the middle of its samples.
    pub fn point(&self) -> Point3 {
        self.center + self.axes[2] * self.height[0]
    }

    /// The unit normal there, on the sensor's side.
    pub fn normal(&self) -> Vector3 {
        self.normal_at(0.0, 0.0)
    }

    /// Standard deviation of the point along the normal from noise alone, in the model's unit.
    pub fn sigma(&self) -> f64 {
        self.sigma_at(0.0, 0.0)
    }

    /// The standard deviation over a place of the tangent plane, for samples that are spread evenly
    /// over the square: the sum of the squares of Legendre's polynomials, up to the patch's order.
    fn sigma_at(&self, a: f64, b: f64) -> f64 {
        let (aa, bb) = (a * a, b * b);
        let plane = 1.0 + 3.0 * (aa + bb);
        let second = |x: f64| 5.0 * (1.5 * x - 0.5).powi(2);
        let bent = second(aa) + second(bb) + 9.0 * aa * bb;
        self.sigma * if self.flat { plane } else { plane + bent }.sqrt()
    }

    /// Half the side of the square that holds its samples, in the model's length unit.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Signed distance of a point from the surface, positive on the sensor's side, with the normal
    /// and the standard deviation there; `None` beyond the samples.
    pub fn distance(&self, p: &Point3) -> Option<(f64, Vector3, f64)> {
        let d = p - self.center;
        let (a, b) = (d.dot(&self.axes[0]) / self.radius, d.dot(&self.axes[1]) / self.radius);
        if a.abs().max(b.abs()) > 1.0 {
            return None;
        }
        let normal = self.normal_at(a, b);
        let above = d.dot(&self.axes[2]) - at(&self.height, a, b);
        Some((above * normal.dot(&self.axes[2]), normal, self.sigma_at(a, b)))
    }

    fn normal_at(&self, a: f64, b: f64) -> Vector3 {
        let [_, c1, c2, c3, c4, c5] = self.height;
        let slope_a = (c1 + 2.0 * c3 * a + c4 * b) / self.radius;
        let slope_b = (c2 + c4 * a + 2.0 * c5 * b) / self.radius;
        (self.axes[2] - self.axes[0] * slope_a - self.axes[1] * slope_b).normalize()
    }
}

/// The heights of second order that fit points best.
fn second_order(points: &[(f64, f64, f64)]) -> Option<[f64; 6]> {
    let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for (a, b, h) in points {
        let terms = Vector6::from(terms(*a, *b));
        normal.syger(1.0, &terms, &terms, 1.0);
        right.axpy(*h, &terms, 1.0);
    }
    normal.fill_upper_triangle_with_lower_triangle();
    Some(normal.cholesky()?.solve(&right).into())
}

/// Sum of the squares of what points depart from heights.
fn squares(points: &[(f64, f64, f64)], height: &[f64; 6]) -> f64 {
    points.iter().map(|(a, b, h)| (h - at(height, *a, *b)).powi(2)).sum()
}

fn terms(a: f64, b: f64) -> [f64; 6] {
    [1.0, a, b, a * a, a * b, b * b]
}

fn at(height: &[f64; 6], a: f64, b: f64) -> f64 {
    terms(a, b).iter().zip(height).map(|(t, c)| t * c).sum()
}

/// Mean of the samples, and the axes of the plane through them.
fn tangent(cell: &Cell<'_>) -> Option<(Point3, [Vector3; 3])> {
    let n = cell.samples.len() as f64;
    let mean = Point3::from(cell.samples.iter().map(|p| p.coords).sum::<Vector3>() / n);
    let mut scatter = Matrix3::zeros();
    for p in cell.samples {
        let d = p - mean;
        scatter.syger(1.0, &d, &d, 1.0);
    }
    scatter.fill_upper_triangle_with_lower_triangle();
    let eigen = SymmetricEigen::try_new(scatter, f64::EPSILON, 100)?;
    let thin = eigen.eigenvalues.imin();
    let normal = eigen.eigenvectors.column(thin).into_owned();
    let normal = if normal.dot(&cell.ray) > 0.0 { -normal } else { normal };
    let across = cell.ray.cross(&normal);
    let first = if across.norm() > 1e-3 {
        across
    } else {
        eigen.eigenvectors.column((thin + 1) % 3).into_owned()
    };
    let first = (first - normal * first.dot(&normal)).try_normalize(0.0)?;
    Some((mean, [first, normal.cross(&first), normal]))
}
