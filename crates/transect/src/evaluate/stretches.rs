//! The number of curves to expect where views saw parts of one curve.

use super::sample::Sample;

/// Number of seen stretches of one curve, from its samples in order and whether each was seen.
///
/// Unseen parts shorter than `shortest` do not separate stretches: views have samples on both
/// sides. Seen parts shorter than that are not counted.
pub(super) fn seen_stretches(
    samples: impl Iterator<Item = (Sample, bool)>,
    is_closed: bool,
    shortest: f64,
) -> usize {
    let mut runs = Vec::new();
    let run = |(sample, seen): (Sample, bool)| Run {
        seen,
        length: sample.length,
        seen_length: if seen { sample.length } else { 0.0 },
    };
    samples.for_each(|s| extend(&mut runs, run(s)));
    close(&mut runs, is_closed);
    let mut without_gaps = Vec::new();
    for run in runs {
        let seen = run.seen || run.length < shortest;
        extend(&mut without_gaps, Run { seen, ..run });
    }
    close(&mut without_gaps, is_closed);
    without_gaps.iter().filter(|r| r.seen && r.seen_length >= shortest).count()
}

/// A part of a curve whose samples were all seen, or all unseen.
#[derive(Debug, Clone, Copy)]
struct Run {
    seen: bool,
    length: f64,
    /// Length of it that was seen.
    seen_length: f64,
}

impl Run {
    fn add(&mut self, other: &Self) {
        self.length += other.length;
        self.seen_length += other.seen_length;
    }
}

fn extend(runs: &mut Vec<Run>, more: Run) {
    match runs.last_mut() {
        Some(last) if last.seen == more.seen => last.add(&more),
        _ => runs.push(more),
    }
}

/// On a closed curve the last run continues in the first.
fn close(runs: &mut Vec<Run>, is_closed: bool) {
    if let (true, [first, .., last]) = (is_closed, runs.as_mut_slice())
        && first.seen == last.seen
    {
        let last = *last;
        first.add(&last);
        runs.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::{Point2, Vector2};

    /// Stretches of a curve of samples of length 1, written as `#` if seen.
    fn count(samples: &str, is_closed: bool, shortest: f64) -> usize {
        let sample = |(k, c): (usize, char)| {
            let (position, direction) = (Point2::new(k as f64, 0.0), Vector2::x());
            (Sample { position, direction, length: 1.0, along: k as f64 }, c == '#')
        };
        seen_stretches(samples.chars().enumerate().map(sample), is_closed, shortest)
    }

    #[test]
    fn what_was_seen_on_both_sides_of_a_short_gap_is_one() {
        assert_eq!(count("####.####...####", false, 2.0), 2);
        assert_eq!(count("####.####...####", false, 1.0), 3);
        assert_eq!(count("................", false, 2.0), 0);
        assert_eq!(count("....#.......####", false, 2.0), 1, "a single sample is no curve");
        assert_eq!(count(".#.", false, 2.0), 0, "nor is one between short gaps");
        assert_eq!(count("#.#.#", false, 3.0), 1);
    }

    #[test]
    fn a_closed_curve_has_no_beginning() {
        assert_eq!(count("################", true, 2.0), 1);
        assert_eq!(count("####....########", true, 2.0), 1);
        assert_eq!(count("####....########", false, 2.0), 2);
        assert_eq!(count(".####....######.", true, 2.0), 2);
        assert_eq!(count(".##############.", true, 3.0), 1);
        assert_eq!(count("#...............", true, 1.0), 1);
    }
}
