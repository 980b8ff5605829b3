//! The sources of views.

use transect_device::{DepthOffsets, ImageOrder, Isometry3, Note, View};
use transect_register::{PosePrior, PoseReading};

/// An error of a source; any type, since sources are foreign code.
pub type SourceError = Box<dyn std::error::Error + Send + Sync>;

/// A view that can be loaded. It is dropped as soon as its curves are found.
pub trait ViewSource: Sync {
    /// The name of the view in reports.
    fn name(&self) -> &str;

    /// The id of the view in a model store, which differs from all others; by default its name.
    fn id(&self) -> &str {
        self.name()
    }

    /// The origin of the view, which a model store keeps for information; by default its name.
    fn origin(&self) -> String {
        self.name().to_owned()
    }

    /// How far the view's pose may be wrong, if that is known of this view. A number that is
    /// not finite or below 1e-12, such as 0, ends a run that refines poses.
    fn pose_prior(&self) -> Option<PosePrior> {
        None
    }

    /// By how much the view's surface may be off along its normals with its pose, as a standard
    /// deviation in the model's length unit, if registration told. The standard deviations of fused
    /// nodes hold it. A number that is negative or not finite ends a run.
    fn surface_sigma(&self) -> Option<f64> {
        None
    }

    /// The pose as the file states it (world from sensor), with the convention by which the user
    /// had it read in place of that; `None` if it was read as stated.
    fn stated_pose(&self) -> Option<(PoseReading, Isometry3)> {
        None
    }

    /// Loads the view.
    ///
    /// # Errors
    /// The error of the source, which names the file.
    fn load(&self) -> Result<LoadedView, SourceError>;

    /// Loads the view with the pixels of its file in another order; `None` where the source has one
    /// order only. Poses that contradict each other may be explained by it.
    fn load_in(&self, _: ImageOrder) -> Option<Result<LoadedView, SourceError>> {
        None
    }
}

/// A loaded view with the notes of its reader.
#[derive(Debug, Clone)]
pub struct LoadedView {
    /// The view.
    pub view: View,
    /// Notes for the report.
    pub notes: Vec<Note>,
}

/// A source whose view is put at another pose.
#[derive(Debug, Clone)]
pub struct Posed<'a, S> {
    /// The source.
    pub source: &'a S,
    /// World coordinates from sensor coordinates.
    pub pose: Isometry3,
    /// The error of the view's depth camera, which its image loses.
    pub depth_offsets: Option<DepthOffsets>,
    /// By how much its surface may be off at that pose; see [`ViewSource::surface_sigma`].
    pub surface_sigma: Option<f64>,
}

impl<S: ViewSource> ViewSource for Posed<'_, S> {
    fn name(&self) -> &str {
        self.source.name()
    }

    fn id(&self) -> &str {
        self.source.id()
    }

    fn origin(&self) -> String {
        self.source.origin()
    }

    fn pose_prior(&self) -> Option<PosePrior> {
        self.source.pose_prior()
    }

    fn surface_sigma(&self) -> Option<f64> {
        self.surface_sigma
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        self.posed(self.source.load()?)
    }

    fn load_in(&self, order: ImageOrder) -> Option<Result<LoadedView, SourceError>> {
        Some(self.source.load_in(order)?.and_then(|loaded| self.posed(loaded)))
    }
}

impl<S> Posed<'_, S> {
    fn posed(&self, LoadedView { view, notes }: LoadedView) -> Result<LoadedView, SourceError> {
        let view = view.with_pose(self.pose)?;
        let Some(offsets) = &self.depth_offsets else { return Ok(LoadedView { view, notes }) };
        let image = offsets.correct(view.frame(), view.image())?;
        Ok(LoadedView { view: view.with_image(image)?, notes })
    }
}

/// A source that stands elsewhere, so that a run can take some views of many, or of several kinds.
macro_rules! same_source {
    ($($of:ty),*) => {$(
        impl<S: ViewSource + ?Sized> ViewSource for $of {
            fn name(&self) -> &str {
                (**self).name()
            }

            fn id(&self) -> &str {
                (**self).id()
            }

            fn origin(&self) -> String {
                (**self).origin()
            }

            fn pose_prior(&self) -> Option<PosePrior> {
                (**self).pose_prior()
            }

            fn surface_sigma(&self) -> Option<f64> {
                (**self).surface_sigma()
            }

            fn stated_pose(&self) -> Option<(PoseReading, Isometry3)> {
                (**self).stated_pose()
            }

            fn load(&self) -> Result<LoadedView, SourceError> {
                (**self).load()
            }

            fn load_in(&self, order: ImageOrder) -> Option<Result<LoadedView, SourceError>> {
                (**self).load_in(order)
            }
        }
    )*};
}

same_source!(&S, Box<S>);

impl ViewSource for View {
    fn name(&self) -> &str {
        View::name(self)
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        Ok(LoadedView { view: self.clone(), notes: Vec::new() })
    }
}
