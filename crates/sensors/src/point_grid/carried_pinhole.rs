//! Lines of sight of a triangulation scanner that is carried past the object, read from its grid.
//!
//! **Idea.** Such a scanner takes one column of the grid at each step along x. The points of a
//! column lie in its laser sheet, those of a row in one plane of the camera's pencil of sight. Both
//! families of planes can be read off the points, and the ray of a pixel is where its two meet.
//!
//! **Steps.**
//! 1. Sheets: `x = x_c + slant · z` with a common slant; least squares over the deviations from the
//!    mean of each column. Interlaced grids shift every second row in x, so the mean is taken per
//!    column and parity of the row.
//! 2. Pencil: row `r` holds `y = y₀ + (c + d r)(z − z₀)`, which is linear in the products:
//!    `y = A + B r + C z + D r z`, so `z₀ = −B / D` and `y₀ = A + C z₀`.
//! 3. A pencil that does not converge in front of the points was not one; there is no fit.
//!
//! Cost: two passes over the points.

use nalgebra::{Matrix4, Vector4};
use transect_device::{ImageSize, Point3};

/// A pinhole at `(y, z)` which the scan carries along x; its sheets lean by `slant`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedPinhole {
    /// Height of the pinhole in the sensor frame.
    pub y: f64,
    /// Depth of the pinhole in the sensor frame.
    pub z: f64,
    /// Change of x along a line of sight per unit of z; 0 for sheets perpendicular to the motion.
    pub slant: f64,
}

impl CarriedPinhole {
    /// Start of the line of sight that ends in a point.
    pub fn start(&self, p: &Point3) -> Point3 {
        Point3::new(p.x + self.slant * (self.z - p.z), self.y, self.z)
    }

    /// Reads the lines of sight from row-major points; points that are not finite are left out.
    ///
    /// `None` if the points do not determine it: too few, too flat, or without a pencil converging
    /// on the side of larger z, where triangulation scanners of this kind stand.
    pub fn fit(size: ImageSize, points: &[Point3]) -> Option<Self> {
        let samples: Vec<Sample> = samples(size, points);
        let mean = |f: fn(&Sample) -> f64| {
            samples.iter().map(f).sum::<f64>() / samples.len().max(1) as f64
        };
        let (row, z) = (mean(|s| s.row), mean(|s| s.point.z));
        let spread = |f: &dyn Fn(&Sample) -> f64| {
            (samples.iter().map(|s| f(s).powi(2)).sum::<f64>() / samples.len().max(1) as f64).sqrt()
        };
        let row_scale = spread(&|s| s.row - row);
        let z_scale = spread(&|s| s.point.z - z);
        if samples.len() < 16 || row_scale <= 0.0 || z_scale <= 0.0 {
            return None;
        }
        let term = |s: &Sample| {
            let (r, d) = ((s.row - row) / row_scale, (s.point.z - z) / z_scale);
            Vector4::new(1.0, r, d, r * d)
        };
        let [a, b, c, d] = least_squares(samples.iter().map(|s| (term(s), s.point.y)))?;
        // In scaled variables the pencil converges at depth −B / D.
        let scaled_depth = -b / d;
        let front = samples.iter().map(|s| s.point.z).fold(f64::NEG_INFINITY, f64::max);
        let pinhole = Self {
            y: a + c * scaled_depth,
            z: z + z_scale * scaled_depth,
            slant: slant(size, &samples),
        };
        let converges = pinhole.y.is_finite() && pinhole.z.is_finite() && pinhole.z > front;
        converges.then_some(pinhole)
    }
}

struct Sample {
    row: f64,
    /// Which mean of x it is compared with: column and parity of the row.
    sheet: usize,
    point: Point3,
}

fn samples(size: ImageSize, points: &[Point3]) -> Vec<Sample> {
    let cols = size.cols.max(1);
    let finite = |p: &Point3| p.coords.iter().all(|c| c.is_finite());
    let numbered = points.iter().enumerate().filter(|(_, p)| finite(p));
    numbered
        .map(|(k, point)| {
            let (row, col) = (k / cols, k % cols);
            Sample { row: row as f64, sheet: 2 * col + row % 2, point: *point }
        })
        .collect()
}

fn slant(size: ImageSize, samples: &[Sample]) -> f64 {
    let mut sums = vec![(0.0, 0.0, 0.0); 2 * size.cols];
    for s in samples {
        if let Some((n, x, z)) = sums.get_mut(s.sheet) {
            (*n, *x, *z) = (*n + 1.0, *x + s.point.x, *z + s.point.z);
        }
    }
    let (mut xz, mut zz) = (0.0, 0.0);
    for s in samples {
        if let Some((n, x, z)) = sums.get(s.sheet) {
            let (dx, dz) = (s.point.x - x / n, s.point.z - z / n);
            (xz, zz) = (xz + dx * dz, zz + dz * dz);
        }
    }
    if zz > 0.0 { xz / zz } else { 0.0 }
}

fn least_squares(rows: impl Iterator<Item = (Vector4<f64>, f64)>) -> Option<[f64; 4]> {
    let mut normal = Matrix4::zeros();
    let mut right = Vector4::zeros();
    for (terms, value) in rows {
        normal += terms * terms.transpose();
        right += terms * value;
    }
    let solution = normal.cholesky()?.solve(&right);
    Some([solution.x, solution.y, solution.z, solution.w])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bumpy object seen by a pinhole at (y, z) = (0.2, 1.3) whose sheets lean.
    fn carried_scan(size: ImageSize, truth: CarriedPinhole) -> Vec<Point3> {
        let mut points = Vec::new();
        for row in 0..size.rows {
            for col in 0..size.cols {
                let z = 0.05 * (0.3 * col as f64).sin() * (0.2 * row as f64).cos();
                let tangent = 0.002 * (row as f64 - 20.0);
                let x = 5e-4 * (col as f64 + 0.5 * (row % 2) as f64) + truth.slant * z;
                points.push(Point3::new(x, truth.y + tangent * (z - truth.z), z));
            }
        }
        points
    }

    #[test]
    fn lines_of_sight_are_recovered_from_an_interlaced_leaning_scan() {
        let size = ImageSize { rows: 40, cols: 50 };
        let truth = CarriedPinhole { y: 0.2, z: 1.3, slant: 0.35 };
        let fit = CarriedPinhole::fit(size, &carried_scan(size, truth)).unwrap();
        assert!((fit.y - truth.y).abs() < 1e-6, "{fit:?}");
        assert!((fit.z - truth.z).abs() < 1e-6, "{fit:?}");
        assert!((fit.slant - truth.slant).abs() < 1e-9, "{fit:?}");
    }

    #[test]
    fn a_flat_grid_tells_nothing() {
        let size = ImageSize { rows: 10, cols: 10 };
        let flat = (0..100)
            .map(|k| Point3::new((k % 10) as f64, (k / 10) as f64, 1.0))
            .collect::<Vec<_>>();
        assert_eq!(CarriedPinhole::fit(size, &flat), None);
    }
}
