//! The quantity that is fitted: the value or its inverse, whichever makes planes straighter.

use crate::noise::lattice;
use transect_device::{DeviceFrame, Pixel, SensorPlane, View};

/// Pixels along each side of the lattice on which planes are tried. Chosen by hand; more change no
/// choice.
const LATTICE: usize = 12;

/// Pixels between the places at which a plane is compared; about the largest window's radius.
const STEP: usize = 6;

/// The function of a value that is fitted by a polynomial in row and column.
///
/// A fit of second order has no bias where the fitted quantity is of second order itself. The
/// inverse depth of a plane is exactly affine in the pixel coordinates of a pinhole camera. The
/// inverse range is nearly so in the angles of an imaging radar. Depth and range themselves are
/// not, least of all on planes seen obliquely. The values of triangulation sensors and of parallel
/// rays are affine as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Value,
    Inverse,
}

impl Quantity {
    /// The better one for a view: oblique planes are laid through some of its points, and the
    /// values of each plane at three pixels in line are compared.
    pub fn of(view: &View) -> Self {
        let (mut value, mut inverse) = (0.0, 0.0);
        for (pixel, d3) in lattice(view.image(), LATTICE) {
            for step in [(STEP, 0), (0, STEP)] {
                if let Some((v, i)) = bends(view.frame(), pixel, d3, step) {
                    value += v;
                    inverse += i;
                }
            }
        }
        if inverse < value { Self::Inverse } else { Self::Value }
    }

    /// The quantity of a value.
    pub fn of_value(self, d3: f64) -> f64 {
        match self {
            Self::Value => d3,
            Self::Inverse => 1.0 / d3,
        }
    }

    /// 1 over the standard deviation of the quantity from that of the value.
    pub fn inverse_sigma(self, value: f32, inverse_sigma: f32) -> f32 {
        match self {
            Self::Value => inverse_sigma,
            Self::Inverse => value * value * inverse_sigma,
        }
    }

    /// The value of which this is the quantity.
    pub fn value(self, quantity: f64) -> f64 {
        // Both functions are their own inverse.
        self.of_value(quantity)
    }
}

/// Relative second differences of the value, and of its inverse, of a plane seen at 60°.
fn bends(
    frame: &dyn DeviceFrame,
    pixel: Pixel,
    d3: f64,
    (rows, cols): (usize, usize),
) -> Option<(f64, f64)> {
    let before = Pixel { row: pixel.row.checked_sub(rows)?, col: pixel.col.checked_sub(cols)? };
    let after = Pixel { row: pixel.row + rows, col: pixel.col + cols };
    let here = frame.point(pixel, d3)?;
    let ray = frame.ray(pixel)?.direction;
    let to_after = frame.point(after, d3)? - here;
    let across = (to_after - ray * to_after.dot(&ray)).try_normalize(0.0)?;
    let (sin, cos) = 60_f64.to_radians().sin_cos();
    let normal = across * sin - ray * cos;
    let plane = SensorPlane { normal, offset: normal.dot(&here.coords) };
    let (a, b) = (frame.plane_value(before, &plane)? / d3, frame.plane_value(after, &plane)? / d3);
    Some(((a + b - 2.0).abs(), (1.0 / a + 1.0 / b - 2.0).abs()))
}
