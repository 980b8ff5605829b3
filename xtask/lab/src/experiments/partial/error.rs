//! Nodes' errors, and what is said about many of them.

use crate::statistics::quantile;
use crate::table::digits;

/// The errors of a node against the truth; lengths as shares of the solid's size.
#[derive(Debug, Clone, Copy)]
pub struct NodeError {
    /// Positive outside.
    pub signed: f64,
    /// As the node has it.
    pub sigma: f64,
    /// Between surface normal and section plane, in degrees.
    pub angle: f64,
}

/// Fewer nodes than these say nothing.
const ENOUGH: usize = 200;

/// Median, 95 % quantile and bias in thousandths, and, with noise, predicted over observed spread;
/// a dash for too few nodes.
pub fn figures(errors: &[NodeError], noisy: bool) -> String {
    if errors.len() < ENOUGH {
        return "–".to_owned();
    }
    let sizes: Vec<f64> = errors.iter().map(|e| 1e3 * e.signed.abs()).collect();
    let bias = errors.iter().map(|e| 1e3 * e.signed).sum::<f64>() / errors.len() as f64;
    let (median, p95) = (quantile(sizes.clone(), 0.5), quantile(sizes, 0.95));
    let place = |value: f64| if value.abs() < 0.1 { short(value) } else { format!("{value:.2}") };
    let ratio = noisy.then(|| format!(" / {:.2}", predicted_over_observed(errors)));
    format!("{} / {} / {}{}", place(median), place(p95), place(bias), ratio.unwrap_or_default())
}

/// Predicted standard deviation over the observed one, at the median: 1 if predictions are true.
pub fn predicted_over_observed(errors: &[NodeError]) -> f64 {
    let normed = errors.iter().map(|e| e.signed.abs() / e.sigma).collect();
    // The median of |x| of a normal x is 0.6745 of its standard deviation.
    0.6745 / quantile(normed, 0.5)
}

/// Two digits, or a power of ten where there would be many zeros.
fn short(value: f64) -> String {
    if value == 0.0 || value.abs() >= 0.001 {
        return format!("{value:.3}");
    }
    if value.is_finite() { format!("{value:.0e}") } else { digits(value) }
}
