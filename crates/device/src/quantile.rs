//! Medians and quantiles of measured numbers.
//!
//! All crates that know `device` take them from here, so that the median of an even number of
//! values means the same in all. The filter of lookup tables alone has a median of its own. The
//! cost is linear in the number of values.

/// The median of some values, of an even number the upper of the two in the middle. `None` without
/// values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.into_iter().collect();
    let middle = values.len() / 2;
    ascending(values, middle)
}

/// The value with number `share · n` of `n` values in ascending order; a share of 1 gives the
/// largest. `None` without values.
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let values: Vec<f64> = values.into_iter().collect();
    let place = (share * values.len() as f64) as usize;
    let last = values.len().saturating_sub(1);
    ascending(values, place.min(last))
}

/// The value that ascending order puts at a place; `None` without values.
fn ascending(mut values: Vec<f64>, place: usize) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let (_, value, _) = values.select_nth_unstable_by(place, f64::total_cmp);
    Some(*value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_the_upper_of_two() {
        assert_eq!(median([]), None);
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0, 1.0, 3.0, 2.0]), Some(3.0));
    }

    #[test]
    fn quantiles_are_values_and_end_at_the_extremes() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0];
        let of = |share| quantile(values, share);
        assert_eq!(quantile([], 0.5), None);
        assert_eq!([of(0.0), of(0.5), of(0.79), of(1.0)], [1.0, 3.0, 4.0, 5.0].map(Some));
        assert_eq!(quantile(values, 0.5), median(values));
    }
}
