//! The error that a depth camera makes alike in all its images.

use crate::{DeviceFrame, ImageError, ImageSize, Pixel, RangeImage};
use serde::{Deserialize, Serialize};

/// Offsets of 1 / depth over the image of a depth camera, on a grid that spans the image, and the
/// scale of its depths.
///
/// A camera that measures by disparity errs by a disparity of its own at each pixel. That is an
/// offset of 1 / depth, at any depth. A wrong baseline or clock errs by a factor. The true depth is
/// `1 / (1 / (scale · z) + offset)` for a measured `z`. Between the nodes of the grid the offset is
/// bilinear; the outer nodes lie on the image's rim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Grid", into = "Grid")]
pub struct DepthOffsets(Grid);

/// The keys of [`DepthOffsets`] in files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Grid {
    #[serde(default = "one", skip_serializing_if = "is_one")]
    scale: f64,
    rows: usize,
    cols: usize,
    values: Vec<f64>,
}

fn one() -> f64 {
    1.0
}

fn is_one(scale: &f64) -> bool {
    *scale == 1.0
}

/// Four nodes of a grid with their weights.
pub type Nodes = [(usize, f64); 4];

/// Why numbers cannot be [`DepthOffsets`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthOffsetsError {
    /// The grid has fewer than 2 × 2 nodes, or absurdly many.
    #[error("a grid of {rows} x {cols} nodes; it needs 2 x 2 at least")]
    GridSize {
        /// Rows of nodes.
        rows: usize,
        /// Columns of nodes.
        cols: usize,
    },
    /// The number of values is not that of the nodes.
    #[error("{found} values for {rows} x {cols} nodes; give one for each node")]
    WrongCount {
        /// Rows of nodes.
        rows: usize,
        /// Columns of nodes.
        cols: usize,
        /// The number of values.
        found: usize,
    },
    /// An offset is NaN or infinite.
    #[error("value {node} (from 0) is {value}; it must be a finite number")]
    NotFinite {
        /// The number of the value, from 0, row by row.
        node: usize,
        /// The value, in 1 / length unit.
        value: f64,
    },
    /// The scale is no factor.
    #[error("a scale of {0}; it must be a finite number above 0")]
    BadScale(f64),
}

impl TryFrom<Grid> for DepthOffsets {
    type Error = DepthOffsetsError;

    fn try_from(grid: Grid) -> Result<Self, DepthOffsetsError> {
        let Grid { scale, rows, cols, ref values } = grid;
        let found = values.len();
        match rows.checked_mul(cols).filter(|_| rows > 1 && cols > 1) {
            None => return Err(DepthOffsetsError::GridSize { rows, cols }),
            Some(count) if count != found => {
                return Err(DepthOffsetsError::WrongCount { rows, cols, found });
            }
            Some(_) => {}
        }
        if let Some((node, value)) = values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            return Err(DepthOffsetsError::NotFinite { node, value: *value });
        }
        if !(scale.is_finite() && scale > 0.0) {
            return Err(DepthOffsetsError::BadScale(scale));
        }
        Ok(Self(grid))
    }
}

impl From<DepthOffsets> for Grid {
    fn from(offsets: DepthOffsets) -> Self {
        offsets.0
    }
}

impl DepthOffsets {
    /// Offsets at the nodes of a grid, row by row, in 1 / length unit.
    ///
    /// # Errors
    /// [`DepthOffsetsError`] for fewer than 2 × 2 nodes, another number of values, or one that is
    /// not finite.
    pub fn new(rows: usize, cols: usize, values: Vec<f64>) -> Result<Self, DepthOffsetsError> {
        Grid { scale: 1.0, rows, cols, values }.try_into()
    }

    /// The same offsets, for depths that are multiplied by a scale first.
    ///
    /// # Errors
    /// [`DepthOffsetsError::BadScale`] if the scale is not a finite number above 0.
    pub fn after_scale(self, scale: f64) -> Result<Self, DepthOffsetsError> {
        Grid { scale, ..self.0 }.try_into()
    }

    /// The factor on measured depths, before offsets are added.
    pub fn scale(&self) -> f64 {
        self.0.scale
    }

