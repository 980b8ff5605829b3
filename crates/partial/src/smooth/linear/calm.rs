//! Where what a fit has left of the samples is noise.
//!
//! Two things tell around a pixel. The mean square of the residuals shows what robust weights would
//! see. Weaker creases show earlier in the mean along a line, since a fit that is bent by one errs the
//! same way all along it: means of lines and of stripes in four directions see it to within 23°.
//! The limits are what noise exceeds at a percent of the pixels or two.

use super::candidates::Candidates;
use super::convolve::load;
use crate::smooth::lanes::{LANES, Lanes, all};
use crate::smooth::scales::Scales;
use crate::smooth::window;
use fearless_simd::Simd;
use fearless_simd::prelude::*;

/// Pixels to either side that are looked at, along a stripe and in the square.
const ALONG: usize = 3;
/// Pixels to either side of a stripe's middle line.
const ACROSS: usize = 1;

/// Pixels to either side whose residuals have a say in a pixel: along a slanting stripe, they make those
/// around it rough.
pub(super) const LOOKED: usize = 2 * ALONG + ACROSS;

/// Pixels of the square and of a stripe.
const IN_SQUARE: f32 = ((2 * ALONG + 1) * (2 * ALONG + 1)) as f32;
const IN_STRIPE: f32 = ((2 * ALONG + 1) * (2 * ACROSS + 1)) as f32;
const IN_LINE: f32 = (2 * ALONG + 1) as f32;

/// Mean square that noise leaves, in variances of a sample: for wide windows, and less by how much over
/// the radius squared, since small windows follow the noise.
const SQUARE: [f32; 2] = [1.0, 1.8];

/// Largest mean square, in what noise leaves; up to the second of these, it may be that there is more
/// noise than stated.
const LARGEST_SQUARE: f32 = 1.75;
const NOISIER: f32 = 1.3;

/// How many of its standard deviations the mean of a stripe or of a line may differ from 0.
const STRIPE_SIGMAS: f32 = 3.3;

/// By how much more a pixel fails, by its squares or along a line, so that those around it are not calm,
/// either: a crease bends their fits, too, but not by so much that it could be told from noise there.
const SURELY: [f32; 2] = [1.1, 1.15];

/// Standard deviation of a stripe's mean by the window's radius in pixels, in those of a sample: a
/// larger window leaves more noise of a stripe's size.
const STRIPE_SIGMA: [f32; 2] = [0.03, 0.0195];

/// The same of a single line: in wide windows, and less by how much over the radius squared.
const LINE_SIGMA: [f32; 2] = [0.36, 0.62];

/// Smallest radius of a window that is fitted here.
const SMALLEST: f32 = window::SMALLEST;

/// Columns on either side, enough for whole blocks that reach beyond the image.
const ROOM: usize = 2 * LANES;

/// Residuals with room on all sides, 0 where they are not known.
#[derive(Debug)]
pub(super) struct Residuals {
    values: Vec<f32>,
    width: usize,
    stride: usize,
}

impl Residuals {
    pub fn new(rows: usize, width: usize) -> Self {
        let stride = width + 2 * ROOM;
        Self { values: vec![0.0; stride * (rows + 2 * ALONG)], width, stride }
    }

    /// Those of a row of the image from a column on.
    pub fn of(&self, row: usize, col: usize) -> &[f32] {
        &self.values[(row + ALONG) * self.stride + ROOM + col..]
    }

    /// Those of a block of columns.
    pub fn of_mut(&mut self, row: usize, col: usize) -> &mut [f32] {
        let start = (row + ALONG) * self.stride + ROOM + col;
        &mut self.values[start..start + LANES]
    }

    /// What is beyond the sides of a row that is known; `cols` is the number of columns that a full circle
    /// has.
    pub fn close_row(&mut self, row: usize, cols: Option<usize>) {
        let Some(cols) = cols else { return };
        let line = &mut self.values[(row + ALONG) * self.stride..][..self.stride];
        // A diagonal stripe is as wide as it is wide beyond its ends.
        let beyond = ALONG + ACROSS;
        line.copy_within(ROOM + cols - beyond..ROOM + cols, ROOM - beyond);
        line.copy_within(ROOM..ROOM + beyond, ROOM + cols);
    }
}

