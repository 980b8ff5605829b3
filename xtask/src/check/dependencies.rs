//! The tables of dependencies in the documentation equal the Cargo files.

use super::finding::{Finding, TextFile, files, read, report};
use crate::run::Failure;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The page with the table of which crate depends on which.
const ARCHITECTURE: &str = "docs/architecture.md";
/// The page with every dependency from outside.
const DEPENDENCIES: &str = "docs/dependencies.md";

type Names = BTreeSet<String>;

/// The Cargo files of the workspace by the folders of their crates.
type Manifests = BTreeMap<String, Manifest>;

/// The dependencies of one crate.
#[derive(Debug, Default)]
struct Manifest {
    normal: Names,
    /// Those of the tests that are not among the normal ones.
    in_tests: Names,
}

/// Checks both pages against the Cargo files of all crates.
pub fn run(root: &Path) -> Result<(), Failure> {
    let manifests: Manifests = files(root, "", &["/Cargo.toml"])?
        .iter()
        .filter_map(|file| Some((folder_of_crate(&file.name)?, manifest(&file.text))))
        .collect();
    let lock = read(root, "Cargo.lock")?.text;
    let mut findings = check_crates(&read(root, ARCHITECTURE)?, &manifests);
    findings.extend(check_packages(&read(root, DEPENDENCIES)?, &manifests, &lock));
    report(findings)
}

/// `geometry` for `crates/geometry/Cargo.toml`, `xtask/lab` for `xtask/lab/Cargo.toml`.
fn folder_of_crate(file: &str) -> Option<String> {
    let folder = file.strip_suffix("/Cargo.toml")?;
    let Some(name) = folder.strip_prefix("crates/") else { return Some(folder.to_owned()) };
    (!name.contains('/')).then(|| name.to_owned())
}

/// Reads the names in the dependency sections of a Cargo file.
fn manifest(text: &str) -> Manifest {
    let mut manifest = Manifest::default();
    let mut section = "";
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line.trim_matches(['[', ']']);
        } else if let Some((key, _)) = line.split_once('=').filter(|_| !line.starts_with('#')) {
            let name = key.split('.').next().unwrap_or(key).trim().trim_matches('"').to_owned();
            if section.ends_with("dev-dependencies") {
                manifest.in_tests.insert(name);
            } else if section.ends_with("dependencies") {
                manifest.normal.insert(name);
            }
        }
    }
    manifest.in_tests.retain(|name| !manifest.normal.contains(name));
    manifest
}

/// The rows that a table must have by their keys, each with the texts it may begin with.
type Expected = BTreeMap<String, Vec<String>>;

/// The beginning of a row: its first cell, and the cells with the names that follow.
fn row(first: &str, columns: &[&Names]) -> String {
    let cell = |names: &&Names| match names.iter().map(|name| format!("`{name}`")) {
        quoted if quoted.len() > 0 => format!(" {} |", quoted.collect::<Vec<_>>().join(", ")),
        _ => " |".to_owned(),
    };
    format!("| {first} |{}", columns.iter().map(cell).collect::<String>())
}

/// The rows of the tables whose head begins so, with their lines and keys. The key is the first
/// word of the row, with its place below the heading `In tests`.
fn rows<'a>(text: &'a str, head: &str) -> Vec<(usize, String, &'a str)> {
    let mut rows = Vec::new();
    let (mut place, mut is_wanted) = ("", false);
    for (line, number) in text.lines().zip(1..) {
        if let Some(heading) = line.strip_prefix("## ") {
            place = if heading == "In tests" { " in tests" } else { "" };
        }
        if line.starts_with(head) || !line.starts_with('|') {
            is_wanted = line.starts_with(head);
        } else if is_wanted && !line.starts_with("|--") {
            let word = line.split(['|', ' ', '`']).find(|word| !word.is_empty());
            rows.push((number, format!("{}{place}", word.unwrap_or_default()), line));
        }
    }
    rows
}

