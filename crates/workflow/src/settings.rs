//! The settings of a run, as a user gives them.
//!
//! A setting that is not given comes from the scan, or has a default. A [`Length`] has its own
//! unit, or is in the scan's.

use crate::table::digits;
use crate::{Check, MethodSettings, Plausibility, PriorSettings, RefineSettings, WorkflowError};
use std::mem::discriminant;
use std::path::PathBuf;
use transect::{ReconstructError, Setup};
use transect_device::Note;
use transect_exchange::{DxfFrame, PlanesEntry, Scan, read_guide};
use transect_fusion::FusionMethod;
use transect_geometry::{
    Guide, GuideError, GuideKind, Length, LengthUnit, PlaneFamily, StraightGuide, Vector3,
};
use transect_partial::Method;

/// The settings of a run.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Where the section planes are.
    pub planes: PlaneSettings,
    /// How each view's curves are found. Without it the store's method, else
    /// the default.
    pub partial: Option<Method>,
    /// How the views' curves are fused. Without it the store's method, else
    /// the default.
    pub fusion: Option<FusionMethod>,
    /// Settings of the dissertation's own methods.
    pub methods: MethodSettings,
    /// Curves stay that more views looked through than measured.
    pub keep_seen_through: bool,
    /// Checks of plausibility that are turned off.
    pub accept: Vec<Check>,
    /// Where planes are inserted between neighbouring planes; `None` inserts no planes.
    pub refine: Option<RefineSettings>,
    /// The poses of all views are refined before their curves are found.
    pub refine_poses: bool,
    /// How far the given poses may be wrong. Without it, estimated from how far the views
    /// contradict each other.
    pub prior: Option<PriorSettings>,
    /// Frame of the curves in the drawing.
    pub dxf: DxfFrame,
    /// The curves are also written as cubic B-splines no farther from them than this length.
    pub splines: Option<Length>,
    /// The model of a simulated scan is not scored against its truth.
    pub no_score: bool,
}

/// Where the section planes are: plane k is at normal · p = offset + k · interval.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct PlaneSettings {
    /// Normal of the planes in the world, of any length. Without it the scan's own; see
    /// [`OpenScan::suggest_planes`](crate::OpenScan::suggest_planes).
    pub normal: Option<[f64; 3]>,
    /// Curve that the planes are perpendicular to, instead of a normal.
    pub guide: Option<GuideSettings>,
    /// Distance between neighbouring planes. Without it the scan's own.
    pub interval: Option<Length>,
    /// Station of plane 0. Without it the scan's own if the planes have the scan's own direction,
    /// else 0.
    pub offset: Option<Length>,
}

/// A curved guide in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct GuideSettings {
    /// The file: `.csv`, `.geojson` or `.dxf`.
    pub path: PathBuf,
    /// Its points are corners, which are rounded by arcs. Otherwise a cubic spline passes through
    /// them.
    pub polyline: bool,
    /// Largest radius of a polyline's corners. Without it, as large as there is room for.
    pub radius: Option<Length>,
    /// Distance from the guide that is to be covered; an error if planes cross within it.
    pub reach: Option<Length>,
}

impl Settings {
    /// The setup of the modeler: these settings, completed by a scan.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting has no usable value, neither settings nor scan state an
    /// interval, or a guide cannot be read.
    pub fn setup(&self, scan: &Scan) -> Result<Setup, WorkflowError> {
        Ok(self.noted_setup(scan)?.0)
    }

    /// The setup of [`Self::setup`], with notes about the guide's file.
    pub(crate) fn noted_setup(&self, scan: &Scan) -> Result<(Setup, Vec<Note>), WorkflowError> {
        let (planes, notes) = self.planes.family(scan.unit, scan.planes.as_ref())?;
        Ok((self.complete(Setup::new(scan.unit, planes))?, notes))
    }

