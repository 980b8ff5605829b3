//! From a scan on disk to a model, and from there to a result folder.

use crate::faces::{InFaces, in_faces};
use crate::outputs::remove_leftovers;
use crate::plausible::Looked;
use crate::score::{Reference, ScoreLimits, score};
use crate::selection::Limits;
use crate::store_file::{Grown, grow, origin, setup_of};
use crate::table::{Row, digits};
use crate::views::{FileView, OpenScan};
use crate::{
    Check, Costs, Plausibility, ReportFile, ResultFolder, Settings, WorkflowError, as_options,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use transect::register::Reading;
use transect::{Reconstruction, RefinementReport, Report, Setup, ViewReport, Watch, reconstruct};
use transect_device::{Note, View};
use transect_exchange::{DxfFrame, Scan};
use transect_geometry::{CurvedGuide, Guide, GuideKind, LengthUnit};

/// A model that was made of a scan, and what its results will say about it.
#[derive(Debug)]
pub struct Run<'a> {
    /// The model, and the report of the modeler with its notes and warnings.
    pub reconstruction: Reconstruction,
    /// The time and memory of the stages up to now.
    pub costs: Costs,
    scan: &'a OpenScan,
    setup: Setup,
    /// Checks of plausibility that were turned off.
    accepted: Vec<Check>,
    /// Rows on the store, if one was grown.
    store: Vec<Row>,
    /// The files that the model was made of.
    read: Vec<PathBuf>,
    /// Files that results must not replace.
    inputs: Vec<PathBuf>,
    dxf: DxfFrame,
    splines: Option<f64>,
    /// The truth that the model is scored against, if any.
    truth: Reference,
}

impl OpenScan {
    /// Every file that a run reads: those of the scan, its truth, the guide and the store. Results
    /// must not replace them; see [`ResultFolder::claim`].
    pub fn inputs(&self, settings: &Settings, store: Option<&Path>) -> Vec<PathBuf> {
        let mut inputs = self.files_of_model(settings);
        inputs.extend(store.map(Path::to_owned));
        if let Reference::Simulated { truth, .. } = Reference::beside(self.path()) {
            inputs.push(truth);
        }
        inputs
    }

    /// The files that a model is made of: those of the scan, and the guide.
    fn files_of_model(&self, settings: &Settings) -> Vec<PathBuf> {
        let guide = settings.planes.guide.as_ref().map(|guide| guide.path.clone());
        self.scan().inputs.iter().cloned().chain(guide).collect()
    }

