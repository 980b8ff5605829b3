//! The overlap rules: which overlaps of two curves can be, and which would be a fork (dissertation
//! 5.4).
//!
//! The idea: a surface bounds a volume, so its section never forks. Where two views saw the same
//! piece of surface, their curves overlap, and whatever sticks out beyond the overlap belongs to
//! one curve only. Each curve is written as three parts along its direction,
//!
//! ```text
//! a  unenclosed part before the overlap    (â: there is none)
//! b  enclosed part: the overlap
//! c  unenclosed part behind the overlap    (ĉ: there is none)
//! ```
//!
//! 1. Rule 1: no fork. If both curves have an unenclosed beginning, they come together at the
//!    overlap's beginning: fork (1). If both have an unenclosed end: fork (2). Both: fork (3).
//! 2. Of the 16 combinations 9 are left; they make the five patterns of Figure 5.7.
//! 3. Rule 2: two curves overlap in one place, unless they form a ring.
//! 4. Rule 3: two curves that form a ring overlap in two places; cutting the ring anywhere leaves
//!    sections that obey Rule 2.
//!
//! [`TABLE_5_1`] is the dissertation's table as data, [`verdict`] reads it, and [`classify`] finds
//! the overlaps of two curves and their parts. Symbols lost in the scan of Table 5.1 are restored
//! from the rules (errata). Departure: the printed table says only valid or not; here it also
//! names the pattern, which the dissertation leaves to Figure 5.7.

mod matches;
mod overlap;

pub use overlap::{
    CurveRange, Overlap, OverlapTolerance, Overlaps, Relation, ToleranceError, classify,
};

use Fork::{AtBeginning, AtBothEnds, AtEnd};
use Pattern::{BothWhole, EndToBeginning, WholeAndBeginning, WholeAndEnd, WholeAndMiddle};
use Verdict::{Fork as No, Valid as Yes};

/// Which parts of a curve an overlap leaves unenclosed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Parts {
    /// Whether there is curve before the overlap: `a`, not `â`.
    pub begins_unenclosed: bool,
    /// Whether there is curve behind the overlap: `c`, not `ĉ`.
    pub ends_unenclosed: bool,
}

impl Parts {
    /// The four strings in the order of Table 5.1: `abc`, `âbc`, `abĉ`, `âbĉ`.
    pub const ALL: [Self; 4] =
        [Self::new(true, true), Self::new(false, true), Self::new(true, false), Self::WHOLE];

    /// The curve is enclosed from end to end: `âbĉ`.
    pub const WHOLE: Self = Self::new(false, false);

    /// Parts by whether the curve has unenclosed ground before and behind the overlap.
    pub const fn new(begins_unenclosed: bool, ends_unenclosed: bool) -> Self {
        Self { begins_unenclosed, ends_unenclosed }
    }

    /// The parts of the same curve walked the other way round.
    #[must_use]
    pub const fn reversed(self) -> Self {
        Self::new(self.ends_unenclosed, self.begins_unenclosed)
    }

    /// The dissertation's string in lower case, for the first of two curves, such as `âbc`.
    pub const fn symbols(self) -> &'static str {
        ["abc", "âbc", "abĉ", "âbĉ"][self.place()]
    }

    /// The dissertation's string in upper case, for the second of two curves, such as `ÂBC`.
    pub const fn capitals(self) -> &'static str {
        ["ABC", "ÂBC", "ABĈ", "ÂBĈ"][self.place()]
    }

    /// Row or column of Table 5.1.
    const fn place(self) -> usize {
        !self.begins_unenclosed as usize + 2 * !self.ends_unenclosed as usize
    }
}

/// The five valid ways in which two curves overlap (Figure 5.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// (a) The end of one curve lies on the beginning of the other.
    EndToBeginning,
    /// (b) Both curves overlap from end to end.
    BothWhole,
    /// (c) The whole of one curve lies on the end of the other.
    WholeAndEnd,
    /// (d) The whole of one curve lies on the beginning of the other.
    WholeAndBeginning,
    /// (e) The whole of one curve lies on the middle of the other.
    WholeAndMiddle,
}

impl Pattern {
    /// All five in the order of Figure 5.7.
    pub const ALL: [Self; 5] =
        [EndToBeginning, BothWhole, WholeAndEnd, WholeAndBeginning, WholeAndMiddle];

    /// Its letter in Figure 5.7.
    pub const fn letter(self) -> char {
        ['a', 'b', 'c', 'd', 'e'][self as usize]
    }

    /// What it is, in words.
    pub const fn words(self) -> &'static str {
        [
            "end to beginning",
            "both whole",
            "whole and end",
            "whole and beginning",
            "whole and middle",
        ][self as usize]
    }

    /// The pattern after both curves are walked the other way round: (c) and (d) change places.
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            WholeAndEnd => WholeAndBeginning,
            WholeAndBeginning => WholeAndEnd,
            same => same,
        }
    }
}

