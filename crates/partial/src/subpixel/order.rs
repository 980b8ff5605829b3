//! The order of convergence that measured errors show.

/// Orders of convergence between each spacing and the next: `ln(e₁/e₂) / ln(h₁/h₂)`.
///
/// An error that falls with the square of the spacing gives 2. Empty for fewer than two pairs; no
/// unit.
///
/// ```
/// let orders = transect_partial::subpixel::observed_orders(&[0.4, 0.2, 0.1], &[0.16, 0.04, 0.01]);
/// assert!(orders.iter().all(|o| (o - 2.0).abs() < 1e-12));
/// ```
pub fn observed_orders(spacings: &[f64], errors: &[f64]) -> Vec<f64> {
    let pairs = spacings.windows(2).zip(errors.windows(2));
    pairs.map(|(h, e)| (e[0] / e[1]).ln() / (h[0] / h[1]).ln()).collect()
}