    /// Makes a model of all views.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting cannot be used, or a view cannot be loaded or modelled.
    pub fn reconstruct(
        &self,
        settings: &Settings,
        watch: &dyn Watch,
    ) -> Result<Run<'_>, WorkflowError> {
        let (setup, notes) = settings.noted_setup(self.scan())?;
        let splines = self.splines(settings);
        let faces = |view: &View| InFaces::of(view, &setup.planes);
        let (views, faces) = self.looked_at("", settings.plausibility(&setup), faces)?;
        let mut reconstruction = reconstruct(&views, &setup, watch)?;
        let notes = notes.into_iter().chain(in_faces(&faces, &setup.planes));
        reconstruction.report.notes.extend(notes);
        self.run(reconstruction, setup, (settings, splines), None, Vec::new())
    }

    /// Adds the views to a model store, which is made if it is not there; then makes a model of all
    /// views in the store. Views that the store has are left alone, so an interrupted run can be
    /// repeated. `prefix` is put before the views' names, for scans whose views share names.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting cannot be used or is not the store's, or a view cannot be
    /// loaded or modelled. The views before that one are in the store then.
    pub fn grow(
        &self,
        store: &Path,
        prefix: &str,
        settings: &Settings,
        watch: &dyn Watch,
    ) -> Result<Run<'_>, WorkflowError> {
        self.is_read_alike()?;
        remove_leftovers(store);
        let (setup, notes) = self.setup_for_store(store, settings)?;
        let splines = self.splines(settings);
        let faces = |view: &View| InFaces::of(view, &setup.planes);
        let mut plausibility = settings.plausibility(&setup);
        if has_views(store)? {
            // The new views may see the surfaces of the store's views, instead of each other's.
            plausibility.accepted.push(Check::Distance);
        }
        let (views, faces) = self.looked_at(prefix, plausibility, faces)?;
        let Grown { mut reconstruction, views_present, planes_fused } =
            grow(store, &views, &setup, watch)?;
        let notes = notes.into_iter().chain(in_faces(&faces, &setup.planes));
        reconstruction.report.notes.extend(notes);
        let rows = vec![
            Row::plain("store", store.display()),
            Row::plain("views added", reconstruction.report.views.len()),
            Row::plain("views there already", views_present),
            Row::plain("planes fused", planes_fused),
        ];
        self.run(reconstruction, setup, (settings, splines), Some(store), rows)
    }

    /// Checks that a store's commands, which read the scan again without options, read the same.
    fn is_read_alike(&self) -> Result<(), WorkflowError> {
        if self.limits != Limits::default() {
            let setting = if self.selection.crop.is_some() { "crop" } else { "max_range" };
            let problem = "a store takes whole views, because replace-view reads them again from \
                           the scan; leave out the option, or --store";
            return Err(WorkflowError::setting(setting, problem));
        }
        let readings =
            [self.reading.map(Reading::Pose), self.options.image_order.map(Reading::Image)];
        if let Some(reading) = readings.into_iter().flatten().next() {
            let reading = as_options(&reading.to_string());
            let problem = format!(
                "a store's commands read images and poses from the scan as it is; write the scan \
                 anew first: transect register SCAN {reading} --out DIR"
            );
            return Err(WorkflowError::setting("store", problem));
        }
        if let Some(setting) = self.options.first_given() {
            let option = format!("--{}", setting.replace('_', "-"));
            let problem = format!(
                "a store's commands read the scan again, without {option}; write the scan anew \
                 first: transect manifest SCAN {option} … --out scan.json for a folder of depth \
                 images, else transect register SCAN {option} … --out DIR"
            );
            return Err(WorkflowError::setting("store", problem));
        }
        Ok(())
    }

    /// The settings, completed by those of the store if it exists, else by the scan's. Notes
    /// tell where the scan's own planes give way, and are about the guide's file.
    fn setup_for_store(
        &self,
        store: &Path,
        settings: &Settings,
    ) -> Result<(Setup, Vec<Note>), WorkflowError> {
        let scan = self.scan();
        if !store.exists() {
            return settings.noted_setup(scan);
        }
        let there = setup_of(store, crate::read_store(store)?.read()?.header())?;
        let (setup, mut notes) = settings.setup_of_store(scan, there)?;
        let scans_own = scan.planes.as_ref().and_then(|planes| planes.family().ok());
        let differ = settings.planes.is_empty() && scans_own.is_some_and(|p| p != setup.planes);
        let note = "the scan states other planes than the store; the store's are used";
        notes.extend(differ.then(|| Note::new(note)));
        Ok((setup, notes))
    }

    pub(crate) fn views(
        &self,
        prefix: &str,
        plausibility: Plausibility,
    ) -> Result<Vec<FileView<'_>>, WorkflowError> {
        Ok(self.looked_at(prefix, plausibility, |_| ())?.0)
    }

    /// The views, and the findings of a function in the few that plausibility looks at, within the
    /// limits.
    fn looked_at<T: Send>(
        &self,
        prefix: &str,
        mut plausibility: Plausibility,
        of_view: impl Fn(&View) -> T + Sync,
    ) -> Result<(Vec<FileView<'_>>, Vec<T>), WorkflowError> {
        let Looked { kept, found } =
            plausibility.look_at(self.scan(), self.reading, &self.limits, of_view)?;
        let mut read: BTreeMap<_, _> = kept.into_iter().collect();
        let view = |(k, view)| {
            let view = origin(view, self.path(), plausibility.clone());
            let (id, read) =
                (format!("{prefix}{}", view.id), Arc::new(Mutex::new(read.remove(&k))));
            let stated_pose = self.stated_pose(k);
            FileView { id, read, stated_pose, limits: self.limits, ..view }
        };
        Ok((self.scan().views.iter().enumerate().map(view).collect(), found))
    }

    fn splines(&self, settings: &Settings) -> Option<f64> {
        settings.splines.map(|tolerance| tolerance.in_unit(self.scan().unit))
    }

    fn run(
        &self,
        mut reconstruction: Reconstruction,
        setup: Setup,
        (settings, splines): (&Settings, Option<f64>),
        store_path: Option<&Path>,
        store: Vec<Row>,
    ) -> Result<Run<'_>, WorkflowError> {
        let model = &reconstruction.model;
        if model.sections().len() == 0 {
            let (views, nodes) = (model.views().len(), reconstruction.report.fusion.observations);
            return Err(WorkflowError::Empty { views, nodes });
        }
        let off_guide = off_guide(&reconstruction.report, &setup);
        reconstruction.report.notes.extend(off_guide.map(Note::new));
        let mut costs = Costs::default();
        costs.modelled(&reconstruction.report.timings);
        let (read, inputs) = (self.files_of_model(settings), self.inputs(settings, store_path));
        let truth =
            if settings.no_score { Reference::Nothing } else { Reference::beside(self.path()) };
        let accepted = settings.accept.clone();
        Ok(Run {
            reconstruction,
            costs,
            scan: self,
            setup,
            accepted,
            store,
            read,
            inputs,
            dxf: settings.dxf,
            splines,
            truth,
        })
    }
}

