//! The worth of each step of smoothing and fusion: every set is modelled with all steps, and again
//! without one of them.

mod sets;
mod worth;

use super::lab::Lab;
use crate::failure::Failure;
use crate::table::say;
use sets::{Raw, Sources};
use std::path::PathBuf;
use transect_fusion::ConsensusOptions;
use transect_fusion::consensus::Steps;
use transect_partial::Method;
use transect_partial::one_pass::OnePassOptions;
use worth::Worth;

/// Options of `experiments ablation`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
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
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let sources = Sources { data: lab.scans()?, peers: arguments.peers.as_deref() };
    let mut worth = Worth::default();
    let chosen = |name: &str| arguments.set.as_ref().is_none_or(|set| name.contains(set.as_str()));
    sources.each(chosen, |name, raw| {
        eprintln!("{name}");
        measure(name, raw, arguments, &mut worth)
    })?;
    worth.print(lab)?;
    say(
        "A figure is the change if the step is left out, in per cent: positive is worse. Median and \
         p95 of the distance, completeness, and time change relative to all steps. Loops lost and \
         crossings added count per 100 curves.\nEach cell has the largest gain of all sets, the \
         set, and the largest loss; of times it has the median of all sets.",
    );
    Ok(())
}

/// Models a set with all steps, and without each.
fn measure(set: &str, raw: &Raw, arguments: &Arguments, worth: &mut Worth) -> Result<(), Failure> {
    let chosen = |name: &str| arguments.step.as_ref().is_none_or(|s| name.contains(s.as_str()));
    let default = ConsensusOptions::default();
    let all = raw.observed(&Method::default())?;
    let full = all.figures(&default)?;
    worth.add_full(set, full);
    for (name, method) in methods_left_out().into_iter().filter(|(name, _)| chosen(name)) {
        let other = raw.observed(&method)?;
        let mut without = other.figures(&default)?;
        // The time of these rows is that of finding the curves.
        without.seconds = full.seconds * other.finding_seconds / all.finding_seconds;
        worth.add(set, name, without);
    }
    for (name, steps) in Steps::each_left_out().into_iter().filter(|(name, _)| chosen(name)) {
        let mut options = default;
        options.steps = steps;
        worth.add(set, name, all.figures(&options)?);
    }
    // Once more, which tells how far times can be trusted.
    worth.add(set, "(again)", all.figures(&default)?);
    Ok(())
}

/// The default way to find curves without smoothing, and without each step of it.
fn methods_left_out() -> [(&'static str, Method); 9] {
    let without = |leave_out: fn(&mut OnePassOptions)| {
        let mut options = OnePassOptions::default();
        leave_out(&mut options);
        Method::OnePass(options)
    };
    [
        ("grazing", without(|o| o.grazing = false)),
        ("smoothing", without(|o| o.smooth = false)),
        ("smoothing: shared_noise", without(|o| o.smoothing.shared_noise = false)),
        ("smoothing: half_resolution", without(|o| o.smoothing.half_resolution = false)),
        ("smoothing: near_planes", without(|o| o.smoothing.near_planes = false)),
        ("smoothing: wider_window", without(|o| o.smoothing.wider_window = false)),
        ("smoothing: robust_weights", without(|o| o.smoothing.robust_weights = false)),
        ("smoothing: flying_pixels", without(|o| o.smoothing.flying_pixels = false)),
        ("smoothing: fill", without(|o| o.smoothing.fill = false)),
    ]
}
