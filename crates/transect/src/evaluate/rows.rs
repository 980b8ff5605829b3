//! Figures as rows of a table.

use super::{Accuracy, Duplication};
use serde::Serialize;
use transect_geometry::LengthUnit;

/// A line of a table of results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The quantity, in a few words.
    pub metric: String,
    /// Its value as text: lengths with four digits, shares in per cent, `none` if it is not known.
    pub value: String,
    /// Its unit; empty for counts, texts and quantities that are not known.
    pub unit: String,
    /// The value as a number, if it is a length, an area or a volume. Files do not hold it.
    #[serde(skip)]
    pub quantity: Option<Quantity>,
}

/// A length, an area or a volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    value: f64,
    unit: LengthUnit,
    power: u8,
}

impl Quantity {
    /// A length (power 1), an area (2) or a volume (3) in powers of a length unit.
    pub fn new(value: f64, unit: LengthUnit, power: u8) -> Self {
        Self { value, unit, power }
    }

    /// The length unit whose powers its number counts.
    pub fn unit(&self) -> LengthUnit {
        self.unit
    }

    /// Its number in powers of another unit.
    pub fn in_unit(&self, unit: LengthUnit) -> f64 {
        let ratio = self.unit.in_metres() / unit.in_metres();
        if unit == self.unit { self.value } else { self.value * ratio.powi(self.power.into()) }
    }

    /// Its own unit, if a person can read the number there: from 0.1 to 100 000. Otherwise the
    /// largest unit of the same system in which this holds.
    pub fn readable_unit(&self) -> LengthUnit {
        use LengthUnit::{Centimetre, Foot, Inch, Metre, Micrometre, Millimetre};
        let others: &[LengthUnit] = match (self.unit, self.power) {
            (Inch | Foot, _) => &[Foot, Inch],
            (_, 1) => &[Metre, Millimetre, Micrometre],
            _ => &[Metre, Centimetre, Millimetre],
        };
        let is_readable = |unit: &LengthUnit| (0.1..1e5).contains(&self.in_unit(*unit).abs());
        let units = [self.unit].into_iter().chain(others.iter().copied());
        units.into_iter().find(is_readable).unwrap_or(self.unit)
    }

    /// Number and unit as text, in the given unit or the readable one.
    pub fn shown(&self, unit: Option<LengthUnit>) -> [String; 2] {
        let unit = unit.unwrap_or_else(|| self.readable_unit());
        [digits(self.in_unit(unit)), format!("{unit}{}", power_mark(self.power))]
    }
}

fn power_mark(power: u8) -> &'static str {
    match power {
        2 => "²",
        3 => "³",
        _ => "",
    }
}

impl Row {
    /// A line from its three parts.
    pub fn new(
        metric: impl Into<String>,
        value: impl Into<String>,
        unit: impl Into<String>,
    ) -> Self {
        Self { metric: metric.into(), value: value.into(), unit: unit.into(), quantity: None }
    }

    /// A line with a length, an area or a volume.
    pub fn of(metric: impl Into<String>, quantity: Quantity) -> Self {
        let [value, unit] = quantity.shown(Some(quantity.unit));
        Self { quantity: Some(quantity), ..Self::new(metric, value, unit) }
    }

    /// A line with a length.
    pub fn length(metric: impl Into<String>, length: f64, unit: LengthUnit) -> Self {
        Self::of(metric, Quantity::new(length, unit, 1))
    }

    /// The line with its quantity in the given unit, or in one that a person can read.
    pub fn shown(&self, unit: Option<LengthUnit>) -> Self {
        let Some(quantity) = &self.quantity else { return self.clone() };
        let [value, unit] = quantity.shown(unit);
        Self::new(self.metric.clone(), value, unit)
    }

    /// A line without a unit: a count or a text.
    pub fn plain(metric: impl Into<String>, value: impl ToString) -> Self {
        Self::new(metric, value.to_string(), "")
    }

    fn distance(metric: &str, length: Option<f64>, unit: LengthUnit) -> Self {
        length.map_or(Self::plain(metric, "none"), |length| Self::length(metric, length, unit))
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
            Row::distance("median distance from truth", self.median, unit),
            Row::distance("95 % of distances below", self.p95, unit),
            Row::distance("largest distance", self.max, unit),
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
    if value.abs() < 0.5 * 10_f64.powi(-MOST_DECIMALS) {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
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
        assert_eq!([-0.0, -1e-13, 1e-300].map(digits), ["0", "0", "0"]);
    }

    #[test]
    fn quantities_are_shown_in_a_unit_that_people_read() {
        use LengthUnit::{Foot, Inch, Metre, Millimetre};
        for (value, unit, power, own, read) in [
            (0.000_029_8, Metre, 1, "0.00002980 m", "29.80 um"),
            (0.5, Metre, 1, "0.5000 m", "0.5000 m"),
            (0.0, Metre, 1, "0 m", "0 m"),
            (3e-9, Metre, 1, "0.000000003000 m", "0.000000003000 m"),
            (123_456.0, Millimetre, 1, "123456 mm", "123.5 m"),
            (-0.000_5, Metre, 2, "-0.0005000 m²", "-5.000 cm²"),
            (3.2e-5, Metre, 3, "0.00003200 m³", "32.00 cm³"),
            (2.5, Inch, 1, "2.500 in", "2.500 in"),
            (0.01, Foot, 1, "0.01000 ft", "0.1200 in"),
        ] {
            let quantity = Quantity::new(value, unit, power);
            assert_eq!(quantity.shown(Some(unit)).join(" "), own);
            assert_eq!(quantity.shown(None).join(" "), read);
        }
        let volume = Row::of("volume", Quantity::new(2.0, Metre, 3));
        assert_eq!(volume.shown(Some(Millimetre)), Row::new("volume", "2000000000", "mm³"));
    }

    #[test]
    fn figures_carry_their_unit_and_missing_ones_none() {
        let length = Row::length("length", 2.5, LengthUnit::Inch);
        assert_eq!(length.shown(None), Row::new("length", "2.500", "in"));
        assert_eq!(Row::share("off", Some(0.012_34)), Row::new("off", "1.23", "%"));
        assert_eq!(Row::share("off", None), Row::new("off", "none", ""));
        assert_eq!(Row::plain("curves", 7), Row::new("curves", "7", ""));
    }
}
