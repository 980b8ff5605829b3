//! Tables of any width, in the form that the documentation's pages have them.

use crate::table::say;

/// Prints a table: its heads, then its lines; every line has as many cells as there are heads.
pub fn print(heads: &[&str], lines: &[Vec<String>]) {
    let widths: Vec<usize> = (0..heads.len())
        .map(|k| {
            let cells = lines.iter().filter_map(|l| l.get(k)).map(|c| c.chars().count());
            cells.chain(heads.get(k).map(|h| h.chars().count())).max().unwrap_or(0)
        })
        .collect();
    let row = |cells: &[String]| {
        let padded = cells.iter().zip(&widths).map(|(cell, &width)| format!(" {cell:width$} |"));
        format!("|{}", padded.collect::<String>())
    };
    say(&row(&heads.iter().map(|h| (*h).to_owned()).collect::<Vec<_>>()));
    say(&format!(
        "|{}",
        widths.iter().map(|w| format!("{}|", "-".repeat(w + 2))).collect::<String>()
    ));
    lines.iter().for_each(|line| say(&row(line)));
}
