//! `cargo xtask reconstruct`: a scan in, a cross-section model with its report and pictures out.

use super::evaluate::{self, Reference};
use super::outputs::{self, DrawingFrame};
use super::planes::{PlaneArguments, parse_length, parse_refinement};
use super::report_file::{ReportFile, StageCost};
use super::{FileView, default_out, growing, simulate};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::simulation;
use crate::table::{Row, digits, print, say};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use std::time::Instant;
use transect::{Reconstruction, RefinementReport, Setup, reconstruct};
use transect_exchange::Scan;
use transect_fusion::FusionMethod;
use transect_geometry::LengthUnit;

/// How a view's curves are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[value(rename_all = "snake_case")]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// All planes in one sweep over the range image.
    OnePass,
    /// Plane by plane, in the dissertation's own steps.
    Dissertation,
}

impl Method {
    pub(super) fn options(self) -> transect_partial::Method {
        match self {
            Self::OnePass => transect_partial::Method::OnePass(Default::default()),
            Self::Dissertation => transect_partial::Method::Dissertation(Default::default()),
        }
    }
}

/// How the views' curves are fused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[value(rename_all = "snake_case")]
#[serde(rename_all = "snake_case")]
pub enum Fusion {
    /// All views at once.
    Consensus,
    /// View by view, by the dissertation's overlap rules.
    Pairwise,
}

impl Fusion {
    pub(super) fn options(self) -> FusionMethod {
        match self {
            Self::Consensus => FusionMethod::Consensus(Default::default()),
            Self::Pairwise => FusionMethod::Pairwise(Default::default()),
        }
    }
}

/// Options of `reconstruct`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scan: a folder with scan.json, a scan.json, a Stanford .conf, or a folder of depth images
    /// [default: simulate the bundled room].
    scan: Option<PathBuf>,
    /// Length unit of a scan that does not state one: m, dm, cm, mm, um, in or ft.
    #[arg(long)]
    unit: Option<LengthUnit>,
    /// Folder for the results [default: target/transect/NAME].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    store: growing::StoreArguments,
    /// Frame of the curves in model.dxf.
    #[arg(long, value_enum, default_value_t = DrawingFrame::World, value_name = "FRAME")]
    dxf: DrawingFrame,
    /// Also write the curves as cubic B-splines no farther from them than this: splines.dxf and
    /// splines.json.
    #[arg(long, value_name = "TOLERANCE")]
    splines: Option<String>,
    /// Insert planes where the curves of neighbouring planes are farther than this from each other, down to a
    /// smallest interval: the interval halved a whole number of times [default: a sixteenth of it].
    #[arg(long, value_name = "TOLERANCE[,SMALLEST]", conflicts_with = "store")]
    refine: Option<String>,
    #[command(flatten)]
    planes: PlaneArguments,
    /// How each view's curves are found.
    #[arg(long, value_enum, default_value_t = Method::OnePass, help_heading = "Method")]
    method: Method,
    /// How the views' curves are fused.
    #[arg(long, value_enum, default_value_t = Fusion::Consensus, help_heading = "Method")]
    fusion: Fusion,
    /// Number of threads; 0 takes all cores. The results do not depend on it.
    #[arg(long, default_value_t = 0, value_name = "NUMBER", help_heading = "Running")]
    threads: usize,
    /// Show no progress.
    #[arg(long, help_heading = "Running")]
    quiet: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build_global()?;
    let mut stages = Stages::begin();
    let path = match &arguments.scan {
        Some(path) => path.clone(),
        None => bundled_scan(arguments, &mut stages)?,
    };
    let scan = Scan::open_with_unit(&path, arguments.unit)?;
    // Before anything can fail: a note may well be the reason.
    scan.notes.iter().for_each(|note| eprintln!("note: {note}"));
    let planes = match arguments.store.planes(&scan, &arguments.planes)? {
        Some(planes) => planes,
        None => arguments.planes.family(&scan)?,
    };
    let mut setup = Setup::new(scan.unit, planes);
    setup.partial = arguments.method.options();
    setup.fusion = arguments.fusion.options();
    let refine = arguments.refine.as_ref();
    setup.refinement = refine.map(|text| parse_refinement(&setup, text)).transpose()?;
    let tolerance = arguments.splines.as_ref();
    let tolerance = tolerance.map(|text| parse_length(scan.unit, "--splines", text)).transpose()?;
    let out = arguments.out.clone().unwrap_or_else(|| default_out(&scan.name));

    let progress = Progress::new(arguments.quiet);
    let result = model(arguments, &path, &scan, &setup, &progress);
    progress.finish();
    let (result, store_rows) = result?;
    stages.modelled(&result);

    outputs::write(&out, &scan.name, &result.model, arguments.dxf)?;
    stages.end("writing");
    let mut rows = result_rows(&scan, &result);
    // A store that had all views already is not read again to count pixels.
    rows.retain(|row| row.metric != "valid pixels" || !result.report.views.is_empty());
    rows.extend(store_rows);
    if let Some(tolerance) = tolerance {
        rows.extend(outputs::write_splines(&out, &result.model, tolerance)?);
        stages.end("fitting splines");
    }
    let accuracy = accuracy_rows(&path, &out)?;
    if !accuracy.is_empty() {
        stages.end("scoring");
    }
    rows.extend(accuracy);
    rows.extend(stages.rows());
    let report = ReportFile::new(&scan, &path, &setup, &result.report);
    report.write(&out.join("report.json"), &rows, &stages.costs)?;
    finish(&result, &rows, &out);
    Ok(())
}

