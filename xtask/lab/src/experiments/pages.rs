//! The tables and pictures of the documentation beside the files that experiments write.
//!
//! A comment before a table or a picture of a page names the command that makes it, and the file
//! below `transect-out/experiments`:
//!
//! ```text
//! <!-- table: experiments poses, poses/table.md -->
//! <!-- times: experiments ablation, ablation/times.md -->
//! <!-- picture: experiments posters, posters/room.svg -->
//! ```
//!
//! Times differ between machines, so only their heads and the names of their rows are compared.
//! A mark of pictures can name a folder; every picture below it is then the file of its name.

use crate::failure::Failure;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The content behind a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Table,
    Times,
    Picture,
}

/// The names of the kinds.
const KINDS: [(&str, Kind); 3] =
    [("table", Kind::Table), ("times", Kind::Times), ("picture", Kind::Picture)];

/// A comment that names a command.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Mark {
    kind: Kind,
    command: String,
    /// The file below the experiments' folder.
    file: String,
    /// Its line, counted from 0.
    line: usize,
}

/// A page of the documentation.
pub struct Page {
    file: PathBuf,
    text: String,
}

/// Writes the tables and pictures that experiments have written into the pages, and returns the
/// names of the pages and pictures that changed.
pub fn write(root: &Path, folder: &Path) -> Result<Vec<String>, Failure> {
    let mut changed = Vec::new();
    for page in Page::all(root)? {
        let mut lines: Vec<String> = page.lines().map(str::to_owned).collect();
        for mark in page.marks().iter().rev() {
            match mark.kind {
                Kind::Table | Kind::Times => {
                    if let Some(table) = mark.table(folder) {
                        lines.splice(table_below(&lines, mark.line), table);
                    }
                }
                Kind::Picture => {
                    for (shown, drawn) in page.pictures_below(mark, folder) {
                        let Ok(drawn) = std::fs::read(drawn) else { continue };
                        if std::fs::read(&shown).ok().as_ref() != Some(&drawn) {
                            let written = std::fs::write(&shown, drawn);
                            written.map_err(|e| Failure::with_file(&shown, e))?;
                            changed.push(shown.display().to_string());
                        }
                    }
                }
            }
        }
        let text = lines.join("\n") + "\n";
        if text != page.text {
            std::fs::write(&page.file, text).map_err(|e| Failure::with_file(&page.file, e))?;
            changed.push(page.file.display().to_string());
        }
    }
    Ok(changed)
}

impl Page {
    /// The README and the pages of `docs`, by name.
    pub fn all(root: &Path) -> Result<Vec<Self>, Failure> {
        let docs = root.join("docs");
        let entries = std::fs::read_dir(&docs).map_err(|e| Failure::with_file(&docs, e))?;
        let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        files.retain(|file| file.extension().is_some_and(|ending| ending == "md"));
        files.push(root.join("README.md"));
        files.sort();
        let read = |file: PathBuf| match std::fs::read_to_string(&file) {
            Ok(text) => Ok(Self { file, text }),
            Err(error) => Err(Failure::with_file(&file, error)),
        };
        files.into_iter().map(read).collect()
    }

    fn lines(&self) -> impl Iterator<Item = &str> {
        self.text.lines()
    }

    /// The marks, from the first to the last.
    fn marks(&self) -> Vec<Mark> {
        self.lines().enumerate().filter_map(|(line, text)| Mark::parse(line, text)).collect()
    }

    /// The files of the pictures in the paragraph below a mark, each with the file that its
    /// command writes.
    fn pictures_below(&self, mark: &Mark, folder: &Path) -> Vec<(PathBuf, PathBuf)> {
        let below = self.lines().skip(mark.line + 1).take_while(|text| !text.trim().is_empty());
        let below = below.collect::<Vec<_>>().join(" ");
        let targets = below.split("](").skip(1).filter_map(|text| text.split_once(')'));
        let drawn = folder.join(&mark.file);
        let files = targets.map(|(target, _)| {
            let shown = self.file.with_file_name(target);
            let drawn = match (drawn.extension(), shown.file_name()) {
                (None, Some(name)) => drawn.join(name),
                _ => drawn.clone(),
            };
            (shown, drawn)
        });
        files.collect()
    }
}

