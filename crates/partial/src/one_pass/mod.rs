//! Contours of a whole plane family from one sweep over a range image.
//!
//! **Problem.** Every plane of the family cuts the surface that the image samples; all those curves
//! are wanted, linked, in order, with the solid on their left.
//!
//! **Idea.** The dissertation makes a plane range image and a label image per plane (chapter 3).
//! Measured in intervals, the height of each pixel's surface point over plane 0 is one scalar
//! image, the *level*, and the label of plane k is "level > k". The curves of *all* planes are the
//! level lines of that one image. One pass over the pixels finds them, and the cost no longer grows
//! with planes × pixels.
//!
//! **Steps.**
//! 1. Per row (`rows.rs`): levels, `L = ceil(level)`: plane k lies between two pixels exactly if k
//!    is in `[min L, max L)`; a pixel on the plane counts as low (3.4).
//! 2. Pairs with a missing pixel or a range jump are broken **before** anything is emitted: few
//!    pairs are jumps, but they hold a large share of all level differences (3.4.2). Joined pairs,
//!    and those among them that a plane crosses, are bit masks.
//! 3. Each crossed pair emits its crossings with consecutive numbers (`emit.rs`), solved for the
//!    point where the line between the two samples meets the plane (3.6, Cartesian curve–plane,
//!    linear).
//! 4. Each cell of four pixels links its entering crossings to its leaving ones, seen with the high
//!    side on the left (`link.rs`, `cell.rs`). This replaces the search windows of 3.5.
//! 5. Every few rows, a *band*, links are followed while they are in the processor's cache. This
//!    gives *pieces* of curves (`trace.rs`); pieces that meet at a band's border are joined, and
//!    whole lines are put into their final order and place (`chains.rs`). Parts of the image may be
//!    swept in parallel (`part.rs`); where it is cut, for either reason, changes no bit of the
//!    result.
//! 6. Handedness turns "high on the left" into "solid on the left" (3.7). A curve runs along
//!    `n × N`: plane normal, outward surface normal. Seen from the sensor, the high side is on its
//!    left, whatever side of the plane the sensor is on. So a mirrored grid reverses all curves,
//!    and a plain one none. No range comparison per curve is needed.
//! 7. Lines that noise alone makes where the surface is nearly tangent to the plane are left out;
//!    see `near_tangent.rs`. If asked, lines cut by a few missing pixels are joined, and the unit
//!    between is marked (3.5.1); see `bridge.rs`.
//! 8. Lines become curves (`curves.rs`): places again in `f64`, by any of the ways of
//!    [`mod@crate::subpixel`]. Nodes state what is known of them (`nodes.rs`), and how far their
//!    chords may lie off the surface (`bend.rs`). Open curves state why they end (`ends.rs`).
//!
//! Steps 1 to 5 are [`contours`], for those who want lines and nothing else.
//!
//! **Arithmetic.** Steps 1 to 6 work in `f32`, with the offset of the planes taken out in `f64`
//! before ([`SectionAxes`]). Multiplications and additions are never contracted, so all instruction
//! sets give the same bits, and so do all processors. A tie is low; a saddle is decided by the mean
//! of its four levels; a missing pixel is known by its value, never by its level. A label may
//! differ from that of the exact level where the level is within `2⁻²² · (|p| · |g| + |c|)` of a
//! plane (level `g · p + c`). A pair may be judged otherwise than in `f64` where its range step is
//! within `10⁻⁶` of the range of the limit. Backends without tables
//! ([`transect_device::SeparableForm`]) round once, at the end.
//!
//! **Departures from the source.** No thinning: curves of a scalar image are one crossing wide.
//!
//! **Cost.** One visit per pixel, one per crossing. Memory, kept in a [`Workspace`]: some rows, one
//! band, and about 25 bytes per crossing where planes are dense ([`Workspace::bytes`]), 8 of which
//! are the lines.
//!
//! **Curved guides.** Levels along them are not an affine function of the point; `along_guide.rs`
//! gives samples coordinates in which they are.

mod along_guide;
mod apart;
mod band;
mod bend;
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
mod vertex;

pub use crate::Instructions;
pub use contours::{Contours, Effort, Polyline, Workspace, contours};
pub use seen::{Seen, seen};
pub use vertex::{Kind, Vertex};

use crate::near_planes::near_planes;
use crate::subpixel::Subpixel;
use crate::{PartialError, PartialModel, SectionAxes};
use along_guide::Straightening;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use transect_device::View;
use transect_geometry::{CurvedGuide, PlaneFamily};
use transect_image::smooth::{PixelChoice, Smoothing, SmoothingSteps, ValueBounds};
use transect_image::{BreakRule, NoisyView, PreparedView, RangeNoise};

