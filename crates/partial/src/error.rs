//! Why a view could not be modelled.

use transect_geometry::PlaneIndex;

/// Largest number of planes one view may span, 2²².
///
/// Levels count from the middle of the view and are compared as `f32`, which resolves an eighth of
/// an interval 2²¹ planes from there. Doubled, it resolves a quarter.
pub const MAX_LEVELS: i64 = 1 << 22;

/// Largest number of a plane. Theory: `f64` holds whole numbers up to 2⁵³, about 9e15. Doubled,
/// neighbouring planes could get one number.
pub const MAX_PLANE: f64 = 9e15;

/// Most crossings of one view, 2²³: with their curves they take about 0.9 GiB. A view of four
/// million pixels has that many if one plane passes between any two neighbours of a row or of a
/// column. Doubled, they take twice the memory.
pub const MAX_CROSSINGS: usize = 1 << 23;

/// Why a view could not be modelled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PartialError {
    /// The sensor has no point for any value of the image.
    #[error(
        "the values of the image run from {nearest} to {farthest}, and the sensor has no point for \
         any of them: check the image's scale, and the keys of the sensor"
    )]
    NoPoints {
        /// The smallest value.
        nearest: f32,
        /// The largest value.
        farthest: f32,
    },
    /// The planes lie so densely that a level no longer has a usable resolution.
    #[error(
        "the view spans {planes:.3e} planes of interval {interval}; at most {MAX_LEVELS} are possible: \
         is the interval in the right unit?"
    )]
    TooManyPlanes {
        /// How many planes the view's sensing volume spans.
        planes: f64,
        /// The interval, in the model's length unit.
        interval: f64,
    },
    /// Plane 0 is so far away that a plane's number is no longer exact in `f64`.
    #[error(
        "the view lies {planes:.3e} planes of interval {interval} from plane 0; at most \
         {MAX_PLANE:.0e} can be counted: is the interval in the right unit? If it is, choose an \
         offset near the view"
    )]
    TooFar {
        /// How many planes the middle of the view is from plane 0.
        planes: f64,
        /// The interval, in the model's length unit.
        interval: f64,
    },
    /// A single plane that was asked for is so far from the view that it cannot be counted from it.
    #[error("plane {plane} is more than 2^31 planes from the view; choose a plane that crosses it")]
    OffView {
        /// The plane.
        plane: PlaneIndex,
    },
    /// So many crossings that their curves would not fit into memory.
    #[error(
        "the view crosses the planes of interval {interval} more than {MAX_CROSSINGS} times: \
         is the interval in the right unit?"
    )]
    TooManyCrossings {
        /// The interval, in the model's length unit.
        interval: f64,
    },
    /// The method is for parallel planes alone.
    #[error(
        "this method is for planes along a straight guide; along a curved one use the method `one_pass`"
    )]
    CurvedGuide,
}
