//! Spectra of evenly sampled series, and the period of an oscillation.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::statistics::{Mean, batch_mean, slope, student};

/// One-sided power spectral density.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spectrum {
    /// Frequencies [1/time of the interval], from one bin above 0 to half the sampling rate.
    pub frequencies: Vec<f64>,
    /// Density [square of the series' unit · time]; its sum times the distance of frequencies is the variance.
    pub densities: Vec<f64>,
}

/// Periodogram of a series without its mean and linear trend, under a Hann window; `None` with fewer than 16 samples.
pub(super) fn periodogram(series: &[f64], interval: f64) -> Option<Spectrum> {
    let count = series.len();
    if count < 16 || interval <= 0.0 || series.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let places: Vec<f64> = (0..count).map(|i| i as f64).collect();
    let slope = slope(&places, series);
    let mean = series.iter().sum::<f64>() / count as f64;
    let middle = 0.5 * (count - 1) as f64;
    let window = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / count as f64).cos();
    let weight: f64 = (0..count).map(|i| window(i).powi(2)).sum();
    let mut lines: Vec<Complex<f64>> = (0..count)
        .map(|i| (series[i] - mean - slope * (i as f64 - middle)) * window(i))
        .map(|value| Complex::new(value, 0.0))
        .collect();
    FftPlanner::new()
        .plan_fft_forward(count)
        .process(&mut lines);
    let bins = 1..=count / 2;
    let densities = bins
        .clone()
        .map(|bin| {
            let sides = if 2 * bin == count { 1.0 } else { 2.0 };
            sides * lines[bin].norm_sqr() * interval / weight
        })
        .collect();
    Some(Spectrum {
        frequencies: bins
            .map(|bin| bin as f64 / (count as f64 * interval))
            .collect(),
        densities,
    })
}

impl Spectrum {
    /// Frequency of the highest peak, between bins by the parabola through its logarithms.
    pub fn dominant(&self) -> Option<f64> {
        let (peak, &top) = self
            .densities
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))?;
        if top <= 0.0 || top.is_nan() {
            return None;
        }
        let step = self.frequencies[0];
        let at = |i: usize| self.densities[i].max(f64::MIN_POSITIVE).ln();
        let shift = if peak > 0 && peak + 1 < self.densities.len() {
            let [left, centre, right] = [at(peak - 1), at(peak), at(peak + 1)];
            let bend = left - 2.0 * centre + right;
            if bend < 0.0 {
                0.5 * (left - right) / bend
            } else {
                0.0
            }
        } else {
            0.0
        };
        Some(self.frequencies[peak] + shift * step)
    }

    /// Sum of the densities of several series at the same frequencies, over their number.
    pub fn mean_of(spectra: &[Self]) -> Option<Self> {
        let (first, rest) = spectra.split_first()?;
        let mut mean = first.clone();
        for one in rest {
            for (sum, density) in mean.densities.iter_mut().zip(&one.densities) {
                *sum += density;
            }
        }
        for density in &mut mean.densities {
            *density /= spectra.len() as f64;
        }
        Some(mean)
    }
}

/// Period and amplitude of an oscillation, with the uncertainty of the period that its length leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Oscillation {
    /// Period of the strongest frequency.
    pub period: f64,
    /// Half the width of a bin of the spectrum, as a period.
    pub period_error: f64,
    /// Amplitude of the sine with the same variance, all frequencies together.
    pub amplitude: f64,
}

/// The oscillation of a series; an error says why there is none.
pub(super) fn oscillation(series: &[f64], interval: f64) -> Result<Oscillation, &'static str> {
    let spectrum = periodogram(series, interval).ok_or("fewer than 16 samples")?;
    let frequency = spectrum.dominant().ok_or("it does not oscillate")?;
    let length = interval * series.len() as f64;
    if frequency * length < 3.0 {
        return Err("fewer than three periods were seen");
    }
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    let variance = series.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / series.len() as f64;
    Ok(Oscillation {
        period: 1.0 / frequency,
        period_error: 0.5 / (length * frequency * frequency),
        amplitude: (2.0 * variance).sqrt(),
    })
}