/// Holds the rows of the tables whose head begins so against what they have to be.
fn compare(page: &TextFile, head: &str, mut expected: Expected) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut last = 1;
    for (line, key, text) in rows(&page.text, head) {
        last = line;
        let message = match expected.remove(&key) {
            Some(texts) if texts.iter().any(|wanted| text.starts_with(wanted)) => continue,
            Some(texts) => format!("{key}: the row must begin with {}", texts.join(" or ")),
            None => format!("{key}: no Cargo file asks for this row; remove it"),
        };
        findings.push(page.finding(line, message));
    }
    let missing = expected.into_values().map(|texts| texts.join(" or "));
    findings.extend(missing.map(|row| page.finding(last, format!("a row is missing; add {row}"))));
    findings
}

/// Holds the tables of crates against the Cargo files.
fn check_crates(page: &TextFile, manifests: &Manifests) -> Vec<Finding> {
    let ours = |names: &Names| {
        let folders = names.iter().map(|name| name.trim_start_matches("transect-").to_owned());
        folders.filter(|folder| manifests.contains_key(folder)).collect::<Names>()
    };
    let (mut graph, mut knowledge) = (Expected::new(), Expected::new());
    for (name, manifest) in manifests {
        let first = format!("`{name}`");
        let columns = [&ours(&manifest.normal), &ours(&manifest.in_tests)];
        graph.insert(name.clone(), vec![row(&first, &columns)]);
        knowledge.insert(name.clone(), vec![row(&first, &[])]);
    }
    let mut findings = compare(page, "| crate | depends on | in its tests also |", graph);
    findings.extend(compare(page, "| crate | knows |", knowledge));
    findings
}

