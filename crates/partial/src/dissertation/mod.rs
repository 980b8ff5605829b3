//! The dissertation's own method: plane by plane, through plane range images (chapter 3).
//!
//! **Problem.** The curves in which a family of planes cuts the surface that a range image samples
//! are wanted, linked, in order, with the solid on their left.
//!
//! **Idea.** A sensor that saw the plane alone would measure a plane range image, which the inverse
//! mapping F gives without measuring. Where the object's range passes the plane's from one pixel to
//! the next, the surface crosses the plane. Everything is decided among pixels, which lie on a
//! regular grid in the device frame and on none in space.
//!
//! **Citation.** The dissertation, chapter 3 and Appendix A, with its errata.
//!
//! **Steps**, for each plane that the view can see (3.2):
//! 1. the plane range image (3.4.1): [`PlaneImage`], `plane_image.rs`;
//! 2. the label image Ω (Eq. 3.2–3.4): [`LabelImage`], `label.rs`; thick borders are thinned
//!    (3.5.2) in `thin.rs`;
//! 3. codes 0–3, with the test for a range jump on both sides of a border (3.4.2): [`CodeImage`],
//!    `code.rs`;
//! 4. linking (3.5.1): search orders by code in `search.rs`, adjacent pixels in `link.rs`, gaps of
//!    1 to 4 missing pixels in `gap.rs`, tracing in `trace.rs`;
//! 5. subpixel places (3.6): [`crate::subpixel`];
//! 6. the direction of the curve (3.7): [`DirectionRule`], `orient.rs`; what is known of every
//!    node, `nodes.rs`.
//!
//! **Departures from the source** stand at the head of each file. The main ones: Labels come from
//! signed heights, since the printed comparison loses the plane through the sensor. Expected codes
//! of the search are exact, so that tracing is without choice where no pixel is missing. Thinning
//! is done on labels, before tracing. A gap is bridged only where range and direction continue, and
//! is marked. A saddle of four labels always cuts off the upper left and the lower right pixel,
//! because a pixel of code 3 is one pixel of one curve.
//!
//! **Cost.** Every plane visits every pixel: this is the specification in the source's own terms,
//! the baseline of benchmarks and the oracle for labels and codes. For speed there is
//! [`one_pass`](crate::one_pass). Of the inverse mapping F it needs the values of planes alone, so
//! grids of points are modelled, too: their rays meet planes without F.

mod code;
mod crossing;
mod gap;
mod label;
mod link;
mod nodes;
mod orient;
mod plane_image;
mod samples;
mod search;
mod steps;
mod thin;
mod trace;

pub use code::{Code, CodeImage, JumpTest};
pub use label::{Label, LabelImage};
pub use orient::DirectionRule;
use orient::Orient;
pub use plane_image::PlaneImage;
pub use steps::{CrossingStep, CurveSteps, PlaneSteps};

use crate::subpixel::{AngularGrid, Solver, Subpixel};
use crate::{
    MAX_CROSSINGS, PartialCounts, PartialCurve, PartialError, PartialModel, PlaneCurves,
    SectionAxes,
};
use code::Surface;
use link::Contour;
use nodes::Maker;
use samples::Samples;
use search::SearchOrder;
use serde::{Deserialize, Serialize};
use trace::Trace;
use transect_device::View;
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_image::smooth::Smoothing;
use transect_image::{NoisyView, PreparedView};

/// Longest gap, and largest useful thickness, in pixels. By hand: a search window of 131 × 131
/// pixels. Doubled, every open end costs four times the time.
pub const MOST_PIXELS: usize = 64;

/// Options.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct DissertationOptions {
    /// How an intersection is told from a range jump.
    pub jump: JumpTest,
    /// Most missing pixels that a curve is continued across; 0 bridges nothing. More than
    /// [`MOST_PIXELS`] are taken for as many.
    pub gap: usize,
    /// Thickness in pixels up to which alternating labels are taken for one curve; under 2 thins
    /// nothing.
    pub thickness: usize,
    /// How the point between two pixels is found.
    pub subpixel: Subpixel,
    /// How the direction of a curve is found.
    pub direction: DirectionRule,
    /// Whether noisy images are smoothed first (6.4); see [`transect_image::smooth`].
    pub smooth: bool,
}

impl Default for DissertationOptions {
    /// The source's gaps and thickness of up to 4 pixels (3.5).
    fn default() -> Self {
        Self {
            jump: JumpTest::default(),
            gap: 4,
            thickness: 4,
            subpixel: Subpixel::default(),
            direction: DirectionRule::default(),
            smooth: true,
        }
    }
}

/// The partial model of a view.
///
/// # Errors
/// [`PartialError`] if the planes are not parallel, or too dense for the view.
pub fn partial_model(
    view: &View,
    planes: &PlaneFamily,
    options: &DissertationOptions,
) -> Result<PartialModel, PartialError> {
    let noisy = NoisyView::whole(view);
    let prepared = prepared(&noisy, options);
    let axes = SectionAxes::new(prepared.view(), planes)?;
    let modeler = Modeler::new(&prepared, &axes, options);
    let mut model = PartialModel::default();
    model.counts.jumps = modeler.samples.jumps;
    model.take_prepared(&prepared);
    // A plane passes between two levels exactly if it is at the lower one or over it.
    let (low, high) = modeler.samples.extremes();
    for level in low.ceil() as i32..high.ceil() as i32 {
        let curves = modeler.curves(level, &mut model.counts)?;
        if !curves.is_empty() {
            model.planes.push(PlaneCurves { plane: axes.plane(level), curves });
        }
    }
    Ok(model)
}