/// Sums over the rows around one, by column.
struct Sums {
    /// Straight up and down as far as a stripe is long, and as far as it is wide; along both diagonals.
    upright: Vec<f32>,
    flat: Vec<f32>,
    diagonals: [Vec<f32>; 2],
    squares: Vec<f32>,
}

impl Sums {
    fn new(stride: usize) -> Self {
        let none = vec![0.0; stride];
        let diagonals = [none.clone(), none.clone()];
        Self { upright: none.clone(), flat: none.clone(), diagonals, squares: none }
    }

    /// Finds those around a row of the image, in some of its blocks from the one before the first.
    #[inline(always)]
    fn find<S: Simd>(&mut self, simd: S, residuals: &Residuals, row: usize, blocks: &[bool]) {
        let (values, stride) = (&residuals.values[row * residuals.stride..], residuals.stride);
        let blocks = blocks.iter().enumerate().filter(|(_, looked)| **looked);
        for col in blocks.map(|(block, _)| ROOM - LANES + block * LANES) {
            let zero = all(simd, 0.0);
            let (mut upright, mut flat, mut squares) = (zero, zero, zero);
            let (mut falling, mut rising) = (zero, zero);
            for k in 0..=2 * ALONG {
                let found = load(simd, values, k * stride + col);
                upright += found;
                squares += found * found;
                if k.abs_diff(ALONG) <= ACROSS {
                    flat += found;
                }
                falling += load(simd, values, k * stride + col + k - ALONG);
                rising += load(simd, values, k * stride + col + ALONG - k);
            }
            let out = col..col + LANES;
            upright.store_slice(&mut self.upright[out.clone()]);
            flat.store_slice(&mut self.flat[out.clone()]);
            squares.store_slice(&mut self.squares[out.clone()]);
            falling.store_slice(&mut self.diagonals[0][out.clone()]);
            rising.store_slice(&mut self.diagonals[1][out]);
        }
    }

    /// Which of some pixels are calm, and which are not for sure, one bit each.
    #[inline(always)]
    fn judge<S: Simd>(
        &self,
        simd: S,
        (row, col): (&[f32], usize),
        limits: [Lanes<S>; 3],
    ) -> [u64; 2] {
        let at = ROOM + col;
        let [falling, rising] = &self.diagonals;
        let stripes = across(simd, &self.upright, at, ACROSS)
            .abs()
            .max(across(simd, &self.flat, at, ALONG).abs())
            .max(across(simd, falling, at, ACROSS).abs())
            .max(across(simd, rising, at, ACROSS).abs());
        let squares = across(simd, &self.squares, at, ALONG);
        let lines = load(simd, &self.upright, at)
            .abs()
            .max(across(simd, row, at, ALONG).abs())
            .max(load(simd, falling, at).abs())
            .max(load(simd, rising, at).abs());
        let [square, stripe, line] = limits;
        // More noise makes larger means, too.
        let more = (squares / (square * (NOISIER / LARGEST_SQUARE))).max(all(simd, 1.0));
        let more = more.sqrt();
        let worst = (stripes / stripe).max(lines / line);
        // Comparisons with NaN are false, and then a pixel is not calm.
        let calm = squares.simd_le(square).to_bitmask() & worst.simd_le(more).to_bitmask();
        let perhaps = squares.simd_le(square * SURELY[0]).to_bitmask()
            & worst.simd_le(more * SURELY[1]).to_bitmask();
        [calm, !perhaps]
    }
}

