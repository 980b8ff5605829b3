//! Whether the stated counts of columns and rows are those of the points.
//!
//! **Problem.** Counts with the right product and wrong factors give a grid without a gap in the
//! file. Its neighbours are no neighbours: each of its columns holds parts of two columns, or two.
//!
//! **Idea.** A scanner goes along a column in one direction and turns back to begin the next one.
//! So the directions of consecutive points turn back at the ends of columns, and only there.
//! Missing points are left out: the turn is then somewhere between the two points around them.
//!
//! **Steps.**
//! 1. Find the places where consecutive valid points turn back ([`Sweep::of`]).
//! 2. The stated counts pass if turns are at the ends of columns, and ends have turns.
//! 3. Else other factors of the product are tried, by stricter limits. Without one that passes, the
//!    stated counts pass, too: they may belong to a scanner of another kind.

use transect_device::{ImageSize, median};
use transect_geometry::Point3;

/// Shortest step that counts as turning back, in median steps between neighbours. Chosen by hand:
/// jitter of a scanner's directions is below one step. Doubled, columns of six points are not told.
const LEAST_TURN: f64 = 3.0;

/// Least share of turns at ends of columns, and of ends with a turn, with which stated counts pass.
/// Theory: half or less with a wrong factor of 2, all with the right one. Doubled, nothing passes.
const PASSES: f64 = 0.8;

/// The same for counts that replace the stated ones. Chosen by hand: above it, chance has no part.
/// Doubled, nothing is found.
const CERTAIN: f64 = 0.95;

/// Fewest turns that tell anything. Chosen by hand. Doubled, scans of ten columns are not told.
const FEWEST_TURNS: usize = 8;

/// The counts that the points have, if they are certainly not the stated ones. `at` gives the valid
/// point at a place in the file, in which points stand column by column.
pub(super) fn other_counts(
    stated: ImageSize,
    scanner: &Point3,
    at: impl Fn(usize) -> Option<Point3>,
) -> Option<ImageSize> {
    let sweep = Sweep::of(stated.pixels(), scanner, at)?;
    if sweep.fits(stated.rows, PASSES) {
        return None;
    }
    let all = stated.pixels();
    let small = (2..).take_while(|k| k * k <= all).filter(|k| all.is_multiple_of(*k));
    let mut rows = small.flat_map(|k| [k, all / k]).filter(|rows| all / rows > 1);
    let rows = rows.find(|rows| sweep.fits(*rows, CERTAIN))?;
    Some(ImageSize { rows, cols: all / rows })
}

/// The steps between consecutive valid points: the places of both in the file.
#[derive(Debug, Default)]
struct Sweep {
    /// Steps that turn back.
    turns: Vec<[usize; 2]>,
    /// The others.
    onward: Vec<[usize; 2]>,
}

impl Sweep {
    /// The steps of a scan; `None` if too few turn back to tell anything.
    fn of(all: usize, scanner: &Point3, at: impl Fn(usize) -> Option<Point3>) -> Option<Self> {
        let direction = |k| {
            let direction = (at(k)? - scanner).try_normalize(0.0)?;
            direction.iter().all(|c| c.is_finite()).then_some((k, direction))
        };
        let valid = || (0..all).filter_map(direction);
        let pairs = || valid().zip(valid().skip(1));
        let neighbours = pairs().filter(|((a, _), (b, _))| a + 1 == *b);
        let usual = median(neighbours.map(|((_, a), (_, b))| (b - a).norm()))?;
        let (mut sweep, mut before) = (Self::default(), None);
        for ((k, from), (next, to)) in pairs() {
            let step = to - from;
            // After a turn the direction of the column is not known until the next step.
            let Some(along) = before.replace(step) else { continue };
            if step.dot(&along) < 0.0 && step.norm() > LEAST_TURN * usual {
                sweep.turns.push([k, next]);
                before = None;
            } else {
                sweep.onward.push([k, next]);
            }
        }
        (sweep.turns.len() >= FEWEST_TURNS).then_some(sweep)
    }

