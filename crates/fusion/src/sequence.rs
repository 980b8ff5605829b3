//! Walking along a curve: its arc lengths, and the pairs of neighbours.

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
