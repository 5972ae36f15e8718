//! From when on the forces on a rigid body count, and how well their means are known; the same of plates of fabric.
//!
//! Lengths are those that a body's coefficients refer to, L; times count in L/U. What the numbers come from is in
//! `docs/results/2026-11-23-bodies-settling-and-walls.md`.

use crate::measure::reduce;
use crate::measure::statistics::{Mean, average, mean_of, range};

/// Averaging begins so long after the wind, or the body's own speed, has risen, where the wake is steady [L/U].
pub const SETTLING: f64 = 10.0;

/// The same where the wake may shed vortices: it grows long and symmetric first, breaks up, and overshoots.
pub const UNSTEADY_SETTLING: f64 = 30.0;

/// Shortest window that the results of a steady wake are taken from [L/U].
pub const STEADY_WINDOW: f64 = 4.0;

/// The same of an unsteady one [L/U]: five batches.
pub const UNSTEADY_WINDOW: f64 = 20.0;

/// Force across the stream over the drag, below which the flow has kept the symmetry of the case.
const SYMMETRIC: f64 = 1e-6;

/// Length of a batch [L/U]: two thirds of a period at a Strouhal number of 0.17. With batches of 5 the interval of 21 L/U covers the mean of
/// an oscillation at St 0.13 to 0.2 in 88 % of trials, with 4 in 96 %.
const BATCH: f64 = 4.0;

/// Fewest batches that an interval is taken from.
const LEAST_BATCHES: usize = 5;

/// Range of the drag over its mean within which a force counts as steady.
const QUIET: f64 = 0.02;

/// Batches of a steady force, whatever the window's length.
const QUIET_BATCHES: usize = 8;

/// Drift over a window, relative to the mean drag, from which on a result is marked.
const DRIFT_LIMIT: f64 = 0.01;

/// Change from the middle third to the last over that from the first to the middle, from which on no limit is in sight; the interval is
/// that of this ratio.
const NO_LIMIT: f64 = 0.9;

/// What the rule must know of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling {
    /// L/U [s].
    pub unit_s: f64,
    /// When wind and body have their speeds [s].
    pub risen_s: f64,
    /// Time of a turn of a body that rotates steadily [s].
    pub turn_s: Option<f64>,
    /// The wake may shed vortices.
    pub unsteady: bool,
}

impl Settling {
    /// From the end of the rise to the begin of the window, and its least length [L/U].
    #[must_use]
    pub const fn times(&self) -> [f64; 2] {
        if self.unsteady {
            [UNSTEADY_SETTLING, UNSTEADY_WINDOW]
        } else {
            [SETTLING, STEADY_WINDOW]
        }
    }
}

/// The part of a record over which the means of a body are taken.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyWindow {
    /// First sample.
    pub first: usize,
    /// One past the last sample.
    pub end: usize,
    /// Length, in units as `L/U`.
    pub length: f64,
    /// Name of the unit of its times.
    unit: &'static str,
    /// True if it begins only after the flow has settled.
    pub settled: bool,
    /// Samples per batch.
    batch: usize,
    /// From the end of the rise to the begin of a settled window, and its least length, in that unit.
    times: [f64; 2],
    /// The drag hardly changes in it: its range is the interval where the window is too short for batches.
    quiet: bool,
}

impl BodyWindow {
    /// Chooses the window from the times of the samples and their drag; `None` before two samples exist after t = 0.
    #[must_use]
    pub fn new(times: &[f64], drag: &[f64], settling: &Settling) -> Option<Self> {
        let turn_s = settling.turn_s.unwrap_or(0.0);
        let unit = (settling.unit_s, "L/U");
        let mut window = Self::chosen(times, unit, settling.risen_s, settling.times(), turn_s)?;
        let drag = window.of(drag);
        window.quiet = !settling.unsteady && range(drag) <= QUIET * average(drag).abs();
        Some(window)
    }

