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
}

/// The verdict of the rules on an overlap.
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

/// The verdict of Table 5.1 on an overlap that leaves these parts of two curves.
pub const fn verdict(first: Parts, second: Parts) -> Verdict {
    TABLE_5_1[first.place()][second.place()]
}
