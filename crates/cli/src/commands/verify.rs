//! `transect verify`: checks a model or a model store: checksums and contents.

use crate::failure::Failure;
use crate::table::{Row, print};
use std::path::{Path, PathBuf};
use transect::Grower;
use transect_model::store::{Store, Verification};
use transect_workflow::{ModelFile, OpenStore, setup_of};

/// Options of `verify`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store, model file, or folder that `reconstruct` wrote.
    file: PathBuf,
    /// Fuse every plane of a store again and compare.
    #[arg(long)]
    fusion: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.file;
    match ModelFile::open_unfinished(path)? {
        ModelFile::Plain(_) if arguments.fusion => {
            let problem = "--fusion fuses the curves of the views again, and a plain model file \
                           does not keep them; leave out --fusion, or make a model store: \
                           reconstruct SCAN --store FILE";
            return Err(Failure::with_file(path, problem));
        }
        ModelFile::Plain(model) => print(&[
            Row::new("sound", "yes", ""),
            Row::plain("views", model.views().len()),
            Row::plain("planes", model.sections().len()),
            Row::plain("curves", model.curve_count()),
            Row::plain("nodes", model.node_count()),
            Row::plain("crossings", model.crossing_count()),
        ]),
        ModelFile::Store(OpenStore { snapshot, mut store, .. }) => {
            // Verifying needs the store alone.
            drop(snapshot);
            let found = store.verify()?;
            let fused = if arguments.fusion { fuse_again(path, &store)? } else { None };
            print(&rows(&found).into_iter().chain(fused).collect::<Vec<_>>());
            if found.pending > 0 {
                eprintln!(
                    "note: an interrupted run left {} planes to be fused, whose curves are not counted. \
                     The next change of the store fuses them; other commands fuse them in memory",
                    found.pending
                );
            }
        }
    }
    Ok(())
}

fn rows(found: &Verification) -> Vec<Row> {
    vec![
        Row::new("sound", "yes", ""),
        Row::plain("views", found.views),
        Row::plain("planes", found.planes),
        Row::plain("planes still to be fused", found.pending),
        Row::plain("curves of all views", found.partial_curves),
        Row::plain("nodes of all views", found.partial_nodes),
        Row::plain("curves", found.curves),
        Row::plain("nodes", found.nodes),
        Row::plain("crossings", found.crossings),
        Row::new("hash of the contents", format!("{:016x}", found.hash), ""),
    ]
}

fn fuse_again(path: &Path, store: &Store) -> Result<Option<Row>, Failure> {
    let setup = setup_of(path, store.read()?.header())?;
    let stale = Grower::new(store, &setup)?.stale_planes()?;
    if stale.is_empty() {
        return Ok(Some(Row::new("fused again", "the same", "")));
    }
    let names: Vec<String> = stale.iter().take(20).map(ToString::to_string).collect();
    let reason = format!(
        "fusing again gives other curves on {} planes ({}): another version of the program fused \
         them, or their lines were edited before import",
        stale.len(),
        names.join(", ")
    );
    Err(Failure::with_file(path, reason))
}
