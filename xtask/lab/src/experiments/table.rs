//! Tables of any width, in the form that the documentation's pages have them.

use crate::table::say;
use transect_workflow::table::grid;

/// Prints a table: its heads, then its lines; every line has as many cells as there are heads.
pub fn print(heads: &[&str], lines: &[Vec<String>]) {
    say(&grid(heads, lines));
}
