//! Transect beside other programs: the same simulated depth images, and one scorer in Python.
//!
//! This side simulates the scans and writes them twice: as given, and smoothed by Transect, so that
//! smoothing and fusion are told apart. It also writes Transect's own curves without and with its
//! smoothing. `xtask/peers/run.py` has the other programs make meshes of both scans, cuts these on
//! the scan's planes, and scores all curves against the true mesh. It shares no code with Transect.

mod kitchen;
mod real;

use super::lab::Lab;
use super::python;
use super::trial;
use crate::failure::Failure;
use crate::table::{line, say};
use std::path::{Path, PathBuf};
use std::time::Instant;
use transect::image::smooth::Smoothing;
use transect::image::{NoisyView, PreparedView, RangeNoise};
use transect::{Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_exchange::{write_contours, write_file};
use transect_partial::Method;
use transect_partial::one_pass::OnePassOptions;
use transect_workflow::default_folder;
use transect_workflow::simulation::{SensorKind, SensorPlan, StripeImages};

/// Options of `experiments peers`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Only the first scene, at the coarsest resolution.
    #[arg(long)]
    quick: bool,
    /// Only scans whose name contains this.
    #[arg(long, value_name = "NAME")]
    scan: Option<String>,
}

impl Arguments {
    fn chooses(&self, name: &str) -> bool {
        self.scan.as_ref().is_none_or(|scan| name.contains(scan.as_str()))
    }
}

/// A bundled scene, the number of its views, and the factor on its noise.
#[derive(Debug, Clone, Copy)]
struct Scan(&'static str, Option<usize>, f64);

/// The scans. All views are depth cameras: the scene's own, or cameras in place of its scanners.
const SCANS: [Scan; 7] = [
    Scan("machined_part", None, 1.0),
    Scan("machined_part", None, 4.0),
    Scan("face_mask", None, 1.0),
    Scan("room", Some(12), 1.0),
    Scan("thin_sheet", None, 1.0),
    Scan("tunnel", Some(12), 1.0),
    Scan("kitchen", None, 1.0),
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

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let hint = " (VDBFusion needs Python 3.10 or older)";
    let python = lab.python("peers", "numpy, scipy, open3d", hint)?;
    let (scans, resolutions) = match arguments.quick {
        true => (&SCANS[..1], &RESOLUTIONS[..1]),
        false => (&SCANS[..], &RESOLUTIONS[..]),
    };
    say(&format!("noise of the seed {SEED}"));
    let mut run = Run { python, shares: resolutions.join(","), lab, times: Vec::new() };
    if !arguments.quick && arguments.chooses("kitchen") {
        kitchen::draw(lab, &run.python)?;
    }
    let named = || scans.iter().map(|scan| scan.name()).chain([real::NAME.to_owned()]);
    if !named().any(|name| arguments.chooses(&name)) {
        let names = named().collect::<Vec<_>>().join(", ");
        return Err(Failure::because(format!("no scan has this name; there are {names}")));
    }
    for scan in scans.iter().filter(|scan| arguments.chooses(&scan.name())) {
        let name = scan.name();
        let folder = default_folder("peers").join(&name);
        let seconds = write(*scan, &folder)?;
        run.score(&name, seconds, &folder)?;
    }
    if arguments.quick {
        return Ok(());
    }
    if arguments.chooses(real::NAME) {
        let folder = default_folder("peers").join(real::NAME);
        let seconds = real::write(lab.scans()?, &folder)?;
        run.score(real::NAME, seconds, &folder)?;
    }
    // A table without a scan would differ from the documentation's.
    if arguments.scan.is_some() { Ok(()) } else { run.print_times() }
}

/// The scans that are scored one after the other.
struct Run<'a> {
    python: PathBuf,
    shares: String,
    lab: &'a Lab,
    /// Seconds of each program, by scan.
    times: Vec<(String, Vec<(String, String)>)>,
}

