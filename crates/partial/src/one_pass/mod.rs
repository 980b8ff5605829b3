//! Contours of a whole plane family from one sweep over a range image.
//!
//! **Problem.** Every plane of the family cuts the surface that the image samples; all those curves
//! are wanted, linked, in order, with the solid on their left.
//!
//! **Idea.** The dissertation makes a plane range image and a label image per plane (chapter 3).
//! Measured in intervals, the height of each pixel's surface point over plane 0 is one scalar
//! image, the *level*, and the label of plane k is "level > k". The curves of *all* planes are the
//! level lines of that one image, so one pass over the pixels finds them, and the cost no longer
//! grows with planes × pixels.
//!
//! **Steps.**
//! 1. Per row: levels (the device frame's fast path), `L = ceil(level)`: plane k lies between two
//!    pixels exactly if k is in `[min L, max L)`; a pixel on the plane counts as low (3.4).
//! 2. Pairs with a missing pixel or a range jump are broken **before** anything is emitted: few
//!    pairs are jumps, but they hold a large share of all level differences (3.4.2).
//! 3. Each unbroken pair emits its crossings with consecutive numbers, solved for the point where
//!    the line between the two samples meets the plane (3.6, Cartesian curve–plane, linear).
//! 4. Each cell of four pixels links its entering crossings to its leaving ones, seen with the high
//!    side on the left; see `cell.rs`. This replaces the search windows of 3.5.
//! 5. Chains are followed from their heads, then closed loops; see `trace.rs`.
//! 6. Handedness turns "high on the left" into "solid on the left" (3.7): seen from the sensor, the
//!    curve direction `n × N` (plane normal, outward surface normal) has the high side on its left
//!    whatever side of the plane the sensor is on, so a mirrored grid reverses all curves and a
//!    plain one none. No range comparison per curve is needed.
//!
//! 7. Lines that noise alone makes where the surface is nearly tangent to the plane are left out; see
//!    `near_tangent.rs`. Lines cut by a few missing pixels are joined, and the unit between them is
//!    marked (3.5.1); see `bridge.rs`.
//! 8. Crossings may be solved again by another of the ways of [`mod@crate::subpixel`]. What is known
//!    of every node: `nodes.rs`.
//!
//! **Departures from the source.** No thinning: curves of a scalar image are one crossing wide.
//!
//! **Cost.** One visit per pixel, one per crossing; memory for a few rows and the crossings. Not for
//! curved guides, whose levels are not an affine function of the point.

mod band;
mod bridge;
mod cell;
mod chains;
mod contours;
mod crossing;
mod curves;
mod emit;
mod ends;
mod link;
mod near_tangent;
mod nodes;
mod pair_line;
mod part;
mod refine;
mod rows;
mod seen;
mod source;
mod trace;

pub use contours::{Contours, Effort, Instructions, Kind, Polyline, Vertex, Workspace, contours};
pub use seen::{Seen, seen};

use crate::prepared::Prepared;
use crate::subpixel::Subpixel;
use crate::{BreakRule, PartialError, PartialModel, SectionAxes};
use transect_device::View;
use transect_geometry::PlaneFamily;

/// What can be set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnePassOptions {
    /// Largest angle between a ray and the surface normal at which two pixels still count as one
    /// surface, in radians. Larger keeps more of the rims, where real scanners overshoot.
    pub max_incidence_rad: f64,
    /// How many standard deviations of the range a pair may differ by from noise alone.
    pub jump_sigmas: f64,
    /// Whether noisy images are smoothed before their contours are found; see [`mod@crate::smooth`].
    pub smooth: bool,
    /// How the point between two pixels is found. Diagonals of cells with a missing pixel are solved
    /// linearly, and so are all crossings with four points that noise alone may have bent. Four
    /// points take twice the time for nodes, and noise that neighbours share, which no estimate
    /// sees, bends them: they are for ranges known to be clean.
    pub subpixel: Subpixel,
    /// Most missing pixels in a row that a curve is continued across; 0 bridges nothing.
    pub gap: usize,
    /// Standard deviations by which the surface must leave the plane on both sides of a curve; 0
    /// keeps what noise alone makes where the surface is nearly tangent to the plane.
    pub excursion_sigmas: f64,
    /// Smallest factor between range noise and a node's error across the curve.
    ///
    /// With errors along the ray alone, a surface seen obliquely moves less across the curve than
    /// along the ray, by a factor of down to 0.25; with that as bound, the predicted errors are the
    /// observed ones of simulated noise. Real scanners err in other ways, too, and most where they
    /// see a surface obliquely: a bound of 1 does not claim the gain.
    pub least_sigma_factor: f64,
}

impl Default for OnePassOptions {
    fn default() -> Self {
        Self {
            max_incidence_rad: 78_f64.to_radians(),
            jump_sigmas: 4.0,
            smooth: true,
            subpixel: Subpixel::Cartesian,
            gap: 4,
            excursion_sigmas: 4.0,
            least_sigma_factor: 1.0,
        }
    }
}

/// The partial model of a view.
///
/// # Errors
/// [`PartialError`] if the planes are too dense for the view.
pub fn partial_model(
    view: &View,
    planes: &PlaneFamily,
    options: &OnePassOptions,
) -> Result<PartialModel, PartialError> {
    partial_model_with(view, planes, options, &Effort::default(), &mut Workspace::default())
}

/// The same, in memory that is kept from view to view, and with a say in how the work is done.
///
/// # Errors
/// As [`partial_model`].
pub fn partial_model_with(
    view: &View,
    planes: &PlaneFamily,
    options: &OnePassOptions,
    effort: &Effort,
    work: &mut Workspace,
) -> Result<PartialModel, PartialError> {
    let rule = |sigma| BreakRule::new(options.max_incidence_rad, options.jump_sigmas * sigma);
    let prepared = Prepared::new(view, options.smooth, rule);
    let axes = SectionAxes::new(prepared.view(), planes)?;
    let rule = rule(prepared.sigma());
    let contours = contours(prepared.view(), &axes, &rule, effort, work)?;
    let lines =
        curves::Lines { prepared: &prepared, axes: &axes, rule: &rule, contours: &contours };
    let mut model = lines.model(options);
    model.counts.crossings = contours.vertex_count();
    model.counts.jumps = contours.jumps();
    prepared.count(&mut model.counts);
    Ok(model)
}
