//! How accurate one view's curves are, by method, noise, surface and angle.

mod accuracy;
mod chart;
mod error;
mod surface;

pub use accuracy::{Arguments, run};
