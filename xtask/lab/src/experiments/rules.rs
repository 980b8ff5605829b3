//! A drawn example of each pattern and of each fork of Table 5.1.

use super::output::Output;
use crate::failure::Failure;
use crate::table::say;
use transect_exchange::write_file;
use transect_workflow::explain::rule_figures;

/// Runs the experiment.
pub fn run(out: &Output) -> Result<(), Failure> {
    let out = out.folder()?;
    let figures = rule_figures().ok_or_else(|| Failure::because("a rule has no example"))?;
    for (name, figure) in &figures {
        write_file(&out.join(format!("{name}.svg")), |file| figure.write(file))?;
    }
    say(&format!("{} figures in {}", figures.len(), out.display()));
    Ok(())
}
