//! Numbers in text files.

/// The numbers of a line; `None` for a word that is no number.
pub(super) fn numbers(line: &str) -> impl Iterator<Item = Option<f64>> + '_ {
    line.split_ascii_whitespace().map(|word| word.parse().ok())
}
