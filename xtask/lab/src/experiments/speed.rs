//! How fast curves are found in one image, by the number of planes, and beside other programs.

use super::output::Output;
use crate::bench::partial::{Columns, columns};
use crate::failure::Failure;
use crate::table::{digits, say};

/// Rows and columns of the image.
const SIZE: usize = 1024;

/// Numbers of planes.
const PLANES: [usize; 3] = [16, 256, 1024];

/// Rounds whose median is the time of a variant.
const ROUNDS: usize = 3;

/// Runs the experiment, or tells what is skipped.
pub fn run(out: &Output) -> Result<Option<String>, Failure> {
    let [own, others] = columns(SIZE, &PLANES, ROUNDS, true)?;
    say("");
    table("own", &own, "nanoseconds per pixel", out)?;
    if others.len() < PLANES.len() {
        return Ok(Some("no Python has contourpy and GDAL; set TRANSECT_PYTHON".to_owned()));
    }
    table("others", &others, "multiples of the sweep's time", out)?;
    Ok(None)
}

fn table(name: &str, columns: &Columns, what: &str, out: &Output) -> Result<(), Failure> {
    let counts = PLANES.map(|count| format!("{count} planes"));
    let heads: Vec<&str> = std::iter::once(what).chain(counts.iter().map(String::as_str)).collect();
    let first = columns.first().into_iter().flatten().enumerate();
    let cell = |column: &Vec<(&str, f64)>, k: usize| {
        column.get(k).map_or(String::new(), |(_, figure)| digits(*figure))
    };
    let line = |(k, (name, _)): (usize, &(&str, f64))| {
        let cells = columns.iter().map(|column| cell(column, k));
        std::iter::once((*name).to_owned()).chain(cells).collect()
    };
    out.table(name, &heads, &first.map(line).collect::<Vec<_>>())
}
