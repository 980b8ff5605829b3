//! Printing results to stdout.

use std::io::Write;
use transect_workflow::table::rows;
pub use transect_workflow::table::{Row, digits};

/// Prints rows of metric, value and unit.
pub fn print(table: &[Row]) {
    say(&rows(table));
}

/// Prints a line; a reader that has gone away is no error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
