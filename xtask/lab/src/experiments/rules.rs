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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use transect_fusion::pattern::{Fork, Pattern};

    /// The drawings of docs/overlap-rules.md are those that the code makes, and all are shown.
    #[test]
    fn the_drawings_of_the_page_are_those_of_the_code() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        let page = std::fs::read_to_string(docs.join("overlap-rules.md")).unwrap();
        let figures = rule_figures().unwrap();
        assert_eq!(figures.len(), Pattern::ALL.len() + Fork::ALL.len() + 1);
        for (name, figure) in figures {
            let file = format!("images/rules/{name}.svg");
            let mut drawn = Vec::new();
            figure.write(&mut drawn).unwrap();
            let there = std::fs::read(docs.join(&file)).unwrap_or_default();
            let help = "run: cargo xtask experiments rules";
            assert!(there == drawn, "docs/{file} is not what the code draws; {help}");
            assert!(page.contains(&format!("]({file})")), "overlap-rules.md does not show {file}");
        }
    }
}
