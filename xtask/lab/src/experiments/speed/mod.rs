//! How fast curves are found in one image, by the number of planes, and beside other programs.

mod case;
mod others;
mod scene;

use super::lab::Lab;
use crate::failure::Failure;
use crate::table::{digits, line, say};
use case::Case;
use others::Program;

/// Options of `experiments speed`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Rows and columns of the image.
    #[arg(long, default_value_t = 1024)]
    size: usize,
    /// Numbers of planes.
    #[arg(long, value_delimiter = ',', default_values_t = [16, 256, 1024])]
    planes: Vec<usize>,
    /// How often each variant is timed; the result is the median.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
}

/// Names and figures for one number of planes.
type Column = Vec<(&'static str, f64)>;

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let Arguments { size, planes: counts, rounds } = arguments;
    let view = scene::view(*size).ok_or_else(|| Failure::because("no such view"))?;
    let (programs, missing) = Program::all(lab);
    let (mut own, mut others) = (Vec::new(), Vec::new());
    for &count in counts {
        let planes = scene::planes(&view, count);
        let planes = planes.ok_or_else(|| Failure::because("no such planes"))?;
        say(&format!("{size} × {size} pixels, {count} planes"));
        own.push(Case { view: &view, planes: &planes, count, rounds: *rounds }.run()?);
        if !programs.is_empty() {
            others.push(others::compare(&programs, (&view, &planes, count), *rounds)?);
        }
    }
    table("own", "nanoseconds per pixel", (counts, &own), lab)?;
    // A table without a program would differ from the documentation's.
    match missing {
        Some(reason) => Err(reason),
        None => table("others", "multiples of the sweep's time", (counts, &others), lab),
    }
}

/// A column for each number of planes.
fn table(
    name: &str,
    what: &str,
    (counts, columns): (&[usize], &[Column]),
    lab: &Lab,
) -> Result<(), Failure> {
    let counts = counts.iter().map(|count| format!("{count} planes"));
    let heads = line(what, counts).join(" | ");
    let of_program = |(k, (name, _)): (usize, &(&str, f64))| {
        line(*name, columns.iter().filter_map(|column| Some(digits(column.get(k)?.1))))
    };
    let first = columns.first().into_iter().flatten().enumerate();
    lab.table(name, &heads, first.map(of_program))
}
