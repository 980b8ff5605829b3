//! Transect beside other programs: the same simulated depth images, and one scorer in Python.
//!
//! This side simulates the scans and writes them twice: as given, and smoothed by Transect, so that
//! smoothing and fusion are told apart. It also writes Transect's own curves without and with its
//! smoothing. `xtask/peers/run.py` has the other programs make meshes of both scans, cuts these on
//! the scan's planes, and scores all curves against the true mesh. It shares no code with Transect.

use super::output::Output;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use transect::image::PreparedView;
use transect::image::smooth::Smoothing;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_exchange::{write_contours, write_file};
use transect_partial::one_pass::OnePassOptions;
use transect_partial::{BreakRule, Method};
use transect_workflow::default_folder;
use transect_workflow::simulation::{
    PreparedScene, SensorKind, SensorPlan, SimulatedScan, StripeImages,
};

/// Options of `experiments peers`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Only the first scene, at the coarsest resolution.
    #[arg(long)]
    quick: bool,
    /// Python with the modules of xtask/peers/requirements.txt [default: the one in target/peers,
    /// else python3].
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
}

/// A bundled scene, the number of its views, and the factor on its noise.
#[derive(Debug, Clone, Copy)]
struct Scan(&'static str, Option<usize>, f64);

/// The scans. All views are depth cameras: the scene's own, or cameras in place of its scanners.
const SCANS: [Scan; 4] = [
    Scan("machined_part", None, 1.0),
    Scan("machined_part", None, 4.0),
    Scan("face_mask", None, 1.0),
    Scan("room", Some(12), 1.0),
];

/// Edges of voxels, or of Poisson's finest cells, as shares of the scene's size.
const RESOLUTIONS: [&str; 2] = ["0.005", "0.0025"];

/// Seed of the noise. No setting of Transect was chosen with it.
const SEED: u64 = 2026;

impl Scan {
    /// The name of its folder and of its table.
    fn name(self) -> String {
        let Self(scene, _, noise) = self;
        if noise == 1.0 { scene.to_owned() } else { format!("{scene}-noise-{noise}") }
    }
}

/// Runs the experiment, or tells why it is skipped.
pub fn run(arguments: &Arguments, out: &Output) -> Result<Option<String>, Failure> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers");
    let made = here.join("../../target/peers/bin/python");
    let usual = if made.is_file() { made } else { "python3".into() };
    let python = arguments.python.as_ref().unwrap_or(&usual);
    if let Some(reason) = missing(python) {
        return Ok(Some(reason));
    }
    let (scans, resolutions) = match arguments.quick {
        true => (&SCANS[..1], &RESOLUTIONS[..1]),
        false => (&SCANS[..], &RESOLUTIONS[..]),
    };
    say(&format!("noise of the seed {SEED}"));
    let is_complete = import(python, "vdbfusion").is_ok();
    for scan in scans {
        let name = scan.name();
        let folder = default_folder("peers").join(&name);
        write(*scan, &folder)?;
        let table = score(python, &here.join("run.py"), &resolutions.join(","), &folder)?;
        say(&table);
        // A table without a program would differ from the documentation's.
        if is_complete {
            out.write(&name, &table)?;
        }
    }
    Ok(None)
}

/// The table of a scan's folder, by the script.
fn score(python: &Path, script: &Path, shares: &str, folder: &Path) -> Result<String, Failure> {
    // Without files of byte code beside the scripts.
    let mut command = Command::new(python);
    command.arg("-B").arg(script).arg(shares).arg(folder).stderr(Stdio::inherit());
    let output = command.output().map_err(|error| Failure::with_file(python, error))?;
    if !output.status.success() {
        return Err(Failure::because(format!("xtask/peers/run.py: {}", output.status)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

/// Why a Python cannot run the other programs, and what to do; `None` if it can.
fn missing(python: &Path) -> Option<String> {
    let reason = import(python, "numpy, scipy, open3d").err()?;
    Some(format!(
        "{}: {reason}. Make a Python with the other programs (VDBFusion needs Python 3.10 or \
         older), and repeat:\n  python3 -m venv target/peers\n  \
         target/peers/bin/pip install -r xtask/peers/requirements.txt",
        python.display()
    ))
}

/// Whether a Python can import modules; otherwise the last line of its error.
fn import(python: &Path, modules: &str) -> Result<(), String> {
    let output = Command::new(python).args(["-c", &format!("import {modules}")]).output();
    let output = output.map_err(|error| error.to_string())?;
    let error = String::from_utf8_lossy(&output.stderr);
    let last = error.lines().last().unwrap_or("the import failed");
    if output.status.success() { Ok(()) } else { Err(last.to_owned()) }
}

/// Writes a scan, as given and smoothed, and our curves without and with smoothing.
fn write(Scan(name, views, noise): Scan, folder: &Path) -> Result<(), Failure> {
    eprintln!("{name}");
    let mut scene = trial::bundled(name)?;
    scene.description.noise.seed = SEED;
    scene.description.noise.sigma *= noise;
    let plan = match views {
        Some(_) => SensorPlan { views, ..SensorPlan::with(SensorKind::Pinhole) },
        None => SensorPlan::OWN,
    };
    let mut scan = scene.simulate(&plan)?;
    for smooth in [false, true] {
        let images = if smooth { "smoothed" } else { "given" };
        let mut options = OnePassOptions::default();
        options.smooth = smooth;
        model(&scene, &scan, options, &folder.join(images).with_extension("json"))?;
        if smooth {
            scan.views = scan.views.iter().map(smoothed).collect();
        }
        scan.write(&scene, StripeImages::Extracted, &folder.join(images))?;
    }
    Ok(())
}

/// Writes the curves of the given images.
fn model(
    scene: &PreparedScene,
    scan: &SimulatedScan,
    options: OnePassOptions,
    file: &Path,
) -> Result<(), Failure> {
    let mut setup = Setup::new(scene.description.unit, scene.description.planes.clone());
    setup.partial = Method::OnePass(options);
    let model = reconstruct(&scan.views, &setup, &Unwatched)?.model;
    let parent = file.parent().unwrap_or(file);
    std::fs::create_dir_all(parent).map_err(|e| Failure::with_file(parent, e))?;
    write_file(file, |out| write_contours(&model, out))?;
    Ok(())
}

/// A view with all its pixels smoothed, as a run smooths those near its planes.
fn smoothed(view: &View) -> View {
    let options = OnePassOptions::default();
    let rule = |sigma| {
        BreakRule::new(options.max_incidence_rad, options.jump_sigmas * sigma).on_rays_of(view)
    };
    PreparedView::new(view, Some(&Smoothing::default()), rule).view().clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scorer_is_right_on_exact_cases() {
        let python = std::env::var("TRANSECT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        if let Err(reason) = import(python.as_ref(), "numpy, scipy") {
            println!("skipped: {python}: {reason}; set TRANSECT_PYTHON");
            return;
        }
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../peers/test_score.py");
        let output = Command::new(python).args(["-B", script]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    #[test]
    fn a_python_without_the_programs_is_told_how_to_get_them() {
        let reason = missing("no/such/python".as_ref()).unwrap();
        assert!(reason.contains("pip install -r xtask/peers/requirements.txt"), "{reason}");
    }
}
