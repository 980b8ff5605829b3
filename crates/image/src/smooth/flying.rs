//! Flying pixels: samples of no surface, between the two surfaces of a range jump.
//!
//! **Problem.** At the rim of an object a pixel's spot falls on the object and on what is behind
//! it, and the sensor reports a range in between.
//!
//! **Idea.** A flying pixel is alone. It belongs to the surface of no neighbour, its range is
//! between those of its neighbours on either side of the rim, and both go on as surfaces. Tang,
//! Huber and Akinci (2007) compare filters of such pixels by their angles and by their ranges; here
//! the pair test is the angle.
//!
//! **Steps.** In a row or in a column, pixel k is a flying one if
//! 1. pixels k − 2 and k − 1 are joined, and pixels k + 1 and k + 2, too;
//! 2. pixel k is joined to none of its four neighbours;
//! 3. its value is between those of pixels k − 1 and k + 1;
//! 4. both its steps are more than [`ROUND_RIM`] times the step of the surface beside them.
//!
//! Steps 1 and 3 spare what is seen at a grazing angle, where pair after pair is broken, and thin
//! objects in front of others. Step 4 spares surfaces that bend away.
//!
//! **Limits.** Flying pixels that are joined to each other are not found, be it by chance or since
//! the rim runs along the pixels. Leaving them out as well opens curves of the Stanford bunny: a
//! fold of its surface is seen by one row of pixels.

use super::links::Links;
use crate::tuning::HALF_WINDOW;
use transect_device::RangeImage;

/// Largest factor from one step to the next where a surface bends away. Near the rim of a round
/// surface the range grows with the root of the distance from the rim. The last two steps of whole
/// pixels are therefore as 1 to √2 − 1 at most.
const ROUND_RIM: f32 = 1.0 + std::f32::consts::SQRT_2;

/// Steps 3 and 4, for the values of five pixels in line.
fn is_between_surfaces([before, near, here, far, beyond]: [f32; 5]) -> bool {
    let (there, back) = (here - near, far - here);
    there * back > 0.0
        && there.abs() > ROUND_RIM * (near - before).abs()
        && back.abs() > ROUND_RIM * (beyond - far).abs()
}

/// The flying pixels of an image in ascending order, as places in its rows.
///
/// The outermost two pixels on each end of a row have no surfaces on both sides, nor have those of
/// a column. A full circle goes on at its seam.
pub(super) fn flying_pixels(image: &RangeImage, links: &Links) -> Vec<usize> {
    let size = image.size();
    let mut lone = vec![[0; 2]; links.words()];
    let mut found = Vec::new();
    for row in 0..size.rows {
        links.lone(row, &mut lone);
        for (word, [across, down]) in lone.iter().enumerate() {
            let mut both = across | down;
            while both != 0 {
                let bit = both.trailing_zeros();
                both &= both - 1;
                // The margin of a full circle holds its other side once more.
                let col = (64 * word + bit as usize).checked_sub(HALF_WINDOW);
                let Some(col) = col.filter(|col| *col < size.cols) else { continue };
                let across = across >> bit & 1 == 1 && {
                    // Beyond the seam of a full circle; others have no joined pixels there.
                    let at = |k: usize| image.row(row)[(col + size.cols + k - 2) % size.cols];
                    is_between_surfaces([0, 1, 2, 3, 4].map(at))
                };
                let down = down >> bit & 1 == 1 && {
                    let at = |k: usize| image.row(row + k - 2)[col];
                    is_between_surfaces([0, 1, 2, 3, 4].map(at))
                };
                if across || down {
                    found.push(row * size.cols + col);
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth::pairs::is_set;
    use transect_device::ImageSize;

    const ROWS: usize = 9;
    const COLS: usize = 150;

    /// The four steps, pixel by pixel.
    fn slow(image: &RangeImage, left: &[Vec<u64>], up: &[Vec<u64>]) -> Vec<usize> {
        let value = |row: usize, col: usize| image.row(row)[col];
        let between = |v: [f32; 5]| {
            let step = |k: usize| f64::from((v[k + 1] - v[k]).abs());
            let monotone = v[1] < v[2] && v[2] < v[3] || v[1] > v[2] && v[2] > v[3];
            let factor = 1.0 + 2_f64.sqrt();
            monotone && step(1) > factor * step(0) && step(2) > factor * step(3)
        };
        let all = (0..ROWS).flat_map(|row| (0..COLS).map(move |col| (row, col)));
        let flying = all.filter(|&(row, col)| {
            let any = |bits: &[Vec<u64>], at: [(usize, usize); 2]| {
                at.iter().any(|&(row, col)| {
                    let inside = row < ROWS && col < COLS;
                    inside && is_set(&bits[row], col)
                })
            };
            let alone =
                !any(left, [(row, col), (row, col + 1)]) && !any(up, [(row, col), (row + 1, col)]);
            let across = (2..COLS - 2).contains(&col) && {
                let joined = |k: usize| is_set(&left[row], k);
                let values = std::array::from_fn(|k| value(row, col + k - 2));
                joined(col - 1) && alone && joined(col + 2) && between(values)
            };
            let down = (2..ROWS - 2).contains(&row) && {
                let joined = |k: usize| is_set(&up[k], col);
                let values = std::array::from_fn(|k| value(row + k - 2, col));
                joined(row - 1) && alone && joined(row + 2) && between(values)
            };
            across || down
        });
        flying.map(|(row, col)| row * COLS + col).collect()
    }

    #[test]
    fn masks_find_what_the_steps_find_pixel_by_pixel() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            state >> 33
        };
        let mut count = 0;
        for _ in 0..200 {
            let values = (0..ROWS * COLS).map(|_| (1 + random() % 100) as f32).collect();
            let image = RangeImage::from_values(ImageSize { rows: ROWS, cols: COLS }, values);
            let image = image.unwrap();
            let mut links = Links::new(ROWS, COLS);
            let (mut left, mut up) = (Vec::new(), Vec::new());
            for row in 0..ROWS {
                // A pair needs two pixels.
                let valid = |row: usize, col: usize| !image.row(row)[col].is_nan();
                let mut bits = [[0; 3]; 2].map(Vec::from);
                for col in 0..COLS {
                    let pairs = [
                        col > 0 && valid(row, col) && valid(row, col - 1),
                        row > 0 && valid(row, col) && valid(row - 1, col),
                    ];
                    for (bits, there) in bits.iter_mut().zip(pairs) {
                        bits[col / 64] |= u64::from(there && random() % 2 == 0) << (col % 64);
                    }
                }
                links.set_row(row, [&bits[0], &bits[1]], (COLS, 0));
                let [of_left, of_up] = bits;
                left.push(of_left);
                up.push(of_up);
            }
            let found = flying_pixels(&image, &links);
            assert_eq!(found, slow(&image, &left, &up));
            count += found.len();
        }
        assert!(count > 30, "{count}");
    }
}
