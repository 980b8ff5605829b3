//! `transect register`: refines the poses of a scan, or of the views in a model store.

use super::note_finished;
use super::planes::AcceptArguments;
use super::reconstruct::tell;
use super::scan::ScanArguments;
use crate::failure::Failure;
use crate::notes;
use crate::progress::Progress;
use crate::table::{Lengths, Row, print, print_grid, say};
use std::path::{Path, PathBuf};
use transect::PoseReport;
use transect::register::{PoseOutcome, RefinedPose};
use transect_exchange::MANIFEST_FILE;
use transect_workflow::{PriorSettings, Registration, StoreFile, is_model};

/// Options of `register`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scan, or model store. A scan is left as it is; the views of a store are replaced.
    path: PathBuf,
    #[command(flatten)]
    open: ScanArguments,
    /// Folder for scan.json with the refined poses, and report.json; for scans.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How far the given poses may be wrong, as standard deviations: an angle in degrees and a
    /// length, which is in the scan's unit if it has none, such as 0.3,10mm [default: estimated
    /// from how far the views contradict each other].
    #[arg(long, value_name = "DEGREES,LENGTH", allow_hyphen_values = true)]
    prior: Option<String>,
    #[command(flatten)]
    accept: AcceptArguments,
    /// Show no progress.
    #[arg(long, help_heading = "Running")]
    quiet: bool,
}

impl Arguments {
    fn prior(&self) -> Result<Option<PriorSettings>, Failure> {
        Ok(self.prior.as_deref().map(str::parse).transpose()?)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let progress = Progress::new(arguments.quiet);
    let usage = |problem: &str| Err(Failure::Usage(problem.to_owned()));
    match (is_model(&arguments.path), arguments.out.as_deref()) {
        (true, None) if arguments.open.is_empty() => store(arguments, &progress),
        (false, Some(out)) => scan(arguments, out, &progress),
        (true, _) => usage(
            "all views of a store are refined in it; leave out --out and the options that open a \
             scan or choose a part of it",
        ),
        (false, None) => usage("a scan needs --out DIR, the folder for its refined poses"),
    }
}

fn scan(arguments: &Arguments, out: &Path, progress: &Progress) -> Result<(), Failure> {
    let scan = arguments.open.open(&arguments.path)?;
    Registration::claim(&scan, out)?;
    let prior = arguments.prior()?;
    let registered = scan.register(prior, &arguments.accept.accept, progress);
    progress.finish();
    let registered = registered?;
    let warnings = registered.write(out)?;
    notes::tell(&registered.notes);
    notes::warn(&warnings);
    print_poses(&registered.poses);
    let file = out.join(MANIFEST_FILE);
    say(&format!("\nreconstruct it: transect reconstruct {}", file.display()));
    Ok(())
}

fn store(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    let store = StoreFile::open(&arguments.path)?;
    note_finished(store.planes_finished());
    let prior = arguments.prior()?;
    let replaced = store.register(prior, &arguments.accept.accept, progress);
    progress.finish();
    let replaced = replaced?;
    store.close()?;
    if let Some(problem) = replaced.report.poses.as_ref().and_then(PoseReport::unfit) {
        return Err(Failure::Failed(format!("{}: {problem}", arguments.path.display()).into()));
    }
    tell(&replaced.report);
    replaced.report.poses.iter().for_each(print_poses);
    say("");
    let poses = replaced.report.poses.iter().flat_map(|report| &report.refinement);
    let moved = poses.flat_map(|r| &r.poses).filter(|pose| pose.has_moved());
    print(&[
        Row::plain("views moved", moved.count()),
        Row::plain("views updated", replaced.views.len()),
        Row::plain("planes fused anew", replaced.planes_fused),
    ]);
    Ok(())
}

/// One line per view; nothing if no pose was refined.
fn print_poses(report: &PoseReport) {
    let poses: Vec<_> = report.refinement.iter().flat_map(|r| &r.poses).collect();
    if poses.is_empty() {
        return;
    }
    let lengths = |p: &&RefinedPose| {
        let residual = p.residual_before.unwrap_or(0.0);
        p.translation.max(residual)
    };
    let lengths = Lengths::new(report.unit, poses.iter().map(lengths).fold(0.0, f64::max));
    let unit = lengths.unit;
    let heads = [
        "view",
        "outcome",
        "turned, °",
        "σ, °",
        &format!("moved, {unit}"),
        &format!("σ, {unit}"),
        &format!("residual before, {unit}"),
        &format!("after, {unit}"),
    ];
    let length = |l: Option<f64>| l.map_or(String::new(), |l| lengths.digits(l, 1));
    let degrees = |radians: f64| format!("{:.4}", radians.to_degrees());
    let line = |pose: &&RefinedPose| {
        vec![
            pose.view.clone(),
            outcome(pose.outcome).to_owned(),
            degrees(pose.rotation),
            pose.sigma.map_or(String::new(), |sigma| degrees(sigma.rotation)),
            length(Some(pose.translation)),
            length(pose.surface_sigma),
            length(pose.residual_before),
            length(pose.residual_after),
        ]
    };
    print_grid(&heads, &poses.iter().map(line).collect::<Vec<_>>());
}

fn outcome(outcome: PoseOutcome) -> &'static str {
    match outcome {
        PoseOutcome::Refined => "refined",
        PoseOutcome::BroughtBack => "brought back",
        PoseOutcome::Kept => "kept",
        PoseOutcome::Alone => "alone",
        PoseOutcome::Misplaced => "misplaced",
    }
}
