//! Search orders: where the next contour pixel may lie, by code (3.5.1, Figure 3.6).
//!
//! ```text
//!   code 1                 code 2                 code 3
//!        (i−1, j)                                      (i−1, j)
//!   W <---- x ----> E        (i,j−1) x (i, j)               x ----> E
//!        (i, j)                      | N above     (i,j−1) x (i, j)
//!                                    v S below             v S
//! ```
//!
//! A border between two pixels is crossed by the curve, which leaves it into the two cells of four
//! pixels beside the border. A pixel of code 1 has one border, left to the west and the east; code
//! 2 to the north and the south. Of code 3 the two borders share the cell north-west of the pixel
//! and follow each other there, so it is left to the east and the south.
//!
//! The order visits the closest pixel first and at equal distance the pixel of the same code, since
//! along a smooth curve codes seldom change. Every step has the code it expects, and the side on
//! which the curve comes in. **Adjacent** steps lead to a border of the same cell; all others
//! bridge a gap.
//!
//! **Departure from the source**: expected codes are exact. Each way out of a pixel has at most one
//! adjacent way in, except where pixels are missing. So gaps arise from missing pixels and range
//! jumps alone, and never from the search.

use super::MOST_PIXELS;
use transect_device::Neighbour;

/// A side on which a curve leaves or enters a contour pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    North,
    East,
    South,
    West,
}

impl Side {
    /// The border that the curve crosses there.
    pub fn border(self) -> Neighbour {
        match self {
            Self::East | Self::West => Neighbour::Up,
            Self::North | Self::South => Neighbour::Left,
        }
    }

    /// One step out of the pixel, in rows and columns.
    pub fn outward(self) -> (i32, i32) {
        match self {
            Self::North => (-1, 0),
            Self::East => (0, 1),
            Self::South => (1, 0),
            Self::West => (0, -1),
        }
    }
}

/// The two sides of a contour pixel by its code, 1 to 3.
pub(super) fn sides(code: u8) -> [Side; 2] {
    match code {
        1 => [Side::East, Side::West],
        2 => [Side::South, Side::North],
        _ => [Side::East, Side::South],
    }
}

/// One step of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SearchStep {
    /// Rows down, Δi.
    pub rows: i32,
    /// Columns to the right, Δj.
    pub cols: i32,
    /// The side on which the current pixel is left.
    pub leaves: Side,
    /// The code expected there.
    pub expected: u8,
    /// The side on which the pixel there is entered.
    pub enters: Side,
    /// Whether both borders are of one cell.
    pub adjacent: bool,
}

/// The search orders of all codes.
#[derive(Debug, Clone)]
pub(super) struct SearchOrder {
    by_code: [Vec<SearchStep>; 3],
}

impl SearchOrder {
    /// Orders for gaps of up to so many missing pixels; 0 for none.
    pub fn new(gap: usize) -> Self {
        let reach = gap.min(MOST_PIXELS) as i32 + 1;
        Self { by_code: [1, 2, 3].map(|code| order(code, reach, gap > 0)) }
    }

    /// Steps from a pixel of some code, in the order of the search.
    pub fn of(&self, code: u8) -> &[SearchStep] {
        self.by_code.get(usize::from(code).wrapping_sub(1)).map_or(&[], Vec::as_slice)
    }
}

fn order(code: u8, reach: i32, gaps: bool) -> Vec<SearchStep> {
    let offsets = (-reach..=reach).flat_map(|rows| (-reach..=reach).map(move |cols| (rows, cols)));
    let all = offsets.flat_map(|offset| steps_to(code, offset));
    let mut steps: Vec<SearchStep> = all.filter(|s| s.adjacent || gaps).collect();
    // Figure 3.6: the right-hand neighbour of the same code first, then the left-hand one.
    steps.sort_by_key(|s| {
        let distance = s.rows * s.rows + s.cols * s.cols;
        (distance, s.expected != code, -s.cols, -s.rows, s.expected)
    });
    steps
}

/// All steps to one offset.
fn steps_to(code: u8, (rows, cols): (i32, i32)) -> impl Iterator<Item = SearchStep> {
    let ways = (1..=3).flat_map(move |expected| {
        let pairs = sides(code).map(|leaves| sides(expected).map(|e| (leaves, expected, e)));
        pairs.into_iter().flatten()
    });
    ways.filter_map(move |(leaves, expected, enters)| {
        let adjacent = ADJACENT.contains(&(leaves, (rows, cols), enters));
        let step = SearchStep { rows, cols, leaves, expected, enters, adjacent };
        let elsewhere = (rows, cols) != (0, 0);
        (elsewhere && (adjacent || runs_on(&step))).then_some(step)
    })
}

