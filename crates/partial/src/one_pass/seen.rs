//! Levels and pairs of an image as the sweep has them, for tests and comparisons.

use super::rows::{PAD, Row};
use super::source::Source;
use crate::SectionAxes;
use transect_device::View;
use transect_image::BreakRule;
use transect_image::Instructions;

/// The inputs of the sweep: one entry per pixel, row-major.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Seen {
    /// Level from the base of the view's axes; NaN where missing.
    pub levels: Vec<f32>,
    /// Whether a pixel and its left neighbour belong to one surface.
    pub left: Vec<bool>,
    /// Whether a pixel and the one above belong to one surface.
    pub up: Vec<bool>,
}

/// Levels and pairs of a view as the sweep sees them.
pub fn seen(view: &View, axes: &SectionAxes, rule: &BreakRule, with: Instructions) -> Seen {
    let source = Source::new(view, axes, rule);
    let (mut seen, mut above, mut row) = (Seen::default(), Row::default(), Row::default());
    above.fit(source.cols);
    row.fit(source.cols);
    for i in 0..source.rows {
        fearless_simd::dispatch!(with.level(), simd => row.read(simd, &source, i, &above));
        let bits = |mask: &[u64]| {
            let bit = |j: usize| mask[j / 64] >> (j % 64) & 1 == 1;
            (0..source.cols).map(bit).collect::<Vec<bool>>()
        };
        seen.left.extend(bits(&row.left.joined));
        seen.up.extend(bits(&row.up.joined));
        let samples = row.values.iter().zip(&row.levels).skip(PAD).take(source.cols);
        seen.levels.extend(samples.map(|(v, level)| if v.is_nan() { f32::NAN } else { *level }));
        std::mem::swap(&mut above, &mut row);
    }
    seen
}