/// One entry per pixel, as in the scales: whether it is a candidate and the residuals around it are noise.
/// `cols` is the number of columns that a full circle has.
#[inline(always)]
pub(super) fn calm<S: Simd>(
    simd: S,
    scales: &Scales,
    residuals: &Residuals,
    cols: Option<usize>,
    candidates: &Candidates,
) -> Vec<bool> {
    let width = residuals.width;
    let mut sums = Sums::new(residuals.stride);
    let pixels = scales.inverse_sigma.len();
    let mut calm = vec![false; pixels];
    let mut rough = vec![false; pixels];
    for row in 0..pixels / width {
        sums.find(simd, residuals, row, candidates.looked_at(row));
        let middle = &residuals.values[(row + ALONG) * residuals.stride..][..residuals.stride];
        for col in candidates.looked(row) {
            let pixel = row * width + col;
            let [bits, not] = sums.judge(simd, (middle, col), limits(simd, scales, pixel));
            for lane in 0..LANES {
                calm[pixel + lane] = bits >> lane & 1 == 1;
                rough[pixel + lane] = not >> lane & 1 == 1;
            }
        }
    }
    spread(&rough, &mut calm, width, cols);
    candidates.retain(&mut calm);
    calm
}

/// Pixels around those that are rough are not calm.
#[inline(always)]
fn spread(rough: &[bool], calm: &mut [bool], width: usize, cols: Option<usize>) {
    let mut line = vec![false; width + 2 * ALONG];
    let mut beside = vec![false; width];
    for (row, rough) in rough.chunks_exact(width).enumerate() {
        if !rough.contains(&true) {
            continue;
        }
        line[ALONG..ALONG + width].copy_from_slice(rough);
        if let Some(cols) = cols {
            line.copy_within(cols..cols + ALONG, 0);
            line.copy_within(ALONG..2 * ALONG, cols + ALONG);
        }
        for (beside, rough) in beside.iter_mut().zip(line.windows(2 * ALONG + 1)) {
            *beside = rough.iter().fold(false, |any, rough| any | rough);
        }
        let (first, last) = (row.saturating_sub(ALONG), row + ALONG + 1);
        for calm in calm[first * width..].chunks_exact_mut(width).take(last - first) {
            calm.iter_mut().zip(&beside).for_each(|(calm, beside)| *calm &= !beside);
        }
    }
}

/// Largest sums of squares, of stripes, and of lines around some pixels.
#[inline(always)]
fn limits<S: Simd>(simd: S, scales: &Scales, pixel: usize) -> [Lanes<S>; 3] {
    let [rows, cols] = [0, 1].map(|axis| &scales.radii[axis][pixel..pixel + LANES]);
    // The longer radius counts for more.
    let mean = |lane: usize| {
        let (a, b) = (f32::from(rows[lane]), f32::from(cols[lane]));
        0.35 * a.min(b) + 0.65 * a.max(b)
    };
    let radius = Lanes::load_array(simd, std::array::from_fn(mean));
    // Where there is no window, no fit asks.
    let radius = (radius * super::kernel::radius(1)).max(all(simd, SMALLEST));
    let [wide, less] = SQUARE;
    let [least, per_pixel] = STRIPE_SIGMA;
    let [in_wide, less_so] = LINE_SIGMA;
    let over_square = all(simd, 1.0) / (radius * radius);
    let square = all(simd, wide) - over_square * less;
    let stripe = radius * per_pixel + least;
    let line = all(simd, in_wide) - over_square * less_so;
    [
        square * (LARGEST_SQUARE * IN_SQUARE),
        stripe * (STRIPE_SIGMAS * IN_STRIPE),
        line * (STRIPE_SIGMAS * IN_LINE),
    ]
}

