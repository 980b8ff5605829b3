//! Thinning of contours that are several pixels thick (3.5.2).
//!
//! **Problem.** Noise, or a surface nearly tangent to the plane, makes labels alternate across a
//! curve, so that its contour pixels lie several deep. One of them per row or column is wanted.
//!
//! **Idea.** As printed, the contour pixels across the curve are looked for in a window of 3 to 4
//! pixels. The one in their middle is kept: (i_v, j_v) of a column, (i_h, j_h) of a row.
//!
//! **Steps.** Down every column and then along every row:
//! 1. collect the borders between labels, as long as neighbours are of one surface;
//! 2. from the first one on, take those within the thickness; of an even number leave out the last;
//! 3. if they are three or more, keep the border nearest to the middle of the outermost two, and
//!    give the pixels before and behind it the label of their side.
//! 4. Again, until nothing changes.
//!
//! **Departures from the source.** Done on labels before tracing, instead of on pixels during it.
//! The rest is then a border again: it has two sides and is traced like any other, up to its
//! ends. An even number of borders has the same label on both sides. It is a strip, whose two
//! curves run in opposite directions. The printed rule would draw one line through it that has no
//! inside. The printed choice between (i_v, j_v) and (i_h, j_h) takes the nearer to the current
//! pixel, which near a curve's end is that pixel itself. Here borders between rows are thinned down
//! columns and borders between columns along rows, which is across the curve by their code.
//!
//! Surface features narrower than the thickness are taken for noise, as in the source.

use super::label::LabelImage;
use crate::pixel_grid::Grid;
use transect_device::{Neighbour, Pixel};

/// Most rounds of columns and rows; thinning one can thicken the other, by less each time.
const MAX_ROUNDS: usize = 4;

/// Thins all borders that are up to `thickness` pixels thick; less than 2 changes nothing.
pub(super) fn thin(
    labels: &mut LabelImage,
    grid: &Grid,
    thickness: usize,
    joined: impl Fn(Pixel, Neighbour) -> bool,
) {
    let size = grid.size();
    // Around the seam of a full circle, rows are looked at a little beyond their end.
    let seam = if grid.wraps() { thickness.min(size.cols) } else { 0 };
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for col in 0..size.cols {
            let column: Vec<_> = (0..size.rows).map(|row| Pixel::new(row, col)).collect();
            let line = Line { pixels: &column, neighbour: Neighbour::Up, thickness };
            changed |= line.thin(labels, &joined);
        }
        for row in 0..size.rows {
            let cols = (0..size.cols).chain(0..seam);
            let pixels: Vec<_> = cols.map(|col| Pixel::new(row, col)).collect();
            let line = Line { pixels: &pixels, neighbour: Neighbour::Left, thickness };
            changed |= line.thin(labels, &joined);
        }
        if !changed {
            break;
        }
    }
}

/// A column or a row of pixels.
struct Line<'a> {
    pixels: &'a [Pixel],
    neighbour: Neighbour,
    thickness: usize,
}