    /// The nodes around a place in an image, with their weights. `row` and `col` are shares of the
    /// image's height and width. A grid has two rows and columns at least.
    pub fn nodes(rows: usize, cols: usize, row: f64, col: f64) -> Nodes {
        let along = |share: f64, nodes: usize| {
            let at = share.clamp(0.0, 1.0) * nodes.saturating_sub(1) as f64;
            let low = (at as usize).min(nodes.saturating_sub(2));
            (low, at - low as f64)
        };
        let ((row, down), (col, right)) = (along(row, rows), along(col, cols));
        let first = row * cols + col;
        let (up, left) = (1.0 - down, 1.0 - right);
        let below = first + cols;
        [
            (first, up * left),
            (first + 1, up * right),
            (below, down * left),
            (below + 1, down * right),
        ]
    }

    /// The offset at a pixel of an image of the given size.
    pub fn at(&self, size: ImageSize, pixel: Pixel) -> f64 {
        let share = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
        let (row, col) = (share(pixel.row, size.rows), share(pixel.col, size.cols));
        let nodes = Self::nodes(self.0.rows, self.0.cols, row, col);
        nodes.iter().filter_map(|(node, weight)| Some(self.0.values.get(*node)? * weight)).sum()
    }

    /// The image of a camera with the error taken out. All rays start in the origin of the sensor
    /// frame, and the depth runs along its z axis.
    ///
    /// # Errors
    /// [`ImageError::OtherSize`] if the frame has another size than the image.
    pub fn correct(
        &self,
        frame: &dyn DeviceFrame,
        image: &RangeImage,
    ) -> Result<RangeImage, ImageError> {
        let size = image.size();
        if frame.size() != size {
            return Err(ImageError::OtherSize { size: frame.size(), found: size });
        }
        let corrected = |pixel: Pixel| {
            let value = image.get(pixel)?;
            let depth = frame.point(pixel, f64::from(value))?.z;
            // Points move along their rays, so depths and lengths change by the same factor.
            Some((f64::from(value) * self.factor(self.at(size, pixel), depth)) as f32)
        };
        let values = size.all_pixels().map(|pixel| corrected(pixel).unwrap_or(f32::NAN));
        RangeImage::from_values(size, values.collect())
    }

    /// The true over the measured depth, where the offset is this one.
    pub fn factor(&self, offset: f64, depth: f64) -> f64 {
        1.0 / (1.0 / self.0.scale + offset * depth)
    }

    /// The offsets of both, one after the other, on the grid of the second ones.
    pub fn then(&self, next: &Self) -> Self {
        let (first, second) = (&self.0, &next.0);
        let share = |k: usize, nodes: usize| k as f64 / (nodes - 1) as f64;
        let of_first = |k: usize| -> f64 {
            let row = share(k / second.cols, second.rows);
            let nodes =
                Self::nodes(first.rows, first.cols, row, share(k % second.cols, second.cols));
            nodes.iter().filter_map(|(node, w)| Some(first.values.get(*node)? * w)).sum()
        };
        let values =
            second.values.iter().enumerate().map(|(k, v)| v + of_first(k) / second.scale).collect();
        Self(Grid { values, scale: first.scale * second.scale, ..*second })
    }

    /// The camera's error at a depth, in the length unit: the root mean square over the nodes.
    pub fn error_at(&self, depth: f64) -> f64 {
        self.rms_about(0.0, depth)
    }

    /// Standard deviation over the nodes of the camera's error at a depth, in the length unit.
    pub fn spread_at(&self, depth: f64) -> f64 {
        let errors = self.0.values.iter().map(|offset| self.error(*offset, depth));
        self.rms_about(errors.sum::<f64>() / self.0.values.len() as f64, depth)
    }

    fn rms_about(&self, middle: f64, depth: f64) -> f64 {
        let off = |offset: &f64| (self.error(*offset, depth) - middle).powi(2);
        (self.0.values.iter().map(off).sum::<f64>() / self.0.values.len() as f64).sqrt()
    }

