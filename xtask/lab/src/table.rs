//! Printing results to stdout.

use std::io::Write;
pub use transect_workflow::table::{Row, digits, grid};

/// Prints a line; a reader that has gone away is no error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
