//! `cargo xtask experiments`: measurements that take the whole system, printed as tables.
//!
//! Each answers a question of users of the system. The documentation states the figures that they
//! print.

mod ablation;
mod circles;
mod database;
mod depth_camera;
mod figures;
mod formats;
mod nodes;
mod operations;
mod orders;
mod output;
pub mod pages;
mod partial;
mod peers;
mod pictures;
mod poses;
mod poses_judged;
mod posters;
mod python;
mod real_noise;
mod real_scans;
mod rules;
mod sensors;
mod speed;
mod trial;

use crate::failure::Failure;
use crate::table::say;
use clap::{Command, FromArgMatches, Subcommand};
use output::Output;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Options of `experiments`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
    /// Folder for tables and pictures; each experiment has a folder in it.
    #[arg(long, global = true, value_name = "DIR", default_value = DEFAULT_FOLDER)]
    out: PathBuf,
    /// Also write the tables and pictures into the README and the pages of docs.
    #[arg(long, global = true)]
    write_docs: bool,
}

/// Folder of the tables and pictures.
const DEFAULT_FOLDER: &str = "transect-out/experiments";

#[derive(Debug, Subcommand)]
enum Experiment {
    /// How accurate is every sensor on every bundled scene, without noise?
    Sensors(sensors::Arguments),
    /// What is each step of fusion worth?
    Ablation(ablation::Arguments),
    /// How far does fusion move a circle, and how much noise does it take out?
    Circles,
    /// Where are nodes wrong, and does the model know their errors?
    Nodes(nodes::Arguments),
    /// How accurate are models of public scans of real things?
    RealScans(real_scans::Arguments),
    /// Does the same scan in files of other programs give the same sections?
    Formats(formats::Arguments),
    /// How fast are curves found, beside other programs?
    Speed,
    /// How does the error fall when the sensors' grids get denser?
    Orders(orders::Arguments),
    /// How many operations does a view take, against Appendix A?
    Operations,
    /// How accurate are one view's curves, by method, noise, surface and angle?
    Partial(partial::Arguments),
    /// Does the model database keep its promises?
    Database(database::Arguments),
    /// Is a turned view named, and does it spoil the sections?
    PosesJudged(poses_judged::Arguments),
    /// What do errors of the poses cost, as given and refined?
    Poses(poses::Arguments),
    /// How much noise has a real image, beside its simulation?
    RealNoise(real_noise::Arguments),
    /// What does each error of a depth camera cost?
    DepthCamera,
    /// Draw posters of the bundled scenes.
    Posters,
    /// Draw scanned points and models of every sensor.
    Pictures,
    /// Draw the dissertation's own results, by its own methods.
    Figures,
    /// Draw an example of each overlap rule.
    Rules,
    /// How accurate are other programs on the same images?
    Peers(peers::Arguments),
    /// Run every experiment with its default arguments.
    All,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { experiment, out, write_docs } = arguments;
    let outcome = match experiment {
        Experiment::All => run_all(out),
        one => run_one(one, out),
    };
    if *write_docs {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let changed = pages::write(here.ancestors().nth(2).unwrap_or(here), out)?;
        changed.iter().for_each(|file| say(&format!("changed: {file}")));
    }
    outcome
}

/// Runs an experiment.
fn run_one(experiment: &Experiment, out: &Path) -> Result<(), Failure> {
    let command = command_line(std::env::args().skip(1));
    let name = command.split(' ').nth(1).unwrap_or_default();
    if let Some(reason) = start(experiment, &Output::new(out, name, command.clone()))? {
        say(&format!("SKIPPED: {reason}"));
    }
    Ok(())
}

/// The words of a command without options that leave its tables as they are.
fn command_line(words: impl Iterator<Item = String>) -> String {
    let mut words =
        words.filter(|word| !["--out=", "--python="].iter().any(|o| word.starts_with(o)));
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--write-docs" => (),
            "--out" | "--python" => drop(words.next()),
            _ => kept.push(word),
        }
    }
    kept.join(" ")
}

/// Runs an experiment, or tells why it is skipped.
fn start(experiment: &Experiment, out: &Output) -> Result<Option<String>, Failure> {
    match experiment {
        Experiment::Sensors(a) => sensors::run(a, out)?,
        Experiment::Ablation(a) => return ablation::run(a, out),
        Experiment::Circles => circles::run(out)?,
        Experiment::Nodes(a) => return nodes::run(a, out),
        Experiment::RealScans(a) => return real_scans::run(a, out),
        Experiment::Formats(a) => return formats::run(a, out),
        Experiment::Speed => return speed::run(out),
        Experiment::Orders(a) => orders::run(a, out)?,
        Experiment::Operations => operations::run(out)?,
        Experiment::Partial(a) => partial::run(a, out)?,
        Experiment::Database(a) => database::run(a, out)?,
        Experiment::PosesJudged(a) => poses_judged::run(a, out)?,
        Experiment::Poses(a) => poses::run(a, out)?,
        Experiment::RealNoise(a) => return real_noise::run(a, out),
        Experiment::DepthCamera => depth_camera::run(out)?,
        Experiment::Posters => posters::run(out)?,
        Experiment::Pictures => pictures::run(out)?,
        Experiment::Figures => figures::run(out)?,
        Experiment::Rules => rules::run(out)?,
        Experiment::Peers(a) => return peers::run(a, out),
        Experiment::All => return Err(Failure::because("one experiment is asked for")),
    }
    Ok(None)
}

/// Runs every experiment in the order of the help. A failure does not stop the others.
fn run_all(out: &Path) -> Result<(), Failure> {
    let mut failed = Vec::new();
    for (name, experiment) in all()? {
        let start_time = Instant::now();
        let output = Output::new(out, &name, format!("experiments {name}"));
        let outcome = start(&experiment, &output);
        let seconds = start_time.elapsed().as_secs();
        let verdict = match outcome {
            Ok(None) => format!("done in {seconds} s"),
            Ok(Some(reason)) => format!("SKIPPED: {reason}"),
            Err(failure) => {
                failed.push(name.clone());
                format!("FAILED after {seconds} s: {failure}")
            }
        };
        say(&format!("experiments {name}: {verdict}"));
    }
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::because(format!("experiments failed: {}", failed.join(", ")))),
    }
}

/// Every experiment but `all`, by its name, with its default arguments.
fn all() -> Result<Vec<(String, Experiment)>, Failure> {
    let command = Experiment::augment_subcommands(Command::new("experiments"));
    let names = command.get_subcommands().map(|c| c.get_name().to_owned());
    let parse = |name: String| {
        let matches = command.clone().try_get_matches_from(["experiments", &name])?;
        Ok((name, Experiment::from_arg_matches(&matches)?))
    };
    names.filter(|name| name != "all").map(parse).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_experiment_runs_without_arguments() {
        let all = super::all().unwrap();
        assert!(all.len() > 8, "{all:?}");
    }
}
