//! Points of a query that views of a store looked through.
//!
//! **Problem.** A query takes the side of the nearest curve. A point may lie far behind the front
//! of a thin thing, where other views looked past it: it is not inside.
//!
//! **Idea.** What a view looked through is free. One view may have looked through a window, or
//! before something was put there, so that its word against a curve leaves the point unknown. Two
//! such views make it outside, as they make curves be left out (`seen_through.rs`).
//!
//! Cost: the space that each view looked through is read, some 100 kB and a few milliseconds, if
//! any point is inside. One view is in memory at a time.

use super::kept_image::KeptImage;
use crate::seen_through::{LEAST_THROUGH, Witness};
use transect_geometry::Point3;
use transect_model::store::{Snapshot, StoreError};
use transect_model::{Location, SpaceAnswer};

/// Corrects the answers about points that are inside by their nearest curves, where views of the
/// store looked through them. Returns how many were corrected. Use it on stores that were made with
/// [`Setup::free_space`](crate::Setup::free_space).
///
/// # Errors
/// If the store is damaged.
pub fn correct_by_free_space(
    snapshot: &Snapshot,
    points: &[Point3],
    answers: &mut [SpaceAnswer],
) -> Result<usize, StoreError> {
    let asked = points.iter().zip(answers).filter(|(_, a)| a.location == Location::Inside);
    let mut asked: Vec<_> = asked.map(|(point, answer)| (point, answer, 0)).collect();
    if asked.is_empty() {
        return Ok(0);
    }
    for view in snapshot.views()? {
        let kept = snapshot.copy(&view.entry)?.as_ref().and_then(KeptImage::read);
        let Some(free) = kept.and_then(KeptImage::free_space) else { continue };
        let witness = Witness::new(&view.entry.world_from_sensor, free);
        for (point, _, through) in &mut asked {
            *through += u32::from(witness.looked_through(point));
        }
    }
    let mut corrected = 0;
    for (_, answer, through) in asked.into_iter().filter(|(_, _, through)| *through > 0) {
        let is_sure = through >= LEAST_THROUGH;
        answer.location = if is_sure { Location::Outside } else { Location::Unknown };
        corrected += 1;
    }
    Ok(corrected)
}