    /// The same of what sways in a wind that has risen at t = 0. `unit` is that of its times [s] and its name, `settled` the begin of a settled window
    /// and its least length in it.
    pub(in crate::measure) fn of_swaying(
        times: &[f64],
        unit: (f64, &'static str),
        settled: [f64; 2],
    ) -> Option<Self> {
        Self::chosen(times, unit, 0.0, settled, 0.0)
    }

    fn chosen(
        times: &[f64],
        (unit_s, unit): (f64, &'static str),
        risen_s: f64,
        [begin, least]: [f64; 2],
        turn_s: f64,
    ) -> Option<Self> {
        let end = times.len();
        let from_s = risen_s.max(0.0) + begin * unit_s;
        let first = times.partition_point(|&time| time < from_s);
        let settled = first + 1 < end && times[end - 1] - times[first] >= (least - 1e-6) * unit_s;
        let first = if settled {
            first
        } else {
            second_half(times)?.start
        };
        let span = times[end - 1] - times[first];
        let rate = (end - 1 - first) as f64 / span;
        let batch_s = (BATCH * unit_s).max(turn_s);
        Some(Self {
            first,
            end,
            length: span / unit_s,
            unit,
            settled,
            times: [begin, least],
            batch: (batch_s * rate).round().max(1.0) as usize,
            quiet: false,
        })
    }

    fn of<'a>(&self, column: &'a [f64]) -> &'a [f64] {
        let end = self.end.min(column.len());
        &column[self.first.min(end)..end]
    }

    fn has_batches(&self) -> bool {
        self.end - self.first >= LEAST_BATCHES * self.batch
    }

    /// True if a wake that may shed vortices has not lost its symmetry.
    #[must_use]
    pub fn is_symmetric(&self, drag: &[f64], across: [&[f64]; 2]) -> bool {
        let unsteady = self.times[0] > SETTLING;
        let largest = across.map(|force| range(self.of(force)));
        unsteady && largest[0].max(largest[1]) <= SYMMETRIC * average(self.of(drag)).abs()
    }

    /// How intervals of means over it are found.
    #[must_use]
    pub const fn how(&self) -> &'static str {
        if self.end - self.first >= LEAST_BATCHES * self.batch {
            "batch means, 95 %"
        } else {
            "range and drift of a steady force"
        }
    }

    /// Samples per batch in which a drift is looked for.
    fn drift_batch(&self) -> usize {
        if self.has_batches() {
            self.batch
        } else {
            (self.end - self.first) / QUIET_BATCHES
        }
    }

    /// Mean of a column with the half width of its 95 % interval: that of batches, or of a short steady record its range; no less than
    /// what a drift leads to. Without an interval where neither is known.
    #[must_use]
    pub fn mean(&self, column: &[f64]) -> Mean {
        let series = self.of(column);
        let spread = match (self.has_batches(), self.quiet) {
            (true, _) => mean_of(series, self.batch).confidence,
            (false, true) => Some(range(series)),
            (false, false) => None,
        };
        let away = Drift::of(series, self.drift_batch()).map_or(0.0, |drift| drift.away);
        Mean {
            value: average(series),
            confidence: spread.map(|spread| spread.max(away)),
        }
    }

    /// Why means over the window cannot be trusted, from its length, the drag and, where a wake may shed vortices, the forces across the stream in the same unit.
    /// `None` where nothing is known against them.
    #[must_use]
    pub fn unsettled(&self, drag: &[f64], across: Option<[&[f64]; 2]>) -> Option<String> {
        let (unit, [begin, least]) = (self.unit, self.times);
        if !self.settled {
            return Some(format!(
                "not settled: the second half of a run too short; averaging begins {begin} {unit} after the speeds have risen and needs {least}"
            ));
        }
        if !self.quiet && !self.has_batches() {
            return Some(format!(
                "not settled: {:.1} {unit} of averaging, an unsteady force needs {UNSTEADY_WINDOW}",
                self.length
            ));
        }
        if across.is_some_and(|across| self.is_symmetric(drag, across)) {
            return Some(
                "not settled: without any force across the stream the flow has kept the symmetry of the case, and a wake that sheds vortices has \
                 nothing to begin with; turn the body by 2 degrees, or shift it"
                    .to_owned(),
            );
        }
        let series = self.of(drag);
        let drift = Drift::of(series, self.drift_batch())?;
        let share = drift.change / average(series);
        (share.abs() > DRIFT_LIMIT).then(|| {
            format!(
                "not settled: the drag changes by {:+.1} % from the first third of the window to the last{}",
                100.0 * share,
                if drift.goes_on {
                    ", with no limit in sight"
                } else {
                    ""
                }
            )
        })
    }
}

/// The samples of the second half of a record after t = 0; `None` if there are fewer than two.
#[must_use]
pub fn second_half(times: &[f64]) -> Option<std::ops::Range<usize>> {
    let first = reduce::second_half(times)?;
    (first + 1 < times.len()).then_some(first..times.len())
}

/// How a series drifts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drift {
    /// From the mean to the limit.
    away: f64,
    /// From the first third to the last.
    change: f64,
    /// No limit is in sight.
    goes_on: bool,
}

