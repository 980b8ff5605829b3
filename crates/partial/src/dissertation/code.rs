//! Codes of contour pixels, and the test for a range jump on both sides of a border (3.4.2).
//!
//! ```text
//!            (i−1, j)            code 1: the label differs from that of the row before
//!               | 1              code 2: … of the column before
//!   (i, j−1) -- (i, j)           code 3: both;  code 0: neither
//!            2
//! ```
//!
//! A border between labels is an intersection only if both its pixels are of one surface. The
//! printed test asks of both that |r_obj − r_pln| is under a threshold in the length unit; the
//! default is the scale-free rule [`BreakRule`](crate::BreakRule) on the pair itself.

use super::label::LabelImage;
use super::plane_image::PlaneImage;
use super::samples::Samples;
use crate::pixel_grid::Grid;
use serde::{Deserialize, Serialize};
use transect_device::{ImageSize, Neighbour, Pixel, View};
use transect_image::BreakRule;

/// How an intersection is told from a range jump.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum JumpTest {
    /// Two neighbours are of one surface unless it would be seen too obliquely.
    ScaleFree {
        /// Largest angle between a ray and the surface normal, in radians.
        max_incidence_rad: f64,
        /// How many standard deviations of the range a pair may differ by from noise alone.
        jump_sigmas: f64,
    },
    /// The printed test: both pixels lie nearer to the plane than this, along their rays.
    Printed {
        /// Largest |r_obj − r_pln|, in the model's length unit.
        threshold: f64,
    },
}

impl Default for JumpTest {
    fn default() -> Self {
        let max_incidence_rad = BreakRule::MAX_INCIDENCE_RAD;
        Self::ScaleFree { max_incidence_rad, jump_sigmas: BreakRule::JUMP_SIGMAS }
    }
}

impl JumpTest {
    /// The rule for the pairs of all planes. The printed test breaks pairs plane by plane.
    pub(super) fn break_rule(self, sigma: f64) -> BreakRule {
        match self {
            Self::ScaleFree { max_incidence_rad, jump_sigmas } => {
                BreakRule::new(max_incidence_rad, jump_sigmas * sigma)
            }
            Self::Printed { .. } => BreakRule::new(0.0, f64::INFINITY),
        }
    }

    /// Which pixels smoothing may join: the printed test, made for planes, does not say.
    pub(super) fn smoothing_rule(self, sigma: f64) -> BreakRule {
        match self {
            Self::ScaleFree { .. } => self.break_rule(sigma),
            Self::Printed { .. } => Self::default().break_rule(sigma),
        }
    }
}

/// The code of a pixel, 0 to 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Code(u8);

impl Code {
    /// No border at this pixel.
    pub const NONE: Self = Self(0);

    /// A code from what differs.
    pub fn new(row_differs: bool, column_differs: bool) -> Self {
        Self(u8::from(row_differs) + 2 * u8::from(column_differs))
    }

    /// 0, 1, 2 or 3.
    pub fn number(self) -> u8 {
        self.0
    }

    /// Whether the border with a neighbour is an intersection.
    pub fn crosses(self, neighbour: Neighbour) -> bool {
        self.0 & if neighbour == Neighbour::Up { 1 } else { 2 } != 0
    }
}

/// A code per pixel, for one plane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodeImage {
    size: ImageSize,
    codes: Vec<Code>,
}

impl CodeImage {
    /// Codes from labels and from which neighbours are of one surface.
    pub(super) fn new(
        labels: &LabelImage,
        grid: &Grid,
        joined: impl Fn(Pixel, Neighbour) -> bool,
    ) -> Self {
        let differs = |p, n| labels.differ(grid, p, n) && joined(p, n);
        let code = |p| Code::new(differs(p, Neighbour::Up), differs(p, Neighbour::Left));
        Self { size: grid.size(), codes: grid.pixels().map(code).collect() }
    }

    /// The code of a pixel; 0 outside the image.
    pub fn get(&self, pixel: Pixel) -> Code {
        let inside = pixel.row < self.size.rows && pixel.col < self.size.cols;
        let at = inside.then(|| self.codes.get(pixel.row * self.size.cols + pixel.col));
        at.flatten().copied().unwrap_or(Code::NONE)
    }

    /// Number of borders that are intersections.
    pub fn crossings(&self) -> usize {
        self.codes.iter().map(|c| c.0.count_ones() as usize).sum()
    }
}

/// Which pixels pass for samples of one surface, as far as one plane is concerned.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    samples: &'a Samples<'a>,
    /// Of the printed test only: which pixels lie near the plane.
    near: Option<Vec<bool>>,
}

impl<'a> Surface<'a> {
    pub fn new(samples: &'a Samples, plane: &PlaneImage) -> Self {
        let near = match samples.jump {
            JumpTest::ScaleFree { .. } => None,
            JumpTest::Printed { threshold } => {
                let near = |p| apart(samples.view, plane, p).is_some_and(|d| d < threshold);
                Some(samples.grid.pixels().map(near).collect())
            }
        };
        Self { samples, near }
    }

    fn near(&self, p: Pixel) -> bool {
        let at = self.samples.grid.index(p);
        self.near.as_ref().is_none_or(|near| near.get(at).copied().unwrap_or(false))
    }

    /// Whether a pixel and a neighbour pass for one surface.
    pub fn joined(&self, p: Pixel, neighbour: Neighbour) -> bool {
        let other = self.samples.grid.before(p, neighbour);
        self.samples.joined(p, neighbour)
            && self.near(p)
            && other.is_some_and(|other| self.near(other))
    }

    /// Whether a curve that would miss another end by a length passes for one surface with it.
    pub fn continues(&self, a: Pixel, b: Pixel, miss: Option<f64>) -> bool {
        self.samples.continues(a, b, miss) && self.near(a) && self.near(b)
    }

    /// Whether two pixels that need not be neighbours pass for one surface.
    pub fn alike(&self, a: Pixel, b: Pixel) -> bool {
        self.samples.alike(a, b) && self.near(a) && self.near(b)
    }
}

/// |r_obj − r_pln| along a pixel's ray, in the length unit; `None` if the ray misses either.
fn apart(view: &View, plane: &PlaneImage, p: Pixel) -> Option<f64> {
    let on_plane = view.frame().point(p, plane.get(p))?;
    Some((view.point_in_sensor(p)? - on_plane).norm())
}
