//! Tables of results as text: rows of metric, value and unit, and grids for the documentation.

use serde::Serialize;

/// One line of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// The quantity.
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

    /// A line without a unit: a count or a text.
    pub fn plain(metric: impl Into<String>, value: impl ToString) -> Self {
        Self::new(metric, value.to_string(), "")
    }
}

impl From<transect::evaluate::Row> for Row {
    fn from(row: transect::evaluate::Row) -> Self {
        Self::new(row.metric, row.value, row.unit)
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

/// A table of rows, one line each below the heads "metric", "value" and "unit".
pub fn rows(rows: &[Row]) -> String {
    let width = |f: fn(&Row) -> &str, head: &str| {
        rows.iter().map(|r| f(r).chars().count()).chain([head.len()]).max().unwrap_or(0)
    };
    let (metric, value) = (width(|r| &r.metric, "metric"), width(|r| &r.value, "value"));
    let mut lines = vec![format!("{:metric$}  {:>value$}  unit", "metric", "value")];
    lines.extend(rows.iter().map(|r| {
        let line = format!("{:metric$}  {:>value$}  {}", r.metric, r.value, r.unit);
        line.trim_end().to_owned()
    }));
    lines.join("\n")
}

/// A Markdown table: its heads, then its lines. Every line has as many cells as there are heads.
pub fn grid(heads: &[&str], lines: &[Vec<String>]) -> String {
    let heads: Vec<String> = heads.iter().map(|head| (*head).to_owned()).collect();
    let width = |k: usize| {
        let cells = lines.iter().chain([&heads]).filter_map(|line| line.get(k));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let row = |cells: &Vec<String>| {
        let padded = cells.iter().zip(&widths).map(|(cell, &width)| format!(" {cell:width$} |"));
        format!("|{}", padded.collect::<String>())
    };
    let rule: String = widths.iter().map(|w| format!("{}|", "-".repeat(w + 2))).collect();
    let mut text = vec![row(&heads), format!("|{rule}")];
    text.extend(lines.iter().map(row));
    text.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!(digits(0.000_123_456), "0.0001235");
        assert_eq!(digits(12.3456), "12.35");
        assert_eq!(digits(123_456.7), "123457");
        assert_eq!(digits(0.0), "0");
        assert_eq!(digits(f64::INFINITY), "inf");
    }

    #[test]
    fn tables_are_aligned() {
        let table = [Row::plain("views", 12), Row::new("length", "3.5", "m")];
        assert_eq!(rows(&table), "metric  value  unit\nviews      12\nlength    3.5  m");
        let lines = [vec!["é".to_owned(), "10".to_owned()]];
        assert_eq!(grid(&["a", "b"], &lines), "| a | b  |\n|---|----|\n| é | 10 |");
    }
}
