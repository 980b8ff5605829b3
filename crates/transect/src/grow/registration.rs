//! Registration of a store: the poses of its views, refined together.
//!
//! **Problem.** A map grows, and is registered every now and then. Poses that began where the last
//! registration left them would take its errors for given: 40 frames of a kitchen that come in four
//! batches would err by 9.9 mm in the end, in place of 6.3.
//!
//! **Idea.** The store keeps the pose that every view was given. Registration begins at these,
//! whatever it found before. So the poses depend on the views and on what was given with them, and
//! not on when they were registered. The given pose is kept with the view; see `kept_image.rs`.

use super::kept_image::Registered;
use super::{GrowError, Grower, InPlace};
use crate::fingerprint::fingerprint;
use crate::{LoadedView, PoseReport, Posed, Report, SourceError, ViewSource, Watch};
use transect_device::{ImageOrder, Note};
use transect_model::store::{StoredView, ViewDescription};
use transect_register::{PosePrior, RefineOptions, RefinedPose};

impl Grower<'_> {
    /// Refines the poses of stored views together. Views that move, and views whose surface may be
    /// off by another length than the store has, are replaced in one transaction. `sources` are the
    /// sources of the stored views.
    ///
    /// The poses are those that the views were given, in whatever steps the store grew and was
    /// registered: its own results are no new evidence. The result is that of one registration of
    /// all views. A pose that [`Grower::replace_views`] put in place is a given one.
    ///
    /// # Errors
    /// If a source has no view in the store, or its image is another one than the store's. Also if
    /// the store cannot be read or written. The store is then unchanged.
    pub fn refine_poses<S: ViewSource>(
        &self,
        sources: &[S],
        options: &RefineOptions,
        watch: &dyn Watch,
    ) -> Result<(Vec<StoredView>, Report), GrowError> {
        super::check_ids(sources)?;
        let snapshot = self.store.read()?;
        let mut stored = Vec::with_capacity(sources.len());
        for source in sources {
            let there = snapshot.view(&source.id().into())?;
            let no_view = || GrowError::NotThere(source.id().to_owned());
            let entry = there.ok_or_else(no_view)?.entry;
            let registered = Registered::read(&snapshot, &entry)?;
            stored.push(Stored { source, entry, registered });
        }
        let options = RefineOptions { images_stay: true, ..*options };
        let mut poses = PoseReport::new(&stored, Some(&options), self.setup.unit, watch)?;
        poses.in_store = true;
        let refined: Vec<_> = poses.refinement.iter().flat_map(|r| &r.poses).collect();
        let is_new = |(pose, view): (&&RefinedPose, &Stored<'_, S>)| {
            let sigma = &view.registered.surface_sigma;
            pose.world_from_sensor != view.entry.world_from_sensor
                || pose.surface_sigma_after(sigma.stated) != sigma.now()
        };
        let new: Vec<bool> = refined.iter().zip(&stored).map(is_new).collect();
        let known = refined.iter().any(|pose| pose.has_moved()) && !new.contains(&true);
        // A store keeps the images as they are: views that come later would differ from these.
        let as_stored = |view| Posed { depth_offsets: None, ..view };
        let posed: Vec<_> = poses.posed(&stored).into_iter().map(as_stored).collect();
        let moved = posed.iter().zip(new).filter(|(_, new)| *new).map(|(source, _)| {
            let Stored { entry, registered, .. } = source.source;
            InPlace { id: entry.id.clone(), source, given: Some(*registered) }
        });
        let (views, mut report) = self.put_in_place(&moved.collect::<Vec<_>>(), watch)?;
        report.set_poses(Some(poses), self.setup.unit);
        if known {
            report.notes.push(Note::new("the store has the refined poses already"));
        }
        Ok((views, report))
    }
}

/// The source of a stored view, which must still have the image of the store.
struct Stored<'a, S> {
    source: &'a S,
    entry: ViewDescription,
    /// What registration did to it before.
    registered: Registered,
}

impl<S: ViewSource> ViewSource for Stored<'_, S> {
    fn name(&self) -> &str {
        self.source.name()
    }

    fn id(&self) -> &str {
        &self.entry.id.0
    }

    fn origin(&self) -> String {
        self.entry.source.clone()
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        let LoadedView { view, notes } = self.source.load()?;
        if fingerprint(&view) != self.entry.source_hash {
            let from = &self.entry.source;
            return Err(format!(
                "{from} has another image, sensor or noise than the store; put back the files that \
                 the view was added from, or replace the view first: transect replace-view"
            )
            .into());
        }
        self.as_stored(LoadedView { view, notes })
    }

    fn pose_prior(&self) -> Option<PosePrior> {
        self.source.pose_prior()
    }

    fn surface_sigma(&self) -> Option<f64> {
        self.registered.surface_sigma.stated
    }

    fn load_in(&self, order: ImageOrder) -> Option<Result<LoadedView, SourceError>> {
        Some(self.source.load_in(order)?.and_then(|loaded| self.as_stored(loaded)))
    }
}

impl<S> Stored<'_, S> {
    /// A loaded view under its name in the store, and at the pose that it was given.
    fn as_stored(&self, LoadedView { view, notes }: LoadedView) -> Result<LoadedView, SourceError> {
        let view = view.with_pose(self.registered.given)?.with_name(&self.entry.id.0);
        Ok(LoadedView { view, notes })
    }
}
