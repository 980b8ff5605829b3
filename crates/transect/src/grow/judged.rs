//! The poses in a store, judged by the coarse copies that it keeps of the views' images.
//!
//! Views come one after the other, and the images of earlier ones may be gone. With every view the
//! store keeps its [`CoarseView`], as [`StoredCopy`](transect_register::StoredCopy). The views are
//! judged at the poses that they have in the store, as in a run over all of them.

use super::GrowError;
use super::kept_image::read_copy;
use crate::poses::{PoseReport, reread};
use crate::{Setup, ViewSource};
use std::collections::BTreeSet;
use transect_device::{Note, Vector3};
use transect_model::store::{Snapshot, StoredView, ViewId};
use transect_register::CoarseView;

/// Most views that are judged at once, unless more are new. No unit. Theory: a view is compared
/// with 60 others at most. Measured on a store of 240 frames of a depth camera: a view is added in
/// 2.6 s, and in 6.1 s with 200 of them; turned by 10° or 30°, it is named with either, and by 3°
/// with neither. Doubled, up to four times as many pairs are compared.
const MOST_JUDGED: usize = 60;

/// The judgement of a store's poses by its copies.
pub(super) struct Judged {
    /// The poses; `None` of fewer than two views.
    pub poses: Option<PoseReport>,
    /// The note on views that have no copy.
    pub note: Option<Note>,
}

/// Judges the poses of a store: of all views, or if there are many, of `new` ones and those around
/// them. Images are read in another way only if all of these views are among the sources.
pub(super) fn judged<S: ViewSource>(
    snapshot: &Snapshot,
    new: &BTreeSet<ViewId>,
    sources: &[S],
    setup: &Setup,
) -> Result<Judged, GrowError> {
    let views = nearest(snapshot.views()?, new);
    let mut copies = Vec::with_capacity(views.len());
    for StoredView { entry, .. } in &views {
        let stored = read_copy(snapshot, entry)?;
        copies.extend(stored.and_then(|c| c.restore(&entry.id.0, entry.world_from_sensor)));
    }
    let (count, without) = (views.len(), views.len() - copies.len());
    let note = (without > 0 && count > 1).then(|| {
        Note::new(format!(
            "the poses of {without} of {count} views are not compared with those of others: the \
             store was made without coarse copies of their images. transect replace-view adds the \
             copy of a view"
        ))
    });
    let known: BTreeSet<&str> = sources.iter().map(ViewSource::id).collect();
    let all_known = views.iter().all(|view| known.contains(view.entry.id.0.as_str()));
    let again =
        |reading| if all_known { reread(sources, reading, CoarseView::quick) } else { None };
    let several = copies.len() > 1;
    let judge =
        || PoseReport { in_store: true, ..PoseReport::of_given(copies, None, again, setup) };
    let poses = several.then(judge);
    Ok(Judged { poses, note })
}

/// The new views, and of the others those whose sensors are nearest to one of theirs.
fn nearest(mut views: Vec<StoredView>, new: &BTreeSet<ViewId>) -> Vec<StoredView> {
    if views.len() <= MOST_JUDGED {
        return views;
    }
    let place = |view: &StoredView| view.entry.world_from_sensor.translation.vector;
    let is_new = |view: &StoredView| new.contains(&view.entry.id);
    let places: Vec<Vector3> = views.iter().filter(|view| is_new(view)).map(place).collect();
    let far = |view: &StoredView| {
        let lengths = places.iter().map(|new| (place(view) - new).norm());
        lengths.fold(f64::INFINITY, f64::min)
    };
    // The sort is stable, so views as far away keep their order.
    views.sort_by(|a, b| is_new(b).cmp(&is_new(a)).then(far(a).total_cmp(&far(b))));
    views.truncate(MOST_JUDGED.max(places.len()));
    views
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::Isometry3;
    use transect_geometry::{LengthUnit, PlaneFamily, StraightGuide};
    use transect_model::store::{Store, StoreHeader, ViewDescription};

    #[test]
    fn of_many_views_the_nearest_to_new_ones_are_judged() {
        let folder = tempfile::tempdir().unwrap();
        let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.0, 1.0);
        let header = StoreHeader {
            unit: LengthUnit::Metre,
            planes: planes.unwrap(),
            options: String::new(),
            tool: String::new(),
        };
        let store = Store::create(folder.path().join("many.transect"), &header).unwrap();
        for k in 0..MOST_JUDGED + 50 {
            let entry = ViewDescription {
                id: format!("{k:03}").as_str().into(),
                name: String::new(),
                sensor: String::new(),
                source: String::new(),
                source_hash: String::new(),
                world_from_sensor: Isometry3::translation(k as f64, 0.0, 0.0),
                sigma: None,
            };
            store.begin_view(entry).unwrap().commit().unwrap();
        }
        let last = MOST_JUDGED + 49;
        let new = BTreeSet::from([last - 4, last].map(|k| format!("{k:03}").as_str().into()));
        let chosen = nearest(store.views().unwrap(), &new);
        let mut ids: Vec<String> = chosen.into_iter().map(|view| view.entry.id.0).collect();
        ids.sort();
        let expected: Vec<String> = (50..=last).map(|k| format!("{k:03}")).collect();
        assert_eq!(ids, expected);
    }
}
