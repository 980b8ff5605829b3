//! The label image Ω of one plane (3.4.2, Eq. 3.2–3.4, errata).
//!
//! One rule by signed heights: a plane sees a pixel high if its sample lies over the plane.
//! Otherwise, and for a tie, it sees it low. A missing pixel has no label. The printed label, r_pln
//! < r_obj, says whether sample and start of the ray lie on opposite sides of the plane. It is this
//! label where the ray starts low, and its complement where it starts high. It is lost where the
//! ray starts on the plane.

use super::samples::Samples;
use crate::pixel_grid::Grid;
use transect_device::{ImageSize, Neighbour, Pixel};

/// On which side of a plane a sample lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// On the plane, or on the side its normal points away from.
    Low,
    /// On the side of the normal.
    High,
}

/// A label per pixel, for one plane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelImage {
    size: ImageSize,
    labels: Vec<Option<Label>>,
}

impl LabelImage {
    /// The labels of the plane at a level.
    pub(super) fn new(samples: &Samples, level: i32) -> Self {
        let label = |p| {
            let high = samples.level(p)? > f64::from(level);
            Some(if high { Label::High } else { Label::Low })
        };
        let labels = samples.grid.pixels().map(label).collect();
        Self { size: samples.grid.size(), labels }
    }

    /// Labels from a picture: `#` high, `.` low, anything else missing.
    #[cfg(test)]
    pub(super) fn drawn(lines: &[&str]) -> (Grid, Self) {
        let label = |c| match c {
            '#' => Some(Label::High),
            '.' => Some(Label::Low),
            _ => None,
        };
        let grid = Grid::plain(lines.len(), lines[0].chars().count());
        let labels = lines.iter().flat_map(|l| l.chars().map(label)).collect();
        (grid, Self { size: grid.size(), labels })
    }

    /// The label of a pixel; `None` where it is missing, and outside the image.
    pub fn get(&self, pixel: Pixel) -> Option<Label> {
        let inside = pixel.row < self.size.rows && pixel.col < self.size.cols;
        inside
            .then(|| self.labels.get(pixel.row * self.size.cols + pixel.col))
            .flatten()
            .copied()?
    }

    pub(super) fn set(&mut self, pixel: Pixel, label: Option<Label>) {
        if let Some(at) = self.labels.get_mut(pixel.row * self.size.cols + pixel.col) {
            *at = label;
        }
    }

    /// Whether a pixel and a neighbour both have labels, and different ones.
    pub(super) fn differ(&self, grid: &Grid, p: Pixel, neighbour: Neighbour) -> bool {
        let other = grid.before(p, neighbour).and_then(|o| self.get(o));
        matches!((self.get(p), other), (Some(a), Some(b)) if a != b)
    }
}