/// The steps of one plane, from its range image to its directed curves; see [`PlaneSteps`].
///
/// # Errors
/// [`PartialError`] if the planes are not parallel, or too dense for the view, or if this plane is
/// far from it.
pub fn plane_steps(
    view: &View,
    planes: &PlaneFamily,
    plane: PlaneIndex,
    options: &DissertationOptions,
) -> Result<PlaneSteps, PartialError> {
    let noisy = NoisyView::whole(view);
    let prepared = prepared(&noisy, options);
    let axes = SectionAxes::new(prepared.view(), planes)?;
    let modeler = Modeler::new(&prepared, &axes, options);
    let level = plane.0.checked_sub(axes.base().0).and_then(|level| i32::try_from(level).ok());
    let level = level.ok_or(PartialError::OffView { plane })?;
    Ok(modeler.with_plane(level, |traced| traced.steps(&modeler)))
}

/// The view, smoothed as the options say. All of it is smoothed, since gaps are bridged and thick
/// labels thinned by what is around a curve.
fn prepared<'a>(view: &'a NoisyView<'a>, options: &DissertationOptions) -> PreparedView<'a> {
    let smoothing = options.smooth.then(Smoothing::default);
    PreparedView::new(view, smoothing.as_ref(), |noise| options.jump.smoothing_rule(noise.length()))
}

/// The label image of the plane at a level from the axes' base, before thinning.
pub fn label_image(view: &View, axes: &SectionAxes, level: i32) -> LabelImage {
    LabelImage::new(&Samples::new(view, axes, JumpTest::default(), 0.0), level)
}

/// The code image of the plane at a level from the axes' base, before thinning.
///
/// `sigma` is the range noise that the scale-free test for a jump allows for, in the length unit.
pub fn code_image(
    view: &View,
    axes: &SectionAxes,
    level: i32,
    jump: JumpTest,
    sigma: f64,
) -> CodeImage {
    let samples = Samples::new(view, axes, jump, sigma);
    let plane_image = PlaneImage::new(view.frame(), &axes.sensor_plane(level));
    let surface = Surface::new(&samples, &plane_image);
    let labels = LabelImage::new(&samples, level);
    CodeImage::new(&labels, &samples.grid, |p, n| surface.joined(p, n))
}

/// The modeler's inputs, which are the same for all planes.
struct Modeler<'a> {
    samples: Samples<'a>,
    order: SearchOrder,
    angles: Option<AngularGrid>,
    options: DissertationOptions,
    prepared: &'a PreparedView<'a>,
}

/// One plane after tracing.
struct Traced<'a> {
    level: i32,
    plane_image: &'a PlaneImage,
    labels: &'a LabelImage,
    codes: &'a CodeImage,
    surface: &'a Surface<'a>,
    traces: Vec<Trace>,
}

impl<'a> Modeler<'a> {
    fn new(
        prepared: &'a PreparedView<'a>,
        axes: &'a SectionAxes,
        options: &DissertationOptions,
    ) -> Self {
        let view = prepared.view();
        let uses_angles = options.subpixel.uses_angles();
        Self {
            samples: Samples::new(view, axes, options.jump, prepared.sigma()),
            order: SearchOrder::new(options.gap),
            angles: uses_angles.then(|| AngularGrid::read(view.frame())).flatten(),
            options: *options,
            prepared,
        }
    }

    /// Steps 1 to 4 of one plane, and what is to be done with them.
    fn with_plane<T>(&self, level: i32, then: impl FnOnce(Traced<'_>) -> T) -> T {
        let samples = &self.samples;
        let plane = samples.axes.sensor_plane(level);
        let plane_image = PlaneImage::new(samples.view.frame(), &plane);
        let surface = Surface::new(samples, &plane_image);
        let joined = |p, n| surface.joined(p, n);
        let mut labels = LabelImage::new(samples, level);
        thin::thin(&mut labels, &samples.grid, self.options.thickness, joined);
        let codes = CodeImage::new(&labels, &samples.grid, joined);
        let contour = Contour::new(samples.grid, &labels, &codes, &surface);
        let mut links = contour.link_adjacent(&self.order);
        gap::bridge(&contour, samples, level, &self.order, &mut links);
        let traces = trace::trace(&contour, &links, samples);
        let (plane_image, labels, codes) = (&plane_image, &labels, &codes);
        then(Traced { level, plane_image, labels, codes, surface: &surface, traces })
    }

    /// The curves of one plane; adds to the counts.
    fn curves(
        &self,
        level: i32,
        counts: &mut PartialCounts,
    ) -> Result<Vec<PartialCurve>, PartialError> {
        self.with_plane(level, |traced| {
            counts.crossings += traced.codes.crossings();
            if counts.crossings > MAX_CROSSINGS {
                return Err(PartialError::TooManyCrossings {
                    interval: self.samples.axes.interval(),
                });
            }
            let maker = self.maker(&traced);
            Ok(traced.traces.iter().filter_map(|t| maker.curve(t)).collect())
        })
    }

    /// The maker of curves from the traces of a plane: steps 5 and 6.
    fn maker<'b>(&'b self, traced: &'b Traced<'_>) -> Maker<'b> {
        let (samples, options) = (&self.samples, &self.options);
        let (surface, plane_image, level) = (traced.surface, traced.plane_image, traced.level);
        let plane = samples.axes.sensor_plane(level);
        let solver = Solver::new(samples.view, plane, options.subpixel, self.angles.as_ref());
        let orient = Orient { rule: options.direction, samples, surface, plane, plane_image };
        Maker { prepared: self.prepared, samples, surface, orient, level, solver }
    }
}
