//! Medians and quantiles for tables, which show NaN where there are no values.

/// The median, of an even number of values the upper one; NaN of no values.
pub fn median(values: &[f64]) -> f64 {
    transect_device::median(values.iter().copied()).unwrap_or(f64::NAN)
}

/// A quantile; NaN of no values.
pub fn quantile(values: Vec<f64>, q: f64) -> f64 {
    transect_device::quantile(values, q).unwrap_or(f64::NAN)
}
