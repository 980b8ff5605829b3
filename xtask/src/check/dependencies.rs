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

/// A row of a table.
struct Row<'a> {
    line: usize,
    /// The heading above the table.
    heading: &'a str,
    cells: Vec<&'a str>,
}

/// The rows of the tables of a page that have these heads.
fn rows<'a>(text: &'a str, heads: &[&str]) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    let (mut heading, mut is_wanted, mut is_head) = ("", false, true);
    for (line, number) in text.lines().zip(1..) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if !line.starts_with('|') {
            is_head = true;
            heading = line.strip_prefix("## ").unwrap_or(heading);
        } else if is_head {
            is_head = false;
            is_wanted = cells.starts_with(heads);
        } else if is_wanted && !line.starts_with("|--") {
            rows.push(Row { line: number, heading, cells });
        }
    }
    rows
}

/// The names in backquotes in a cell.
fn names(cell: &str) -> Names {
    cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// What each row of a table has to name in each column behind the first, by the row's first cell.
type Expected = BTreeMap<String, Vec<Names>>;

/// Holds the rows of tables with these heads against what they have to be. `key` makes the name of
/// a row.
fn compare(
    page: &TextFile,
    heads: &[&str],
    mut expected: Expected,
    key: impl Fn(&Row) -> String,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut last = 1;
    for row in rows(&page.text, heads) {
        let name = key(&row);
        last = row.line;
        let Some(columns) = expected.remove(&name) else {
            let message = format!("{name}: no Cargo file asks for this row; remove it");
            findings.push(page.finding(row.line, message));
            continue;
        };
        for ((head, cell), wanted) in heads.iter().zip(&row.cells).skip(1).zip(columns) {
            let found = names(cell);
            if found != wanted {
                let message = format!(
                    "{name}, column \"{head}\": found {found:?}, but the Cargo files say {wanted:?}"
                );
                findings.push(page.finding(row.line, message));
            }
        }
    }
    findings.extend(expected.into_iter().map(|(name, columns)| {
        let row = format!("add {name} with {columns:?} to the table {heads:?}");
        page.finding(last, format!("a row is missing; {row}"))
    }));
    findings
}

/// Holds the tables of crates against the Cargo files.
fn check_crates(page: &TextFile, manifests: &Manifests) -> Vec<Finding> {
    let ours = |names: &Names| {
        let folders = names.iter().map(|name| name.trim_start_matches("transect-").to_owned());
        folders.filter(|folder| manifests.contains_key(folder)).collect::<Names>()
    };
    let columns = |m: &Manifest| vec![ours(&m.normal), ours(&m.in_tests)];
    let graph = manifests.iter().map(|(name, manifest)| (name.clone(), columns(manifest)));
    let knowledge = manifests.keys().map(|name| (name.clone(), Vec::new()));
    let key = |row: &Row| row.cells[0].trim_matches('`').to_owned();
    let heads = ["crate", "depends on", "in its tests also"];
    let mut findings = compare(page, &heads, graph.collect(), key);
    findings.extend(compare(page, &["crate", "knows"], knowledge.collect(), key));
    findings
}

/// Holds the tables of packages from outside against the Cargo files and the lock file.
fn check_packages(page: &TextFile, manifests: &Manifests, lock: &str) -> Vec<Finding> {
    let mut expected = Expected::new();
    for (name, manifest) in manifests {
        let in_tests = manifest.in_tests.iter().map(|package| format!("{package} in tests"));
        for package in manifest.normal.iter().cloned().chain(in_tests) {
            if !package.starts_with("transect") {
                let columns = expected.entry(package).or_insert_with(|| vec![Names::new()]);
                columns[0].insert(name.clone());
            }
        }
    }
    let heads = ["dependency", "used by"];
    let mut findings = compare(page, &heads, expected, |row| {
        let package = row.cells[0].split(' ').next().unwrap_or_default();
        let place = if row.heading == "In tests" { " in tests" } else { "" };
        format!("{package}{place}")
    });
    for row in rows(&page.text, &heads) {
        let (package, version) = row.cells[0].split_once(' ').unwrap_or_default();
        let entry = format!("name = \"{package}\"\nversion = \"{version}");
        // Some versions have a suffix that says nothing about their age, such as +spec-1.1.0.
        if !["\"", "+"].iter().any(|end| lock.contains(&format!("{entry}{end}"))) {
            let message = format!("Cargo.lock has no {}; write its version", row.cells[0]);
            findings.push(page.finding(row.line, message));
        }
    }
    findings
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
        let message = "docs/page.md:3: device, column \"depends on\": found {\"scene\"}, but the \
                       Cargo files say {}";
        assert_eq!(crates(&wrong), [message]);
        let missing = CRATES.replace("| `device` | `scene` |", "| `device` | |");
        let message = "docs/page.md:4: partial, column \"in its tests also\": found {}, but the \
                       Cargo files say {\"scene\"}";
        assert_eq!(crates(&missing), [message]);
    }

    #[test]
    fn missing_and_superfluous_rows_of_crates_are_found() {
        let missing = crates(&CRATES.replace("| `scene` | | |\n", ""));
        assert_eq!(missing.len(), 1);
        assert!(missing[0].starts_with("docs/page.md:4: a row is missing; add scene with"));
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
        let message = "docs/page.md:11: proptest in tests, column \"used by\": found {\"scene\"}, \
                       but the Cargo files say {\"partial\"}";
        assert_eq!(packages(&PACKAGES.replace("0 | `partial` |", "0 | `scene` |")), [message]);
        let message = "docs/page.md:5: Cargo.lock has no nalgebra 0.34.0; write its version";
        assert_eq!(packages(&PACKAGES.replace("0.35.0", "0.34.0")), [message]);
        let moved = packages(&PACKAGES.replace("## In tests", "## Elsewhere"));
        assert_eq!(moved.len(), 2, "one row too many and one too few: {moved:?}");
    }

    #[test]
    fn missing_and_superfluous_rows_of_packages_are_found() {
        let row = "| nalgebra 0.35.0 | `device`, `partial` |\n";
        let missing = packages(&PACKAGES.replace(row, ""));
        assert_eq!(missing.len(), 1);
        assert!(
            missing[0].contains("add nalgebra with [{\"device\", \"partial\"}]"),
            "{missing:?}"
        );
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