/// The sum of some places and of those beside them.
#[inline(always)]
fn across<S: Simd>(simd: S, sums: &[f32], at: usize, beside: usize) -> Lanes<S> {
    let mut sum = load(simd, sums, at);
    for k in 1..=beside {
        sum += load(simd, sums, at - k) + load(simd, sums, at + k);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one_pass::Instructions;
    use fearless_simd::dispatch;

    const WIDTH: usize = 64;

    fn calm_of(changes: &[f32], cols: Option<usize>) -> Vec<bool> {
        calm_where(changes, cols, |_, _| true)
    }

    fn calm_where(
        changes: &[f32],
        cols: Option<usize>,
        is_candidate: impl Fn(usize, usize) -> bool,
    ) -> Vec<bool> {
        // Windows of a radius of 5 pixels.
        let radii = [vec![80; changes.len()], vec![80; changes.len()]];
        let scales = Scales { width: WIDTH, radii, inverse_sigma: vec![1.0; changes.len()] };
        let shape = (changes.len() / WIDTH, cols.unwrap_or(WIDTH), WIDTH);
        let of_row =
            |row: usize| (0..shape.1).filter(|col| is_candidate(row, *col)).collect::<Vec<_>>();
        let candidates = Candidates::new(shape, cols.is_some(), |row| of_row(row).into_iter());
        let mut residuals = Residuals::new(shape.0, WIDTH);
        for (row, changes) in changes.chunks(WIDTH).enumerate() {
            for (block, changes) in changes.chunks(LANES).enumerate() {
                // Known where a candidate looks.
                if candidates.looked_at(row)[block + 1] {
                    residuals.of_mut(row, block * LANES).copy_from_slice(changes);
                }
            }
            residuals.close_row(row, cols);
        }
        let level = Instructions::Best.level();
        dispatch!(level, simd => calm(simd, &scales, &residuals, cols, &candidates))
    }

    fn image(f: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        (0..40 * WIDTH).map(|k| f(k / WIDTH, k % WIDTH)).collect()
    }

    #[test]
    fn noise_is_calm_and_lines_of_any_direction_are_not() {
        let noise = |row: usize, col: usize| if (row * 7 + col * 3) % 5 < 2 { 0.9 } else { -0.6 };
        assert!(calm_of(&image(noise), None).iter().all(|calm| *calm));
        let lines: [fn(usize, usize) -> bool; 4] = [
            |row, _| row == 20,
            |_, col| col == 20,
            |row, col| row == col,
            |row, col| row + col == 40,
        ];
        for line in lines {
            let calm = calm_of(&image(|row, col| if line(row, col) { 1.8 } else { 0.0 }), None);
            assert!(!calm[20 * WIDTH + 20]);
            // For sure, so what is beside it is left out, too.
            assert!(!calm[22 * WIDTH + 21]);
            assert!(calm[5 * WIDTH + 50]);
        }
        assert!(calm_of(&vec![1.2; 40 * WIDTH], None).iter().all(|calm| !calm));
        assert!(calm_of(&vec![f32::NAN; 40 * WIDTH], None).iter().all(|calm| !calm));
    }

    #[test]
    fn a_full_circle_is_looked_at_across_its_seam() {
        let cols = WIDTH - 4;
        let at_last = image(|_, col| if col == cols - 1 { 3.0 } else { 0.0 });
        assert!(calm_of(&at_last, None)[20 * WIDTH]);
        assert!(!calm_of(&at_last, Some(cols))[20 * WIDTH]);
    }

    #[test]
    fn what_is_said_of_a_candidate_does_not_depend_on_others() {
        // A hash; so large that about half of the pixels are calm.
        let random =
            |k: u32| (k.wrapping_mul(0x9e37_79b1) >> 16 ^ k).wrapping_mul(0x85eb_ca6b) >> 8;
        let noise =
            |row, col| 3.7 * (random((row * WIDTH + col) as u32) as f32 / 16_777_216.0 - 0.5);
        let changes = image(noise);
        for cols in [WIDTH, WIDTH - 3, WIDTH - 7] {
            for circle in [None, Some(cols)] {
                let all = calm_of(&changes, circle);
                let count = all.iter().filter(|calm| **calm).count();
                assert!((200..2000).contains(&count), "{count}");
                for col in (0..8).chain(cols - 8..cols) {
                    let alone = calm_where(&changes, circle, |_, c| c == col);
                    for row in 0..40 {
                        let pixel = row * WIDTH + col;
                        assert_eq!(alone[pixel], all[pixel], "{circle:?} {row} {col}");
                    }
                }
            }
        }
    }
}