/// Options.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct OnePassOptions {
    /// Largest angle between a ray and the surface normal at which two pixels still count as one
    /// surface, in radians. Larger keeps more of the rims, where real scanners overshoot. Flat
    /// surfaces are kept beyond it: [`transect_image::Grazing`].
    pub max_incidence_rad: f64,
    /// How many standard deviations of the range a pair may differ by from noise alone.
    pub jump_sigmas: f64,
    /// Whether noisy images are smoothed before their contours are found; see
    /// [`transect_image::smooth`]. Images that are not smoothed are not halved, either.
    pub smooth: bool,
    /// How the point between two pixels is found. Diagonals of cells with a missing pixel are
    /// solved linearly, and so are all crossings with four points that noise alone may have bent.
    /// Four points take twice the time for nodes, and noise that neighbours share, which no
    /// estimate sees, bends them: they are for ranges known to be clean.
    pub subpixel: Subpixel,
    /// Most missing pixels in a row that a curve is continued across, 4 as in the source; 0 bridges
    /// nothing. In a view that is halved, half as many of the pixels read, rounded up. Bridged
    /// units are marked: fusion never lets them keep seen nodes from each other.
    pub gap: usize,
    /// Standard deviations by which the surface must leave the plane on both sides of a curve. 0
    /// keeps the curves that noise alone makes where the surface is nearly tangent to the plane.
    pub excursion_sigmas: f64,
    /// Smallest factor between range noise and a node's error across the curve.
    ///
    /// With errors along the ray alone, a surface seen obliquely moves less across the curve than
    /// along the ray, by a factor of down to 0.25. With that as bound, the default, predicted
    /// errors are the observed ones of simulated noise. Real scanners err in other ways, too, and
    /// most where they see a surface obliquely: a bound of 1 does not claim the gain.
    pub least_sigma_factor: f64,
    /// Whether flat surfaces beyond the largest angle are joined; off in experiments alone.
    #[doc(hidden)]
    #[serde(skip)]
    pub grazing: bool,
    /// Steps of the smoother that are taken; all but in experiments.
    #[doc(hidden)]
    #[serde(skip)]
    pub smoothing: SmoothingSteps,
}

impl Default for OnePassOptions {
    fn default() -> Self {
        Self {
            max_incidence_rad: BreakRule::MAX_INCIDENCE_RAD,
            jump_sigmas: BreakRule::JUMP_SIGMAS,
            smooth: true,
            subpixel: Subpixel::Cartesian,
            gap: 4,
            excursion_sigmas: 4.0,
            least_sigma_factor: 0.25,
            grazing: true,
            smoothing: SmoothingSteps::default(),
        }
    }
}

impl OnePassOptions {
    /// A view with its noise, at the resolution in which curves are found.
    pub fn resolved<'a>(&self, view: &'a View) -> NoisyView<'a> {
        let steps = self.smoothing;
        let noisy = match self.smooth && steps.shared_noise && steps.half_resolution {
            true => NoisyView::resolved(view),
            false => NoisyView::whole(view),
        };
        if !(self.smooth && steps.fill) {
            return noisy;
        }
        let rule = self.break_rule(noisy.view(), noisy.noise());
        noisy.filled(&rule)
    }

    /// The rule for range jumps in a view with this noise.
    pub fn break_rule(&self, view: &View, noise: &RangeNoise) -> BreakRule {
        let slack = self.jump_sigmas * noise.length();
        let rule = BreakRule::new(self.max_incidence_rad, slack).on_rays_of(view);
        if self.grazing && !noise.is_mostly_shared() { rule.with_grazing() } else { rule }
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

/// The same, in memory that is kept from view to view. `effort` sets how the work is done.
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
    if let Some(guide) = planes.guide().curved() {
        return along_guide(view, (planes, guide), options, effort, work);
    }
    let noisy = options.resolved(view);
    let view = noisy.view();
    let rule = |noise: &RangeNoise| options.break_rule(view, noise);
    let axes = SectionAxes::new(view, planes)?;
    let near = |bounds: &ValueBounds| near_planes(view, &axes, bounds, effort.instructions);
    let (instructions, steps) = (effort.instructions, options.smoothing);
    // The cubic reads samples beside the pairs, which may be far from every plane.
    let pixels = (options.subpixel != Subpixel::FourPoint).then_some(&near as &PixelChoice<'_>);
    let smoothing = Smoothing { pixels, instructions, steps };
    let prepared = PreparedView::new(&noisy, options.smooth.then_some(&smoothing), rule);
    let rule = rule(prepared.noise());
    let contours = contours(prepared.view(), &axes, &rule, effort, work)?;
    let lines = curves::Lines {
        view: prepared.view(),
        prepared: &prepared,
        axes: &axes,
        rule: &rule,
        contours: &contours,
        along: None,
    };
    Ok(counted(lines, options))
}

/// The same on planes along a curved guide; see `along_guide.rs`.
fn along_guide(
    view: &View,
    (planes, guide): (&PlaneFamily, &Arc<CurvedGuide>),
    options: &OnePassOptions,
    effort: &Effort,
    work: &mut Workspace,
) -> Result<PartialModel, PartialError> {
    let noisy = options.resolved(view);
    let rule = |noise: &RangeNoise| options.break_rule(noisy.view(), noise);
    let (instructions, steps) = (effort.instructions, options.smoothing);
    let smoothing = Smoothing { pixels: None, instructions, steps };
    let prepared = PreparedView::new(&noisy, options.smooth.then_some(&smoothing), rule);
    let rule = rule(prepared.noise());
    let mut model = PartialModel::default();
    let off_guide = match Straightening::of(prepared.view(), planes, guide)? {
        Straightening::Off(off_guide) => {
            model.take_prepared(&prepared);
            off_guide
        }
        Straightening::Along(along) => {
            let axes = SectionAxes::new(&along.view, &along.planes)?;
            let contours = contours(&along.view, &axes, &rule, effort, work)?;
            let lines = curves::Lines {
                view: &along.view,
                prepared: &prepared,
                axes: &axes,
                rule: &rule,
                contours: &contours,
                along: Some(&along),
            };
            model = counted(lines, options);
            model.notes.extend(along.note);
            along.off_guide
        }
    };
    model.counts.beyond_ends = off_guide.beyond_ends;
    model.counts.beyond_reach = off_guide.beyond_reach;
    Ok(model)
}

/// The curves of all lines, with what is counted of them.
fn counted(lines: curves::Lines<'_>, options: &OnePassOptions) -> PartialModel {
    let mut model = lines.model(options);
    model.counts.crossings = lines.contours.vertex_count();
    model.counts.jumps = lines.contours.jumps();
    model.take_prepared(lines.prepared);
    model
}