impl Run<'_> {
    /// Scores a scan's folder by the script, after the seconds that Transect took.
    fn score(&mut self, name: &str, seconds: f64, folder: &Path) -> Result<(), Failure> {
        let folder = folder.to_string_lossy();
        let printed = python::run(&self.python, "peers/run.py", &[&self.shares, &folder])?;
        let (table, times) = printed.split_once("\n\n").unwrap_or((&printed, ""));
        say(table);
        // A table without a program would differ from the documentation's.
        if python::import(&self.python, "vdbfusion").is_ok() {
            self.lab.write(name, table)?;
        }
        let of_line = |line: &str| {
            let (program, seconds) = line.split_once('\t')?;
            Some((program.to_owned(), seconds.to_owned()))
        };
        let own = ("Transect".to_owned(), format!("{seconds:.1}"));
        let times = std::iter::once(own).chain(times.lines().filter_map(of_line)).collect();
        self.times.push((name.to_owned(), times));
        Ok(())
    }

    /// The seconds of each program on the images as given.
    fn print_times(&self) -> Result<(), Failure> {
        let scans = self.times.iter().map(|(scan, _)| scan.as_str());
        let heads = std::iter::once("seconds").chain(scans).collect::<Vec<_>>().join(" | ");
        let mut programs: Vec<&String> = Vec::new();
        for (program, _) in self.times.iter().flat_map(|(_, times)| times) {
            if !programs.contains(&program) {
                programs.push(program);
            }
        }
        let cell = |times: &[(String, String)], program: &String| {
            let found = times.iter().find(|(name, _)| name == program);
            found.map_or("–".to_owned(), |(_, seconds)| seconds.clone())
        };
        let of_program = |program: &&String| {
            let cells = self.times.iter().map(|(_, times)| cell(times, program));
            line((*program).clone(), cells)
        };
        self.lab.times(&heads, programs.iter().map(of_program))
    }
}

/// Writes a scan, as given and smoothed, and our curves without and with smoothing. Returns the
/// seconds of the default run.
fn write(Scan(name, views, noise): Scan, folder: &Path) -> Result<f64, Failure> {
    eprintln!("{name}");
    let mut scene = trial::bundled(name)?;
    scene.description.noise.seed = SEED;
    scene.description.noise.sigma *= noise;
    let plan = match views {
        Some(_) => SensorPlan { views, ..SensorPlan::with(SensorKind::Pinhole) },
        None => SensorPlan::OWN,
    };
    let mut scan = scene.simulate(&plan)?;
    let seconds = models(&scan.views, trial::setup(&scene), folder)?;
    scan.write(&scene, StripeImages::Extracted, &folder.join("given"))?;
    scan.views = scan.views.iter().map(smoothed).collect();
    scan.write(&scene, StripeImages::Extracted, &folder.join("smoothed"))?;
    Ok(seconds)
}

/// Writes our curves of the given images without and with smoothing, and returns the seconds of the
/// second model.
fn models(views: &[View], mut setup: Setup, folder: &Path) -> Result<f64, Failure> {
    std::fs::create_dir_all(folder).map_err(|e| Failure::with_file(folder, e))?;
    let mut seconds = 0.0;
    for (smooth, name) in [(false, "given.json"), (true, "smoothed.json")] {
        let mut options = OnePassOptions::default();
        options.smooth = smooth;
        setup.partial = Method::OnePass(options);
        let start_time = Instant::now();
        let model = reconstruct(views, &setup, &Unwatched)?.model;
        seconds = start_time.elapsed().as_secs_f64();
        write_file(&folder.join(name), |out| write_contours(&model, out))?;
    }
    Ok(seconds)
}

/// A view with all its pixels smoothed, as a run smooths those near its planes.
fn smoothed(view: &View) -> View {
    let options = OnePassOptions::default();
    let rule = |noise: &RangeNoise| options.break_rule(view, noise);
    let noisy = NoisyView::whole(view);
    PreparedView::new(&noisy, Some(&Smoothing::default()), rule).view().clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scorer_is_right_on_exact_cases() {
        let python = std::env::var("TRANSECT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        if let Err(reason) = python::import(python.as_ref(), "numpy, scipy") {
            println!("skipped: {python}: {reason}; set TRANSECT_PYTHON");
            return;
        }
        python::run(python.as_ref(), "peers/test_score.py", &[]).unwrap();
    }
}