/// Holds the tables of packages from outside against the Cargo files and the lock file.
fn check_packages(page: &TextFile, manifests: &Manifests, lock: &str) -> Vec<Finding> {
    let mut users = BTreeMap::<(&str, &str), Names>::new();
    for (name, Manifest { normal, in_tests }) in manifests {
        let all = normal.iter().map(|p| (p, "")).chain(in_tests.iter().map(|p| (p, " in tests")));
        for (package, place) in all.filter(|(package, _)| !package.starts_with("transect")) {
            users.entry((package, place)).or_default().insert(name.clone());
        }
    }
    let expected = users.into_iter().map(|((package, place), users)| {
        let entry = format!("name = \"{package}\"\nversion = \"");
        let entries = lock.split(entry.as_str()).skip(1);
        // Some versions have a suffix that says nothing about their age, such as +spec-1.1.0.
        let versions = entries.filter_map(|rest| rest.split(['"', '+']).next());
        let rows = versions.map(|version| row(&format!("{package} {version}"), &[&users]));
        (format!("{package}{place}"), rows.collect())
    });
    compare(page, "| dependency | used by |", expected.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(text: &str) -> TextFile {
        TextFile { name: "docs/page.md".into(), text: text.into() }
    }

    fn manifests() -> Manifests {
        let device =
            "[package]\nname = \"transect-device\"\n[dependencies]\nnalgebra.workspace = true\n";
        let partial = "[dependencies]\nnalgebra = { workspace = true }\n# rayon = 1\n\
                       transect-device.workspace = true\n[dev-dependencies]\n\
                       proptest.workspace = true\ntransect-device.workspace = true\n\
                       transect-scene.workspace = true\n[lints]\nworkspace = true\n";
        let scene = "[dependencies]\n";
        [("device", device), ("partial", partial), ("scene", scene)]
            .map(|(name, text)| (name.to_owned(), manifest(text)))
            .into()
    }

    const CRATES: &str = "| crate | depends on | in its tests also |\n|---|---|---|\n\
                          | `device` | | |\n| `partial` | `device` | `scene` |\n| `scene` | | |\n\n\
                          | crate | knows |\n|---|---|\n| `device` | a |\n| `partial` | b |\n\
                          | `scene` | c |\n";

    fn crates(text: &str) -> Vec<String> {
        check_crates(&page(text), &manifests()).iter().map(Finding::to_string).collect()
    }

    #[test]
    fn tables_of_crates_that_equal_the_cargo_files_are_right() {
        assert_eq!(crates(CRATES), Vec::<String>::new());
    }

    #[test]
    fn wrong_rows_of_crates_are_found() {
        let wrong = CRATES.replace("| `device` | | |", "| `device` | `scene` | |");
        let message = "docs/page.md:3: device: the row must begin with | `device` | | |";
        assert_eq!(crates(&wrong), [message]);
        let missing = CRATES.replace("| `device` | `scene` |", "| `device` | |");
        let message =
            "docs/page.md:4: partial: the row must begin with | `partial` | `device` | `scene` |";
        assert_eq!(crates(&missing), [message]);
    }

    #[test]
    fn missing_and_superfluous_rows_of_crates_are_found() {
        let missing = crates(&CRATES.replace("| `scene` | | |\n", ""));
        assert_eq!(missing, ["docs/page.md:4: a row is missing; add | `scene` | | |"]);
        let superfluous =
            crates(&CRATES.replace("| `scene` | c |", "| `scene` | c |\n| `x` | d |"));
        let message = "docs/page.md:12: x: no Cargo file asks for this row; remove it";
        assert_eq!(superfluous, [message]);
        let unknown = crates(&CRATES.replace("| `scene` | | |", "| `scene` | | |\n| `x` | | |"));
        assert_eq!(unknown, [message.replace(":12:", ":6:")]);
    }

    const PACKAGES: &str = "## In the crates\n\n| dependency | used by |\n|---|---|\n\
                            | nalgebra 0.35.0 | `device`, `partial` |\n\n## In tests\n\n\
                            | dependency | used by |\n|---|---|\n| proptest 1.12.0 | `partial` |\n";
    const LOCK: &str = "name = \"nalgebra\"\nversion = \"0.35.0\"\n\n\
                        name = \"proptest\"\nversion = \"1.12.0+suffix\"\n";

    fn packages(text: &str) -> Vec<String> {
        check_packages(&page(text), &manifests(), LOCK).iter().map(Finding::to_string).collect()
    }

    #[test]
    fn tables_of_packages_that_equal_the_cargo_files_are_right() {
        assert_eq!(packages(PACKAGES), Vec::<String>::new());
    }

    #[test]
    fn wrong_rows_of_packages_are_found() {
        let message = "docs/page.md:11: proptest in tests: the row must begin with \
                       | proptest 1.12.0 | `partial` |";
        assert_eq!(packages(&PACKAGES.replace("0 | `partial` |", "0 | `scene` |")), [message]);
        let message = "docs/page.md:5: nalgebra: the row must begin with \
                       | nalgebra 0.35.0 | `device`, `partial` |";
        assert_eq!(packages(&PACKAGES.replace("0.35.0", "0.34.0")), [message]);
        let moved = packages(&PACKAGES.replace("## In tests", "## Elsewhere"));
        assert_eq!(moved.len(), 2, "one row too many and one too few: {moved:?}");
    }

    #[test]
    fn missing_and_superfluous_rows_of_packages_are_found() {
        let row = "| nalgebra 0.35.0 | `device`, `partial` |\n";
        let missing = packages(&PACKAGES.replace(row, ""));
        let message = "docs/page.md:10: a row is missing; add \
                       | nalgebra 0.35.0 | `device`, `partial` |";
        assert_eq!(missing, [message]);
        let extra = packages(&format!("{PACKAGES}| nalgebra 0.35.0 | `partial` |\n"));
        let message =
            "docs/page.md:12: nalgebra in tests: no Cargo file asks for this row; remove it";
        assert_eq!(extra, [message]);
    }

    #[test]
    fn only_crates_of_the_workspace_are_read() {
        assert_eq!(folder_of_crate("crates/geometry/Cargo.toml").as_deref(), Some("geometry"));
        assert_eq!(folder_of_crate("xtask/lab/Cargo.toml").as_deref(), Some("xtask/lab"));
        assert_eq!(folder_of_crate("crates/model/fuzz/Cargo.toml"), None);
    }
}
