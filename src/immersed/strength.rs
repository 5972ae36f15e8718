//! How strongly markers push, and how much slip they leave: what both engines share.

/// Upper bound of a_k relative to a: where few markers share a kernel (the rim), the exchange is strengthened.
pub const LARGEST_OVER_RELAXATION_RATIO: f64 = 2.5;

/// Length of a vector.
#[must_use]
pub fn length(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Root mean square of `values`, weighted by area.
#[must_use]
pub fn area_mean_square(values: &[f64], areas: &[f64]) -> f64 {
    let square: f64 = values.iter().zip(areas).map(|(v, area)| area * v * v).sum();
    (square / areas.iter().sum::<f64>()).sqrt()
}
