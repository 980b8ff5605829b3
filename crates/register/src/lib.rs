//! The poses of range images: judged, explained and refined before any section plane is known.
//!
//! The one decision of this crate: poses are compared **through the images**, along the rays of the
//! views, and never through curves. It knows no section planes, no files and no model.
//!
//! * [`CoarseView`]: a view as a few thousand patches of surface and the free space before them.
//! * [`FreeSpace`]: how far a view looked through in each direction.
//! * [`judge`]: which views, groups of views or regions of a view contradict the others.
//! * [`refine`]: the poses of all views, refined together.
//! * [`find_reading`]: another convention by which the same poses or images may have been written.

mod coarse;
mod free_space;
mod judge;
mod prior;
mod readings;
mod refine;
mod scrambled;
mod tuning;

pub use coarse::{CoarseView, Patch, PatchMeeting, StoredCopy};
pub use free_space::FreeSpace;
pub use judge::{
    Agreement, Finding, Judgement, Misplaced, Motion, Region, RegionKind, Scaled, judge,
};
pub use prior::{PosePrior, PriorError};
pub use readings::{Accord, FoundReading, PoseReading, Reading, StatedPoses, find_reading};
pub use refine::{PoseOutcome, PoseRefinement, RefineOptions, RefinedPose, refine};
