//! All tunables of consensus, by the file that uses them, in the order in which a node meets them.
//!
//! Each says its meaning, unit and source, and what happens when it is doubled. "By hand": chosen
//! on simulated sets and the bunny by `cargo xtask experiments ablation`. Lengths are in
//! footprints (a view's sample spacing) or standard deviations. A number that belongs to a formula
//! is explained beside it.

mod connect;
mod estimate;
mod measure;
mod shape;

pub(super) use connect::*;
pub(super) use estimate::*;
pub(super) use measure::*;
pub(super) use shape::*;
