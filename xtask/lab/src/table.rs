//! Printing results to stdout.

use std::io::Write;
pub use transect_workflow::table::{Row, digits};
use transect_workflow::table::{grid, rows};

/// Prints rows of metric, value and unit.
pub fn print(table: &[Row]) {
    say(&rows(table));
}

/// Prints a Markdown table, as the documentation has them; every line has as many cells as heads.
pub fn print_grid(heads: &[&str], lines: &[Vec<String>]) {
    say(&grid(heads, lines));
}

/// Prints a line; a reader that has gone away is no error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
