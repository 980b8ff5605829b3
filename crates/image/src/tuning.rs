//! Every number of the smoother that was chosen rather than derived.
//!
//! "Measured" refers to the median error of the curves of the two rooms, the parts and the face of
//! the peers' data sets. Their noise is 0.1 % and 0.5 % of their size.

/// Half the width of the largest window, in pixels. A window then has 21 × 21 pixels.
///
/// Chosen by hand: eight windows side by side then have 28 columns, which fit 32 bits, see
/// `links.rs`. It limits [`WIDEST_RADIUS`]; doubled, windows no longer fit their bit masks.
pub(crate) const HALF_WINDOW: usize = 10;

/// Columns of the largest window.
pub(crate) const WINDOW_COLUMNS: usize = 2 * HALF_WINDOW + 1;

/// Radius of the window where noise equals the spacing of the rays, in pixels.
///
/// Theory: the best radius grows with noise, and bias with the third power of the radius, so the
/// radius follows the cube root of noise over spacing. The factor is measured: between 5.9 and 6.3
/// median and 95 % quantile together hardly change. Doubled, small features are flattened.
pub(crate) const RADIUS: f32 = 6.0;

/// Radius below which a pixel is not smoothed, in pixels.
///
/// Theory: a smaller window holds hardly more pixels than the six coefficients of the fit. Doubled,
/// images whose noise is under half the spacing stay as noisy as they are.
pub(crate) const SMALLEST_RADIUS: f32 = 2.3;

/// Radius of the largest narrow window, in pixels.
///
/// Chosen by hand: far enough below [`WIDEST_RADIUS`] that the wider window still holds twice the
/// pixels. Doubled, both windows are the same.
pub(crate) const LARGEST_RADIUS: f32 = 7.5;

/// Radius of the largest wider window, in pixels; pixels on its rim have weight 0.
pub(crate) const WIDEST_RADIUS: f32 = HALF_WINDOW as f32 + 0.5;

/// Radius of the wider window over that of the narrow one. No unit.
///
/// Measured: from √2, which gives twice the pixels, to 1.5 the median error of the curves falls by
/// 1 to 3 %, and a whole run takes 2 % longer. Doubled, the two windows seldom agree, and the wider
/// one seldom counts.
pub(crate) const WIDER: f32 = 1.5;

/// Least noise that neighbours share, over the noise that each pixel has of its own, of a view that
/// is halved. Every second row of a window is left out there, too.
///
/// Theory: shared noise of this size has groups of four pixels and more, so at least four fifths of
/// the variance of a mean are shared noise. Half the samples then add at most a fifth to it.
/// Measured: simulated depth cameras have 1.2 to 2.5, and the red kitchen has 2.2 to 3.3. Half the
/// rows take half the time and change neither median nor 95 % distance of `kitchen_kin40_real` and
/// the red kitchen. Doubled, most depth cameras are read whole, which takes twice the time.
pub(crate) const MOSTLY_SHARED: f64 = 1.0;

/// Residual at which a pixel's robust weight becomes 0, in standard deviations of a sample.
///
/// Theory: Tukey's biweight is 96 % as efficient as least squares on normal noise with 5, 95 % with
/// 4.685 and 98 % with 6. Measured: with 4.685 parts at 0.5 % noise have a 95 % quantile 1 %
/// larger, with 5.5 rooms at 0.5 % noise one 5 % larger. Doubled, the other side of a crease or of
/// a low step takes part in the fit.
pub(crate) const CUT: f32 = 5.0;

/// Change from which a pixel keeps its sample, in standard deviations of a sample.
///
/// Theory: normal noise is larger at one pixel in 16 000; a sample that differs by more is of
/// another surface than the fit. It also bounds the pixels that have to be smoothed near a plane.
/// At most [`CUT`]; doubled, samples of thin objects move to the surface behind them.
pub(crate) const LARGEST_CHANGE: f32 = 4.0;

/// Difference between the estimates of two windows from which the wider one has no share, in
/// standard deviations of that difference.
///
/// Chosen by hand. Doubled, curved surfaces are flattened by wide windows.
pub(crate) const AGREEMENT: f32 = 3.0;

/// Share of the windows' squared difference that counts as variance of the result.
///
/// Chosen by hand: on walls a third would do, where surfaces bend both windows err by more.
/// Doubled, pixels at bends are stated to be noisier than they are.
pub(crate) const DOUBT: f32 = 0.7;

/// Largest squared difference that counts so, in variances of a sample.
///
/// Theory: a result is never worse than a sample, whose variance is 1. Doubled, a pixel keeps its
/// sample where the two windows differ by more than 1.2 standard deviations of a sample, because
/// the stated variance then exceeds 1.
pub(crate) const MOST_DOUBT: f32 = 1.0;

/// Pivot of the normal equations, as a share of its diagonal, below which a term is left out.
///
/// Chosen by hand: x² cannot be told from x in a window of two columns, where the share is of the
/// order of rounding, 10⁻⁷. Doubled, nothing changes.
pub(crate) const SMALLEST_PIVOT: f32 = 1e-3;