/// Whether a store exists and has views.
fn has_views(store: &Path) -> Result<bool, WorkflowError> {
    Ok(store.exists() && !crate::read_store(store)?.read()?.views()?.is_empty())
}

impl Run<'_> {
    /// Writes every result into a folder, and scores the model if the scan has its truth beside it
    /// and the settings ask for it. Returns the table of the run, which is in the report, too. All
    /// files appear together.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that cannot be written, or read for the scores. The folder
    /// keeps its old files then.
    pub fn write(&mut self, folder: &ResultFolder) -> Result<Vec<Row>, WorkflowError> {
        folder.claim(&self.inputs)?;
        folder.write_together(|staged| self.write_into(staged))
    }

    fn write_into(&mut self, folder: &ResultFolder) -> Result<Vec<Row>, WorkflowError> {
        let (model, costs) = (&self.reconstruction.model, &mut self.costs);
        let title = &self.scan.scan().name;
        costs.stage("writing", || folder.write_curves(title, model, self.dxf))?;
        let mut rows = result_rows(self.scan.scan(), &self.reconstruction);
        rows.extend(self.store.iter().cloned());
        if let Some(tolerance) = self.splines {
            let write = || folder.write_splines(model, tolerance);
            rows.extend(costs.stage("fitting splines", write)?);
        }
        // The truth counts what all views could see, so a part of them is not scored.
        let options = &self.scan.options;
        let as_stated = self.scan.reading.is_none() && options.image_order.is_none();
        let is_whole = self.scan.selection.is_whole() && as_stated && !options.skip_missing;
        let mut read = self.read.clone();
        if is_whole && let Reference::Simulated { truth, .. } = &self.truth {
            read.push(truth.clone());
            let score = || score(model, &self.truth, &ScoreLimits::default());
            rows.extend(costs.stage("scoring", score)?.agreement);
        }
        rows.extend(costs.rows());
        let report = &self.reconstruction.report;
        let report = ReportFile::new(self.scan, &self.setup, report, &self.accepted, &read);
        folder.write_report(&report, &rows, costs)?;
        Ok(rows)
    }
}

/// Least share of the pixels too far from a guide of which a note tells. No unit. Chosen by hand.
/// Doubled, strips of the walls of a bend are left out in silence.
const TOLD_BEYOND: f64 = 0.01;

/// The pixels of all views that a count of their reports tells.
fn pixels(report: &Report, count: impl Fn(&ViewReport) -> usize) -> usize {
    report.views.iter().map(count).sum()
}

/// The note for pixels that are left out because the planes of a guide may cross there.
fn off_guide(report: &Report, setup: &Setup) -> Option<String> {
    let guide = setup.planes.guide().curved()?;
    let left_out = pixels(report, |v| v.beyond_guide_reach) as f64;
    let share = left_out / pixels(report, |v| v.read_pixels).max(1) as f64;
    let radius = match is_radius_binding(guide) {
        true => ", or a larger value of the setting `guide_radius`",
        false => "",
    };
    (share >= TOLD_BEYOND).then(|| {
        format!(
            "{} % of the pixels lie more than {} {} from the guide and are left out, because its \
             planes may cross there; give a guide with wider bends{radius}",
            digits(100.0 * share),
            digits(guide.usable_distance()),
            setup.unit
        )
    })
}

/// Whether the largest radius that a user gave makes the bends of a polyline narrower.
fn is_radius_binding(guide: &CurvedGuide) -> bool {
    if !matches!(guide.kind(), GuideKind::Polyline(Some(_))) {
        return false;
    }
    // Equal radii give equal distances but for rounding.
    let usable = guide.usable_distance() * (1.0 + 1e-9);
    let widest = CurvedGuide::polyline(guide.points().to_vec(), None);
    widest.is_ok_and(|widest| widest.usable_distance() > usable)
}