/// Where two overlapping curves would make a fork, which no section of a solid has (Rule 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fork {
    /// (1) Both curves come in separately before the overlap.
    AtBeginning,
    /// (2) Both curves go on separately behind the overlap.
    AtEnd,
    /// (3) Both of these.
    AtBothEnds,
}

impl Fork {
    /// All three in the order of their numbers.
    pub const ALL: [Self; 3] = [AtBeginning, AtEnd, AtBothEnds];

    /// Where it is, in words.
    pub const fn words(self) -> &'static str {
        ["at the beginning", "at the end", "at both ends"][self as usize]
    }

    /// Its number in Table 5.1.
    pub const fn number(self) -> u8 {
        self as u8 + 1
    }

    /// The fork after both curves are walked the other way round: (1) and (2) change places.
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            AtBeginning => AtEnd,
            AtEnd => AtBeginning,
            AtBothEnds => AtBothEnds,
        }
    }
}

/// What the rules say about an overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The overlap can be; the curves can be merged.
    Valid(Pattern),
    /// Merging would make a fork.
    Fork(Fork),
}

impl Verdict {
    /// Whether the two curves can be merged.
    pub const fn is_valid(self) -> bool {
        matches!(self, Yes(_))
    }

    /// The verdict after both curves are walked the other way round.
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            Yes(pattern) => Yes(pattern.reversed()),
            No(fork) => No(fork.reversed()),
        }
    }
}

/// As in the cells of Table 5.1: `VALID`, or `N/A` with the fork's number.
impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Yes(_) => f.pad("VALID"),
            No(fork) => f.pad(&format!("N/A ({})", fork.number())),
        }
    }
}

/// Table 5.1: rows are the first curve's parts, columns the second's, both as in [`Parts::ALL`].
#[rustfmt::skip]
pub const TABLE_5_1: [[Verdict; 4]; 4] = [
    //          ABC                     ÂBC                     ABĈ                    ÂBĈ
    /* abc */ [No(AtBothEnds),         No(AtEnd),              No(AtBeginning),       Yes(WholeAndMiddle)],
    /* âbc */ [No(AtEnd),              No(AtEnd),              Yes(EndToBeginning),   Yes(WholeAndBeginning)],
    /* abĉ */ [No(AtBeginning),        Yes(EndToBeginning),    No(AtBeginning),       Yes(WholeAndEnd)],
    /* âbĉ */ [Yes(WholeAndMiddle),    Yes(WholeAndBeginning), Yes(WholeAndEnd),      Yes(BothWhole)],
];

/// What Table 5.1 says about an overlap that leaves these parts of two curves.
pub const fn verdict(first: Parts, second: Parts) -> Verdict {
    TABLE_5_1[first.place()][second.place()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn combinations() -> impl Iterator<Item = (Parts, Parts)> {
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

    /// The patterns by what they say: how much of each curve the overlap takes.
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
            assert_eq!(verdict(a, b), law, "{} {}", a.symbols(), b.capitals());
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
        assert_eq!(TABLE_5_1.map(|row| row.map(|cell| cell.to_string())), printed);
    }

    #[test]
    fn nine_are_valid_and_fall_into_five_patterns() {
        let count = |v| combinations().filter(|&(a, b)| verdict(a, b) == v).count();
        let patterns = Pattern::ALL.map(|p| count(Verdict::Valid(p)));
        assert_eq!(patterns, [2, 1, 2, 2, 2]);
        let forks = [Fork::AtBeginning, Fork::AtEnd, Fork::AtBothEnds];
        assert_eq!(forks.map(|f| count(Verdict::Fork(f))), [3, 3, 1]);
        assert_eq!(Pattern::ALL.map(Pattern::letter), ['a', 'b', 'c', 'd', 'e']);
    }

    #[test]
    fn the_rules_do_not_care_which_curve_is_the_first() {
        for (a, b) in combinations() {
            assert_eq!(verdict(a, b), verdict(b, a));
        }
    }

    #[test]
    fn walking_both_curves_back_exchanges_beginnings_and_ends() {
        for (a, b) in combinations() {
            assert_eq!(verdict(a.reversed(), b.reversed()), verdict(a, b).reversed());
            assert_eq!(a.reversed().reversed(), a);
        }
    }

    #[test]
    fn parts_are_written_as_in_the_dissertation() {
        assert_eq!(Parts::ALL.map(Parts::symbols), ["abc", "âbc", "abĉ", "âbĉ"]);
        assert_eq!(Parts::ALL.map(Parts::place), [0, 1, 2, 3]);
    }
}
