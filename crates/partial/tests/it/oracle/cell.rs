//! Which crossings of a cell follow each other.
//!
//! ```text
//!   TL --top-- TR        Seen with rows running down and columns to the right, a curve has its
//!    |          |        high pixels on the left. Between a high left and a low right pixel it
//!   left      right      runs up, between a high upper and a low lower pixel to the right. So a
//!    |          |        crossing leaves one of its two cells and enters the other, and each cell
//!   BL -bottom- BR       links what enters to what leaves.
//! ```

/// A side of a cell, as an index into its four pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Edge {
    Top = 0,
    Left = 1,
    Right = 2,
    Bottom = 3,
}

/// A corner of a cell, as a bit of its code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corner {
    TopLeft = 0,
    TopRight = 1,
    BottomLeft = 2,
    BottomRight = 3,
}

type Links = &'static [(Edge, Edge)];

/// Entering and leaving edge by code: bit 0 TL, 1 TR, 2 BL, 3 BR is high. Saddles (TL and BR, or TR
/// and BL) stand here with their low corners joined; [`links`] gives the other way.
#[rustfmt::skip]
const LINKS: [Links; 16] = {
    use Edge::{Bottom, Left, Right, Top};
    [
        /* ....          */ &[],
        /* TL            */ &[(Left, Top)],
        /* TR            */ &[(Top, Right)],
        /* TL TR         */ &[(Left, Right)],
        /* BL            */ &[(Bottom, Left)],
        /* TL BL         */ &[(Bottom, Top)],
        /* TR BL         */ &[(Top, Right), (Bottom, Left)],
        /* TL TR BL      */ &[(Bottom, Right)],
        /* BR            */ &[(Right, Bottom)],
        /* TL BR         */ &[(Left, Top), (Right, Bottom)],
        /* TR BR         */ &[(Top, Bottom)],
        /* TL TR BR      */ &[(Left, Bottom)],
        /* BL BR         */ &[(Right, Left)],
        /* TL BL BR      */ &[(Right, Top)],
        /* TR BL BR      */ &[(Top, Left)],
        /* all           */ &[],
    ]
};

const SADDLE_TL_BR: usize = 0b1001;
const SADDLE_TR_BL: usize = 0b0110;

/// The pairs of (entering, leaving) edges of a cell at one level.
///
/// `middle_high` decides a saddle: whether the mean of the four levels exceeds the plane, so that
/// the two high corners are joined through the middle.
pub(super) fn links(code: usize, middle_high: impl Fn() -> bool) -> Links {
    use Edge::{Bottom, Left, Right, Top};
    match code {
        SADDLE_TL_BR if middle_high() => &[(Right, Top), (Left, Bottom)],
        SADDLE_TR_BL if middle_high() => &[(Top, Left), (Bottom, Right)],
        _ => LINKS.get(code).copied().unwrap_or(&[]),
    }
}

/// What a cell still carries when some of its pairs are broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// At most one broken pair: curves pass between the others.
    Whole,
    /// Both pairs of one corner are broken: the other three corners make a triangle.
    Without(Corner),
    /// Nothing can be said.
    Broken,
}

/// The shape left by which of the four pairs (top, left, right, bottom) are unbroken.
pub(super) fn shape(unbroken: [bool; 4]) -> Shape {
    match unbroken {
        [false, false, true, true] => Shape::Without(Corner::TopLeft),
        [false, true, false, true] => Shape::Without(Corner::TopRight),
        [true, false, true, false] => Shape::Without(Corner::BottomLeft),
        [true, true, false, false] => Shape::Without(Corner::BottomRight),
        _ if unbroken.iter().filter(|u| **u).count() >= 3 => Shape::Whole,
        _ => Shape::Broken,
    }
}

/// How a triangle is treated as a cell: the missing corner moves onto a neighbour.
///
/// The pair between the two then has no length, and its pair with the other neighbour becomes the
/// triangle's diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Triangle {
    /// The corner that the missing one moves onto.
    pub onto: Corner,
    /// The corner at the other end of the diagonal.
    pub across: Corner,
    /// The edge that becomes the diagonal.
    pub diagonal: Edge,
}

/// The triangle that is left without a corner.
pub(super) fn triangle(missing: Corner) -> Triangle {
    use Corner::{BottomLeft, BottomRight, TopLeft, TopRight};
    match missing {
        TopLeft => Triangle { onto: TopRight, across: BottomLeft, diagonal: Edge::Left },
        TopRight => Triangle { onto: TopLeft, across: BottomRight, diagonal: Edge::Right },
        BottomLeft => Triangle { onto: BottomRight, across: TopLeft, diagonal: Edge::Left },
        BottomRight => Triangle { onto: BottomLeft, across: TopRight, diagonal: Edge::Right },
    }
}
