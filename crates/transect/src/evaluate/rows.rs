//! Figures as rows of a table.

use super::{Accuracy, Duplication};
use serde::Serialize;
use transect_geometry::LengthUnit;

/// A line of a table of results.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// The quantity, in a few words.
    pub metric: String,
    /// Its value as text: lengths with four digits, shares in per cent, `none` if it is not known.
    pub value: String,
    /// Its unit; empty for counts, texts and quantities that are not known.
    pub unit: String,
}

impl Row {
    /// A line from its three parts.
    pub fn new(
        metric: impl Into<String>,
        value: impl Into<String>,
        unit: impl Into<String>,
    ) -> Self {
        Self { metric: metric.into(), value: value.into(), unit: unit.into() }
    }

    /// A line without a unit: a count or a text.
    pub fn plain(metric: impl Into<String>, value: impl ToString) -> Self {
        Self::new(metric, value.to_string(), "")
    }

    fn length(metric: &str, length: impl Into<Option<f64>>, unit: LengthUnit) -> Self {
        let shown = |length| Self::new(metric, digits(length), unit.symbol());
        length.into().map_or(Self::plain(metric, "none"), shown)
    }

    fn share(metric: &str, share: Option<f64>) -> Self {
        let shown = |share: f64| Self::new(metric, format!("{:.2}", 100.0 * share), "%");
        share.map_or(Self::plain(metric, "none"), shown)
    }
}

impl Accuracy {
    /// The figures as table rows, most important first; `unit` is the unit of their lengths.
    pub fn rows(&self, unit: LengthUnit) -> Vec<Row> {
        let mut rows = self.agreement_rows(unit);
        rows.extend([
            Row::share("planes with closed curves only", self.planes_closed_only),
            Row::share("planes with the true loops", self.planes_same_loops),
            Row::plain("planes with truth", self.planes_with_truth),
            Row::plain("curves", self.pieces),
            Row::plain("closed curves", self.closed),
            Row::plain("open curves", self.open),
            Row::plain("curves of the truth", self.truth_pieces),
            Row::plain("nodes", self.vertices),
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
            rows.push(Row::plain("curves expected from what was seen", self.expected_pieces));
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
            Row::plain("curves", self.pieces),
            Row::plain("closed curves", self.closed),
            Row::plain("open curves", self.open),
            Row::plain("nodes", self.vertices),
            Row::length("length", self.length, unit),
        ]
    }
}

/// A number with four significant digits, or as many as its whole part has; no exponent.
pub fn digits(value: f64) -> String {
    // Lengths below 1e-12 of any unit are rounding.
    const MOST_DECIMALS: i32 = 12;
    if !value.is_finite() || value == 0.0 {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    let decimals = (3 - magnitude).clamp(0, MOST_DECIMALS) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_show_four_digits_and_no_exponent() {
        let shown = [34457.92, 34.457_92, 0.5, 3.2433e-5, 0.0].map(digits);
        assert_eq!(shown, ["34458", "34.46", "0.5000", "0.00003243", "0"]);
    }

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!(digits(0.000_123_456), "0.0001235");
        assert_eq!(digits(12.3456), "12.35");
        assert_eq!(digits(123_456.7), "123457");
        assert_eq!(digits(0.0), "0");
        assert_eq!(digits(f64::INFINITY), "inf");
    }

    #[test]
    fn figures_carry_their_unit_and_missing_ones_none() {
        let length = Row::length("length", 2.5, LengthUnit::Inch);
        assert_eq!(length, Row::new("length", "2.500", "in"));
        assert_eq!(Row::share("off", Some(0.012_34)), Row::new("off", "1.23", "%"));
        assert_eq!(Row::share("off", None), Row::new("off", "none", ""));
        assert_eq!(Row::plain("curves", 7), Row::new("curves", "7", ""));
    }
}
