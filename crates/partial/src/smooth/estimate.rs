//! What a fit says of its centre, and which of two fits counts.

use super::block::CUT;
use super::lanes::{LANES, Lanes, all};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x8};

/// Standard deviations of their difference by which the estimates of two windows may differ and still
/// have the wider one count.
const AGREEMENT: f32 = 3.0;

/// Share of the windows' squared difference that counts as the result's variance, and how large that
/// difference is for it at most, in variances of a sample.
///
/// On walls a third of it would do, for what taking sides by the difference costs; where surfaces bend
/// both windows err, and more.
const DOUBT: f32 = 0.7;
const MOST_DOUBT: f32 = 1.0;

/// What fits say of the centres of some pixels, side by side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimates<const N: usize> {
    /// By how many cuts each quantity changes.
    pub changes: [f32; N],
    /// Of the results, as shares of those of the samples.
    pub variances: [f32; N],
}

/// What becomes of some pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted<const N: usize> {
    /// Of their quantities.
    pub changes: [f32; N],
    /// Of their standard deviations.
    pub factors: [f32; N],
    /// Share of the wider window in each.
    pub shares: [f32; N],
    /// Which pixels change at all.
    pub holds: [bool; N],
}

impl<const N: usize> Estimates<N> {
    pub fn none() -> Self {
        Self { changes: [0.0; N], variances: [0.0; N] }
    }

    /// What becomes of pixels by these estimates and those of wider windows. `inverse_cuts` are those of
    /// the pixels' quantities, 0 where one stays as it is.
    #[inline(always)]
    pub fn fitted<S: Simd>(&self, simd: S, wide: &Self, inverse_cuts: &[f32; N]) -> Fitted<N> {
        const { assert!(N.is_multiple_of(LANES)) };
        let mut fitted =
            Fitted { changes: [0.0; N], factors: [1.0; N], shares: [0.0; N], holds: [false; N] };
        for first in (0..N).step_by(LANES) {
            let lanes = first..first + LANES;
            let narrow = Both::load(simd, self, first);
            let (best, share) = narrow.or_wider(simd, &Both::load(simd, wide, first));
            let inverse_cut = Lanes::from_slice(simd, &inverse_cuts[lanes.clone()]);
            (best.change / inverse_cut).store_slice(&mut fitted.changes[lanes.clone()]);
            best.variance.sqrt().store_slice(&mut fitted.factors[lanes.clone()]);
            share.store_slice(&mut fitted.shares[lanes.clone()]);
            let stays = inverse_cut.simd_eq(all(simd, 0.0)).to_bitmask();
            let holds = narrow.holds(simd).to_bitmask() & best.holds(simd).to_bitmask() & !stays;
            for (k, flag) in fitted.holds[lanes].iter_mut().enumerate() {
                *flag = holds >> k & 1 == 1;
            }
        }
        fitted
    }

    /// Whether any holds.
    #[inline(always)]
    pub fn any<S: Simd>(&self, simd: S) -> bool {
        let holds = |first| Both::load(simd, self, first).holds(simd).to_bitmask() != 0;
        (0..N).step_by(LANES).any(holds)
    }
}

/// What fits say of the centres of [`LANES`] pixels.
#[derive(Debug, Clone, Copy)]
struct Both<S: Simd> {
    change: Lanes<S>,
    variance: Lanes<S>,
}

impl<S: Simd> Both<S> {
    #[inline(always)]
    fn load<const N: usize>(simd: S, all: &Estimates<N>, first: usize) -> Self {
        let load = |numbers: &[f32; N]| Lanes::from_slice(simd, &numbers[first..first + LANES]);
        Self { change: load(&all.changes), variance: load(&all.variances) }
    }

    /// Whether they are of the surface that the centre belongs to, and better than the sample.
    #[inline(always)]
    fn holds(&self, simd: S) -> mask32x8<S> {
        // A fit without pixels has variance 0. One that differs by a cut is of another surface.
        let [zero, one] = [0.0, 1.0].map(|number| all(simd, number));
        self.variance.simd_gt(zero) & self.variance.simd_lt(one) & self.change.abs().simd_lt(one)
    }

    /// The better estimates of these and those of wider windows: those where noise explains their
    /// differences, these where it does not, and means of both in between; and the others' shares.
    ///
    /// A share that falls smoothly keeps neighbouring pixels from taking different sides.
    #[inline(always)]
    fn or_wider(&self, simd: S, wide: &Self) -> (Self, Lanes<S>) {
        let [zero, one] = [0.0, 1.0].map(|number| all(simd, number));
        let counts = wide.holds(simd) & wide.variance.simd_lt(self.variance);
        // Of nested windows, the variance of the difference is the difference of the variances.
        let gain = self.variance - wide.variance;
        let apart = (self.change - wide.change) * CUT as f32;
        let squared = apart * apart;
        let fall = (one - squared / (gain * AGREEMENT * AGREEMENT)).max(zero);
        let share = fall * fall;
        let mix = |this: Lanes<S>, wide: Lanes<S>| this + share * (wide - this);
        let doubt = squared.min(all(simd, MOST_DOUBT)) * DOUBT;
        let variance = mix(self.variance, wide.variance) + doubt;
        let best = Self {
            change: counts.select(mix(self.change, wide.change), self.change),
            variance: counts.select(variance, self.variance),
        };
        (best, counts.select(share, zero))
    }
}
