//! The fitted value at the window's centre, and the choice between the narrow and the wide window.

use super::lanes::{MOST, Native, all, positive};
use crate::tuning::{AGREEMENT, CUT, DOUBT, LARGEST_CHANGE, MOST_DOUBT};
use fearless_simd::Simd;
use fearless_simd::prelude::*;

/// The fitted values at the centres of a block's windows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimates<S: Simd> {
    simd: S,
    /// Change of each pixel's quantity, in cuts.
    pub change: Native<S>,
    /// Variance of each result, in variances of a sample.
    pub variance: Native<S>,
}

/// The results for a block of pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted {
    /// Changes of their quantities.
    pub changes: [f32; MOST],
    /// Factors of their standard deviations.
    pub factors: [f32; MOST],
    /// Which pixels change at all, one bit each.
    pub holds: u64,
}

impl<S: Simd> Estimates<S> {
    pub fn new(simd: S, change: Native<S>, variance: Native<S>) -> Self {
        Self { simd, change, variance }
    }

    /// The results from these estimates and those of the wider windows. `inverse_cut` is that of
    /// each pixel's quantity, 0 where the pixel stays as it is.
    #[inline(always)]
    pub fn fitted(&self, wide: &Self, inverse_cut: Native<S>) -> Fitted {
        let mut fitted = Fitted { changes: [0.0; MOST], factors: [1.0; MOST], holds: 0 };
        let best = self.or_wider(wide);
        let lanes = ..Native::<S>::LEN;
        (best.change / inverse_cut).store_slice(&mut fitted.changes[lanes]);
        best.variance.sqrt().store_slice(&mut fitted.factors[lanes]);
        let stays = inverse_cut.simd_eq(all(self.simd, 0.0)).to_bitmask();
        fitted.holds = self.hold() & best.hold() & !stays;
        fitted
    }

    /// Which estimates are of the surface that the centre belongs to and better than the sample,
    /// one bit each.
    #[inline(always)]
    pub fn hold(&self) -> u64 {
        // A fit without pixels has variance 0.
        let [zero, one, largest] =
            [0.0, 1.0, LARGEST_CHANGE / CUT].map(|number| all(self.simd, number));
        self.variance.simd_gt(zero).to_bitmask()
            & self.variance.simd_lt(one).to_bitmask()
            & self.change.abs().simd_lt(largest).to_bitmask()
    }

    /// The better of these estimates and those of the wider windows.
    ///
    /// The wider window counts where noise explains the difference, the narrow one where it does
    /// not, and a mean of both in between. A share that falls smoothly keeps neighbouring pixels
    /// from taking different sides.
    #[inline(always)]
    fn or_wider(&self, wide: &Self) -> Self {
        let simd = self.simd;
        let [zero, one, largest] = [0.0, 1.0, LARGEST_CHANGE / CUT].map(|number| all(simd, number));
        // Of nested windows, the variance of the difference is the difference of the variances.
        let gain = self.variance - wide.variance;
        let apart = (self.change - wide.change) * CUT;
        let squared = apart * apart;
        let fall = positive(simd, one - squared / (gain * AGREEMENT * AGREEMENT));
        let counts = wide.variance.simd_gt(zero)
            & wide.variance.simd_lt(one)
            & wide.change.abs().simd_lt(largest)
            & wide.variance.simd_lt(self.variance);
        let share = counts.select(fall * fall, zero);
        let mix = |this: Native<S>, wide: Native<S>| this + share * (wide - this);
        let doubt = counts.select(squared.min(all(simd, MOST_DOUBT)) * DOUBT, zero);
        let (change, variance) = (mix(self.change, wide.change), mix(self.variance, wide.variance));
        Self { simd, change, variance: variance + doubt }
    }
}
