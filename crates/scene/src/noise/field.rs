//! Normal numbers that neighbouring pixels share.
//!
//! Independent numbers are smoothed along rows, then along columns, by a Gaussian window. Its
//! weights have a sum of squares of 1, which keeps the variance. Only the rows inside the window
//! are kept.

use super::{FIELD_POSITION, Noise, WORDS_PER_ROW_LOG2, normal, source};
use std::collections::VecDeque;

/// Standard deviations that the window reaches to either side. Chosen by hand: weights beyond are
/// below 4e-4 of the largest. Doubled, the numbers stay the same to three digits, at twice the
/// time.
const REACH: f64 = 4.0;

/// The rows of a view's shared numbers, from row 0 on.
pub(crate) struct Field<'a> {
    noise: &'a Noise,
    view: u64,
    cols: usize,
    weights: Vec<f64>,
    /// The next row of independent numbers. The image begins half a window further down.
    next: usize,
    /// Rows that are smoothed along themselves: those of the last window but its last row.
    rows: VecDeque<Vec<f64>>,
}

impl<'a> Field<'a> {
    /// The numbers of a view; `None` if the pixels' errors are independent.
    pub fn new(noise: &'a Noise, view: u64, cols: usize) -> Option<Self> {
        // Two numbers smoothed by a window of deviation s correlate by exp(-(distance / 2s)²).
        let deviation = 0.5 * noise.correlation;
        if deviation <= 0.0 {
            return None;
        }
        let reach = (REACH * deviation).ceil() as i32;
        let weight = |k: i32| (-0.5 * (f64::from(k) / deviation).powi(2)).exp();
        let mut weights: Vec<f64> = (-reach..=reach).map(weight).collect();
        let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        weights.iter_mut().for_each(|w| *w /= norm);
        Some(Self { noise, view, cols, weights, next: 0, rows: VecDeque::new() })
    }

    /// The next row of the image.
    pub fn next_row(&mut self) -> Vec<f64> {
        while self.rows.len() < self.weights.len() {
            let row = self.smoothed_row();
            self.rows.push_back(row);
        }
        let mut sums = vec![0.0; self.cols];
        for (weight, row) in self.weights.iter().zip(&self.rows) {
            sums.iter_mut().zip(row).for_each(|(sum, number)| *sum += weight * number);
        }
        self.rows.pop_front();
        sums
    }

    /// A row of independent numbers, smoothed along itself.
    fn smoothed_row(&mut self) -> Vec<f64> {
        let position = ((self.next as u128) << WORDS_PER_ROW_LOG2) | FIELD_POSITION;
        let mut numbers = source(self.noise.seed, self.view, position);
        self.next += 1;
        let count = self.cols + self.weights.len() - 1;
        let independent: Vec<f64> = (0..count).map(|_| normal(&mut numbers)).collect();
        let sum = |window: &[f64]| window.iter().zip(&self.weights).map(|(n, w)| n * w).sum();
        independent.windows(self.weights.len()).map(sum).collect()
    }
}