    /// The setup of the modeler for a store: these settings, completed by the store's. Notes are
    /// about the guide's file.
    pub(crate) fn setup_of_store(
        &self,
        scan: &Scan,
        mut store: Setup,
    ) -> Result<(Setup, Vec<Note>), WorkflowError> {
        let own = PlanesEntry::from(&store.planes);
        let (planes, notes) = self.planes.family(scan.unit, Some(&own))?;
        (store.planes, store.unit) = (planes, scan.unit);
        Ok((self.complete(store)?, notes))
    }

    fn complete(&self, mut setup: Setup) -> Result<Setup, WorkflowError> {
        // The name of a method that the store has keeps the store's options.
        let is_other = |partial: &Method| discriminant(partial) != discriminant(&setup.partial);
        setup.partial = self.partial.filter(is_other).unwrap_or(setup.partial);
        let is_other = |fusion: &FusionMethod| discriminant(fusion) != discriminant(&setup.fusion);
        setup.fusion = self.fusion.filter(is_other).unwrap_or(setup.fusion);
        self.methods.apply(&mut setup)?;
        setup.free_space &= !self.keep_seen_through;
        setup.check_options().map_err(ReconstructError::from)?;
        setup.refinement = self.refine.map(|refine| refine.refinement(&setup)).transpose()?;
        let poses = PriorSettings::options(self.prior, setup.unit);
        setup.refine_poses = self.refine_poses.then_some(poses);
        Ok(setup)
    }

    pub(crate) fn plausibility(&self, setup: &Setup) -> Plausibility {
        let (interval, accepted) = (setup.planes.interval(), self.accept.clone());
        Plausibility { interval, unit: setup.unit, accepted, usual_spacing: None }
    }
}

impl PlaneSettings {
    /// Whether nothing is given.
    pub(crate) fn is_empty(&self) -> bool {
        let Self { normal, guide, interval, offset } = self;
        normal.is_none() && guide.is_none() && interval.is_none() && offset.is_none()
    }

    /// Whether the planes need nothing else.
    pub(crate) fn is_complete(&self) -> bool {
        self.interval.is_some() && (self.normal.is_some() || self.guide.is_some())
    }

    /// The station of plane 0 and the distance between neighbouring planes, where they are given.
    pub(crate) fn lengths(&self, unit: LengthUnit) -> [Option<f64>; 2] {
        [self.offset, self.interval].map(|length| length.map(|length| length.in_unit(unit)))
    }

    /// The planes: these settings, completed by those of a scan or a store. Notes are about the
    /// guide's file.
    fn family(
        &self,
        unit: LengthUnit,
        own: Option<&PlanesEntry>,
    ) -> Result<(PlaneFamily, Vec<Note>), WorkflowError> {
        let (guide, notes) = self.guide(unit, own)?;
        let [offset, interval] = self.lengths(unit);
        // "3in" and "7.62cm" are the same length, but for rounding.
        let same = |own: f64, given: f64| (own - given).abs() <= 1e-12 * own.abs();
        let complete = |given: Option<f64>, own: Option<f64>| match given {
            Some(given) => own.filter(|own| same(*own, given)).or(Some(given)),
            None => own,
        };
        let interval = complete(interval, own.map(|p| p.interval));
        // Stations along another direction have nothing to do with the scan's own offset.
        let is_along = |own: &&PlanesEntry| own.family().is_ok_and(|own| *own.guide() == guide);
        let offset = complete(offset, own.filter(is_along).map(|p| p.offset));
        let interval = interval.ok_or(WorkflowError::NoInterval)?;
        Ok((PlaneFamily::new(guide, offset.unwrap_or(0.0), interval)?, notes))
    }

    fn guide(
        &self,
        unit: LengthUnit,
        own: Option<&PlanesEntry>,
    ) -> Result<(Guide, Vec<Note>), WorkflowError> {
        if let Some(guide) = &self.guide {
            return guide.read(unit);
        }
        let normal = match (self.normal, own) {
            (Some(normal), _) => normal.into(),
            (None, Some(PlanesEntry { guide: Some(guide), .. })) => {
                return Ok((guide.clone().into(), Vec::new()));
            }
            (None, own) => own.map_or(Vector3::z(), |p| p.normal.into()),
        };
        Ok((StraightGuide::along(normal)?.into(), Vec::new()))
    }
}

