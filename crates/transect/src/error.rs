//! Why a run ends without a model.

use crate::evaluate::digits;
use crate::{OptionError, SourceError};
use transect_geometry::{GuideError, LengthUnit, Point3};
use transect_partial::PartialError;
use transect_register::PriorError;

/// Why a run ends without a model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReconstructError {
    /// No views were given.
    #[error("the scan has no views")]
    NoViews,
    /// A view could not be loaded.
    #[error("view {view}")]
    Load {
        /// Its name.
        view: String,
        /// The error of its source.
        #[source]
        source: SourceError,
    },
    /// A view could not be modelled.
    #[error("view {view}")]
    Partial {
        /// Its name.
        view: String,
        /// The error of the partial modeler.
        #[source]
        source: PartialError,
    },
    /// No plane crosses any view's surface: usually a wrong unit, offset or depth scale.
    #[error(
        "no section plane crosses the surfaces of the scan (views: {views}). By their ranges \
         they lie somewhere within the stations {} to {} {unit}; check the unit, the depth scale, \
         the offset and interval of the planes, and the rule for range jumps{}",
        digits(*low),
        digits(*high),
        offset_between(*low, *high, *has_plane)
    )]
    Nothing {
        /// How many views there were.
        views: usize,
        /// Lowest station of the views' points.
        low: f64,
        /// Highest station of the views' points.
        high: f64,
        /// Whether a plane lies between these stations.
        has_plane: bool,
        /// The model's unit.
        unit: LengthUnit,
    },
    /// No plane along a curved guide crosses any view's surface.
    #[error(
        "no section plane along the guide crosses the surfaces of the scan (views: {views}). \
         {beyond_ends} of their pixels lie beyond its ends{}. The guide reaches over {} {unit}, the \
         surfaces over {} {unit}. Check that both are in the same unit and in the same coordinate \
         system",
        too_far(*beyond_reach, *usable, *unit),
        extent(&extents[0]),
        extent(&extents[1])
    )]
    OffGuide {
        /// How many views there were.
        views: usize,
        /// Pixels beyond the guide's ends.
        beyond_ends: usize,
        /// Pixels so far from it that its planes may cross there.
        beyond_reach: usize,
        /// The distance from the guide up to which pixels count; infinite for a straight guide.
        usable: f64,
        /// Lowest and highest coordinates of the guide, and of the views' points.
        extents: Box<[[Point3; 2]; 2]>,
        /// The model's unit.
        unit: LengthUnit,
    },
    /// Planes cross surfaces of the views, but no view has two crossings beside each other.
    #[error(
        "the surfaces of the scan (views: {views}) cross the section planes {crossings} times, but \
         nowhere twice in a row. Planes in a face or just behind it, which the noise of the face \
         alone crosses, make no curves: move them by the setting `offset`. Neither do images of one \
         row, too few pixels, or a sigma as large as the objects"
    )]
    NoCurves {
        /// How many views there were.
        views: usize,
        /// How many crossings.
        crossings: usize,
    },
    /// An option of a method has a value that it cannot have.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// How far poses may be wrong has a value that it cannot have.
    #[error(transparent)]
    Prior(#[from] PriorError),
    /// By how much the surface of a view may be off has a value that it cannot have.
    #[error(
        "view {view}: its surface_sigma is {}, and its farthest value {}, in the unit of length; \
         expected a number of 0 to 100 times that value, or none",
        digits(*sigma),
        digits(*farthest)
    )]
    SurfaceSigma {
        /// The name of the view.
        view: String,
        /// Its `surface_sigma`.
        sigma: f64,
        /// The largest value of its image.
        farthest: f64,
    },
    /// The smallest interval of the refined planes is not a positive length.
    #[error("the section planes cannot be refined")]
    Refine(#[source] GuideError),
    /// The watcher asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// Advice on an offset where no plane lies between the lowest and the highest station.
fn offset_between(low: f64, high: f64, has_plane: bool) -> String {
    let extent = high - low;
    if has_plane || !(extent.is_finite() && extent > 0.0) {
        return String::new();
    }
    let decimals = (1.0 - extent.log10().floor()).clamp(0.0, 12.0) as usize;
    format!(
        ". No plane lies between these stations; the setting `offset` {:.decimals$} puts a plane \
         in their middle",
        0.5 * (low + high)
    )
}

/// The pixels too far from a guide, in words; empty for a straight guide, from which none is.
fn too_far(pixels: usize, usable: f64, unit: LengthUnit) -> String {
    if usable.is_infinite() {
        return String::new();
    }
    format!(", and {pixels} farther from it than the usable distance of {} {unit}", digits(usable))
}

/// Lowest and highest coordinates in words.
fn extent([low, high]: &[Point3; 2]) -> String {
    let along =
        |k: usize| format!("{} {} to {}", ["x", "y", "z"][k], digits(low[k]), digits(high[k]));
    [0, 1, 2].map(along).join(", ")
}
