//! One range image before any section plane is known: its noise, its range jumps, its smoothing.
//!
//! The one decision of this crate: an image is judged **by itself**, from neighbouring pixels. It
//! knows no section planes, no curves and no other views.
//!
//! * [`RangeNoise`]: the range noise of a view, stated or estimated from its image;
//! * [`BreakRule`]: whether two neighbouring pixels belong to one surface (dissertation, 3.4.2);
//!   [`PairTests`] is the same rule for many pairs side by side;
//! * [`Grazing`]: whether two others do, as both lie on a flat surface seen at a grazing angle;
//! * [`mod@smooth`]: edge-preserving smoothing;
//! * [`NoisyView`]: a view with its noise, at the resolution that the noise leaves;
//! * [`PreparedView`]: the same view with its image smoothed.

mod breaks;
mod fill;
mod grazing;
mod instructions;
mod noise;
mod noisy_view;
mod pair_rule;
mod prepared;
pub mod smooth;
mod tuning;

pub use breaks::BreakRule;
pub use grazing::Grazing;
pub use instructions::Instructions;
pub use noise::{RangeNoise, estimate_sigma, estimate_value_sigma, length_per_value};
pub use noisy_view::NoisyView;
pub use pair_rule::{PairTest, PairTests, padded};
// Their types are those of a vector library, which other crates need not know.
#[doc(hidden)]
pub use pair_rule::{TestPairs, UniformTest};
pub use prepared::PreparedView;
