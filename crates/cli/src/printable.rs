//! Text for the terminal: control characters of names and files are printed as their code.

/// A text of lines in which all other control characters stand as their code, such as `\\u{1b}`.
///
/// Names of scans and views come from files. A terminal takes control characters for commands: they
/// colour, move or delete what was printed.
pub fn lines(text: &str) -> String {
    escaped(text, |c| c.is_control() && c != '\n')
}

/// The text of one cell of a table, in which every control character stands as its code.
pub fn cell(text: &str) -> String {
    escaped(text, char::is_control)
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_escaped(c) {
            true => shown.extend(c.escape_unicode()),
            false => shown.push(c),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_stand_as_their_code() {
        assert_eq!(lines("a\u{1b}[31m\nwall µ\r"), "a\\u{1b}[31m\nwall µ\\u{d}");
        assert_eq!(cell("a\nb\u{9b}"), "a\\u{a}b\\u{9b}");
    }
}
