//! The stripe in one camera row; the steps are those of the module above.

use super::{Peak, StripeProfile};

/// The sampled template and the limits of a match.
#[derive(Debug)]
pub(super) struct Template {
    /// Heights over the template's first value, `2 · half + 1` of them.
    heights: Vec<f64>,
    /// Half the window, in cells.
    half: usize,
    /// Largest sum of absolute differences that still is a stripe.
    worst_sum: f64,
    peak: Peak,
}

impl Template {
    pub(super) fn new(profile: StripeProfile, least_height: f64, peak: Peak) -> Self {
        let half = (profile.width / 2.0).floor() as usize;
        let rim = profile.at(half as f64);
        let heights = (0..=2 * half).map(|k| profile.at(k as f64 - half as f64) - rim);
        let heights: Vec<f64> = heights.collect();
        // Rounding of an even background.
        let no_stripe: f64 = heights.iter().sum();
        let worst_sum = no_stripe * (1.0 - least_height / profile.height);
        Self { heights, half, worst_sum, peak }
    }

    /// Cells of the window.
    pub(super) fn window(&self) -> usize {
        self.heights.len()
    }

    /// The stripe's place in cells from the row's left edge.
    pub(super) fn locate(&self, row: &[f64]) -> Option<f64> {
        let start = self.best_window(row)?;
        let cell = self.brightest(row, start)?;
        let refined = match self.peak {
            Peak::WholeCell => None,
            Peak::SubCell => self.zero_crossing(row, cell),
        };
        // From cell numbers to distances from the edge.
        Some(refined.unwrap_or(cell) + 0.5)
    }

    /// Where the window's sum of absolute differences is least (steps 1 and 2).
    fn best_window(&self, row: &[f64]) -> Option<usize> {
        let mut best = None;
        let mut least = self.worst_sum;
        for (start, window) in row.windows(self.window()).enumerate() {
            let sum = self.difference(window, least);
            if sum <= least && (best.is_none() || sum < least) {
                (best, least) = (Some(start), sum);
            }
        }
        best
    }

    /// Sum of absolute differences; any larger number once it exceeds `enough`.
    fn difference(&self, window: &[f64], enough: f64) -> f64 {
        let background = window.first().copied().unwrap_or(0.0);
        let mut sum = 0.0;
        for (value, height) in window.iter().zip(&self.heights) {
            sum += (value - background - height).abs();
            if sum > enough {
                break;
            }
        }
        sum
    }

    /// The brightest local maximum in a window, or its brightest cell if it has none (step 3).
    ///
    /// In cell numbers; the middle of a level top.
    fn brightest(&self, row: &[f64], start: usize) -> Option<f64> {
        let end = (start + self.window()).min(row.len());
        let at = |k: usize| row.get(k).copied().unwrap_or(f64::NEG_INFINITY);
        let before = |k: usize| k.checked_sub(1).map_or(f64::NEG_INFINITY, at);
        let mut best: Option<(bool, f64, f64)> = None;
        let mut k = start;
        while k < end {
            let mut last = k;
            while last + 1 < end && at(last + 1) == at(k) {
                last += 1;
            }
            let local_maximum = before(k) < at(k) && at(last + 1) < at(k);
            let candidate = (local_maximum, at(k), 0.5 * (k + last) as f64);
            if best.is_none_or(|(m, value, _)| (m, value) < (local_maximum, candidate.1)) {
                best = Some(candidate);
            }
            k = last + 1;
        }
        best.map(|(_, _, middle)| middle)
    }

    /// Where the balance of right and left half falls through zero, nearest to a peak (step 4).
    fn zero_crossing(&self, row: &[f64], peak: f64) -> Option<f64> {
        let near = peak.round() as usize;
        let first = near.saturating_sub(self.half).max(self.half);
        let last = (near + self.half).min(row.len().checked_sub(self.half + 1)?);
        let mut nearest: Option<f64> = None;
        let mut rising: Option<(f64, f64)> = None;
        for cell in first..=last {
            let (place, balance) = (cell as f64, self.balance(row, cell));
            if balance > 0.0 {
                rising = Some((place, balance));
            } else if balance < 0.0
                && let Some((left, before)) = rising.take()
            {
                let crossing = left + (place - left) * before / (before - balance);
                let closer = |old: f64| (crossing - peak).abs() < (old - peak).abs();
                if nearest.is_none_or(closer) {
                    nearest = Some(crossing);
                }
            }
        }
        nearest
    }

    /// `D(c) = Σ I(c+k) - I(c-k)` over half a window.
    fn balance(&self, row: &[f64], cell: usize) -> f64 {
        let at = |k: usize| row.get(k).copied().unwrap_or(0.0);
        (1..=self.half).map(|k| at(cell + k) - at(cell.saturating_sub(k))).sum()
    }
}
