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
mod lab;
mod nodes;
mod operations;
mod orders;
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
mod visitors;

use crate::failure::Failure;
use crate::table::say;
use clap::{Command, FromArgMatches, Subcommand};
use lab::{Lab, Places};
use std::path::Path;
use std::time::Instant;

/// Options of `experiments`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
    #[command(flatten)]
    places: Places,
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
    Nodes,
    /// How accurate are models of public scans of real things?
    RealScans,
    /// Does the same scan in files of other programs give the same sections?
    Formats,
    /// How fast are curves found, beside other programs?
    Speed(speed::Arguments),
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
    RealNoise,
    /// What does each error of a depth camera cost?
    DepthCamera,
    /// What is left of people who walk by?
    Visitors,
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
    let Arguments { experiment, places, write_docs } = arguments;
    let outcome = match experiment {
        Experiment::All => run_all(places),
        one => run_one(one, places),
    };
    if *write_docs {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let changed = pages::write(here.ancestors().nth(2).unwrap_or(here), &places.out)?;
        changed.iter().for_each(|file| say(&format!("changed: {file}")));
    }
    outcome
}

/// Runs an experiment.
fn run_one(experiment: &Experiment, places: &Places) -> Result<(), Failure> {
    let command = command_line(std::env::args().skip(1));
    let name = command.split(' ').nth(1).unwrap_or_default();
    match start(experiment, &Lab::new(places, name, command.clone())) {
        Err(Failure::Skipped(reason)) => say(&format!("SKIPPED: {reason}")),
        outcome => return outcome,
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

/// Runs an experiment.
fn start(experiment: &Experiment, lab: &Lab) -> Result<(), Failure> {
    match experiment {
        Experiment::Sensors(a) => sensors::run(a, lab),
        Experiment::Ablation(a) => ablation::run(a, lab),
        Experiment::Circles => circles::run(lab),
        Experiment::Nodes => nodes::run(lab),
        Experiment::RealScans => real_scans::run(lab),
        Experiment::Formats => formats::run(lab),
        Experiment::Speed(a) => speed::run(a, lab),
        Experiment::Orders(a) => orders::run(a, lab),
        Experiment::Operations => operations::run(lab),
        Experiment::Partial(a) => partial::run(a, lab),
        Experiment::Database(a) => database::run(a, lab),
        Experiment::PosesJudged(a) => poses_judged::run(a, lab),
        Experiment::Poses(a) => poses::run(a, lab),
        Experiment::RealNoise => real_noise::run(lab),
        Experiment::DepthCamera => depth_camera::run(lab),
        Experiment::Visitors => visitors::run(lab),
        Experiment::Posters => posters::run(lab),
        Experiment::Pictures => pictures::run(lab),
        Experiment::Figures => figures::run(lab),
        Experiment::Rules => rules::run(lab),
        Experiment::Peers(a) => peers::run(a, lab),
        Experiment::All => Err(Failure::because("one experiment is asked for")),
    }
}

/// Runs every experiment in the order of the help. A failure does not stop the others.
fn run_all(places: &Places) -> Result<(), Failure> {
    let mut failed = Vec::new();
    for (name, experiment) in all()? {
        let start_time = Instant::now();
        let outcome = start(&experiment, &Lab::new(places, &name, format!("experiments {name}")));
        let seconds = start_time.elapsed().as_secs();
        let verdict = match outcome {
            Ok(()) => format!("done in {seconds} s"),
            Err(Failure::Skipped(reason)) => format!("SKIPPED: {reason}"),
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
