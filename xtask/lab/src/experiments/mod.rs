//! `cargo xtask experiments`: measurements that take the whole system, printed as tables.
//!
//! Each answers a question of users of the system. The documentation states the figures that they
//! print.

mod ablation;
mod database;
mod figures;
mod orders;
mod partial;
mod pictures;
mod poses;
mod poses_judged;
mod rules;
mod sensors;
mod trial;

use crate::failure::Failure;

/// Options of `experiments`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, clap::Subcommand)]
enum Experiment {
    /// How accurate is every sensor on every bundled scene, without noise?
    Sensors(sensors::Arguments),
    /// What is each step of fusion worth?
    Ablation(ablation::Arguments),
    /// How does the error fall when the sensors' grids get denser?
    Orders(orders::Arguments),
    /// How accurate are one view's curves, by method, noise, surface and angle?
    Partial(partial::Arguments),
    /// Does the model database keep its promises?
    Database(database::Arguments),
    /// Is a turned view named, and does it spoil the sections?
    PosesJudged(poses_judged::Arguments),
    /// What do errors of the poses cost, as given and refined?
    Poses(poses::Arguments),
    /// Draw scanned points and models of every sensor.
    Pictures(pictures::Arguments),
    /// Draw the dissertation's own results, by its own methods.
    Figures(figures::Arguments),
    /// Draw an example of each overlap rule.
    Rules(rules::Arguments),
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.experiment {
        Experiment::Sensors(a) => sensors::run(a),
        Experiment::Ablation(a) => ablation::run(a),
        Experiment::Orders(a) => orders::run(a),
        Experiment::Partial(a) => partial::run(a),
        Experiment::Database(a) => database::run(a),
        Experiment::PosesJudged(a) => poses_judged::run(a),
        Experiment::Poses(a) => poses::run(a),
        Experiment::Pictures(a) => pictures::run(a),
        Experiment::Figures(a) => figures::run(a),
        Experiment::Rules(a) => rules::run(a),
    }
}
