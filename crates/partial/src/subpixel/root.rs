//! A root between two places of which a function's values have different signs.

/// Steps after which the bracket is as small as rounding.
const MAX_STEPS: usize = 100;

/// The root of `f` in [0, 1] by regula falsi with the Illinois rule. `None` if the values at the
/// ends have one sign or a value is not a number.
///
/// Superlinear on smooth functions, and never outside the bracket.
pub(super) fn between_0_and_1(f: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let (mut a, mut b) = (0.0, 1.0);
    let (mut at_a, mut at_b) = (f(a)?, f(b)?);
    let scale = at_a.abs().max(at_b.abs());
    if at_a == 0.0 || at_b == 0.0 {
        return Some(if at_a == 0.0 { a } else { b });
    }
    // Not a number on either side is no change of sign.
    let changes = at_a * at_b < 0.0;
    if !changes {
        return None;
    }
    for _ in 0..MAX_STEPS {
        let t = (a * at_b - b * at_a) / (at_b - at_a);
        let value = f(t)?;
        if value.abs() <= f64::EPSILON * scale || (b - a).abs() <= f64::EPSILON {
            return Some(t);
        }
        if value * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            // The end that stays a second time counts half, or it would stay for good.
            at_a *= 0.5;
        }
        (b, at_b) = (t, value);
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_to_rounding() {
        let root = between_0_and_1(|t| Some(t * t * t - 0.3)).unwrap();
        assert!((root - 0.3_f64.cbrt()).abs() < 1e-14, "{root}");
        let steep = between_0_and_1(|t| Some((40.0 * (t - 0.9)).exp() - 1.0)).unwrap();
        assert!((steep - 0.9).abs() < 1e-14, "{steep}");
    }

    #[test]
    fn no_change_of_sign_is_no_root() {
        assert_eq!(between_0_and_1(|t| Some(1.0 + t)), None);
        assert_eq!(between_0_and_1(|_| Some(f64::NAN)), None);
        assert_eq!(between_0_and_1(|_| None), None);
        assert_eq!(between_0_and_1(|t| Some(t - 1.0)), Some(1.0));
    }
}
