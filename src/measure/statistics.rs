//! Means of correlated time series with an honest uncertainty.

/// Mean with the half width of its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// Mean.
    pub value: f64,
    /// Half width of the 95 % interval; `None` if the series is too short to tell.
    pub confidence: Option<f64>,
}

/// Batches of the second interval of [`mean_of`], of which the wider is taken: long ones see what wanders slowly.
const LONG_BATCHES: usize = 4;

/// Quantiles of Student's t at 97.5 % for 1, 2, … degrees of freedom.
const STUDENT: [f64; 15] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131,
];

/// Quantile of Student's t at 97.5 %.
#[must_use]
pub fn student(degrees_of_freedom: usize) -> f64 {
    match STUDENT.get(degrees_of_freedom.saturating_sub(1)) {
        Some(&quantile) => quantile,
        // From 16 on within 0.2 %.
        None => 1.96 + 2.5 / degrees_of_freedom as f64,
    }
}

/// Mean of an evenly sampled series by *batch means*: the series is cut into batches of `batch` samples, whose means count as
/// independent. At least four batches are needed for an interval. Batches should be long against the series' correlation time; where it wanders more
/// slowly than a batch lasts, the interval is too narrow: it then covers the mean in 75 to 90 % of trials instead of 95 %.
#[must_use]
pub fn batch_mean(series: &[f64], batch: usize) -> Mean {
    let value = series.iter().sum::<f64>() / series.len() as f64;
    let count = series.len() / batch.max(1);
    if count < 4 {
        return Mean {
            value,
            confidence: None,
        };
    }
    let length = series.len() / count;
    // Drop the oldest remainder.
    let used = &series[series.len() - count * length..];
    let means: Vec<f64> = used
        .chunks_exact(length)
        .map(|b| b.iter().sum::<f64>() / length as f64)
        .collect();
    let centre = means.iter().sum::<f64>() / count as f64;
    let variance = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / (count - 1) as f64;
    let confidence = student(count - 1) * (variance / count as f64).sqrt();
    Mean {
        value,
        confidence: Some(confidence),
    }
}

/// Index of the first peak: the first value that is at least `share` of the overall maximum and is not exceeded within the
/// following `window` samples; `None` if the series ends before that is known.
#[must_use]
pub fn first_peak(series: &[f64], share: f64, window: usize) -> Option<usize> {
    let top = series.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = share * top;
    (0..series.len().saturating_sub(window)).find(|&i| {
        series[i] >= least
            && series[i + 1..=i + window]
                .iter()
                .all(|&later| later <= series[i])
    })
}

/// Mean of a series, with the wider of the intervals from batches of `batch` samples and from long ones.
#[must_use]
pub fn mean_of(series: &[f64], batch: usize) -> Mean {
    let short = batch_mean(series, batch);
    let long = batch_mean(series, series.len() / LONG_BATCHES);
    Mean {
        confidence: short
            .confidence
            .and_then(|short| Some(short.max(long.confidence?))),
        ..short
    }
}

/// Largest value; NaN if any is (a spring network has no tensions, which must not look like zero).
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |largest: f64, value| {
        if value.is_nan() {
            f64::NAN
        } else if value > largest {
            value
        } else {
            largest
        }
    })
}

/// Plain mean; not a number of nothing.
pub(super) fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Largest less smallest value.
pub(super) fn range(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Slope of the least-squares line through (x, y).
#[must_use]
pub fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x
        .iter()
        .zip(y)
        .map(|(x, y)| (x - mean_x) * (y - mean_y))
        .sum();
    let variance: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first-order autoregressive series of known mean: the interval must cover it in about 95 % of the trials.
    #[test]
    fn the_interval_covers_the_mean_of_a_correlated_series() {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut covered = 0;
        for _ in 0..400 {
            let mut x = 0.0;
            let series: Vec<f64> = (0..1000)
                .map(|_| {
                    x = 0.9 * x + uniform();
                    3.0 + x
                })
                .collect();
            let mean = batch_mean(&series, 100);
            covered += usize::from((mean.value - 3.0).abs() <= mean.confidence.unwrap());
        }
        assert!((360..=396).contains(&covered), "{covered} of 400");
    }

    /// Tables of Student's t: 2.120, 2.086, 2.042, 2.000, 1.980 for 16, 20, 30, 60, 120 degrees of freedom.
    #[test]
    fn quantiles_go_on_beyond_their_table() {
        for (degrees, quantile) in [
            (16, 2.120),
            (20, 2.086),
            (30, 2.042),
            (60, 2.0),
            (120, 1.98),
        ] {
            assert!(
                (student(degrees) / quantile - 1.0).abs() < 2e-3,
                "{degrees}"
            );
        }
        assert_eq!((student(1), student(15)), (12.706, 2.131));
    }

    #[test]
    fn short_series_have_no_interval() {
        assert_eq!(batch_mean(&[1.0, 2.0, 3.0], 1).confidence, None);
    }

    #[test]
    fn the_first_peak_is_found_before_a_higher_later_one() {
        let series: Vec<f64> = (0..200)
            .map(|i| (f64::from(i) * 0.1).sin() + 0.001 * f64::from(i))
            .collect();
        let peak = first_peak(&series, 0.5, 20).unwrap();
        assert!((14..=18).contains(&peak), "{peak}");
    }
}
