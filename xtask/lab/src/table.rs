//! Printing results to stdout.

use std::io::Write;
pub use transect_workflow::table::{Row, digits, grid};

/// A length as a cell; "none" if it is infinite.
pub fn length(length: Option<f64>) -> String {
    length.map_or("none".to_owned(), digits)
}

/// A share as a cell, in per cent.
pub fn share(share: Option<f64>) -> String {
    share.map_or("none".to_owned(), |share| format!("{:.2}", 100.0 * share))
}

/// The cells of a line that are separated by " | ".
pub fn cells(line: &str) -> Vec<String> {
    line.split(" | ").map(str::to_owned).collect()
}

/// A line of a table: its name, and its cells.
pub fn line(name: impl Into<String>, cells: impl IntoIterator<Item = String>) -> Vec<String> {
    std::iter::once(name.into()).chain(cells).collect()
}

/// Prints a line; a reader that has gone away is no error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
