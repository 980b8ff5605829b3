//! Round numbers for scales, grids and labels.

/// The smallest of 1, 2, 5 times a power of ten that is at least `value`.
pub(super) fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    // Rounding may put the quotient slightly above the round number.
    let ratio = value / power * (1.0 - 1e-9);
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().find(|&s| ratio <= s).unwrap_or(10.0);
    step * power
}

/// The largest of 1, 2, 5 times a power of ten that is at most `value`.
pub(super) fn round_down(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let ratio = value / power * (1.0 + 1e-9);
    let step = [10.0, 5.0, 2.0, 1.0].into_iter().find(|&s| ratio >= s).unwrap_or(1.0);
    step * power
}

/// A number with the decimals that `resolution` needs, without trailing zeros.
pub(super) fn tidy(value: f64, resolution: f64) -> String {
    let needed = (-resolution.abs().log10() - 1e-9).ceil();
    let decimals = if needed.is_finite() { needed.clamp(0.0, 15.0) as usize } else { 6 };
    let text = format!("{value:.decimals$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.replace('-', "\u{2212}") }
}

/// A vector as reports write it.
pub(super) fn vector(v: &transect_geometry::Vector3) -> String {
    let [x, y, z] = [v.x, v.y, v.z].map(|c| tidy(c, 1e-3));
    format!("({x}, {y}, {z})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn round_numbers_enclose_the_value(value in 1e-9..1e9) {
            let (low, high) = (round_down(value), round_up(value));
            prop_assert!(low <= value * 1.000_001 && value <= high * 1.000_001);
            prop_assert!(high <= low * 2.500_001, "{} {} {}", low, value, high);
            prop_assert!((round_up(high) / high - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn labels_are_short_and_have_no_negative_zero() {
        assert_eq!(tidy(0.30000000000000004, 0.1), "0.3");
        assert_eq!(tidy(-1e-17, 0.01), "0");
        assert_eq!(tidy(5_400_000.25, 0.01), "5400000.25");
        assert_eq!(tidy(100.0, 10.0), "100");
        assert_eq!(tidy(-2.0, 0.5), "\u{2212}2");
    }
}
