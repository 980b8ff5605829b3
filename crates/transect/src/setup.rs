//! The settings of a run.

use crate::Refinement;
use transect_fusion::FusionMethod;
use transect_geometry::{GuideError, LengthUnit, PlaneFamily};
use transect_partial::Method;
use transect_register::RefineOptions;

/// The settings of a run: unit, planes and options.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Setup {
    /// The unit of every length.
    pub unit: LengthUnit,
    /// Where the section planes are.
    pub planes: PlaneFamily,
    /// How each view's curves are found.
    pub partial: Method,
    /// How the views' curves are fused.
    pub fusion: FusionMethod,
    /// Whether nodes are left out that more views looked through than measured, such as those of
    /// people who walked by. `true` by default.
    pub free_space: bool,
    /// Where planes are inserted between these; `None` inserts no planes.
    pub refinement: Option<Refinement>,
    /// How the poses of all views are refined before their curves are found; `None` keeps them.
    pub refine_poses: Option<RefineOptions>,
}

impl Setup {
    /// Planes in a unit, with default options.
    pub fn new(unit: LengthUnit, planes: PlaneFamily) -> Self {
        let (partial, fusion) = (Method::default(), FusionMethod::default());
        Self {
            unit,
            planes,
            partial,
            fusion,
            free_space: true,
            refinement: None,
            refine_poses: None,
        }
    }

    /// The same settings with the planes of the smallest interval of the refinement.
    pub(crate) fn with_least_interval(&self) -> Result<Self, GuideError> {
        let mut setup = self.clone();
        if let Some(refinement) = &self.refinement {
            setup.planes = refinement.family(&self.planes)?;
        }
        Ok(setup)
    }
}
