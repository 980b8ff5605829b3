//! Which crossings of a cell follow each other.
//!
//! ```text
//!   TL --top-- TR        Seen with rows running down and columns to the right, a curve has its
//!    |          |        high pixels on the left. Between a high left and a low right pixel it
//!   left      right      runs up, between a high upper and a low lower pixel to the right. So a
//!    |          |        crossing leaves one of its two cells and enters the other, and each cell
//!   BL -bottom- BR       links what enters to what leaves.
//! ```

pub(super) const TOP: u8 = 0;
pub(super) const LEFT: u8 = 1;
pub(super) const RIGHT: u8 = 2;
pub(super) const BOTTOM: u8 = 3;

/// Entering and leaving edge of one curve through a cell.
pub(super) type Link = [u8; 2];

/// The link by code: bit 0 TL, 1 TR, 2 BL, 3 BR is high. Codes without a curve, and the two
/// saddles, which have two links, hold the link of an edge to itself.
#[rustfmt::skip]
pub(super) const LINKS: [Link; 16] = [
    /* ....          */ [TOP, TOP],
    /* TL            */ [LEFT, TOP],
    /* TR            */ [TOP, RIGHT],
    /* TL TR         */ [LEFT, RIGHT],
    /* BL            */ [BOTTOM, LEFT],
    /* TL BL         */ [BOTTOM, TOP],
    /* TR BL         */ [TOP, TOP],
    /* TL TR BL      */ [BOTTOM, RIGHT],
    /* BR            */ [RIGHT, BOTTOM],
    /* TL BR         */ [TOP, TOP],
    /* TR BR         */ [TOP, BOTTOM],
    /* TL TR BR      */ [LEFT, BOTTOM],
    /* BL BR         */ [RIGHT, LEFT],
    /* TL BL BR      */ [RIGHT, TOP],
    /* TR BL BR      */ [TOP, LEFT],
    /* all           */ [TOP, TOP],
];

/// Code of a cell whose high corners are TL and BR.
pub(super) const SADDLE_TL_BR: usize = 0b1001;
/// Code of a cell whose high corners are TR and BL.
pub(super) const SADDLE_TR_BL: usize = 0b0110;

/// The two links of a saddle. `middle_high`: whether the mean of the four levels exceeds the plane,
/// so that the two high corners are joined through the middle.
pub(super) fn saddle(code: usize, middle_high: bool) -> [Link; 2] {
    match (code, middle_high) {
        (SADDLE_TL_BR, true) => [[RIGHT, TOP], [LEFT, BOTTOM]],
        (SADDLE_TL_BR, false) => [[LEFT, TOP], [RIGHT, BOTTOM]],
        (_, true) => [[TOP, LEFT], [BOTTOM, RIGHT]],
        (_, false) => [[TOP, RIGHT], [BOTTOM, LEFT]],
    }
}

/// How the three corners that are left without one of four are treated as a cell: the missing
/// corner moves onto a neighbour. The pair between the two then has no length, and its pair with
/// the other neighbour becomes the triangle's diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Triangle {
    /// The missing corner, as a bit of the code.
    pub missing: usize,
    /// The corner that the missing one moves onto.
    pub onto: usize,
    /// The edge that becomes the diagonal.
    pub diagonal: u8,
    /// Whether the diagonal runs from TL to BR; the other one from TR to BL.
    pub falls: bool,
    /// Which edges can be crossed: the two pairs of the corner opposite the missing one, and the
    /// diagonal.
    pub joined: [bool; 4],
}

/// The triangles left without each corner: TL, TR, BL, BR.
pub(super) const TRIANGLES: [Triangle; 4] = [
    Triangle {
        missing: 0,
        onto: 1,
        diagonal: LEFT,
        falls: false,
        joined: [false, true, true, true],
    },
    Triangle {
        missing: 1,
        onto: 0,
        diagonal: RIGHT,
        falls: true,
        joined: [false, true, true, true],
    },
    Triangle {
        missing: 2,
        onto: 3,
        diagonal: LEFT,
        falls: true,
        joined: [true, true, true, false],
    },
    Triangle {
        missing: 3,
        onto: 2,
        diagonal: RIGHT,
        falls: false,
        joined: [true, true, true, false],
    },
];

/// Which cells of a word of 64 still carry curves when some of their pairs are broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shapes {
    /// All four pairs joined.
    pub whole: u64,
    /// Three pairs joined: curves pass between them.
    pub open: u64,
    /// Both pairs of one corner broken, by corner: the other three make a triangle.
    pub without: [u64; 4],
}

impl Shapes {
    /// Cells that are triangles, whichever corner is missing.
    #[inline(always)]
    pub fn triangles(&self) -> u64 {
        let [a, b, c, d] = self.without;
        a | b | c | d
    }

    /// From which pairs are joined: top, left, right, bottom.
    #[inline(always)]
    pub fn of([top, left, right, bottom]: [u64; 4]) -> Self {
        let (upright, level) = (left & right, top & bottom);
        let (either, any) = (left | right, top | bottom);
        Self {
            whole: upright & level,
            open: (upright & any | level & either) & !(upright & level),
            without: [
                right & bottom & !top & !left,
                left & bottom & !top & !right,
                top & right & !left & !bottom,
                top & left & !right & !bottom,
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a code has a crossing on an edge, and whether the curve enters the cell there.
    fn enters(code: usize, edge: u8) -> Option<bool> {
        let high = |bit: usize| code >> bit & 1 == 1;
        let [tl, tr, bl, br] = [high(0), high(1), high(2), high(3)];
        let (from, to) = match edge {
            TOP => (tr, tl),
            LEFT => (tl, bl),
            RIGHT => (br, tr),
            _ => (bl, br),
        };
        (from != to).then_some(from)
    }

    fn links(code: usize, middle_high: bool) -> Vec<Link> {
        match code {
            0 | 15 => Vec::new(),
            SADDLE_TL_BR | SADDLE_TR_BL => saddle(code, middle_high).to_vec(),
            _ => vec![LINKS[code]],
        }
    }

    #[test]
    fn every_code_links_each_entering_crossing_to_one_leaving_crossing() {
        for code in 0..16 {
            for middle_high in [false, true] {
                let pairs = links(code, middle_high);
                for edge in [TOP, LEFT, RIGHT, BOTTOM] {
                    let entering = pairs.iter().filter(|[from, _]| *from == edge).count();
                    let leaving = pairs.iter().filter(|[_, to]| *to == edge).count();
                    let expected = match enters(code, edge) {
                        Some(true) => (1, 0),
                        Some(false) => (0, 1),
                        None => (0, 0),
                    };
                    assert_eq!((entering, leaving), expected, "code {code:04b} edge {edge}");
                }
            }
        }
    }

    #[test]
    fn a_missing_corner_breaks_its_two_pairs_only() {
        for code in 0..16_u64 {
            let joined = [0, 1, 2, 3].map(|edge| code >> edge & 1);
            let shapes = Shapes::of(joined);
            let [top, left, right, bottom] = joined.map(|j| j == 1);
            let triangle = match (top, left, right, bottom) {
                (false, false, true, true) => Some(0),
                (false, true, false, true) => Some(1),
                (true, false, true, false) => Some(2),
                (true, true, false, false) => Some(3),
                _ => None,
            };
            assert_eq!(shapes.whole == 1, code == 15, "{code:04b}");
            assert_eq!(shapes.open == 1, code.count_ones() == 3, "{code:04b}");
            for corner in 0..4 {
                assert_eq!(shapes.without[corner] == 1, triangle == Some(corner), "{code:04b}");
            }
        }
    }
}
