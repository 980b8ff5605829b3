//! Walking along a curve: its arc lengths, the pairs of neighbours, and the parts between cuts.

use transect_geometry::{Curve, EndReason};

/// Arc length at the beginning of each unit, and at the end of the last one.
pub(crate) fn arc_lengths(units: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut length = 0.0;
    let mut arc = vec![length];
    arc.extend(units.into_iter().map(|unit| {
        length += unit;
        length
    }));
    arc
}

/// Each item with the one that follows it; round a closed sequence, the first follows the last.
pub(crate) fn neighbours<T>(items: &[T], closed: bool) -> impl Iterator<Item = (&T, &T)> {
    let closing = items.first().filter(|_| closed);
    items.iter().zip(items.iter().skip(1).chain(closing))
}

/// The numbers 0 to n in runs, each of which ends behind a cut. A closed sequence is opened at its
/// first cut, so that no run is cut in two.
pub(crate) fn runs(n: usize, closed: bool, is_cut: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let opened = (0..n).find(|k| closed && is_cut(*k)).map_or(0, |k| k + 1);
    let numbers: Vec<usize> = (opened..n).chain(0..opened).collect();
    numbers.split_inclusive(|k| is_cut(*k)).map(<[usize]>::to_vec).collect()
}

/// The parts of a curve without some of its units, of which there is at least one. Where these
/// units were, the parts begin and end for the given reason.
pub(crate) fn without_units(
    curve: &Curve,
    is_left_out: impl Fn(usize) -> bool,
    reason: Option<EndReason>,
) -> Vec<Curve> {
    let runs = runs(curve.nodes().len(), curve.is_closed(), is_left_out);
    let [begin, end] = if curve.is_closed() { [reason; 2] } else { curve.ends() };
    let part = |(k, run): (usize, &Vec<usize>)| {
        let nodes = run.iter().map(|k| curve.nodes()[*k]).collect();
        let ends_by = if k + 1 == runs.len() { end } else { reason };
        let ends = [if k == 0 { begin } else { reason }, ends_by];
        Some(Curve::new(nodes, false).ok()?.with_ends(ends))
    };
    runs.iter().enumerate().filter_map(part).collect()
}
