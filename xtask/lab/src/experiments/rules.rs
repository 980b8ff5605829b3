//! A drawn example of each pattern and of each fork of Table 5.1.

use super::lab::Lab;
use crate::failure::Failure;
use crate::table::say;
use transect_exchange::write_file;
use transect_workflow::explain::rule_figures;

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let folder = lab.folder()?;
    let figures = rule_figures().ok_or_else(|| Failure::because("a rule has no example"))?;
    for (name, figure) in &figures {
        write_file(&folder.join(format!("{name}.svg")), |file| figure.write(file))?;
    }
    say(&format!("{} figures in {}", figures.len(), folder.display()));
    Ok(())
}