impl Mark {
    fn parse(line: usize, text: &str) -> Option<Self> {
        let comment = text.trim().strip_prefix("<!-- ")?.strip_suffix(" -->")?;
        let (kind, rest) = comment.split_once(": ")?;
        let kind = KINDS.iter().find(|(name, _)| *name == kind)?.1;
        let (command, file) = rest.rsplit_once(", ")?;
        Some(Self { kind, command: command.to_owned(), file: file.to_owned(), line })
    }

    /// The table that the mark's own command has written; other arguments make another table.
    fn table(&self, folder: &Path) -> Option<Vec<String>> {
        let text = std::fs::read_to_string(folder.join(&self.file)).ok()?;
        let mut lines = text.lines().map(str::to_owned);
        (lines.next()? == format!("<!-- {} -->", self.command)).then(|| lines.collect())
    }
}

/// The lines of the table that follows a line.
fn table_below(lines: &[impl AsRef<str>], line: usize) -> Range<usize> {
    let is_row = |k: &usize| lines.get(*k).is_some_and(|text| text.as_ref().starts_with('|'));
    let first = line + 1;
    first..(first..).find(|k| !is_row(k)).unwrap_or(first)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

    impl Page {
        /// The commands of the marks and of the text, without `cargo xtask`, with their page.
        pub fn commands_of_the_lab() -> Vec<(PathBuf, String)> {
            let mut commands = Vec::new();
            for page in Page::all(ROOT.as_ref()).unwrap() {
                let quoted = page.text.split('`').skip(1).step_by(2);
                let quoted = quoted.flat_map(|text| match text.strip_prefix("sh\n") {
                    Some(lines) => lines.lines().map(str::to_owned).collect(),
                    None => vec![text.replace('\n', " ")],
                });
                let quoted =
                    quoted.filter_map(|c| Some(c.strip_prefix("cargo xtask ")?.to_owned()));
                let of_marks = page.marks().into_iter().map(|mark| mark.command);
                let own = quoted.chain(of_marks).filter(|command| {
                    ["experiments ", "bench "].iter().any(|start| command.starts_with(start))
                });
                commands.extend(own.map(|command| (page.file.clone(), command)));
            }
            commands
        }
    }

    fn cells(row: &str) -> Vec<&str> {
        row.trim().trim_matches('|').split('|').map(str::trim).collect()
    }

    /// Whether cells agree: numbers may differ by one in the last digit of the page.
    fn agree(page: &str, file: &str) -> bool {
        let words = |cell: &str| cell.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let agree = |(page, file): (&String, &String)| {
            let decimals = page.split_once('.').map_or(0, |(_, digits)| digits.len());
            let digit = 10_f64.powi(-i32::try_from(decimals).unwrap());
            let near = |a: f64, b: f64| !page.contains('e') && (a - b).abs() < 1.001 * digit;
            page == file || matches!((page.parse(), file.parse()), (Ok(a), Ok(b)) if near(a, b))
        };
        let (page, file) = (words(page), words(file));
        page.len() == file.len() && page.iter().zip(&file).all(agree)
    }

    /// The first difference between a page's table and a written one.
    fn difference(kind: Kind, page: &[&str], file: &[String]) -> Option<String> {
        if page.len() != file.len() {
            return Some(format!("{} rows, and the file has {}", page.len(), file.len()));
        }
        // Dashes below the heads say nothing.
        let rows = page.iter().zip(file).enumerate().filter(|(k, _)| *k != 1);
        let differ = |(k, (page, file)): (usize, (&&str, &String))| {
            let (a, b) = (cells(page), cells(file));
            let compared = if kind == Kind::Times && k > 0 { 1 } else { a.len().max(b.len()) };
            let cell = |row: &[&str], k: usize| row.get(k).copied().unwrap_or_default().to_owned();
            let differ = |k: &usize| !agree(&cell(&a, *k), &cell(&b, *k));
            let place = (0..compared).find(differ)?;
            Some(format!("{:?}, and the file has {:?}", cell(&a, place), cell(&b, place)))
        };
        rows.into_iter().find_map(differ)
    }

    /// Whether a table states figures: half of its cells but the first ones begin with a number.
    fn has_figures(table: &[&str]) -> bool {
        let is_figure = |cell: &&str| {
            cell.trim_start_matches(['*', '+', '-', '.']).starts_with(|c: char| c.is_ascii_digit())
        };
        let body = table.iter().skip(2).flat_map(|row| cells(row).into_iter().skip(1));
        let body: Vec<&str> = body.collect();
        2 * body.iter().filter(|c| is_figure(c)).count() > body.len()
    }

    #[test]
    fn tables_and_pictures_are_those_that_the_commands_made() {
        let folder = Path::new(ROOT).join(super::super::DEFAULT_FOLDER);
        let mut found = Vec::new();
        for page in Page::all(ROOT.as_ref()).unwrap() {
            let lines: Vec<&str> = page.lines().collect();
            for mark in page.marks() {
                let differs = match mark.kind {
                    Kind::Picture => {
                        let files = page.pictures_below(&mark, &folder);
                        assert!(!files.is_empty(), "{}: no picture", mark.file);
                        let differ = |(shown, drawn): &(PathBuf, PathBuf)| {
                            let shown = std::fs::read(shown).expect("a picture's file");
                            std::fs::read(drawn).is_ok_and(|drawn| drawn != shown)
                        };
                        let other = files.iter().find(|files| differ(files));
                        other.map(|(shown, _)| format!("{} has other bytes", shown.display()))
                    }
                    kind => mark.table(&folder).and_then(|file| {
                        difference(kind, &lines[table_below(&lines, mark.line)], &file)
                    }),
                };
                let place = format!("{}:{}", page.file.display(), mark.line + 1);
                found.extend(differs.map(|what| format!("{place}: {}: {what}", mark.file)));
            }
        }
        let help = "run the commands again with --write-docs";
        assert!(found.is_empty(), "{help}:\n{}", found.join("\n"));
    }

    #[test]
    fn every_table_of_figures_and_every_picture_has_its_command() {
        let mut found = Vec::new();
        for page in Page::all(ROOT.as_ref()).unwrap() {
            for paragraph in page.text.split("\n\n") {
                let table: Vec<&str> =
                    paragraph.lines().filter(|line| line.starts_with('|')).collect();
                let has_picture =
                    paragraph.contains("](images/") || paragraph.contains("](docs/images/");
                let needs = has_figures(&table) || has_picture;
                let mut marks = paragraph.lines().filter_map(|text| Mark::parse(0, text));
                if needs && marks.next().is_none() {
                    let first: String = paragraph.chars().take(60).collect();
                    found.push(format!("{}: {first}", page.file.display()));
                }
            }
        }
        let help = "name the command in a comment above: see xtask/lab/src/experiments/pages.rs";
        assert!(found.is_empty(), "{help}:\n{}", found.join("\n"));
    }

    #[test]
    fn marks_are_read_and_tables_compared() {
        let mark =
            Mark::parse(4, "<!-- table: experiments poses --full, poses/table.md -->").unwrap();
        assert_eq!((mark.kind, mark.command.as_str()), (Kind::Table, "experiments poses --full"));
        assert_eq!(mark.file, "poses/table.md");
        let page = ["| a | b |", "|---|---|", "| x | 1.25 mm |"];
        let file = |row: &str| [page[0], page[1], row].map(str::to_owned);
        assert_eq!(difference(Kind::Table, &page, &file("| x   | 1.26 mm |")), None);
        let other = difference(Kind::Table, &page, &file("| x | 1.27 mm |")).unwrap();
        assert_eq!(other, "\"1.25 mm\", and the file has \"1.27 mm\"");
        assert_eq!(difference(Kind::Times, &page, &file("| x | 9 s |")), None);
        assert!(difference(Kind::Times, &page, &file("| y | 1.25 mm |")).is_some());
        assert!(difference(Kind::Table, &page, &file("| x | 1.25 mm | 3 |")).is_some());
    }
}