    fn error(&self, offset: f64, depth: f64) -> f64 {
        depth * (self.factor(offset, depth) - 1.0)
    }

    /// Root mean square of the offsets, in 1 / length unit.
    pub fn rms(&self) -> f64 {
        let squares: f64 = self.0.values.iter().map(|v| v * v).sum();
        (squares / self.0.values.len() as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_a_root_mean_square_and_a_spread() {
        // 1 / depth of 0.5 becomes 0.4 and 0.625.
        let offsets = DepthOffsets::new(2, 2, vec![-0.1, 0.125, -0.1, 0.125]).unwrap();
        let (far, near) = (2.5 - 2.0, 1.6 - 2.0);
        assert!(
            (offsets.error_at(2.0) - ((far * far + near * near) / 2.0_f64).sqrt()).abs() < 1e-12
        );
        assert!((offsets.spread_at(2.0) - 0.5 * (far - near)).abs() < 1e-12);
    }

    #[test]
    fn offsets_are_bilinear_between_nodes_on_the_rim() {
        let offsets = DepthOffsets::new(2, 3, vec![0.0, 1.0, 2.0, 4.0, 5.0, 6.0]).unwrap();
        let size = ImageSize { rows: 4, cols: 4 };
        for pixel in size.all_pixels() {
            let down = (pixel.row as f64 + 0.5) / 4.0;
            let right = (pixel.col as f64 + 0.5) / 4.0;
            let error = offsets.at(size, pixel) - (4.0 * down + 2.0 * right);
            assert!(error.abs() < 1e-12, "{error} at {pixel:?}");
        }
    }

    #[test]
    fn bad_grids_are_refused() {
        let told = |rows, cols, values| DepthOffsets::new(rows, cols, values).unwrap_err();
        let count = |rows, cols| DepthOffsetsError::GridSize { rows, cols };
        assert_eq!(told(1, 3, vec![0.0; 3]), count(1, 3));
        assert_eq!(told(usize::MAX, 3, Vec::new()), count(usize::MAX, 3));
        let wrong = told(2, 3, vec![0.0; 5]).to_string();
        assert_eq!(wrong, "5 values for 2 x 3 nodes; give one for each node");
        let wrong = told(2, 2, vec![0.0, f64::NAN, 0.0, 0.0]).to_string();
        assert_eq!(wrong, "value 1 (from 0) is NaN; it must be a finite number");
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let offsets = DepthOffsets::new(2, 2, vec![0.0; 4]).unwrap();
            let error = offsets.after_scale(scale).unwrap_err();
            assert!(error.to_string().starts_with("a scale of"), "{error}");
        }
    }

    #[test]
    fn a_scale_multiplies_depths_before_the_offset() {
        let offsets = DepthOffsets::new(2, 2, vec![0.1; 4]).unwrap().after_scale(0.8).unwrap();
        // 1 / (1 / (0.8 * 2.5) + 0.1)
        let true_depth = 1.0 / 0.6;
        assert!((2.5 * offsets.factor(0.1, 2.5) - true_depth).abs() < 1e-12);
        assert!((offsets.error_at(2.5) - (2.5 - true_depth)).abs() < 1e-12);
    }

    #[test]
    fn corrections_one_after_the_other_are_one_correction() {
        let grid = |cols, values: &[f64]| DepthOffsets::new(2, cols, values.to_vec()).unwrap();
        // A grid that holds the other one's nodes loses nothing.
        let first = grid(2, &[0.5, 0.25, -0.5, 2.0]).after_scale(1.25).unwrap();
        let second = grid(3, &[0.3, -0.2, 0.7, 0.1, 0.0, -0.9]).after_scale(0.5).unwrap();
        let both = first.then(&second);
        let size = ImageSize { rows: 5, cols: 7 };
        let corrected = |by: &DepthOffsets, pixel, z| z * by.factor(by.at(size, pixel), z);
        for pixel in size.all_pixels() {
            let step_by_step = corrected(&second, pixel, corrected(&first, pixel, 0.4));
            assert!((corrected(&both, pixel, 0.4) - step_by_step).abs() < 1e-12);
        }
    }
}
