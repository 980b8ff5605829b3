//! Libraries name settings in their messages, which the program prints as options.

use super::common::Folder;
use std::collections::BTreeSet;
use std::path::Path;

/// Adds the names of the settings that the messages of a folder's sources name.
fn collect(folder: &Path, names: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, names);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            // A text may go on in the next line.
            let text = text.replace("\\\n", " ").split_whitespace().collect::<Vec<_>>().join(" ");
            let named = text.split("the setting `").skip(1).filter_map(|part| part.split_once('`'));
            let is_name = |name: &&str| name.bytes().all(|c| c.is_ascii_lowercase() || c == b'_');
            names.extend(named.map(|(name, _)| name).filter(is_name).map(str::to_owned));
        }
    }
}

#[test]
fn settings_that_libraries_name_are_options() {
    let mut names = BTreeSet::new();
    for library in ["exchange", "register", "transect", "workflow"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(library).join("src");
        collect(&folder, &mut names);
    }
    let help = |command: &str| Folder::empty().run(command).succeeded().stdout;
    let help = help("reconstruct --help") + &help("evaluate --help");
    assert!(names.len() > 8, "{names:?}");
    for name in names {
        let option = format!("--{}", name.replace('_', "-"));
        assert!(help.contains(&option), "{name}");
    }
}
