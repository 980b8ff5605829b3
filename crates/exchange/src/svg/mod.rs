//! Pictures: a true-to-scale sheet per plane, an overview of all planes in space, and figures of
//! single steps with a legend.
//!
//! All are plain SVG 1.1 with white paper and no scripts. Coordinates are whole multiples of a
//! small step inside a scaled group, and vertices that would not move the line visibly are left
//! out, so that files stay small.

mod camera;
mod canvas;
mod figure;
mod options;
mod overview;
mod points;
mod ramp;
mod raster;
mod ruler;
mod sheet;
mod simplify;

pub use figure::{Anchor, Figure, Mark};
pub use options::OverviewOptions;
pub use overview::write_overview;
pub use points::write_points;
pub use raster::Raster;
pub use sheet::Sheets;

#[cfg(test)]
mod tests;
