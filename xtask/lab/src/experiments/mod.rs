//! `cargo xtask experiments`: measurements that take the whole system, printed as tables.
//!
//! Each answers a question of users of the system. The documentation states the figures that they
//! print.

mod ablation;
mod database;
mod figures;
mod operations;
mod orders;
mod partial;
mod peers;
mod pictures;
mod poses;
mod poses_judged;
mod real_noise;
mod rules;
mod sensors;
mod trial;

use crate::failure::Failure;
use crate::table::say;
use clap::{Command, FromArgMatches, Subcommand};
use std::time::Instant;

/// Options of `experiments`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, Subcommand)]
enum Experiment {
    /// How accurate is every sensor on every bundled scene, without noise?
    Sensors(sensors::Arguments),
    /// What is each step of fusion worth?
    Ablation(ablation::Arguments),
    /// How does the error fall when the sensors' grids get denser?
    Orders(orders::Arguments),
    /// How many operations does a view take, against Appendix A?
    Operations(operations::Arguments),
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
    /// Draw scanned points and models of every sensor.
    Pictures(pictures::Arguments),
    /// Draw the dissertation's own results, by its own methods.
    Figures(figures::Arguments),
    /// Draw an example of each overlap rule.
    Rules(rules::Arguments),
    /// How accurate are other programs on the same images?
    Peers(peers::Arguments),
    /// Run every experiment with its default arguments.
    All,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(reason) = start(&arguments.experiment)? {
        say(&format!("SKIPPED: {reason}"));
    }
    Ok(())
}

/// Runs an experiment, or tells why it is skipped.
fn start(experiment: &Experiment) -> Result<Option<String>, Failure> {
    match experiment {
        Experiment::Sensors(a) => sensors::run(a)?,
        Experiment::Ablation(a) => ablation::run(a)?,
        Experiment::Orders(a) => orders::run(a)?,
        Experiment::Operations(a) => operations::run(a)?,
        Experiment::Partial(a) => partial::run(a)?,
        Experiment::Database(a) => database::run(a)?,
        Experiment::PosesJudged(a) => poses_judged::run(a)?,
        Experiment::Poses(a) => poses::run(a)?,
        Experiment::RealNoise(a) => return real_noise::run(a),
        Experiment::Pictures(a) => pictures::run(a)?,
        Experiment::Figures(a) => figures::run(a)?,
        Experiment::Rules(a) => rules::run(a)?,
        Experiment::Peers(a) => return peers::run(a),
        Experiment::All => run_all()?,
    }
    Ok(None)
}

/// Runs every experiment in the order of the help. A failure does not stop the others.
fn run_all() -> Result<(), Failure> {
    let mut failed = Vec::new();
    for (name, experiment) in all()? {
        let start_time = Instant::now();
        let outcome = start(&experiment);
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
