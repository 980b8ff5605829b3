//! What each step of smoothing and fusion is worth: every set is modelled with all steps, and again
//! without one of them.

mod crossings;
mod sets;
mod worth;

use super::output::Output;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use sets::{Set, Source, Sources};
use std::path::PathBuf;
use transect_fusion::ConsensusOptions;
use transect_fusion::consensus::Steps;
use transect_partial::Method;
use transect_partial::one_pass::OnePassOptions;
use worth::{Figures, Worth};

/// Options of `experiments ablation`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder with stanford_bunny and rgbd_redkitchen.
    #[arg(long, default_value = trial::DATA, value_name = "DIR")]
    data: PathBuf,
    /// Folder of the sets that other programs are compared on.
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,
    /// Only sets whose name contains this.
    #[arg(long, value_name = "NAME")]
    set: Option<String>,
    /// Only steps whose name contains this.
    #[arg(long, value_name = "NAME")]
    step: Option<String>,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments, out: &Output) -> Result<Option<String>, Failure> {
    let sources = Sources { data: &arguments.data, peers: arguments.peers.as_deref() };
    let missing = (!arguments.data.is_dir())
        .then(|| format!("{} is not there: bundled scenes alone", arguments.data.display()));
    // Tables without the public scans are not those of the documentation.
    let out = &if missing.is_some() { Output::printed() } else { out.clone() };
    let mut worth = Worth::default();
    for source in sources.list()? {
        if arguments.set.as_ref().is_some_and(|s| !source.name.contains(s.as_str())) {
            continue;
        }
        eprintln!("{}", source.name);
        measure(&source, arguments, &mut worth)?;
    }
    worth.print(out)?;
    say(
        "\nA figure is the change if the step is left out, in per cent: positive is worse. Median and p95 of the \
         distance, completeness, and time change relative to all steps. Loops lost and crossings added count per \
         100 curves. Each cell has the largest gain of all sets, the set, and the largest loss; of times it has the median of all sets.",
    );
    Ok(missing)
}

/// Models a set with all steps, and without each.
fn measure(source: &Source<'_>, arguments: &Arguments, worth: &mut Worth) -> Result<(), Failure> {
    let chosen = |name: &str| arguments.step.as_ref().is_none_or(|s| name.contains(s.as_str()));
    let set = &(source.load)(&Method::default())?;
    let full = figures(set, &ConsensusOptions::default())?;
    worth.add_full(&source.name, full);
    for (name, method) in methods_left_out().into_iter().filter(|(name, _)| chosen(name)) {
        let other = (source.load)(&method)?;
        let mut without = figures(&other, &ConsensusOptions::default())?;
        // The time of these rows is that of finding the curves.
        without.seconds = full.seconds * other.finding_seconds / set.finding_seconds;
        worth.add(&source.name, name, without);
    }
    for (name, steps) in Steps::each_left_out().into_iter().filter(|(name, _)| chosen(name)) {
        let mut options = ConsensusOptions::default();
        options.steps = steps;
        worth.add(&source.name, name, figures(set, &options)?);
    }
    // Once more, which tells how far times can be trusted.
    worth.add(&source.name, "(again)", figures(set, &ConsensusOptions::default())?);
    Ok(())
}

/// The default way to find curves without smoothing, and without each step of it.
fn methods_left_out() -> [(&'static str, Method); 4] {
    let without = |leave_out: fn(&mut OnePassOptions)| {
        let mut options = OnePassOptions::default();
        leave_out(&mut options);
        Method::OnePass(options)
    };
    [
        ("smoothing", without(|o| o.smooth = false)),
        ("smoothing: near_planes", without(|o| o.smoothing.near_planes = false)),
        ("smoothing: wider_window", without(|o| o.smoothing.wider_window = false)),
        ("smoothing: robust_weights", without(|o| o.smoothing.robust_weights = false)),
    ]
}

fn figures(set: &Set, options: &ConsensusOptions) -> Result<Figures, Failure> {
    set.score(&set.fuse(options))
}
