//! The index of the dissertation names files that exist, and items that they have.
//!
//! In a table of the page, names in backticks behind a link to a `.rs` file are items of that file.

use super::finding::{Finding, TextFile, read, report};
use crate::run::Failure;
use std::path::Path;

/// The page with the index.
const PAGE: &str = "docs/dissertation.md";

/// The words before the name of an item.
const KEYWORDS: [&str; 7] = ["fn", "struct", "enum", "const", "trait", "type", "mod"];

/// Checks every link and every name of the page.
pub fn run(root: &Path) -> Result<(), Failure> {
    let page = read(root, PAGE)?;
    let load = |target: &str| std::fs::read_to_string(root.join("docs").join(target)).ok();
    let is_there = |target: &str| root.join("docs").join(target).exists();
    report(check(&page, load, is_there))
}

fn check(
    page: &TextFile,
    load: impl Fn(&str) -> Option<String>,
    is_there: impl Fn(&str) -> bool,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, line) in page.text.lines().enumerate() {
        let mut say = |message: String| findings.push(page.finding(index + 1, message));
        for cell in line.split('|') {
            for (target, names) in links(cell) {
                if !is_there(target) {
                    say(format!("{target} does not exist; name the file that took its place"));
                } else if let Some(code) = load(target).filter(|_| target.ends_with(".rs")) {
                    let missing = names.iter().filter(|name| !has_item(&code, name));
                    missing.for_each(|name| say(format!("{target} has no item {name}")));
                }
            }
        }
    }
    findings
}

/// The local targets of a cell's links, each with the names in backticks before the next link.
fn links(cell: &str) -> Vec<(&str, Vec<&str>)> {
    let behind = cell.split("](").skip(1).filter_map(|text| text.split_once(')'));
    let local = behind.filter(|(target, _)| !target.contains("://") && !target.starts_with('#'));
    let names = |text| -> Vec<&str> {
        let quoted = str::split(text, '`').skip(1).step_by(2);
        quoted.filter(|name| name.chars().all(|c| c.is_alphanumeric() || c == '_')).collect()
    };
    local.map(|(target, text)| (target.split('#').next().unwrap_or(target), names(text))).collect()
}

/// Whether some code defines an item of a name.
fn has_item(code: &str, name: &str) -> bool {
    let words = |line: &str| {
        let ends = |c: char| !(c.is_alphanumeric() || c == '_');
        let words: Vec<&str> = line.split(ends).filter(|word| !word.is_empty()).collect();
        words.windows(2).any(|pair| KEYWORDS.contains(&pair[0]) && pair[1] == name)
    };
    code.lines().any(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_files_and_items_are_found_with_their_line() {
        let code = "pub fn here(a: u8) {}\nstruct There;\n// fn gone\n";
        let text = "# Index\n\
                    | a | [a.rs](../a.rs) `here` `There`<br>[b.rs](../b.rs) `x` | `transect` |\n\
                    | b | [a.rs](../a.rs#L1) `away` | [page](page.md) `any words` |\n\
                    | c | [web](https://example.org) `x` | [above](#index) |\n";
        let page = TextFile { name: PAGE.into(), text: text.into() };
        let load = |target: &str| (target == "../a.rs").then(|| code.to_owned());
        let found = check(&page, load, |target| target != "../b.rs");
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(
            found,
            [
                "docs/dissertation.md:2: ../b.rs does not exist; name the file that took its place",
                "docs/dissertation.md:3: ../a.rs has no item away",
            ]
        );
    }
}
