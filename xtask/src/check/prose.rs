//! Prose of the documentation and comments wrap at 100 columns.

use super::finding::{Finding, TextFile, files, report};
use crate::run::Failure;
use std::path::Path;

/// Longest line of prose, in characters; `rustfmt.toml` holds code to the same width.
const COLUMNS: usize = 100;

/// Checks every Markdown page, and the comments of every Rust file.
pub fn run(root: &Path) -> Result<(), Failure> {
    report(files(root, "", &[".md", ".rs"])?.iter().flat_map(check).collect())
}

/// The lines of one file that are too long.
fn check(file: &TextFile) -> Vec<Finding> {
    let is_rust = file.name.ends_with(".rs");
    let mut is_in_fence = false;
    let mut findings = Vec::new();
    for (index, line) in file.text.lines().enumerate() {
        let prose = if is_rust { comment(line) } else { Some(line) };
        let Some(prose) = prose.map(str::trim) else {
            is_in_fence = false;
            continue;
        };
        if prose.starts_with("```") || prose.starts_with("~~~") {
            is_in_fence = !is_in_fence;
        }
        let columns = line.chars().count();
        if columns > COLUMNS && !is_in_fence && can_be_wrapped(prose) {
            let message = format!("{columns} columns; wrap the text at {COLUMNS}");
            findings.push(file.finding(index + 1, message));
        }
    }
    findings
}

/// The text of a comment, on a line of its own or behind code.
fn comment(line: &str) -> Option<&str> {
    if let Some(text) = line.trim_start().strip_prefix("//") {
        return Some(text.trim_start_matches(['/', '!']));
    }
    // What follows a quotation mark could be inside a string.
    let (_, text) = line.rsplit_once(" // ")?;
    (!text.contains('"')).then_some(text)
}

/// Whether a line break can go into the text: not in tables, headings, images, comments and single
/// links.
fn can_be_wrapped(prose: &str) -> bool {
    let is_block = ["|", "#", "![", "<!--"].iter().any(|start| prose.starts_with(start));
    let text = prose.trim_start_matches(['*', '-', '>', ' ']);
    let is_link = text.starts_with('[') && text.matches("](").count() == 1 && text.ends_with(')')
        || text.starts_with('[') && text.contains("]: ");
    !is_block && !is_link && text.contains(' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(name: &str, text: &str) -> Vec<usize> {
        let file = TextFile { name: name.into(), text: text.into() };
        check(&file).iter().map(|finding| finding.line).collect()
    }

    /// A text of so many columns made of short words.
    fn words(columns: usize) -> String {
        "word ".repeat(30).chars().take(columns - 1).chain(['.']).collect()
    }

    #[test]
    fn long_prose_is_found_with_its_line() {
        let page = format!("# Title\n\n{}\n{}\n* {}\n", words(100), words(101), words(101));
        assert_eq!(lines("page.md", &page), [4, 5]);
        let message = &check(&TextFile { name: "page.md".into(), text: page })[0].to_string();
        assert_eq!(message, "page.md:4: 101 columns; wrap the text at 100");
    }

    #[test]
    fn columns_are_characters_not_bytes() {
        assert_eq!(lines("page.md", &"ä ".repeat(50)), Vec::<usize>::new());
        assert_eq!(lines("page.md", &"ä ".repeat(51)), [1]);
    }

    #[test]
    fn blocks_that_cannot_be_wrapped_are_left_alone() {
        let long = words(120);
        let fence = format!("```sh\n{long}\n```\n");
        let link = format!("[a text]({})", "x".repeat(120));
        for good in [
            fence.as_str(),
            &format!("| {long} |"),
            &format!("## {long}"),
            &format!("![{long}](room.svg)"),
            &format!("* {link}"),
            &format!("[name]: {}", "x".repeat(120)),
            &"x".repeat(120),
        ] {
            assert_eq!(lines("page.md", good), Vec::<usize>::new(), "{good}");
        }
        assert_eq!(lines("page.md", &format!("{fence}{long}")), [4]);
        assert_eq!(lines("page.md", &format!("See {link} for more.")), [1]);
    }

    #[test]
    fn only_comments_of_rust_files_are_looked_at() {
        let long = words(120);
        let code = format!("/// {long}\nlet x = \"{long}\";\n// {long}\n//! {long}\n");
        assert_eq!(lines("lib.rs", &code), [1, 3, 4]);
        assert_eq!(lines("lib.rs", &format!("let x = 1; // {long}")), [1]);
        assert_eq!(lines("lib.rs", &format!("let x = \"{long} // {long}\";")), Vec::<usize>::new());
    }

    #[test]
    fn a_fence_in_a_comment_ends_with_the_comment() {
        let text = format!("/// ```\n/// {0}\nfn f() {{}}\n/// {0}\n", words(120));
        assert_eq!(lines("lib.rs", &text), [4]);
    }
}
