//! Tables of results as text: rows of metric, value and unit, grids for the documentation, and
//! comma separated values for spreadsheets.

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

/// Comma separated values (RFC 4180): a line of heads, then the lines.
pub fn csv(heads: &[&str], lines: &[Vec<String>]) -> String {
    let cell = |text: &str| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let head = heads.iter().map(|head| cell(head)).collect::<Vec<_>>().join(",");
    let lines = lines.iter().map(|line| line.iter().map(|text| cell(text)).collect::<Vec<_>>());
    std::iter::once(head).chain(lines.map(|line| line.join(","))).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_and_quotes_are_quoted() {
        let lines = [vec!["1,5".to_owned(), "a \"b\"".to_owned()], vec![String::new(); 2]];
        assert_eq!(csv(&["a, m", "b"], &lines), "\"a, m\",b\n\"1,5\",\"a \"\"b\"\"\"\n,");
    }

    #[test]
    fn tables_are_aligned() {
        let table = [Row::plain("views", 12), Row::new("length", "3.5", "m")];
        assert_eq!(rows(&table), "metric  value  unit\nviews      12\nlength    3.5  m");
        let lines = [vec!["é".to_owned(), "10".to_owned()]];
        assert_eq!(grid(&["a", "b"], &lines), "| a | b  |\n|---|----|\n| é | 10 |");
    }
}
