//! What a store keeps of the image of a view.
//!
//! It keeps the coarse copy of the image, and the space that the view looked through. Where
//! registration found another pose, it keeps the given one, too.

use super::GrowError;
use serde::{Deserialize, Serialize};
use transect_device::{Isometry3, View};
use transect_model::store::{Snapshot, ViewCopy, ViewDescription};
use transect_register::{CoarseView, FreeSpace, StoredCopy};

/// The pose that registration put in place of a given one. The order of the fields is the layout in
/// the store.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct GivenPose {
    given: Isometry3,
    refined: Isometry3,
}

/// What a store keeps of the image of a view. The order of the fields is the layout in the store.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct KeptImage {
    copy: StoredCopy,
    /// The pose that the view was given, if registration found another one.
    moved: Option<GivenPose>,
    /// The space that the view looked through.
    free: Option<FreeSpace>,
}

impl KeptImage {
    /// What a store keeps of a view's image. `given` is the pose that the view was given.
    pub fn of(view: &View, given: &Isometry3) -> Self {
        let (given, refined) = (*given, *view.world_from_sensor());
        Self {
            copy: CoarseView::quick(view).stored(),
            moved: (given != refined).then_some(GivenPose { given, refined }),
            free: FreeSpace::of(view),
        }
    }

    /// Reads it; `None` if another program wrote it in a layout of its own.
    pub fn read(stored: &ViewCopy) -> Option<Self> {
        let kept = |copy, moved| Self { copy, moved, free: None };
        // Earlier programs kept the copy alone, or with the given pose.
        let with_pose = || stored.value().map(|(copy, moved)| kept(copy, Some(moved)));
        stored.value().or_else(|| Some(kept(stored.value()?, None))).or_else(with_pose)
    }

    /// The space that the view looked through, if it is known and sound: a file may hold anything.
    pub fn free_space(self) -> Option<FreeSpace> {
        self.free.filter(FreeSpace::is_sound)
    }
}

/// A stored copy, and the pose that its view was given if another program has not moved it since.
pub(super) fn read_copy(
    snapshot: &Snapshot,
    entry: &ViewDescription,
) -> Result<Option<(StoredCopy, Isometry3)>, GrowError> {
    let (copy, pose) = (snapshot.copy(entry)?, entry.world_from_sensor);
    Ok(copy.as_ref().and_then(KeptImage::read).map(|KeptImage { copy, moved, .. }| {
        let given = moved.filter(|moved| moved.refined == pose).map(|moved| moved.given);
        (copy, given.unwrap_or(pose))
    }))
}

/// The pose that a view was given, which registration may have changed.
pub(super) fn given_pose(
    snapshot: &Snapshot,
    entry: &ViewDescription,
) -> Result<Isometry3, GrowError> {
    Ok(read_copy(snapshot, entry)?.map_or(entry.world_from_sensor, |(_, given)| given))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{ImageSize, Point3, RangeImage, Vector3};
    use transect_sensors::{Intrinsics, Pinhole};

    #[test]
    fn images_are_read_as_this_and_earlier_programs_kept_them() {
        let size = ImageSize { rows: 96, cols: 128 };
        let camera = Pinhole::new(size, Intrinsics { fx: 99.0, fy: 99.0, cx: 63.5, cy: 47.5 });
        let image = RangeImage::from_values(size, vec![2.0; size.pixels()]).unwrap();
        let refined = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::zeros());
        let view = View::new("v", image, Arc::new(camera.unwrap()), refined, Some(0.001)).unwrap();
        let given = Isometry3::identity();
        let read = |stored: ViewCopy| {
            let kept = KeptImage::read(&stored).unwrap();
            assert!(kept.copy.clone().restore("v", refined).is_some());
            (kept.moved.clone().map(|moved| moved.given), kept.free_space())
        };
        let new = KeptImage::of(&view, &given);
        let (moved, free) = read(ViewCopy::of(&new).unwrap());
        assert_eq!((moved, free), (Some(given), FreeSpace::of(&view)));
        assert!(new.free.unwrap().holds(&Point3::new(0.0, 0.0, 1.0)));
        assert_eq!(read(ViewCopy::of(&new.copy).unwrap()), (None, None));
        let both = (new.copy, GivenPose { given, refined });
        assert_eq!(read(ViewCopy::of(&both).unwrap()), (Some(given), None));
        assert!(KeptImage::read(&ViewCopy::of(&"another layout").unwrap()).is_none());
    }
}