    /// Whether columns of so many rows end where the steps turn back, for a share of them.
    fn fits(&self, rows: usize, share: f64) -> bool {
        let ends = |steps: &[[usize; 2]]| {
            steps.iter().filter(|[a, b]| a / rows != b / rows).count() as f64
        };
        let at_ends = ends(&self.turns);
        at_ends >= share * self.turns.len() as f64
            && at_ends >= share * (at_ends + ends(&self.onward))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::Vector3;

    const ROWS: usize = 60;
    const COLS: usize = 90;

    /// A number between 0 and 1 for each place.
    fn chance(k: usize) -> f64 {
        (43758.5453 * (k as f64 * 12.9898).sin()).rem_euclid(1.0)
    }

    /// A room as a scanner at a place sees it, column by column, from the floor up. `is_missing`
    /// leaves points out by place, row and chance.
    fn room(
        scanner: Vector3,
        is_missing: impl Fn(usize, f64) -> bool,
    ) -> impl Fn(usize) -> Option<Point3> {
        move |k| {
            let (row, col) = (k % ROWS, k / ROWS);
            let (theta, phi) = (0.07 * col as f64, -1.0 + 0.035 * row as f64);
            let (cos, z) = (phi.cos(), phi.sin());
            let d = Vector3::new(cos * theta.cos(), cos * theta.sin(), z);
            let reach = Vector3::new(5.0, 4.0, 1.5).zip_map(&d, |half, d| half / d.abs()).min();
            // Noise of 1 % along the ray, and of a fifth of a step across it.
            let across = Vector3::new(chance(3 * k), chance(5 * k), chance(7 * k)) * 0.007;
            let reach = reach * (0.99 + 0.02 * chance(2 * k));
            let point = Point3::from(scanner + (d + across) * reach);
            (!is_missing(row, chance(k))).then_some(point)
        }
    }

    fn stated(rows: usize, cols: usize) -> ImageSize {
        ImageSize { rows, cols }
    }

    type Missing = fn(usize, f64) -> bool;

    /// No point, the tripod and the sky, six of ten at random, both.
    const MISSING: [Missing; 4] = [
        |_, _| false,
        |row, _| !(9..=45).contains(&row),
        |_, chance| chance < 0.6,
        |row, chance| !(9..=45).contains(&row) || chance < 0.4,
    ];

    #[test]
    fn the_counts_of_the_points_are_found() {
        let place = Vector3::new(300.0, 50.0, 2.0);
        for (case, missing) in MISSING.into_iter().enumerate() {
            for scanner in [Vector3::zeros(), place] {
                let points = room(scanner, missing);
                let found = |rows, cols| other_counts(stated(rows, cols), &scanner.into(), &points);
                assert_eq!(found(ROWS, COLS), None, "{case}");
                for rows in [30, 90, 120, 20, 180, 100, 2] {
                    let truth = Some(stated(ROWS, COLS));
                    assert_eq!(found(rows, 5400 / rows), truth, "{case}: {rows} rows");
                }
            }
        }
    }

    /// Points of no scanner, and a scan seen from a place where nothing stood.
    #[test]
    fn what_does_not_turn_back_passes() {
        let scattered = |k: usize| Some(Point3::new(chance(k), chance(7 * k), chance(13 * k)));
        assert_eq!(other_counts(stated(60, 90), &Point3::origin(), scattered), None);
        let wall = |k: usize| Some(Point3::new(5.0, (k / 4) as f64, (k % 4) as f64));
        assert_eq!(other_counts(stated(4, 4), &Point3::origin(), wall), None, "too few columns");
        let elsewhere = Point3::new(-40.0, 3.0, 30.0);
        assert_eq!(
            other_counts(stated(60, 90), &elsewhere, room(Vector3::zeros(), MISSING[0])),
            None
        );
    }
}
