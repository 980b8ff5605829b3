//! `transect reconstruct`: a scan in, a cross-section model with its report and pictures out.

use super::lengths::length;
use super::method::MethodArguments;
use super::planes::{AcceptArguments, PlaneArguments};
use super::scan::ScanArguments;
use super::{DxfArguments, simulate};
use crate::failure::Failure;
use crate::notes;
use crate::progress::Progress;
use crate::table::{Row, print, say};
use std::path::{Path, PathBuf};
use transect::Report;
use transect_workflow::{Costs, OpenScan, ResultFolder, Run, Settings, default_folder, simulation};

/// Options of `reconstruct`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scan: scan.json or its folder, a Stanford .conf, a folder of depth images, an E57 or PTX
    /// file, an organised cloud (PCD, PLY, KITTI) [default: simulate the bundled room].
    scan: Option<PathBuf>,
    #[command(flatten)]
    open: ScanArguments,
    /// Folder for the results [default: transect-out/NAME].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    store: StoreArguments,
    #[command(flatten)]
    dxf: DxfArguments,
    /// Also write the curves as cubic B-splines no farther from them than this: splines.dxf and
    /// splines.json.
    #[arg(long, value_name = "TOLERANCE")]
    splines: Option<String>,
    /// Insert planes where the curves of neighbouring planes are farther than this from each other.
    /// SMALLEST is the smallest interval: the interval halved a whole number of times [default: a
    /// sixteenth of it].
    #[arg(long, value_name = "TOLERANCE[,SMALLEST]", conflicts_with = "store")]
    refine: Option<String>,
    /// Refine the poses of all views together before their curves are found.
    #[arg(long, conflicts_with = "store", help_heading = "Poses")]
    refine_poses: bool,
    /// How far the given poses may be wrong, as standard deviations: an angle in degrees and a
    /// length, which is in the scan's unit if it has none, such as 0.3,10mm [default: estimated
    /// from how far the views contradict each other].
    #[arg(
        long,
        value_name = "DEGREES,LENGTH",
        requires = "refine_poses",
        conflicts_with = "store",
        help_heading = "Poses",
        allow_hyphen_values = true
    )]
    prior: Option<String>,
    #[command(flatten)]
    planes: PlaneArguments,
    #[command(flatten)]
    methods: MethodArguments,
    /// Keep curves that more views looked through than measured, such as people who walked by.
    #[arg(long, help_heading = "Method")]
    keep_seen_through: bool,
    #[command(flatten)]
    accept: AcceptArguments,
    /// Do not score the model against the truth of a simulated scan.
    #[arg(long, help_heading = "Running")]
    no_score: bool,
    /// Number of threads, at most 64 per core; 0 takes all cores. The results do not depend on it.
    #[arg(long, default_value_t = 0, value_name = "NUMBER", help_heading = "Running")]
    pub threads: usize,
    /// Show no progress.
    #[arg(long, help_heading = "Running")]
    quiet: bool,
}

/// Options for growing a store.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Model store (views can be added, replaced and removed later)")]
struct StoreArguments {
    /// Model store to add the scan's views to, one transaction each; made if it is not there. Views
    /// that the store has are left alone, so an interrupted run can be repeated.
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,
    /// Put before the names of this scan's views in the store, where several scans share names.
    #[arg(long, value_name = "TEXT", requires = "store", default_value = "",
        conflicts_with_all = ["refine", "refine_poses"])]
    prefix: String,
}

/// The scene that is simulated where no scan is given.
const BUNDLED_SCENE: &str = "room";

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .use_current_thread()
        .build_global()?;
    let mut costs = Costs::default();
    let path = match &arguments.scan {
        Some(path) => path.clone(),
        None => costs.stage("simulating", || bundled_scan(arguments))?,
    };
    let mut scan = arguments.open.open(&path)?;
    let settings = arguments.settings()?;
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&scan.scan().name));
    let folder = ResultFolder::new(out);
    folder.claim(&scan.inputs(&settings, arguments.store.store.as_deref()))?;
    // A store has its planes.
    let has_store = arguments.store.store.as_ref().is_some_and(|store| store.exists());
    if !has_store && scan.lacks_planes(&settings) {
        let note = costs.stage("suggesting planes", || scan.suggest_planes(&settings))?;
        notes::tell(&[note]);
    }
    let mut run = model(arguments, &scan, &settings)?;
    run.costs.begin_with(costs);
    let rows = run.write(&folder)?;
    finish(&run, &rows, &folder);
    Ok(())
}

/// The model of a scan, in one run or by growing a store.
fn model<'a>(
    arguments: &Arguments,
    scan: &'a OpenScan,
    settings: &Settings,
) -> Result<Run<'a>, Failure> {
    let progress = Progress::new(arguments.quiet);
    let run = match &arguments.store.store {
        Some(store) => scan.grow(store, &arguments.store.prefix, settings, &progress),
        None => scan.reconstruct(settings, &progress),
    };
    progress.finish();
    Ok(run?)
}

impl Arguments {
    fn settings(&self) -> Result<Settings, Failure> {
        let mut settings = Settings::default();
        settings.planes = self.planes.settings()?;
        self.methods.apply(&mut settings)?;
        settings.accept.clone_from(&self.accept.accept);
        settings.keep_seen_through = self.keep_seen_through;
        settings.dxf = self.dxf.frame();
        settings.refine = self.refine.as_deref().map(str::parse).transpose()?;
        settings.refine_poses = self.refine_poses;
        settings.prior = self.prior.as_deref().map(str::parse).transpose()?;
        settings.splines = length("splines", self.splines.as_ref())?;
        settings.no_score = self.no_score;
        Ok(settings)
    }
}

/// Simulates the bundled room next to where its results go.
fn bundled_scan(arguments: &Arguments) -> Result<PathBuf, Failure> {
    let description = simulation::describe(Path::new(BUNDLED_SCENE))?;
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&description.name));
    ResultFolder::new(out.clone()).claim(&[])?;
    let folder = out.join("scan");
    simulate::simulate(description, &folder)?;
    Ok(folder)
}

/// Prints the notes and warnings of a report.
pub fn tell(report: &Report) {
    notes::tell(&report.notes);
    notes::warn(&report.warnings());
}

fn finish(run: &Run<'_>, rows: &[Row], folder: &ResultFolder) {
    tell(&run.reconstruction.report);
    print(rows);
    say(&format!("\nresults: {}", folder.path().display()));
    say(&format!("for CAD: {}", folder.drawing().display()));
    say(&format!("picture: {}", folder.overview().display()));
}