impl GuideSettings {
    /// The guide, with notes about its file.
    pub(crate) fn read(&self, unit: LengthUnit) -> Result<(Guide, Vec<Note>), WorkflowError> {
        let radius = self.radius.map(|radius| radius.in_unit(unit));
        let kind = match (self.polyline, radius) {
            (true, radius) => GuideKind::Polyline(radius),
            (false, None) => GuideKind::Spline,
            (false, Some(_)) => {
                let problem = "a spline has no corners to round; the guide must be a polyline";
                return Err(WorkflowError::setting("guide_radius", problem));
            }
        };
        let (guide, notes) = read_guide(&self.path, kind, unit)?;
        if let Some(reach) = self.reach.map(|reach| reach.in_unit(unit)) {
            if reach <= 0.0 {
                let problem = format!("the reach must be a positive length, got {reach}");
                return Err(WorkflowError::setting("guide_reach", problem));
            }
            guide.require_usable_distance(reach).map_err(|e| self.too_curved(e, unit))?;
        }
        Ok((guide.into(), notes))
    }

    /// The error of a guide whose planes cross within the reach, with the unit of its lengths.
    fn too_curved(&self, error: GuideError, unit: LengthUnit) -> WorkflowError {
        let GuideError::TooCurved { station, reach, usable, needed } = error else {
            return WorkflowError::unusable(&self.path, "the guide cannot be used")(error);
        };
        let [station, reach, usable, needed] = [station, reach, usable, needed].map(digits);
        let problem = format!(
            "planes along the guide cross {reach} {unit} away from it, at station {station} {unit}. \
             Points up to {usable} {unit} (0.9 of that) can be used, and {needed} {unit} is needed. \
             Let the guide bend less sharply there, keep its parts farther apart, or ask for a \
             smaller distance (the setting `guide_reach`)"
        );
        WorkflowError::file(&self.path, problem)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor plan's height is no station along a tunnel.
    #[test]
    fn the_scans_own_offset_holds_along_its_own_direction_only() {
        let own = PlanesEntry::new([0.0, 0.0, 2.0], 310.2, 0.1);
        let offset = |settings: &PlaneSettings| {
            let (family, _) = settings.family(LengthUnit::Metre, Some(&own)).unwrap();
            assert_eq!(family.interval(), 0.1);
            family.offset()
        };
        let along = |x, y, z| PlaneSettings { normal: Some([x, y, z]), ..Default::default() };
        assert_eq!(offset(&PlaneSettings::default()), 310.2);
        assert_eq!(offset(&along(0.0, 0.0, 1.0)), 310.2);
        assert_eq!(offset(&along(1.0, 0.0, 0.0)), 0.0);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("axis.csv");
        std::fs::write(&path, "0,0,0\n10,0,0\n20,1,0\n").unwrap();
        let guide = GuideSettings { path, polyline: false, radius: None, reach: None };
        let mut settings = PlaneSettings { guide: Some(guide), ..Default::default() };
        assert_eq!(offset(&settings), 0.0);
        settings.offset = Some("1m".parse().unwrap());
        assert_eq!(offset(&settings), 1.0);
    }

    #[test]
    fn what_was_seen_through_is_kept_on_request_and_where_a_store_keeps_it() {
        for (asked, of_store, left_out) in
            [(false, true, true), (true, true, false), (false, false, false), (true, false, false)]
        {
            let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.0, 0.1);
            let mut store = Setup::new(LengthUnit::Metre, planes.unwrap());
            store.free_space = of_store;
            let settings = Settings { keep_seen_through: asked, ..Settings::default() };
            let setup = settings.complete(store).unwrap();
            assert_eq!(setup.free_space, left_out, "{asked} {of_store}");
        }
    }
}
