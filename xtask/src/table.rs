//! The table a run ends with: metric, value, unit.

use serde::Serialize;
use std::io::Write;

/// One line of a table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// What was measured or counted.
    pub metric: String,
    /// Its value, as text with a sensible number of digits.
    pub value: String,
    /// Its unit; empty for counts and texts.
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

    /// A count.
    pub fn count(metric: impl Into<String>, value: usize) -> Self {
        Self::new(metric, value.to_string(), "")
    }
}

/// A number with four significant digits, or as many as its whole part has.
pub fn digits(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    let decimals = (3 - magnitude).clamp(0, 12) as usize;
    format!("{value:.decimals$}")
}

/// Prints a table to stdout.
pub fn print(rows: &[Row]) {
    let width = |f: fn(&Row) -> &str, head: &str| {
        rows.iter().map(|r| f(r).chars().count()).chain([head.len()]).max().unwrap_or(0)
    };
    let (metric, value) = (width(|r| &r.metric, "metric"), width(|r| &r.value, "value"));
    say(&format!("{:metric$}  {:>value$}  unit", "metric", "value"));
    for r in rows {
        say(format!("{:metric$}  {:>value$}  {}", r.metric, r.value, r.unit).trim_end());
    }
}

/// Prints a line to stdout; a reader that has gone away is no error.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!(digits(0.000_123_456), "0.0001235");
        assert_eq!(digits(12.3456), "12.35");
        assert_eq!(digits(123_456.7), "123457");
        assert_eq!(digits(0.0), "0");
        assert_eq!(digits(f64::INFINITY), "inf");
    }
}
