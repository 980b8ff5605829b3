//! Rays of a lens with radial and tangential distortion.
//!
//! Problem: a calibration gives the image place of a ray, and a depth image needs the ray of a
//! pixel. The model is that of D. C. Brown (*Decentering distortion of lenses*, Photogrammetric
//! Engineering 32, 1966) after A. E. Conrady, with its five coefficients in the order k1 k2 p1 p2
//! k3:
//!
//! ```text
//!   x, y    the ray (x, y, 1)             r² = x² + y²      s = 1 + k1 r² + k2 r⁴ + k3 r⁶
//!   X = x s + 2 p1 x y + p2 (r² + 2 x²)                     column = cx + fx X
//!   Y = y s + p1 (r² + 2 y²) + 2 p2 x y                     row    = cy + fy Y
//! ```
//!
//! Steps, for every pixel:
//! 1. Newton's method from (X, Y), its step halved until the miss gets smaller, down to
//!    [`TOLERANCE`] pixels.
//! 2. The solution must lie before the place where the image folds back: the Jacobian's determinant
//!    must be positive all the way from the axis, checked at [`STATIONS`] places. A lens really
//!    bends that ray there; behind the fold the polynomial only repeats itself.
//!
//! A pixel without such a ray is an error, since a wrong coefficient is likelier than a lens that
//! leaves pixels dark.

use transect_device::{ImageSize, Pixel, Vector3};
use transect_sensors::Intrinsics;

/// Largest miss of a pixel, in pixels. Theory: the rounding of places in an image of some ten
/// thousand columns, a millionth of any calibration's accuracy. Doubling it changes nothing
/// visible.
const TOLERANCE: f64 = 1e-10;
/// Most Newton steps. Five are usual; a step that was halved this often no longer moves. Doubled,
/// only pixels without a ray take longer.
const STEPS: usize = 40;
/// Places between the axis and a ray at which the fold is checked. Chosen by hand. Doubled, a
/// narrower fold is found, at twice the cost.
const STATIONS: usize = 16;

/// The ray of every pixel, row-major, z = 1; or the first pixel that has none.
pub(super) fn rays(
    size: ImageSize,
    intrinsics: Intrinsics,
    distortion: [f64; 5],
) -> Result<Vec<Vector3>, Pixel> {
    let lens = Lens { intrinsics, distortion };
    let mut rays = Vec::with_capacity(size.pixels());
    for row in 0..size.rows {
        for col in 0..size.cols {
            let (x, y) = lens.ray(row as f64, col as f64).ok_or(Pixel::new(row, col))?;
            rays.push(Vector3::new(x, y, 1.0));
        }
    }
    Ok(rays)
}

#[derive(Debug, Clone, Copy)]
struct Lens {
    intrinsics: Intrinsics,
    distortion: [f64; 5],
}

/// The image place of a ray, in focal lengths off the axis, and its derivatives by the ray.
struct Bent {
    place: (f64, f64),
    /// ∂X/∂x, ∂X/∂y, ∂Y/∂x, ∂Y/∂y.
    slopes: [f64; 4],
}

impl Bent {
    fn determinant(&self) -> f64 {
        let [xx, xy, yx, yy] = self.slopes;
        xx * yy - xy * yx
    }
}

impl Lens {
    fn bend(&self, (x, y): (f64, f64)) -> Bent {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let r2 = x * x + y * y;
        let s = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        // ds/dx = x · of_s, ds/dy = y · of_s.
        let of_s = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
        let mixed = x * y * of_s + 2.0 * (p1 * x + p2 * y);
        Bent {
            place: (
                x * s + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * s + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ),
            slopes: [
                s + x * x * of_s + 2.0 * p1 * y + 6.0 * p2 * x,
                mixed,
                mixed,
                s + y * y * of_s + 6.0 * p1 * y + 2.0 * p2 * x,
            ],
        }
    }

    /// The ray of an image place.
    fn ray(&self, row: f64, col: f64) -> Option<(f64, f64)> {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        let wanted = ((col - cx) / fx, (row - cy) / fy);
        let miss = |at: &Bent| {
            let (dx, dy) = (at.place.0 - wanted.0, at.place.1 - wanted.1);
            ((dx, dy), (dx * fx).hypot(dy * fy))
        };
        let mut ray = wanted;
        let mut bent = self.bend(ray);
        let ((mut dx, mut dy), mut pixels) = miss(&bent);
        let mut share = 1.0;
        for _ in 0..STEPS {
            if pixels <= TOLERANCE {
                return self.before_fold(ray).then_some(ray);
            }
            let ([xx, xy, yx, yy], det) = (bent.slopes, bent.determinant());
            let step = ((yy * dx - xy * dy) / det, (xx * dy - yx * dx) / det);
            let next = (ray.0 - share * step.0, ray.1 - share * step.1);
            let there = self.bend(next);
            let (off, next_pixels) = miss(&there);
            if next_pixels < pixels {
                (ray, bent, (dx, dy), pixels) = (next, there, off, next_pixels);
                share = 1.0;
            } else {
                share *= 0.5;
            }
        }
        None
    }

