//! Printing results to stdout, in the unit that the user chose.

use crate::printable::{cell, lines};
use std::io::{self, Write};
use std::sync::OnceLock;
use transect_geometry::LengthUnit;
pub use transect_workflow::table::{Quantity, Row, digits};
use transect_workflow::table::{csv, grid, rows};

/// The unit of printed lengths; without it, one that a person can read.
static OUTPUT_UNIT: OnceLock<LengthUnit> = OnceLock::new();

/// The first error of stdout.
static FAILED: OnceLock<io::Error> = OnceLock::new();

/// Sets the unit of all lengths, areas and volumes that are printed.
pub fn set_output_unit(unit: LengthUnit) {
    let _ = OUTPUT_UNIT.set(unit);
}

/// Prints rows of metric, value and unit.
pub fn print(table: &[Row]) {
    say(&rows(&table.iter().map(shown).collect::<Vec<_>>()));
}

/// A row as it is printed.
fn shown(row: &Row) -> Row {
    let Row { metric, value, unit, .. } = row.shown(OUTPUT_UNIT.get().copied());
    Row::new(cell(&metric), cell(&value), cell(&unit))
}

/// Prints a table with a head for each column.
pub fn print_grid(heads: &[&str], lines: &[Vec<String>]) {
    let lines: Vec<Vec<String>> =
        lines.iter().map(|line| line.iter().map(|text| cell(text)).collect()).collect();
    say(&grid(heads, &lines));
}

/// Prints lines of comma separated values below their heads.
pub fn print_csv(heads: &[&str], lines: &[Vec<String>]) {
    say(&csv(heads, lines));
}

/// Prints rows of metric, value and unit as comma separated values.
pub fn print_rows_csv(table: &[Row]) {
    let shown = table.iter().map(|row| row.shown(OUTPUT_UNIT.get().copied()));
    let lines = shown.map(|row| vec![row.metric, row.value, row.unit]);
    print_csv(&["metric", "value", "unit"], &lines.collect::<Vec<_>>());
}

/// Prints a line, or several. [`written`] reports the first line that could not be written.
pub fn say(line: &str) {
    if let Err(error) = writeln!(io::stdout(), "{}", lines(line)) {
        let _ = FAILED.set(error);
    }
}

/// Whether everything printed reached stdout.
pub fn written() -> io::Result<()> {
    let flushed = io::stdout().flush();
    FAILED.get().map_or(flushed, |error| Err(io::Error::new(error.kind(), error.to_string())))
}

/// A length with its unit, as text.
pub fn length(value: f64, unit: LengthUnit) -> String {
    Quantity::new(value, unit, 1).shown(OUTPUT_UNIT.get().copied()).join(" ")
}

/// Significant digits of numbers for programs. No unit. Theory: numbers keep 15 to 17 digits, of
/// which sums and products spoil the last ones, and 12 digits tell a micrometre in 1000 km.
/// Doubled, 0.2537 prints as 0.25370000000000004.
const SIGNIFICANT: usize = 12;

/// A number in at most [`SIGNIFICANT`] digits, without zeros behind them.
fn for_programs(number: f64) -> String {
    let rounded = format!("{number:.*e}", SIGNIFICANT - 1).parse().unwrap_or(number);
    // A sum of nothing may be -0.
    (rounded + 0.0).to_string()
}

/// The lengths of one table, all in one unit.
#[derive(Debug, Clone, Copy)]
pub struct Lengths {
    own: LengthUnit,
    /// The unit to print.
    pub unit: LengthUnit,
}

impl Lengths {
    /// Lengths in a model's unit. The unit to print is chosen for the largest of them.
    pub fn new(own: LengthUnit, largest: f64) -> Self {
        Self::of(&Quantity::new(largest, own, 1))
    }

    /// Lengths, areas or volumes, the largest of which is given.
    pub fn of(largest: &Quantity) -> Self {
        let readable = || largest.readable_unit();
        Self { own: largest.unit(), unit: OUTPUT_UNIT.get().copied().unwrap_or_else(readable) }
    }

    /// Lengths for other programs: in the unit that the user chose, else in the model's.
    pub fn for_programs(own: LengthUnit) -> Self {
        Self { own, unit: OUTPUT_UNIT.get().copied().unwrap_or(own) }
    }

    /// A length (power 1), an area (2) or a volume (3) without its unit, for programs.
    pub fn exact(&self, value: f64, power: u8) -> String {
        for_programs(self.converted(value, power))
    }

    /// A length (power 1), an area (2) or a volume (3) in the unit to print.
    pub fn converted(&self, value: f64, power: u8) -> f64 {
        Quantity::new(value, self.own, power).in_unit(self.unit)
    }

    /// A length (power 1), an area (2) or a volume (3) as text without its unit.
    pub fn digits(&self, value: f64, power: u8) -> String {
        digits(Quantity::new(value, self.own, power).in_unit(self.unit))
    }

    /// A coordinate or a station as text without its unit: with four digits, and to a tenth of a
    /// millimetre at least, since far from the origin four digits tell no places apart.
    pub fn coordinate(&self, value: f64) -> String {
        let least = (self.unit.in_metres() / 1e-4).log10().ceil().max(0.0) as usize;
        let text = self.digits(value, 1);
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        if decimals >= least {
            return text;
        }
        format!("{:.least$}", Quantity::new(value, self.own, 1).in_unit(self.unit))
    }

    /// A place as text without its unit.
    pub fn place(&self, place: &transect_geometry::Point3) -> String {
        <[f64; 3]>::from(place.coords).map(|c| self.coordinate(c)).join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_get_no_digits_of_rounding() {
        let numbers =
            [0.1 * 3.0, 0.253_700_000_000_000_04, 2_600_001.250_01, -0.0, 1e-9, 1.0 / 3.0];
        let wanted = ["0.3", "0.2537", "2600001.25001", "0", "0.000000001", "0.333333333333"];
        assert_eq!(numbers.map(for_programs), wanted);
    }

    #[test]
    fn coordinates_far_from_the_origin_are_told_apart() {
        let own = LengthUnit::Metre;
        let shown = |unit, value| Lengths { own, unit }.coordinate(value);
        assert_eq!(shown(LengthUnit::Metre, 2_600_001.25), "2600001.2500");
        assert_eq!(shown(LengthUnit::Metre, 400.05), "400.0500");
        assert_eq!(shown(LengthUnit::Metre, 0.012_5), "0.01250");
        assert_eq!(shown(LengthUnit::Millimetre, 1.234_56), "1234.6");
    }
}
