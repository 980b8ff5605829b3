//! From a scan on disk to a model, and from there to a result folder.

use crate::score::{Reference, ScoreLimits, score};
use crate::settings::parse_length;
use crate::store_file::{Grown, grow, origin};
use crate::table::{Row, digits};
use crate::views::{FileView, OpenScan};
use crate::{Costs, ReportFile, ResultFolder, Settings, WorkflowError};
use std::path::Path;
use transect::{Reconstruction, RefinementReport, Setup, Watch, reconstruct};
use transect_exchange::{DxfFrame, Scan};

/// A model that was made of a scan, and what its results will say about it.
#[derive(Debug)]
pub struct Run<'a> {
    /// The model, and the report of the modeler with its notes and warnings.
    pub reconstruction: Reconstruction,
    /// The time and memory of the stages up to now.
    pub costs: Costs,
    scan: &'a OpenScan,
    setup: Setup,
    /// Rows on the store, if one was grown.
    store: Vec<Row>,
    dxf: DxfFrame,
    splines: Option<f64>,
}

impl OpenScan {
    /// Makes a model of all views.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting cannot be used, or a view cannot be loaded or modelled.
    pub fn reconstruct(
        &self,
        settings: &Settings,
        watch: &dyn Watch,
    ) -> Result<Run<'_>, WorkflowError> {
        let setup = settings.setup(self.scan())?;
        let splines = self.splines(settings)?;
        let reconstruction = reconstruct(&self.views(""), &setup, watch)?;
        Ok(self.run(reconstruction, setup, settings.dxf, splines))
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
        let asks_for_planes = self.scan().planes.is_some() || !settings.planes.is_empty();
        let setup = if store.exists() && !asks_for_planes {
            let planes = crate::open_store(store)?.read()?.header().planes.clone();
            settings.setup_with(planes, self.scan())?
        } else {
            settings.setup(self.scan())?
        };
        let splines = self.splines(settings)?;
        let Grown { reconstruction, views_present, planes_fused } =
            grow(store, &self.views(prefix), &setup, watch)?;
        let rows = vec![
            Row::plain("store", store.display()),
            Row::plain("views added", reconstruction.report.views.len()),
            Row::plain("views there already", views_present),
            Row::plain("planes fused", planes_fused),
        ];
        Ok(Run { store: rows, ..self.run(reconstruction, setup, settings.dxf, splines) })
    }

    fn views(&self, prefix: &str) -> Vec<FileView<'_>> {
        let view = |view| {
            let view = origin(view, self.path());
            FileView { id: format!("{prefix}{}", view.id), ..view }
        };
        self.scan().views.iter().map(view).collect()
    }

    fn splines(&self, settings: &Settings) -> Result<Option<f64>, WorkflowError> {
        let tolerance = settings.splines.as_ref();
        tolerance.map(|text| parse_length(self.scan().unit, "splines", text)).transpose()
    }

    fn run(
        &self,
        reconstruction: Reconstruction,
        setup: Setup,
        dxf: DxfFrame,
        splines: Option<f64>,
    ) -> Run<'_> {
        let mut costs = Costs::default();
        costs.modelled(&reconstruction.report.timings);
        Run { reconstruction, costs, scan: self, setup, store: Vec::new(), dxf, splines }
    }
}

impl Run<'_> {
    /// Writes every result into a folder, and scores the model if the scan has its truth beside it.
    /// Returns the table of the run, which is in the report, too.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that cannot be written, or read for the scores.
    pub fn write(&mut self, folder: &ResultFolder) -> Result<Vec<Row>, WorkflowError> {
        let (model, costs) = (&self.reconstruction.model, &mut self.costs);
        let title = &self.scan.scan().name;
        costs.stage("writing", || folder.write_model(title, model, self.dxf))?;
        let mut rows = result_rows(self.scan.scan(), &self.reconstruction);
        rows.extend(self.store.iter().cloned());
        if let Some(tolerance) = self.splines {
            let write = || folder.write_splines(model, tolerance);
            rows.extend(costs.stage("fitting splines", write)?);
        }
        let truth = Reference::beside(self.scan.path());
        if !matches!(truth, Reference::Nothing) {
            let score = || score(model, &truth, &ScoreLimits::default());
            rows.extend(costs.stage("scoring", score)?.agreement);
        }
        rows.extend(costs.rows());
        let report = ReportFile::new(self.scan, &self.setup, &self.reconstruction.report);
        folder.write_report(&report, &rows, costs)?;
        Ok(rows)
    }
}

fn result_rows(scan: &Scan, result: &Reconstruction) -> Vec<Row> {
    let (report, unit) = (&result.report, scan.unit.symbol());
    let fusion = &report.fusion;
    let percent = |part: usize, whole: usize| digits(100.0 * part as f64 / whole.max(1) as f64);
    let mut rows = vec![
        Row::new("scan", scan.name.clone(), ""),
        Row::plain("views", result.model.views().len()),
    ];
    // A store that had all views already is not read again to count pixels.
    if !report.views.is_empty() {
        let valid: usize = report.views.iter().map(|v| v.valid_pixels).sum();
        let pixels: usize = report.views.iter().map(|v| v.pixels).sum();
        rows.push(Row::new("valid pixels", percent(valid, pixels), "%"));
    }
    let closed_only = percent(fusion.planes_closed_only, fusion.planes);
    rows.extend([
        Row::plain("planes with curves", fusion.planes),
        Row::new("planes with closed curves only", closed_only, "%"),
        Row::plain("curves", fusion.curves),
        Row::plain("closed curves", fusion.closed),
        Row::plain("nodes", fusion.nodes),
        Row::plain("nodes of all views", fusion.observations),
        Row::new("curve length", digits(fusion.length), unit),
        Row::new("spread between views", digits(fusion.spread), unit),
        Row::new("overlap threshold", digits(fusion.threshold), unit),
    ]);
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

fn refinement_rows(refinement: &RefinementReport, unit: &str) -> [Row; 4] {
    [
        Row::new("smallest interval", digits(refinement.least_interval), unit),
        Row::plain("planes asked for", refinement.planes),
        Row::plain("planes inserted", refinement.planes_inserted),
        Row::plain("intervals still above the tolerance", refinement.intervals_above_tolerance),
    ]
}
