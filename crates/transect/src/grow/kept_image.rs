//! What a store keeps of the image of a view.
//!
//! It keeps the coarse copy of the image, and the space that the view looked through. Where
//! registration found another pose, it keeps the given one, too, and by how much the surface may
//! still be off.

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
    surface_sigma: SurfaceSigma,
}

/// By how much the surface of a view may be off. The order of the fields is the layout in the
/// store.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SurfaceSigma {
    /// As its source states it.
    pub stated: Option<f64>,
    /// As registration of the store found it.
    pub registered: Option<f64>,
}

impl SurfaceSigma {
    /// What holds for the view as it is, if it is sound: a file may hold anything.
    pub fn now(&self) -> Option<f64> {
        let sound = |sigma: &f64| sigma.is_finite() && *sigma >= 0.0;
        self.registered.or(self.stated).filter(sound)
    }
}

/// The layout of earlier programs.
#[derive(Deserialize)]
#[cfg_attr(test, derive(Serialize))]
struct WithoutSigma {
    copy: StoredCopy,
    moved: Option<GivenPose>,
    free: Option<FreeSpace>,
}

impl KeptImage {
    /// What a store keeps of a view's image. `given` is the pose that the view was given.
    pub fn of(view: &View, given: &Isometry3, surface_sigma: SurfaceSigma) -> Self {
        let (given, refined) = (*given, *view.world_from_sensor());
        Self {
            copy: CoarseView::quick(view).stored(),
            moved: (given != refined).then_some(GivenPose { given, refined }),
            free: FreeSpace::of(view),
            surface_sigma,
        }
    }

    /// Reads it; `None` if another program wrote it in a layout of its own.
    pub fn read(stored: &ViewCopy) -> Option<Self> {
        let surface_sigma = SurfaceSigma::default();
        let kept = |copy, moved, free| Self { copy, moved, free, surface_sigma };
        // Earlier programs kept no sigma; before that the copy alone, or with the given pose.
        let without_sigma = || {
            let WithoutSigma { copy, moved, free } = stored.value()?;
            Some(kept(copy, moved, free))
        };
        let copy_alone = || Some(kept(stored.value()?, None, None));
        let with_pose = || stored.value().map(|(copy, moved)| kept(copy, Some(moved), None));
        stored.value().or_else(without_sigma).or_else(copy_alone).or_else(with_pose)
    }

    /// By how much the view's surface may be off.
    pub fn surface_sigma(&self) -> SurfaceSigma {
        self.surface_sigma
    }

    /// The space that the view looked through, if it is known and sound: a file may hold anything.
    pub fn free_space(self) -> Option<FreeSpace> {
        self.free.filter(FreeSpace::is_sound)
    }
}

/// The coarse copy that a store keeps of a view.
pub(super) fn read_copy(
    snapshot: &Snapshot,
    entry: &ViewDescription,
) -> Result<Option<StoredCopy>, GrowError> {
    Ok(snapshot.copy(entry)?.as_ref().and_then(KeptImage::read).map(|kept| kept.copy))
}

/// What a view of a store was given, and what registration did to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Registered {
    /// The pose that the view was given, if another program has not moved it since.
    pub given: Isometry3,
    pub surface_sigma: SurfaceSigma,
}

impl Registered {
    /// What registration did to a view.
    pub fn read(snapshot: &Snapshot, entry: &ViewDescription) -> Result<Self, GrowError> {
        let (copy, pose) = (snapshot.copy(entry)?, entry.world_from_sensor);
        let kept = copy.as_ref().and_then(KeptImage::read);
        let surface_sigma = kept.as_ref().map(KeptImage::surface_sigma).unwrap_or_default();
        let moved = kept.and_then(|kept| kept.moved).filter(|moved| moved.refined == pose);
        Ok(Self { given: moved.map_or(pose, |moved| moved.given), surface_sigma })
    }
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
            let moved = kept.moved.clone().map(|moved| moved.given);
            (moved, kept.surface_sigma().now(), kept.free_space())
        };
        let sigma = |registered| SurfaceSigma { stated: Some(0.25), registered };
        let new = KeptImage::of(&view, &given, sigma(Some(0.5)));
        let free = FreeSpace::of(&view);
        assert_eq!(read(ViewCopy::of(&new).unwrap()), (Some(given), Some(0.5), free.clone()));
        let stated = KeptImage { surface_sigma: sigma(None), ..new.clone() };
        assert_eq!(read(ViewCopy::of(&stated).unwrap()).1, Some(0.25));
        assert!(new.free.as_ref().unwrap().holds(&Point3::new(0.0, 0.0, 1.0)));
        let unsound = KeptImage { surface_sigma: sigma(Some(f64::NAN)), ..new.clone() };
        assert_eq!(read(ViewCopy::of(&unsound).unwrap()).1, None);
        let KeptImage { copy, moved, .. } = new;
        let without = WithoutSigma { copy: copy.clone(), moved, free: free.clone() };
        assert_eq!(read(ViewCopy::of(&without).unwrap()), (Some(given), None, free));
        assert_eq!(read(ViewCopy::of(&copy).unwrap()), (None, None, None));
        let both = (copy, GivenPose { given, refined });
        assert_eq!(read(ViewCopy::of(&both).unwrap()), (Some(given), None, None));
        assert!(KeptImage::read(&ViewCopy::of(&"another layout").unwrap()).is_none());
    }
}
