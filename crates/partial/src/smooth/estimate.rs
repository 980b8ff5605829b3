//! What a fit says of its centre, and which of two fits counts.

use super::block::CUT;

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

/// What a fit says of its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    /// By how many cuts the quantity changes.
    pub change: f32,
    /// Of the result, as a share of that of the sample.
    pub variance: f32,
}

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

    pub fn at(&self, k: usize) -> Estimate {
        Estimate { change: self.changes[k], variance: self.variances[k] }
    }

    /// Whether any holds.
    pub fn any(&self) -> bool {
        (0..N).any(|k| self.at(k).holds())
    }

    /// What becomes of pixels by these estimates and those of wider windows. `inverse_cuts` are those of
    /// the pixels' quantities, 0 where one stays as it is.
    #[inline(always)]
    pub fn fitted(&self, wide: &Self, inverse_cuts: &[f32; N]) -> Fitted<N> {
        let mut fitted =
            Fitted { changes: [0.0; N], factors: [1.0; N], shares: [0.0; N], holds: [false; N] };
        // Nothing here branches, so several pixels are taken at a time.
        for (k, inverse_cut) in inverse_cuts.iter().enumerate() {
            let narrow = self.at(k);
            let (best, share) = narrow.or_wider(&wide.at(k));
            fitted.changes[k] = best.change / inverse_cut;
            fitted.factors[k] = best.variance.sqrt();
            fitted.shares[k] = share;
            fitted.holds[k] = (*inverse_cut != 0.0) & narrow.holds() & best.holds();
        }
        fitted
    }
}

impl Estimate {
    /// Whether it is one of the surface that the centre belongs to, and better than the sample.
    #[inline(always)]
    pub fn holds(&self) -> bool {
        // A fit without pixels has variance 0. One that differs by a cut is of another surface.
        (self.variance > 0.0) & (self.variance < 1.0) & (self.change.abs() < 1.0)
    }

    /// The better estimate of this and that of a wider window: that one where noise explains their
    /// difference, this one where it does not, and a mean of both in between; and the other's share.
    ///
    /// A share that falls smoothly keeps neighbouring pixels from taking different sides.
    #[inline(always)]
    fn or_wider(&self, wide: &Self) -> (Self, f32) {
        let counts = wide.holds() & (wide.variance < self.variance);
        // Of nested windows, the variance of the difference is the difference of the variances.
        let (gain, apart) =
            (self.variance - wide.variance, CUT as f32 * (self.change - wide.change));
        let squared = apart * apart;
        let fall = (1.0 - squared / (gain * AGREEMENT * AGREEMENT)).max(0.0);
        let share = fall * fall;
        let mix = |this: f32, wide: f32| this + share * (wide - this);
        let doubt = DOUBT * squared.min(MOST_DOUBT);
        let variance = mix(self.variance, wide.variance) + doubt;
        let mixed = Self { change: mix(self.change, wide.change), variance };
        let pick = |mixed: f32, this: f32| if counts { mixed } else { this };
        let change = pick(mixed.change, self.change);
        (Self { change, variance: pick(mixed.variance, self.variance) }, pick(share, 0.0))
    }
}
