//! Quantiles of sorted numbers.

/// The quantile `q` (0 to 1) of ascending numbers, linear between neighbours: position `(n − 1) q`.
///
/// `None` without numbers, and where the result is infinite.
pub(super) fn quantile(ascending: &[f64], q: f64) -> Option<f64> {
    let position = ascending.len().checked_sub(1)? as f64 * q;
    let (below, share) = (position.floor() as usize, position.fract());
    let low = *ascending.get(below)?;
    if share == 0.0 {
        return low.is_finite().then_some(low);
    }
    let value = low + (ascending.get(below + 1)? - low) * share;
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_linear_between_neighbours() {
        let numbers = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quantile(&numbers, 0.0), Some(1.0));
        assert_eq!(quantile(&numbers, 0.5), Some(3.0));
        assert_eq!(quantile(&numbers, 1.0), Some(8.0));
        assert!((quantile(&numbers, 0.95).unwrap() - 7.4).abs() < 1e-12);
        assert_eq!(quantile(&[5.0], 0.95), Some(5.0));
    }

    #[test]
    fn infinite_numbers_reach_only_the_quantiles_that_meet_them() {
        let numbers = [1.0, 2.0, 3.0, f64::INFINITY, f64::INFINITY];
        assert_eq!(quantile(&numbers, 0.5), Some(3.0));
        assert_eq!(quantile(&numbers, 0.6), None);
        assert_eq!(quantile(&numbers, 0.95), None);
        assert_eq!(quantile(&[], 0.5), None);
    }
}
