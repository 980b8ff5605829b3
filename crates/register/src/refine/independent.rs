//! How many of the observations are independent.
//!
//! **Problem.** Neighbouring patches of a view may share an error of the sensor. Thousands of them
//! then tell hardly more than a few.
//!
//! **Idea.** Sums over blocks of an image vary more than sums of independent errors do (Kish,
//! 1965).

use super::observations::Pieces;
use super::pairs::Pair;
use crate::coarse::CoarseView;
use crate::tuning::BLOCKS;
use rayon::prelude::*;

/// The share of the observations that are independent. The pose of each view with observations has
/// taken six numbers out of its blocks.
pub(super) fn independent_share(views: &[&CoarseView], pairs: &[Pair]) -> f64 {
    let of_patches = || pairs.iter().filter(|pair| pair.of == Pieces::Patches);
    // The squares of a view's patches, of its blocks, and the number of its blocks.
    let of_view = |(b, view): (usize, &&CoarseView)| {
        let size = view.size();
        // Every patch is met by several others, all of which see its error: sum and number.
        let mut patches = vec![(0.0, 0.0); size.pixels()];
        for pair in of_patches().filter(|pair| pair.b == b) {
            for o in &pair.observations {
                let Some(sum) = patches.get_mut(o.cells[1]) else { continue };
                sum.0 += pair.weight(o).sqrt() * o.distance;
                sum.1 += 1.0;
            }
        }
        let mut blocks = [None; BLOCKS * BLOCKS];
        let mut squares = 0.0;
        for (cell, (sum, count)) in patches.iter().enumerate().filter(|(_, (_, n))| *n > 0.0) {
            let (row, col) = (cell / size.cols, cell % size.cols);
            let block = row * BLOCKS / size.rows * BLOCKS + col * BLOCKS / size.cols;
            let mean = sum / count;
            *blocks[block].get_or_insert(0.0) += mean;
            squares += mean * mean;
        }
        let sums: f64 = blocks.iter().flatten().map(|sum| sum * sum).sum();
        (squares, sums, blocks.iter().flatten().count())
    };
    let mut of_views: Vec<_> = views.par_iter().enumerate().map(of_view).collect();
    of_views.retain(|(_, _, blocks)| *blocks > 0);
    let add = |a: (f64, f64, usize), b: &(f64, f64, usize)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
    let (squares, sums, blocks) = of_views.iter().fold((0.0, 0.0, 0), add);
    let spare = blocks.saturating_sub(6 * of_views.len()).max(1) as f64;
    if squares > 0.0 { (squares / sums * spare / blocks as f64).min(1.0) } else { 1.0 }
}
