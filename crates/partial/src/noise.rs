//! Range noise of an image of which it is not known.

use transect_device::RangeImage;

/// Largest number of rows looked at; more change the estimate by less than a percent.
const ROWS: usize = 128;

/// Upper quartile of |x| for a normal x of standard deviation 1.
const QUARTILE_OF_NORMAL: f64 = 1.150_349;

/// Standard deviation of the values along their rays, estimated from the image itself.
///
/// The second difference `d[j−1] − 2 d[j] + d[j+1]` along a row of a smooth surface is noise alone,
/// with variance 6 σ². Its upper quartile stands for the whole: jumps are rarer than that, and
/// unlike the median it sees coarsely quantised values, most of whose differences are 0. Surface
/// curvature and texture finer than three pixels count as noise. 0 if no three neighbours are valid.
///
/// # Units
/// That of the image's values, which for a depth camera differs from the range by the obliquity of
/// the ray; the estimate does not go into that.
pub fn estimate_sigma(image: &RangeImage) -> f64 {
    let size = image.size();
    let step = size.rows.div_ceil(ROWS);
    let mut differences: Vec<f64> = Vec::new();
    for row in (0..size.rows).step_by(step) {
        for triple in image.row(row).windows(3) {
            let [a, b, c] = [triple[0], triple[1], triple[2]].map(f64::from);
            let second = (a - 2.0 * b + c).abs();
            if !second.is_nan() {
                differences.push(second);
            }
        }
    }
    if differences.is_empty() {
        return 0.0;
    }
    let at = differences.len() * 3 / 4;
    let (_, quartile, _) = differences.select_nth_unstable_by(at, f64::total_cmp);
    *quartile / QUARTILE_OF_NORMAL / 6_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::ImageSize;

    /// A tilted plane with triangular noise of a known spread and a jump in every row.
    fn noisy_image(spread: f64) -> RangeImage {
        let size = ImageSize { rows: 60, cols: 80 };
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let value = |k: usize, noise: f64| {
            let (row, col) = (k / size.cols, k % size.cols);
            let jump = if col > 40 { 2.0 } else { 0.0 };
            (3.0 + 0.01 * row as f64 + 0.02 * col as f64 + jump + noise) as f32
        };
        let mut values = Vec::new();
        for k in 0..size.pixels() {
            // A sum of two uniforms has variance 1/6.
            let noise = spread * (uniform() + uniform() - 1.0) * 6_f64.sqrt();
            values.push(value(k, noise));
        }
        RangeImage::from_values(size, values).unwrap()
    }

    #[test]
    fn known_noise_is_found_within_a_tenth() {
        for spread in [0.001, 0.02] {
            let found = estimate_sigma(&noisy_image(spread));
            assert!((found / spread - 1.0).abs() < 0.1, "{found} for {spread}");
        }
        assert!(estimate_sigma(&noisy_image(0.0)) < 1e-6);
    }
}