    /// Whether the image has not folded back between the axis and a ray.
    fn before_fold(&self, (x, y): (f64, f64)) -> bool {
        (1..=STATIONS).all(|k| {
            let part = k as f64 / STATIONS as f64;
            self.bend((part * x, part * y)).determinant() > 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Corners are 44° off the axis.
    const CAMERA: Intrinsics = Intrinsics { fx: 20.0, fy: 21.0, cx: 15.6, cy: 11.8 };
    const SIZE: ImageSize = ImageSize { rows: 24, cols: 32 };

    /// The model as printed, in pixels; the slopes play no part in it.
    fn forward(c: Intrinsics, [k1, k2, p1, p2, k3]: [f64; 5], ray: &Vector3) -> (f64, f64) {
        let (x, y) = (ray.x / ray.z, ray.y / ray.z);
        let r = x.hypot(y);
        let s = 1.0 + k1 * r.powi(2) + k2 * r.powi(4) + k3 * r.powi(6);
        let bent_x = x * s + 2.0 * p1 * x * y + p2 * (r * r + 2.0 * x * x);
        let bent_y = y * s + p1 * (r * r + 2.0 * y * y) + 2.0 * p2 * x * y;
        (c.cy + c.fy * bent_y, c.cx + c.fx * bent_x)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_model_puts_every_ray_on_its_pixel(
            k1 in -0.1..0.4_f64, k2 in -0.01..0.1_f64, k3 in -0.002..0.02_f64,
            p in prop::array::uniform2(-5e-3..5e-3_f64),
        ) {
            let distortion = [k1, k2, p[0], p[1], k3];
            let rays = rays(SIZE, CAMERA, distortion).unwrap();
            for (n, ray) in rays.iter().enumerate() {
                let (row, col) = forward(CAMERA, distortion, ray);
                let miss = (row - (n / SIZE.cols) as f64).hypot(col - (n % SIZE.cols) as f64);
                prop_assert!(miss < 1e-9, "pixel {}: {}", n, miss);
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_model() {
        let lens = Lens { intrinsics: CAMERA, distortion: [-0.2, 0.07, 0.01, -0.02, 0.03] };
        let (at, h) = ((0.4, -0.7), 1e-6);
        let along = |dx: f64, dy: f64| {
            let (a, b) = (lens.bend((at.0 + dx, at.1 + dy)), lens.bend((at.0 - dx, at.1 - dy)));
            ((a.place.0 - b.place.0) / (2.0 * h), (a.place.1 - b.place.1) / (2.0 * h))
        };
        let [xx, xy, yx, yy] = lens.bend(at).slopes;
        let ((dxx, dyx), (dxy, dyy)) = (along(h, 0.0), along(0.0, h));
        for (exact, measured) in [(xx, dxx), (xy, dxy), (yx, dyx), (yy, dyy)] {
            assert!((exact - measured).abs() < 1e-8, "{exact} {measured}");
        }
    }

    #[test]
    fn no_distortion_is_the_pinhole() {
        let rays = rays(SIZE, CAMERA, [0.0; 5]).unwrap();
        let last = rays.last().unwrap();
        assert!((last.x - (31.0 - CAMERA.cx) / CAMERA.fx).abs() < 1e-15);
        assert!((last.y - (23.0 - CAMERA.cy) / CAMERA.fy).abs() < 1e-15);
    }

    /// r (1 + k1 r²) has its largest value at r = 1/√(-3 k1): no ray gets farther out.
    #[test]
    fn pixels_beyond_the_fold_have_no_ray() {
        let k1 = -0.4_f64;
        let reach = 2.0 / 3.0 / (-3.0 * k1).sqrt();
        let corner = Pixel::new(0, 0);
        assert!((CAMERA.cx / CAMERA.fx).hypot(CAMERA.cy / CAMERA.fy) > reach);
        assert_eq!(rays(SIZE, CAMERA, [k1, 0.0, 0.0, 0.0, 0.0]).err(), Some(corner));
        // Behind its fold this polynomial comes out again and reaches every place once more.
        let returning = [k1, 0.0, 0.0, 0.0, 0.02];
        let lens = Lens { intrinsics: CAMERA, distortion: returning };
        let behind =
            (1..400).map(|k| 0.01 * f64::from(k)).find(|r| lens.bend((*r, 0.0)).place.0 > 1.2);
        assert!(behind.is_some());
        assert_eq!(rays(SIZE, CAMERA, returning).err(), Some(corner));
        for wild in [[1e300; 5], [f64::MAX, 0.0, 0.0, 0.0, 0.0], [-1e9, 0.0, 0.0, 0.0, 0.0]] {
            assert!(rays(SIZE, CAMERA, wild).is_err(), "{wild:?}");
        }
    }
}