/// Leaving side, offset and entering side of the steps between two borders of one cell. With TL,
/// TR, BL, BR its pixels, the borders are top (TL, TR), left (TL, BL), right (TR, BR), bottom (BL,
/// BR); each belongs to its lower or right pixel.
const ADJACENT: [(Side, (i32, i32), Side); 10] = {
    use Side::{East, North, South, West};
    [
        (East, (0, 1), West),    // left to right
        (West, (0, -1), East),   // right to left
        (South, (1, 0), North),  // top to bottom
        (North, (-1, 0), South), // bottom to top
        (East, (0, 1), North),   // left to bottom
        (North, (0, -1), East),  // bottom to left
        (East, (-1, 1), South),  // left to top
        (South, (1, -1), East),  // top to left
        (West, (-1, 0), South),  // right to top
        (South, (1, 0), West),   // top to right
    ]
};

/// Whether a step across a gap leaves and enters in the direction it goes.
fn runs_on(step: &SearchStep) -> bool {
    let (rows, cols) = between_borders(step);
    let (out, back) = (step.leaves.outward(), step.enters.outward());
    rows * out.0 + cols * out.1 > 0 && rows * back.0 + cols * back.1 < 0
}

/// From border to border, in half pixels: code 1's lies half a row before its pixel's centre.
fn between_borders(step: &SearchStep) -> (i32, i32) {
    let half = |side: Side| if side.border() == Neighbour::Up { (-1, 0) } else { (0, -1) };
    let (from, to) = (half(step.leaves), half(step.enters));
    (2 * step.rows + to.0 - from.0, 2 * step.cols + to.1 - from.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_1_is_searched_as_in_figure_3_6() {
        let order = SearchOrder::new(4);
        let first: Vec<_> =
            order.of(1).iter().take(3).map(|s| (s.rows, s.cols, s.expected)).collect();
        assert_eq!(first[..2], [(0, 1, 1), (0, -1, 1)]);
        assert_ne!(first[2].2, 1, "in step 3 the expected code is 2");
    }

    #[test]
    fn closer_pixels_come_first_and_no_step_comes_twice() {
        for gap in 0..=4 {
            for code in 1..=3 {
                let order = SearchOrder::new(gap);
                let steps = order.of(code);
                let distance = |s: &SearchStep| s.rows * s.rows + s.cols * s.cols;
                assert!(steps.is_sorted_by_key(distance), "code {code}");
                for (k, step) in steps.iter().enumerate() {
                    assert!(!steps[..k].contains(step), "{step:?}");
                    let king_steps = step.rows.abs().max(step.cols.abs()) as usize;
                    assert!(step.adjacent || king_steps <= gap + 1, "{step:?}");
                }
            }
        }
    }

    #[test]
    fn every_pixel_ahead_is_searched_for_every_code() {
        let order = SearchOrder::new(4);
        let ahead = |side: Side, (rows, cols): (i32, i32)| {
            let out = side.outward();
            rows * out.0 + cols * out.1 > 0
        };
        for code in 1..=3 {
            for side in sides(code) {
                for rows in -5..=5 {
                    for cols in -5..=5 {
                        let found = |expected| {
                            order.of(code).iter().any(|s| {
                                let to = (s.rows, s.cols, s.expected);
                                s.leaves == side && to == (rows, cols, expected)
                            })
                        };
                        // Code 3 is open to the east and the south only, so not from everywhere.
                        let open = (1..=2).filter(|e| found(*e)).count() > 0;
                        assert_eq!(open, ahead(side, (rows, cols)) || extra(side, rows, cols));
                    }
                }
            }
        }
    }

    /// Offsets that are not ahead of the pixel, but whose border is ahead of its border.
    fn extra(side: Side, rows: i32, cols: i32) -> bool {
        match side {
            Side::West => cols == 0 && rows != 0,
            Side::North => rows == 0 && cols != 0,
            _ => false,
        }
    }

    #[test]
    fn in_every_cell_each_border_leads_to_exactly_one_other() {
        // TL, TR, BL, BR at (0, 0), (0, 1), (1, 0), (1, 1); borders belong to TR, BL and BR.
        for pattern in 0..16_u8 {
            let high = |row: i32, col: i32| pattern >> (2 * row + col) & 1 == 1;
            let mut ends = Vec::new();
            let (top, left) = (high(0, 0) != high(0, 1), high(0, 0) != high(1, 0));
            let (right, bottom) = (high(0, 1) != high(1, 1), high(1, 0) != high(1, 1));
            // What the other borders of TR and BL are makes no difference to this cell.
            ends.extend(top.then_some(((0, 1), Side::South)));
            ends.extend(left.then_some(((1, 0), Side::East)));
            if right != bottom {
                ends.push(((1, 1), if right { Side::West } else { Side::North }));
            }
            for &(from, leaves) in &ends {
                let partners = ends.iter().filter(|&&(to, enters)| {
                    ADJACENT.contains(&(leaves, (to.0 - from.0, to.1 - from.1), enters))
                });
                assert_eq!(partners.count(), 1, "pattern {pattern:04b} from {from:?}");
            }
        }
    }
}
