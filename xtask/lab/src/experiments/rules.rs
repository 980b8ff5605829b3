//! A drawn example of each pattern and of each fork of Table 5.1.

use crate::failure::Failure;
use crate::table::say;
use std::path::PathBuf;
use transect_exchange::write_file;
use transect_workflow::explain::rule_figures;

/// Options of `experiments rules`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder to draw into.
    #[arg(long, default_value = "docs/images/rules", value_name = "DIR")]
    out: PathBuf,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let out = &arguments.out;
    std::fs::create_dir_all(out).map_err(|e| Failure::with_file(out, e))?;
    let figures = rule_figures().ok_or_else(|| Failure::because("a rule has no example"))?;
    for (name, figure) in &figures {
        write_file(&out.join(format!("{name}.svg")), |file| figure.write(file))?;
    }
    say(&format!("{} figures in {}", figures.len(), out.display()));
    Ok(())
}