/// Frequency of an evenly sampled oscillation, from its upward passages through the mean [1/time of `interval`], with the interval that the
/// scatter of the periods leads to; an error says why there is none, such as an amplitude below `least`.
pub(super) fn frequency(series: &[f64], interval: f64, least: f64) -> Result<Mean, &'static str> {
    let mean = batch_mean(series, 1).value;
    let square = series.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / series.len() as f64;
    if (2.0 * square).sqrt() < least {
        return Err("it does not oscillate");
    }
    let passages: Vec<f64> = (1..series.len())
        .filter(|&i| series[i - 1] < mean && series[i] >= mean)
        .map(|i| i as f64 - (series[i] - mean) / (series[i] - series[i - 1]))
        .collect();
    let periods: Vec<f64> = passages.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if periods.len() < 4 {
        return Err("fewer than four periods");
    }
    let period = periods.iter().sum::<f64>() / periods.len() as f64;
    if periods.iter().any(|p| (p / period - 1.0).abs() > 0.3) {
        return Err("there is no single period");
    }
    let n = periods.len() as f64;
    let variance = periods.iter().map(|p| (p - period).powi(2)).sum::<f64>() / (n - 1.0);
    let half = student(periods.len() - 1) * (variance / n).sqrt();
    let value = 1.0 / (period * interval);
    Ok(Mean {
        value,
        confidence: Some(value * half / period),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(count: usize, interval: f64, frequency: f64, amplitude: f64) -> Vec<f64> {
        (0..count)
            .map(|i| 0.7 + amplitude * (TAU * frequency * interval * i as f64 + 0.3).sin())
            .collect()
    }

    #[test]
    fn a_sine_has_its_period_and_amplitude() {
        // 13.7 periods of 41 ms: no bin of the spectrum.
        let series = sine(562, 1e-3, 1.0 / 0.041, 0.02);
        let found = oscillation(&series, 1e-3).unwrap();
        assert!((found.period / 0.041 - 1.0).abs() < 2e-3, "{found:?}");
        assert!(
            (found.period - 0.041).abs() < found.period_error,
            "{found:?}"
        );
        assert!((found.amplitude / 0.02 - 1.0).abs() < 0.02, "{found:?}");
        assert!(oscillation(&series[..100], 1e-3).is_err());
        assert!(oscillation(&[0.5; 200], 1e-3).is_err());
    }

    /// The transform by its definition, over lengths that are even, odd and prime.
    #[test]
    fn the_spectrum_is_that_of_the_definition() {
        for count in [16, 45, 101] {
            let series: Vec<f64> = (0..count)
                .map(|i| (0.37 * i as f64).sin() + (1.9 * i as f64).cos() + 0.1 * i as f64)
                .collect();
            let spectrum = periodogram(&series, 0.5).unwrap();
            let places: Vec<f64> = (0..count).map(|i| i as f64).collect();
            let slope = crate::measure::statistics::slope(&places, &series);
            let mean = series.iter().sum::<f64>() / count as f64;
            let window = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / count as f64).cos();
            let weight: f64 = (0..count).map(|i| window(i).powi(2)).sum();
            let value = |i: usize| {
                (series[i] - mean - slope * (i as f64 - 0.5 * (count - 1) as f64)) * window(i)
            };
            assert_eq!(spectrum.densities.len(), count / 2);
            for (density, bin) in spectrum.densities.iter().zip(1..) {
                let angle = |i: usize| TAU * (bin * i) as f64 / count as f64;
                let real: f64 = (0..count).map(|i| value(i) * angle(i).cos()).sum();
                let imaginary: f64 = (0..count).map(|i| value(i) * angle(i).sin()).sum();
                let sides = if 2 * bin == count { 1.0 } else { 2.0 };
                let exact = sides * (real * real + imaginary * imaginary) * 0.5 / weight;
                assert!(
                    (density - exact).abs() < 1e-9 * (1.0 + exact),
                    "{count} {bin}"
                );
            }
        }
    }

    /// Parseval: the densities sum to the variance.
    #[test]
    fn the_spectrum_holds_the_variance() {
        let series = sine(1000, 1e-3, 100.0, 3.0);
        let spectrum = periodogram(&series, 1e-3).unwrap();
        let sum: f64 = spectrum.densities.iter().sum::<f64>() * spectrum.frequencies[0];
        assert!((sum / 4.5 - 1.0).abs() < 1e-2, "{sum}");
        assert!((spectrum.dominant().unwrap() - 100.0).abs() < 0.05);
        let twice = Spectrum::mean_of(&[spectrum.clone(), spectrum.clone()]).unwrap();
        assert_eq!(twice, spectrum);
    }

    /// Amplitude below which there is no oscillation to speak of.
    const NO_LIFT: f64 = 2e-3;

    #[test]
    fn frequencies_and_their_absence() {
        let wave = |f: f64, a: f64| -> Vec<f64> {
            (0..500)
                .map(|i| 0.3 + a * (std::f64::consts::TAU * f * 0.1 * f64::from(i)).sin())
                .collect()
        };
        let known = frequency(&wave(0.37, 0.2), 0.1, NO_LIFT).unwrap();
        assert!((known.value - 0.37).abs() < 1e-3, "{known:?}");
        assert!(known.confidence.unwrap() < 1e-3, "{known:?}");
        // Periods of 2.5 and 2.9 in turn: ± 0.2 on ten of them, Student's t 2.26.
        let uneven: Vec<f64> = (0..300)
            .map(|i| {
                let t = (0.1 * f64::from(i)) % 5.4;
                let phase = if t < 2.5 { t / 2.5 } else { (t - 2.5) / 2.9 };
                (std::f64::consts::TAU * phase).sin()
            })
            .collect();
        let scattered = frequency(&uneven, 0.1, NO_LIFT).unwrap();
        let share = scattered.confidence.unwrap() / scattered.value;
        assert!((0.04..0.08).contains(&share), "{scattered:?}");
        assert!(frequency(&wave(0.37, 1e-4), 0.1, NO_LIFT).is_err());
        assert!(frequency(&wave(0.05, 0.2), 0.1, NO_LIFT).is_err());
    }
}
