//! Tables of results as text: rows of metric, value and unit, and grids for the documentation.

pub use transect::evaluate::{Quantity, Row, digits};

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
    fn tables_are_aligned() {
        let table = [Row::plain("views", 12), Row::new("length", "3.5", "m")];
        assert_eq!(rows(&table), "metric  value  unit\nviews      12\nlength    3.5  m");
        let lines = [vec!["é".to_owned(), "10".to_owned()]];
        assert_eq!(grid(&["a", "b"], &lines), "| a | b  |\n|---|----|\n| é | 10 |");
    }
}
