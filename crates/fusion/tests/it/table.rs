//! Table 5.1 as a law, and the names of its rows, patterns and forks.

use transect_fusion::pattern::{Fork, Parts, Pattern, TABLE_5_1, Verdict, verdict};

/// The same overlap of two curves that are both walked the other way round.
pub trait Reversed {
    fn reversed(self) -> Self;
}

impl Reversed for Parts {
    fn reversed(self) -> Self {
        Self::new(self.ends_unenclosed, self.begins_unenclosed)
    }
}

impl Reversed for Verdict {
    fn reversed(self) -> Self {
        match self {
            Self::Valid(Pattern::WholeAndEnd) => Self::Valid(Pattern::WholeAndBeginning),
            Self::Valid(Pattern::WholeAndBeginning) => Self::Valid(Pattern::WholeAndEnd),
            Self::Fork(Fork::AtBeginning) => Self::Fork(Fork::AtEnd),
            Self::Fork(Fork::AtEnd) => Self::Fork(Fork::AtBeginning),
            same => same,
        }
    }
}

/// The dissertation's string for the parts of the first of two curves, such as `âbc`.
pub fn symbols(parts: Parts) -> String {
    let [before, behind] = [parts.begins_unenclosed, parts.ends_unenclosed];
    format!("{}b{}", if before { 'a' } else { 'â' }, if behind { 'c' } else { 'ĉ' })
}

/// The same of the second curve, such as `ÂBC`.
pub fn capitals(parts: Parts) -> String {
    symbols(parts).to_uppercase()
}

/// A cell of the table: `VALID`, or `N/A` with the fork's number.
pub fn cell(verdict: Verdict) -> String {
    match verdict {
        Verdict::Valid(_) => "VALID".to_owned(),
        Verdict::Fork(fork) => format!("N/A ({})", number(fork)),
    }
}

/// The number of a fork in the table.
pub fn number(fork: Fork) -> usize {
    fork as usize + 1
}

/// All combinations of the parts of two curves, in the order of the table.
pub fn combinations() -> impl Iterator<Item = (Parts, Parts)> {
    Parts::ALL.into_iter().flat_map(|a| Parts::ALL.into_iter().map(move |b| (a, b)))
}

/// Rule 1, without the table.
fn fork_of(a: Parts, b: Parts) -> Option<Fork> {
    let at_beginning = a.begins_unenclosed && b.begins_unenclosed;
    let at_end = a.ends_unenclosed && b.ends_unenclosed;
    match (at_beginning, at_end) {
        (true, true) => Some(Fork::AtBothEnds),
        (true, false) => Some(Fork::AtBeginning),
        (false, true) => Some(Fork::AtEnd),
        (false, false) => None,
    }
}

/// The pattern by how much of each curve the overlap takes.
fn pattern_of(a: Parts, b: Parts) -> Pattern {
    if a != Parts::WHOLE && b != Parts::WHOLE {
        return Pattern::EndToBeginning;
    }
    let other = if a == Parts::WHOLE { b } else { a };
    match (other.begins_unenclosed, other.ends_unenclosed) {
        (false, false) => Pattern::BothWhole,
        (true, false) => Pattern::WholeAndEnd,
        (false, true) => Pattern::WholeAndBeginning,
        (true, true) => Pattern::WholeAndMiddle,
    }
}

#[test]
fn the_table_is_the_law_that_there_are_no_forks() {
    for (a, b) in combinations() {
        let law = match fork_of(a, b) {
            Some(fork) => Verdict::Fork(fork),
            None => Verdict::Valid(pattern_of(a, b)),
        };
        assert_eq!(verdict(a, b), law, "{} {}", symbols(a), capitals(b));
    }
}

#[test]
fn the_table_is_the_printed_one() {
    let printed = [
        ["N/A (3)", "N/A (2)", "N/A (1)", "VALID"],
        ["N/A (2)", "N/A (2)", "VALID", "VALID"],
        ["N/A (1)", "VALID", "N/A (1)", "VALID"],
        ["VALID", "VALID", "VALID", "VALID"],
    ];
    assert_eq!(TABLE_5_1.map(|row| row.map(cell)), printed);
    assert_eq!(Parts::ALL.map(symbols), ["abc", "âbc", "abĉ", "âbĉ"]);
}

#[test]
fn nine_are_valid_and_fall_into_five_patterns() {
    let count = |v| combinations().filter(|&(a, b)| verdict(a, b) == v).count();
    assert_eq!(Pattern::ALL.map(|p| count(Verdict::Valid(p))), [2, 1, 2, 2, 2]);
    assert_eq!(Fork::ALL.map(|f| count(Verdict::Fork(f))), [3, 3, 1]);
}

#[test]
fn the_rules_treat_both_curves_alike_in_both_directions() {
    for (a, b) in combinations() {
        assert_eq!(verdict(a, b), verdict(b, a));
        assert_eq!(verdict(a.reversed(), b.reversed()), verdict(a, b).reversed());
    }
}