fn result_rows(scan: &Scan, result: &Reconstruction) -> Vec<Row> {
    let (report, unit) = (&result.report, scan.unit);
    let fusion = &report.fusion;
    let mut rows = vec![
        Row::new("scan", scan.name.clone(), ""),
        Row::plain("views", result.model.views().len()),
    ];
    // A store knows what earlier runs added and fused, and not how many pixels and how far apart.
    let (added, fused_now) = match report.views.len() < result.model.views().len() {
        true => (", added views", ", planes fused now"),
        false => ("", ""),
    };
    rows.extend(pixel_rows(report, added));
    rows.extend(rounding_row(result.model.planes().guide(), unit));
    let closed_only = percent(fusion.planes_closed_only, fusion.planes);
    rows.extend([
        Row::plain("planes with curves", fusion.planes),
        Row::new("planes with closed curves only", closed_only, "%"),
        Row::plain("curves", fusion.curves),
        Row::plain("closed curves", fusion.closed),
        Row::plain("nodes", fusion.nodes),
        Row::plain("nodes of all views", fusion.observations),
        Row::plain("crossings resolved", fusion.crossings_resolved),
        Row::length("curve length", fusion.length, unit),
    ]);
    if fusion.seen_through > 0 {
        let name = format!("nodes seen through, left out{fused_now}");
        rows.push(Row::plain(name, fusion.seen_through));
    }
    // Without a second view, or without planes to fuse, there is nothing to compare.
    let compared =
        [("spread between views", fusion.spread), ("overlap threshold", fusion.threshold)];
    let several = result.model.views().len() > 1;
    let compared = compared.into_iter().filter(|(_, length)| several && *length > 0.0);
    let row = |(name, length)| Row::length(format!("{name}{fused_now}"), length, unit);
    rows.extend(compared.map(row));
    rows.extend(fusion.growth.iter().flat_map(|growth| {
        [
            Row::plain("curves merged", growth.merged),
            Row::plain("rings closed", growth.rings),
            Row::plain("curves cut at forks", growth.cut),
            Row::plain("merges refused", growth.refused()),
        ]
    }));
    rows.extend(report.refinement.iter().flat_map(|refinement| refinement_rows(refinement, unit)));
    rows
}

/// What was read of the images of the views that `added` names; no rows without views.
fn pixel_rows(report: &Report, added: &str) -> Vec<Row> {
    if report.views.is_empty() {
        return Vec::new();
    }
    let valid = percent(pixels(report, |v| v.valid_pixels), pixels(report, |v| v.pixels));
    let mut rows = vec![Row::new(format!("valid pixels{added}"), valid, "%")];
    let halved = report.views.iter().filter(|v| v.read_pixels < v.valid_pixels).count();
    if halved > 0 {
        rows.push(Row::plain("views at half their resolution", halved));
    }
    let changed = [
        ("missing pixels and outliers, filled", pixels(report, |v| v.filled_pixels)),
        ("flying pixels, left out", pixels(report, |v| v.flying_pixels)),
        ("beyond the guide's ends, left out", pixels(report, |v| v.beyond_guide_ends)),
        ("too far from the guide, left out", pixels(report, |v| v.beyond_guide_reach)),
    ];
    let changed = changed.into_iter().filter(|(_, count)| *count > 0);
    let read = pixels(report, |v| v.read_pixels);
    rows.extend(changed.map(|(name, count)| Row::new(name, percent(count, read), "%")));
    rows
}

fn percent(part: usize, whole: usize) -> String {
    digits(100.0 * part as f64 / whole.max(1) as f64)
}

/// How far the arcs of a polyline's corners pass from its points.
fn rounding_row(guide: &Guide, unit: LengthUnit) -> Option<Row> {
    let guide = guide.curved().filter(|guide| matches!(guide.kind(), GuideKind::Polyline(_)))?;
    let distance = guide.distance_from_points();
    Some(Row::length("guide, largest distance from its points", distance, unit))
}

fn refinement_rows(refinement: &RefinementReport, unit: LengthUnit) -> [Row; 4] {
    [
        Row::length("smallest interval", refinement.least_interval, unit),
        Row::plain("planes in use", refinement.planes),
        Row::plain("planes inserted", refinement.planes_inserted),
        Row::plain("intervals still above the tolerance", refinement.intervals_above_tolerance),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::Point3;

    #[test]
    fn a_larger_radius_is_advised_only_where_it_helps() {
        let points = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)].map(|(x, y)| Point3::new(x, y, 0.0));
        let polyline = |radius| CurvedGuide::polyline(points.to_vec(), radius).unwrap();
        assert!(is_radius_binding(&polyline(Some(2.0))));
        assert!(!is_radius_binding(&polyline(Some(50.0))), "there is room for less");
        assert!(!is_radius_binding(&polyline(None)));
        assert!(!is_radius_binding(&CurvedGuide::spline(points.to_vec()).unwrap()));
    }
}