impl Drift {
    /// By von Neumann's ratio of the batches' means: squares of successive differences over twice those of deviations, 1 ± √((n − 2)/(n² − 1))
    /// of n independent means, near 0 of a drift (level 5 %). The limit is that of a geometric sequence through the means of three thirds.
    /// `None` if the series drifts no more than its scatter explains.
    fn of(series: &[f64], batch: usize) -> Option<Self> {
        let batch = batch.max(1);
        let count = series.len() / batch;
        if count < 4 {
            return None;
        }
        let used = &series[series.len() - count * batch..];
        let means: Vec<f64> = used.chunks_exact(batch).map(average).collect();
        let centre = average(&means);
        let deviations: f64 = means.iter().map(|m| (m - centre).powi(2)).sum();
        let differences: f64 = means.windows(2).map(|p| (p[1] - p[0]).powi(2)).sum();
        let n = count as f64;
        let least = 1.0 - 1.645 * ((n - 2.0) / (n * n - 1.0)).sqrt();
        // A constant has neither; round-off is no drift.
        if deviations.sqrt() <= 1e-9 * centre.abs() || differences >= 2.0 * deviations * least {
            return None;
        }
        let third = used.len() / 3;
        let [a, b, c] = [0, 1, 2].map(|k| average(&used[k * third..(k + 1) * third]));
        let ratio = (c - b) / (b - a);
        let mean = average(series);
        let away = if ratio > 0.0 {
            let ratio = ratio.min(NO_LIMIT);
            c + (c - b) * ratio / (1.0 - ratio) - mean
        } else {
            // It has turned: as far as it got.
            (a - mean).abs().max((b - mean).abs()).max((c - mean).abs())
        };
        Some(Self {
            away: away.abs(),
            change: c - a,
            goes_on: ratio >= NO_LIMIT,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTLING_OF_ONE: Settling = Settling {
        unit_s: 1.0,
        risen_s: 0.0,
        turn_s: None,
        unsteady: false,
    };

    /// No force across the stream.
    const NOTHING: [&[f64]; 2] = [&[], &[]];

    /// Samples per L/U.
    const RATE: usize = 8;

    fn times(length: f64) -> Vec<f64> {
        (0..=(length * RATE as f64) as usize)
            .map(|k| k as f64 / RATE as f64)
            .collect()
    }

    fn window(length: f64, drag: impl Fn(f64) -> f64) -> (BodyWindow, Vec<f64>) {
        let times = times(length);
        let drag: Vec<f64> = times.iter().map(|&t| drag(t)).collect();
        let window = BodyWindow::new(&times, &drag, &SETTLING_OF_ONE).unwrap();
        (window, drag)
    }

    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    #[test]
    fn averages_begin_when_the_flow_has_settled() {
        let times = times(30.0);
        let drag = vec![1.0; times.len()];
        let of = |length: usize, risen_s: f64| {
            let end = length * RATE + 1;
            let settling = Settling {
                risen_s,
                ..SETTLING_OF_ONE
            };
            BodyWindow::new(&times[..end], &drag[..end], &settling).unwrap()
        };
        // A wake that may shed vortices takes longer, and one that keeps its symmetry has not begun to.
        let wake = Settling {
            unsteady: true,
            ..SETTLING_OF_ONE
        };
        let long_times = self::times(60.0);
        let steady = vec![1.0; long_times.len()];
        let shed: Vec<f64> = long_times.iter().map(|t| 1e-3 * t.sin()).collect();
        let of_wake = |length: usize| {
            let end = length * RATE + 1;
            BodyWindow::new(&long_times[..end], &steady[..end], &wake).unwrap()
        };
        assert!(!of_wake(49).settled && of_wake(51).settled);
        let window = of_wake(60);
        assert!((long_times[window.first] - UNSTEADY_SETTLING).abs() < 1e-9);
        let why = window.unsettled(&steady, Some(NOTHING)).unwrap();
        assert!(why.contains("symmetry"), "{why}");
        assert_eq!(window.unsettled(&steady, Some([&shed, &[]])), None);
        let long = of(30, 0.0);
        assert!(long.settled && (times[long.first] - SETTLING).abs() < 1e-9);
        assert!((long.length - 20.0).abs() < 1e-9);
        // A body that sets out by itself settles later.
        assert!((times[of(30, 3.0).first] - SETTLING - 3.0).abs() < 1e-9);
        let short = of(13, 0.0);
        assert!(!short.settled && (times[short.first] - 6.5).abs() < 0.2);
        assert!(
            short
                .unsettled(&drag, Some(NOTHING))
                .unwrap()
                .contains("too short")
        );
        assert!(of(14, 0.0).settled);
        assert_eq!(long.unsettled(&drag, Some(NOTHING)), None);
        assert_eq!(long.mean(&drag).confidence, Some(0.0));
    }

    /// A force that approaches its limit: the interval reaches it, and a longer record has a narrower one.
    #[test]
    fn a_drift_widens_the_interval_up_to_its_limit() {
        for decay in [2.0, 4.0, 8.0] {
            let approach = |t: f64| 1.1 + 0.2 * (-t / decay).exp();
            let [short, long, longest] = [15.0, 31.0, 70.0].map(|length| {
                let (window, drag) = window(length, approach);
                let mean = window.mean(&drag);
                let Some(half) = mean.confidence else {
                    // A short record that changes by more than 2 %.
                    assert!(length < 20.0 && window.unsettled(&drag, Some(NOTHING)).is_some());
                    return f64::NAN;
                };
                let off = (mean.value - 1.1).abs();
                assert!(off <= 1.05 * half, "{decay}, {length}: {mean:?}");
                half
            });
            assert!(short.is_nan() == (decay > 5.0), "{decay}: {short}");
            assert!(longest < long, "{long} {longest}");
        }
        // What goes on rising has an interval wider than all that it rose by, and says so.
        let (window, drag) = window(40.0, |t| 1.0 + 0.01 * t);
        let half = window.mean(&drag).confidence.unwrap();
        assert!(half > 0.3, "{half}");
        let why = window.unsettled(&drag, Some(NOTHING)).unwrap();
        assert!(why.contains("no limit in sight"), "{why}");
        assert!(why.contains("+14."), "{why}");
    }

    /// White noise: the interval is that of theory, 1.96 σ/√n (Student's t of few batches above it), and no drift is seen in more than
    /// one of ten records.
    #[test]
    fn intervals_of_white_noise_are_those_of_theory() {
        let mut uniform = noise(5);
        let (mut width, mut covered, mut marked) = (0.0, 0, 0);
        let trials = 400;
        let mut expected = 0.0;
        for _ in 0..trials {
            let times = times(90.0);
            let drag: Vec<f64> = times.iter().map(|_| 1.0 + 0.5 * uniform()).collect();
            let window = BodyWindow::new(&times, &drag, &SETTLING_OF_ONE).unwrap();
            let count = window.end - window.first;
            expected = 1.96 * 0.5 / 12f64.sqrt() / (count as f64).sqrt();
            let mean = window.mean(&drag);
            marked += usize::from(window.unsettled(&drag, Some(NOTHING)).is_some());
            let confidence = mean.confidence.unwrap();
            width += confidence / f64::from(trials);
            covered += usize::from((mean.value - 1.0).abs() <= confidence);
        }
        // Of 16 and of 4 batches the wider is taken.
        assert!(
            (1.0..1.9).contains(&(width / expected)),
            "{width} {expected}"
        );
        assert!(covered >= 376, "{covered} of 400");
        assert!(marked <= 40, "{marked} of 400");
    }

    /// Vortices at St 0.13 to 0.2 under a wandering mean: 20 L/U are needed, and the interval then covers the mean in about 95 % of the trials.
    #[test]
    fn intervals_cover_the_mean_of_a_shedding_body() {
        let mut uniform = noise(11);
        let short = window(24.0, |t| 1.0 + 0.1 * (0.9 * t).sin());
        assert_eq!(short.0.mean(&short.1).confidence, None);
        assert!(
            short
                .0
                .unsettled(&short.1, Some(NOTHING))
                .unwrap()
                .contains("needs 20")
        );
        for length in [31.0, 50.0, 90.0] {
            let mut covered = 0;
            for trial in 0..300 {
                let strouhal = 0.13 + 0.07 * f64::from(trial) / 300.0;
                let phase = std::f64::consts::TAU * uniform();
                let mut wander = 0.05 * (uniform() + uniform());
                let times = times(length);
                let drag: Vec<f64> = times
                    .iter()
                    .map(|t| {
                        wander +=
                            -wander / (5.0 * RATE as f64) + 0.06 * uniform() / (RATE as f64).sqrt();
                        let turn = std::f64::consts::TAU * strouhal * t + phase;
                        1.0 + 0.1 * turn.cos() + wander
                    })
                    .collect();
                let window = BodyWindow::new(&times, &drag, &SETTLING_OF_ONE).unwrap();
                let mean = window.mean(&drag);
                covered += usize::from((mean.value - 1.0).abs() <= mean.confidence.unwrap());
            }
            assert!(covered >= 276, "{length}: {covered} of 300");
        }
    }
}
