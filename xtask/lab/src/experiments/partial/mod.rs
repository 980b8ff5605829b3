//! How accurate one view's curves are, by method, noise, surface and angle.

mod accuracy;
mod error;
mod surface;

pub use accuracy::{Arguments, run};
