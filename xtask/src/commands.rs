//! The list of commands, and which package runs each.

/// The package that runs a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// This one.
    Launcher,
    /// `xtask-lab`: measurements for the documentation.
    Lab,
    /// `transect-cli`: the program `transect`.
    Transect,
}

/// A command of the launcher or of the lab, and what its help says.
const OWN: [(&str, Owner, &str); 4] = [
    ("test", Owner::Launcher, "Run the tests; arguments go to cargo test"),
    ("check", Owner::Launcher, "Run checks, tests and some commands; --without-tests: no tests"),
    ("experiments", Owner::Lab, "Measure the figures that the documentation states"),
    (
        "bench",
        Owner::Lab,
        "bench partial: measure the speed of finding curves, as experiments speed",
    ),
];

/// The commands of `transect`. A test of `transect-cli` compares this list with the program's help.
const TRANSECT: [(&str, &str); 19] = [
    ("reconstruct", "Make a cross-section model of a scan; without a scan, of the bundled room"),
    ("simulate", "Write a scan of a simulated scene, with its truth"),
    ("evaluate", "Score a model against a reference mesh or a simulated scan's truth"),
    ("explain", "Draw each step of the methods on one view and one plane"),
    ("explain-growth", "Draw how a plane of a scan grows view by view, by --fusion pairwise"),
    ("inspect", "List the views, sizes, noise and extent of a scan, or the contents of a model"),
    ("register", "Refine the poses of a scan, or of the views in a model store"),
    ("list-views", "List the views of a model store"),
    ("remove-view", "Remove a view from a model store"),
    ("replace-view", "Replace the image or the pose of a view in a model store"),
    ("verify", "Check the checksums and the contents of a model or a model store"),
    ("compact", "Give the space of removed views back to the disk"),
    ("query", "Tell whether points are inside the solid, outside, or unknown"),
    ("gaps", "List the surface that no view saw, and propose next views"),
    ("measure", "Print bounds of the areas of each plane of a model, and of the volumes"),
    ("export", "Write a model's curves as files for other programs, or a store as JSON lines"),
    ("import", "Make a model store from JSON lines"),
    ("align", "Find a scanner's pose from scans of the machine table and of spheres"),
    ("manifest", "Write a scan.json for a folder of depth images with poses"),
];

/// The package that runs a command; `transect` also answers for unknown ones.
pub fn owner(name: &str) -> Owner {
    OWN.iter().find(|own| own.0 == name).map_or(Owner::Transect, |own| own.1)
}

/// The help of `cargo xtask`.
pub fn help() -> String {
    let line = |(name, about): (&str, &str)| format!("  {name:12}  {about}\n");
    let user: String = TRANSECT.into_iter().map(line).collect();
    let own: String = OWN.into_iter().map(|(name, _, about)| line((name, about))).collect();
    format!(
        "Registered range images in, cross-section models out.\n\n\
         Usage: cargo xtask <COMMAND> [OPTIONS]\n\n\
         Commands of the program transect, built in release and run:\n{user}\n\
         Commands of the workspace:\n{own}\n\
         `cargo xtask <COMMAND> --help` explains a command's options."
    )
}
