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

/// What becomes of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fitted {
    /// Of its quantity.
    pub change: f32,
    /// Of its standard deviation.
    pub factor: f32,
    /// Share of the wider window in it.
    pub share: f32,
}

impl Estimate {
    /// Whether it is one of the surface that the centre belongs to, and better than the sample.
    pub fn holds(&self) -> bool {
        // A fit without pixels has variance 0. One that differs by a cut is of another surface.
        self.variance > 0.0 && self.variance < 1.0 && self.change.abs() < 1.0
    }

    /// What becomes of a pixel by this estimate and that of a wider window; `None` where it stays as it
    /// is. `inverse_cut` is that of the pixel's quantity.
    pub fn fitted(&self, wide: &Self, inverse_cut: f32) -> Option<Fitted> {
        if inverse_cut == 0.0 || !self.holds() {
            return None;
        }
        let (best, share) = self.or_wider(wide);
        let (change, factor) = (best.change / inverse_cut, best.variance.sqrt());
        best.holds().then_some(Fitted { change, factor, share })
    }

    /// The better estimate of this and that of a wider window: that one where noise explains their
    /// difference, this one where it does not, and a mean of both in between; and the other's share.
    ///
    /// A share that falls smoothly keeps neighbouring pixels from taking different sides.
    fn or_wider(&self, wide: &Self) -> (Self, f32) {
        if !wide.holds() || wide.variance >= self.variance {
            return (*self, 0.0);
        }
        // Of nested windows, the variance of the difference is the difference of the variances.
        let (gain, apart) =
            (self.variance - wide.variance, CUT as f32 * (self.change - wide.change));
        let squared = apart * apart;
        let fall = (1.0 - squared / (gain * AGREEMENT * AGREEMENT)).max(0.0);
        let share = fall * fall;
        let mix = |this: f32, wide: f32| this + share * (wide - this);
        let doubt = DOUBT * squared.min(MOST_DOUBT);
        let variance = mix(self.variance, wide.variance) + doubt;
        (Self { change: mix(self.change, wide.change), variance }, share)
    }
}