/// The model of a scan, in one run or by growing a store, and what there is to say of the store.
fn model(
    arguments: &Arguments,
    path: &Path,
    scan: &Scan,
    setup: &Setup,
    progress: &Progress,
) -> Result<(Reconstruction, Vec<Row>), Failure> {
    if let Some(grown) = arguments.store.grow(path, scan, setup, progress) {
        return grown;
    }
    let views: Vec<FileView> = scan.views.iter().map(FileView).collect();
    Ok((reconstruct(&views, setup, progress)?, Vec::new()))
}

/// The scene that is simulated where no scan is given.
const BUNDLED: &str = "room";

/// Simulates the bundled room next to where its results go.
fn bundled_scan(arguments: &Arguments, stages: &mut Stages) -> Result<PathBuf, Failure> {
    let description = simulation::describe(Path::new(BUNDLED))?;
    let out = arguments.out.clone().unwrap_or_else(|| default_out(&description.name));
    let folder = out.join("scan");
    simulate::simulate(&description, &folder)?;
    stages.end("simulating");
    Ok(folder)
}

/// Scores the result if the scan has its truth beside it.
fn accuracy_rows(scan: &Path, out: &Path) -> Result<Vec<Row>, Failure> {
    match Reference::beside(scan) {
        Reference::Nothing => Ok(Vec::new()),
        truth => Ok(evaluate::score(out, &truth, &evaluate::Limits::default())?.agreement),
    }
}

fn result_rows(scan: &Scan, result: &Reconstruction) -> Vec<Row> {
    let (report, unit) = (&result.report, scan.unit.symbol());
    let refinement =
        report.refinement.iter().flat_map(|refinement| refinement_rows(refinement, unit));
    let fusion = &report.fusion;
    let valid: usize = report.views.iter().map(|v| v.valid_pixels).sum();
    let pixels: usize = report.views.iter().map(|v| v.pixels).sum();
    let percent = |part: usize, whole: usize| digits(100.0 * part as f64 / whole.max(1) as f64);
    let rows = vec![
        Row::new("scan", scan.name.clone(), ""),
        Row::count("views", result.model.views().len()),
        Row::new("valid pixels", percent(valid, pixels), "%"),
        Row::count("planes with curves", fusion.planes),
        Row::new(
            "planes with closed curves only",
            percent(fusion.planes_closed_only, fusion.planes),
            "%",
        ),
        Row::count("curves", fusion.curves),
        Row::count("closed curves", fusion.closed),
        Row::count("nodes", fusion.nodes),
        Row::count("nodes of all views", fusion.observations),
        Row::new("curve length", digits(fusion.length), unit),
        Row::new("spread between views", digits(fusion.spread), unit),
        Row::new("overlap threshold", digits(fusion.threshold), unit),
    ];
    rows.into_iter().chain(refinement).collect()
}

fn refinement_rows(refinement: &RefinementReport, unit: &str) -> [Row; 4] {
    [
        Row::new("smallest interval", digits(refinement.least_interval), unit),
        Row::count("planes asked for", refinement.planes),
        Row::count("planes inserted", refinement.planes_inserted),
        Row::count("intervals still above the tolerance", refinement.intervals_above_tolerance),
    ]
}

fn finish(result: &Reconstruction, rows: &[Row], out: &Path) {
    result.report.notes.iter().for_each(|note| eprintln!("note: {note}"));
    for warning in result.report.warnings() {
        eprintln!("warning: {warning}");
    }
    print(rows);
    say(&format!("\nresults: {}", out.display()));
    say(&format!("picture: {}", out.join("overview.svg").display()));
}

/// Time and memory by stage.
struct Stages {
    costs: Vec<StageCost>,
    began: Instant,
}

impl Stages {
    fn begin() -> Self {
        Self { costs: Vec::new(), began: Instant::now() }
    }

    /// Ends a stage that began where the last one ended.
    fn end(&mut self, stage: &str) {
        self.push(stage, self.began.elapsed().as_secs_f64());
        self.began = Instant::now();
    }

    /// The modeler's own stages, which it timed itself.
    fn modelled(&mut self, result: &Reconstruction) {
        let t = &result.report.timings;
        let busy = (t.reading + t.modelling).as_secs_f64();
        // Reading and finding curves run side by side: the clock's time is shared by their work.
        let share = |part: f64| if busy > 0.0 { t.views.as_secs_f64() * part / busy } else { 0.0 };
        self.push("reading", share(t.reading.as_secs_f64()));
        self.push("finding curves", share(t.modelling.as_secs_f64()));
        self.push("fusing", t.fusion.as_secs_f64());
        self.began = Instant::now();
    }

    fn push(&mut self, stage: &str, seconds: f64) {
        let peak = crate::memory::peak_mib();
        self.costs.push(StageCost { stage: stage.to_owned(), seconds, peak_memory_mib: peak });
    }

    fn rows(&self) -> Vec<Row> {
        let row = |c: &StageCost| {
            let peak = c.peak_memory_mib.map_or(String::new(), |m| format!(", peak {m:.0} MiB"));
            Row::new(format!("time {}", c.stage), format!("{:.3}", c.seconds), format!("s{peak}"))
        };
        let total: f64 = self.costs.iter().map(|c| c.seconds).sum();
        let total = Row::new("time in all", format!("{total:.3}"), "s");
        self.costs.iter().map(row).chain([total]).collect()
    }
}