impl Line<'_> {
    fn thin(&self, labels: &mut LabelImage, joined: &impl Fn(Pixel, Neighbour) -> bool) -> bool {
        let differ = |pair: &&[Pixel]| labels.get(pair[0]) != labels.get(pair[1]);
        // Most lines have fewer borders than make one thick.
        if self.pixels.windows(2).filter(differ).count() < 3 {
            return false;
        }
        let mut changed = false;
        let mut borders = Vec::new();
        for k in 1..self.pixels.len() {
            if !joined(self.pixels[k], self.neighbour) {
                changed |= self.thin_borders(labels, &borders);
                borders.clear();
            } else if labels.get(self.pixels[k - 1]) != labels.get(self.pixels[k]) {
                borders.push(k);
            }
        }
        changed | self.thin_borders(labels, &borders)
    }

    /// Steps 2 and 3; a border `k` lies before pixel `k` of the line.
    fn thin_borders(&self, labels: &mut LabelImage, borders: &[usize]) -> bool {
        let mut changed = false;
        let mut rest = borders;
        while let Some(&first) = rest.first() {
            let within = rest.iter().take_while(|b| **b - first <= self.thickness).count();
            let odd = within - usize::from(within % 2 == 0);
            let (group, after) = rest.split_at(odd.max(1));
            if group.len() >= 3 {
                self.keep_middle(labels, group);
                changed = true;
            }
            rest = after;
        }
        changed
    }

    fn keep_middle(&self, labels: &mut LabelImage, group: &[usize]) {
        let (first, last) = (group[0], group[group.len() - 1]);
        let off_middle = |border: &&usize| (2 * **border).abs_diff(first + last);
        let middle = group.iter().min_by_key(off_middle).copied().unwrap_or(first);
        let (before, behind) = (labels.get(self.pixels[first - 1]), labels.get(self.pixels[last]));
        for k in first..last {
            labels.set(self.pixels[k], if k < middle { before } else { behind });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The picture of a label image after thinning.
    fn thinned(lines: &[&str], thickness: usize) -> Vec<String> {
        let (grid, mut labels) = LabelImage::drawn(lines);
        let known = labels.clone();
        let joined = |p, n| {
            let before = grid.before(p, n).and_then(|b| known.get(b));
            known.get(p).is_some() && before.is_some()
        };
        thin(&mut labels, &grid, thickness, joined);
        let drawn = |p| match labels.get(p) {
            Some(super::super::Label::High) => '#',
            Some(super::super::Label::Low) => '.',
            None => ' ',
        };
        let row = |r| (0..grid.size().cols).map(|c| drawn(Pixel::new(r, c))).collect();
        (0..grid.size().rows).map(row).collect()
    }

    #[test]
    fn a_border_three_pixels_thick_becomes_its_middle() {
        let thick = ["....", "####", "....", "####", "####"];
        assert_eq!(thinned(&thick, 4), ["....", "....", "####", "####", "####"]);
        assert_eq!(thinned(&thick, 0), thick);
    }

    proptest! {
        #[test]
        fn noise_in_a_band_of_four_rows_leaves_one_border_from_end_to_end(
            band in prop::collection::vec(prop::collection::vec(any::<bool>(), 4), 3..30),
        ) {
            let label = |row: usize, col: usize| match row {
                0..3 => '.',
                3..7 if band[col][row - 3] => '#',
                3..7 => '.',
                _ => '#',
            };
            let lines: Vec<String> =
                (0..10).map(|r| (0..band.len()).map(|c| label(r, c)).collect()).collect();
            let result = thinned(&lines.iter().map(String::as_str).collect::<Vec<_>>(), 4);
            for col in 0..band.len() {
                let column: Vec<char> =
                    result.iter().map(|l| l.chars().nth(col).unwrap()).collect();
                let borders = column.windows(2).filter(|w| w[0] != w[1]).count();
                prop_assert_eq!(borders, 1, "column {} of {:?}", col, result);
                prop_assert!(column[..3] == ['.'; 3] && column[7..] == ['#'; 3]);
            }
            for row in &result {
                let ends = row.chars().collect::<Vec<_>>();
                let borders: Vec<usize> =
                    (1..ends.len()).filter(|k| ends[*k] != ends[k - 1]).collect();
                let thick = borders.windows(3).any(|w| w[2] - w[0] <= 4);
                prop_assert!(!thick, "{row}");
            }
        }
    }

    #[test]
    fn strips_and_clean_corners_stay() {
        let strip = ["....", "####", "....", "...."];
        assert_eq!(thinned(&strip, 4), strip);
        let corner = ["....", "..##", "..##", ".###"];
        assert_eq!(thinned(&corner, 4), corner);
    }

    #[test]
    fn nothing_is_thinned_across_missing_pixels() {
        let cut = ["..", "##", "  ", "..", "##"];
        assert_eq!(thinned(&cut, 4), cut);
    }
}
