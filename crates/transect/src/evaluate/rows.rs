//! Figures as rows of a table.

use super::{Accuracy, Duplication};
use serde::Serialize;
use transect_geometry::LengthUnit;

/// A line of a result table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Name of the figure, in a few words.
    pub metric: &'static str,
    /// The figure as text: lengths with four digits, shares in per cent, `none` if it is not known.
    pub value: String,
    /// Its unit; empty for counts and for figures that are not known.
    pub unit: &'static str,
}

impl Row {
    fn count(metric: &'static str, count: usize) -> Self {
        Self { metric, value: count.to_string(), unit: "" }
    }

    fn length(metric: &'static str, length: impl Into<Option<f64>>, unit: LengthUnit) -> Self {
        let none = Self { metric, value: "none".to_owned(), unit: "" };
        let shown = |length| Self { metric, value: four_digits(length), unit: unit.symbol() };
        length.into().map_or(none, shown)
    }

    fn share(metric: &'static str, share: Option<f64>) -> Self {
        let none = Self { metric, value: "none".to_owned(), unit: "" };
        share.map_or(none, |s| Self { metric, value: format!("{:.2}", 100.0 * s), unit: "%" })
    }
}

impl Accuracy {
    /// The figures as table rows, most important first; `unit` is the unit of their lengths.
    pub fn rows(&self, unit: LengthUnit) -> Vec<Row> {
        let mut rows = self.agreement_rows(unit);
        rows.extend([
            Row::share("planes with closed curves only", self.planes_closed_only),
            Row::share("planes with the true loops", self.planes_same_loops),
            Row::count("planes with truth", self.planes_with_truth),
            Row::count("curves", self.pieces),
            Row::count("closed curves", self.closed),
            Row::count("open curves", self.open),
            Row::count("curves of the truth", self.truth_pieces),
            Row::count("nodes", self.vertices),
            Row::length("length", self.length, unit),
            Row::length("length of the truth", self.truth_length, unit),
            Row::length("length on planes without truth", self.length_without_truth, unit),
        ]);
        rows
    }

    /// The first of those rows: the agreement of curves and truth, without the counts.
    pub fn agreement_rows(&self, unit: LengthUnit) -> Vec<Row> {
        let mut rows = vec![
            Row::length("median distance from truth", self.median, unit),
            Row::length("95 % of distances below", self.p95, unit),
            Row::length("largest distance", self.max, unit),
        ];
        if self.truth_seen.is_some_and(|s| s < 1.0) {
            rows.push(Row::share("truth that the views could see", self.truth_seen));
            rows.push(Row::share("completeness of that", self.completeness));
            rows.push(Row::count("curves expected from what was seen", self.expected_pieces));
        } else {
            rows.push(Row::share("completeness", self.completeness));
        }
        rows.extend([
            Row::share("length off the truth", self.off),
            Row::share("oriented like the truth", self.oriented),
            Row::share("duplicated length", self.duplicated),
        ]);
        rows
    }
}

impl Duplication {
    /// The figures as table rows; `unit` is the unit of their lengths.
    pub fn rows(&self, unit: LengthUnit) -> Vec<Row> {
        vec![
            Row::share("duplicated length", self.duplicated),
            Row::count("curves", self.pieces),
            Row::count("closed curves", self.closed),
            Row::count("open curves", self.open),
            Row::count("nodes", self.vertices),
            Row::length("length", self.length, unit),
        ]
    }
}

/// A number with four significant digits and no exponent; whole parts are kept whole.
fn four_digits(x: f64) -> String {
    // Lengths below 1e-12 of any unit are rounding.
    const MOST_DECIMALS: f64 = 12.0;
    if x == 0.0 {
        return "0".to_owned();
    }
    let decimals = (3.0 - x.abs().log10().floor()).clamp(0.0, MOST_DECIMALS) as usize;
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_show_four_digits_and_no_exponent() {
        let shown = [34457.92, 34.457_92, 0.5, 3.2433e-5, 0.0].map(four_digits);
        assert_eq!(shown, ["34458", "34.46", "0.5000", "0.00003243", "0"]);
    }

    #[test]
    fn figures_carry_their_unit_and_missing_ones_none() {
        let row = |metric, value: &str, unit| Row { metric, value: value.to_owned(), unit };
        let length = Row::length("length", 2.5, LengthUnit::Inch);
        assert_eq!(length, row("length", "2.500", "in"));
        assert_eq!(Row::share("off", Some(0.012_34)), row("off", "1.23", "%"));
        assert_eq!(Row::share("off", None), row("off", "none", ""));
        assert_eq!(Row::count("curves", 7), row("curves", "7", ""));
    }
}
