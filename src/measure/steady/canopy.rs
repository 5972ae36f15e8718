//! From when on the drag of a canopy counts.
//!
//! What follows was measured with the canopy of `cases/flat-circular-tunnel.toml` at 16 and 24 cells per D₀ over 180 D₀/U, six times
//! (`docs/steady-runs.md`): the opening is over some D₀/U after its first peak, but the wake that goes with the drag needs 18 to form. Before
//! that the drag is up to a fifth too low, and no look at a short record tells, since the breathing hides the drift.

use crate::measure::record::Record;
use crate::measure::shared::{PROJECTED_DIAMETER_RATIO, TIME};
use crate::measure::statistics::{Mean, first_peak, mean_of};
use crate::output::ReadOut;

/// The opening is over this many D₀/U after the first peak of the projected diameter; runs that end before their wake has settled average from here on.
const OPENING: f64 = 4.0;

/// The wake has settled this many D₀/U after that peak, and averaging starts.
pub const SETTLING: f64 = 18.0;

/// On a finer grid averaging starts at least this many D₀/U after the change: from then on the mean over several runs no longer changes.
const SETTLING_ON_FINER_GRID: f64 = 2.0;

/// Shortest settled window that results are taken from [D₀/U]: about one breath. Before it is reached they come from what follows the opening.
const FIRST_WINDOW: f64 = 2.0;

/// Shortest averaging window that may end a run [D₀/U]: its mean is off by 2.3 to 2.6 % (root mean square), that over twice the time by 2.0 to 2.2 %.
pub const SHORTEST_WINDOW: f64 = 6.0;

/// Length of a batch [D₀/U]: two thirds of the breathing period of about 1.8. With whole periods breathing cancels in every batch, and the interval of a
/// window of 8 to 16 covers the mean in half to four fifths of trials only.
pub(in crate::measure) const BATCH: f64 = 1.2;

/// The part of the record over which means are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// First sample.
    pub first: usize,
    /// One past the last sample.
    pub end: usize,
    /// Samples per batch of the mean's uncertainty.
    pub batch: usize,
    /// Length [D₀/U].
    pub length: f64,
    /// First peak of the projected diameter, if it is over.
    pub peak: Option<usize>,
    /// True if the window starts only after the opening.
    pub opened: bool,
    /// True if it starts only after the wake has settled.
    pub settled: bool,
}

/// What decides from when on samples count.
struct Opening<'a> {
    times: &'a [f64],
    /// First sample after release.
    released: usize,
    /// Samples per D₀/U.
    rate: f64,
    /// First peak of the projected diameter, if it is over.
    peak: Option<usize>,
    grid_changed_s: Option<f64>,
    unit_s: f64,
}

impl<'a> Opening<'a> {
    /// `None` before two samples exist after release.
    fn new(
        times: &'a [f64],
        ratios: &[f64],
        grid_changed_s: Option<f64>,
        unit_s: f64,
    ) -> Option<Self> {
        let released = times.iter().position(|&t| t > 0.0)?;
        let intervals = (times.len() - 1).checked_sub(released).filter(|&n| n > 0)?;
        let rate = unit_s * intervals as f64 / (times[times.len() - 1] - times[released]);
        let peak = first_peak(&ratios[released..], 0.8, samples(0.5, rate)).map(|i| released + i);
        Some(Self {
            times,
            released,
            rate,
            peak,
            grid_changed_s,
            unit_s,
        })
    }

    /// First sample that lies `after_peak` behind the peak and `after_change` behind a change to a finer grid, where the flow of the coarser one settles
    /// anew, if the record goes on for `window` from there [D₀/U].
    fn from(&self, after_peak: f64, after_change: f64, window: f64) -> Option<usize> {
        let (times, unit_s) = (self.times, self.unit_s);
        let changed_s = self.grid_changed_s;
        let changed_s = changed_s.map_or(f64::NEG_INFINITY, |t| t + after_change * unit_s);
        let from_s = (times[self.peak?] + after_peak * unit_s).max(changed_s);
        let first = times.partition_point(|&time| time < from_s);
        (first + 1 < times.len() && times[times.len() - 1] - times[first] >= window * unit_s)
            .then_some(first)
    }

    fn window(&self) -> Window {
        let opened = self.from(OPENING, 0.0, 0.0);
        let settled = self.from(SETTLING, SETTLING_ON_FINER_GRID, FIRST_WINDOW);
        // A run too short to settle still shows what follows its opening, or its second half, marked as such.
        let end = self.times.len();
        let first = settled
            .or(opened)
            .unwrap_or_else(|| self.released + (end - self.released) / 2);
        Window {
            first,
            end,
            batch: samples(BATCH, self.rate),
            length: (self.times[end - 1] - self.times[first]) / self.unit_s,
            peak: self.peak,
            opened: opened.is_some(),
            settled: settled.is_some(),
        }
    }
}

/// Samples in so many D₀/U.
fn samples(units: f64, rate: f64) -> usize {
    (units * rate).round().max(1.0) as usize
}

/// Chooses the averaging window of a canopy's record; `unit_s` is D₀/U. `None` before two samples exist after release.
#[must_use]
pub fn window(record: &Record, unit_s: f64) -> Option<Window> {
    let (times, ratios) = columns(record);
    Some(Opening::new(&times, &ratios, record.grid_changed_s(), unit_s)?.window())
}

/// True if a coarser grid of a sequence has done its part: the canopy is open and the flow around it has settled.
#[must_use]
pub fn coarse_grid_is_done(record: &Record, unit_s: f64) -> bool {
    let (times, ratios) = columns(record);
    Opening::new(&times, &ratios, record.grid_changed_s(), unit_s).is_some_and(|opening| {
        opening
            .from(SETTLING, SETTLING_ON_FINER_GRID, 0.0)
            .is_some()
    })
}

fn columns(record: &Record) -> (Vec<f64>, Vec<f64>) {
    (
        record.column(&TIME),
        record.column(&PROJECTED_DIAMETER_RATIO),
    )
}

/// Mean of a column over the window, with the wider of the intervals from short and from long batches.
#[must_use]
pub fn mean(record: &Record, column: &ReadOut, window: &Window) -> Mean {
    let column = record.column(column);
    mean_of(
        &column[window.first..window.end.min(column.len())],
        window.batch,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples per D₀/U.
    const RATE: usize = 20;

    /// Times in D₀/U, and a diameter that peaks after 2 and breathes.
    fn opening(length: f64) -> (Vec<f64>, Vec<f64>) {
        (0..=(length * RATE as f64) as usize)
            .map(|k| {
                let time = k as f64 / RATE as f64;
                let diameter = if time < 2.0 {
                    0.4 * time
                } else {
                    0.72 + 0.08 * (std::f64::consts::TAU * (time - 2.0) / 1.8).cos()
                };
                (time, diameter)
            })
            .unzip()
    }

    #[test]
    fn averages_begin_when_the_wake_has_settled() {
        let (times, ratios) = opening(30.0);
        let window = |length: f64, changed| {
            let end = (length * RATE as f64) as usize;
            Opening::new(&times[..end], &ratios[..end], changed, 1.0)
                .unwrap()
                .window()
        };
        let from = |window: Window| times[window.first];
        let opening = window(3.0, None);
        assert!(!opening.opened && !opening.settled);
        let opened = window(10.0, None);
        assert!(opened.opened && !opened.settled);
        assert!((from(opened) - 6.0).abs() < 0.11, "{opened:?}");
        // Less than a breath of settled wake does not take the place of what there was.
        let barely = window(21.5, None);
        assert!(barely.opened && !barely.settled);
        assert!((from(barely) - 6.0).abs() < 0.11, "{barely:?}");
        let settled = window(26.5, None);
        assert!(settled.opened && settled.settled);
        assert!((from(settled) - 20.0).abs() < 0.11, "{settled:?}");
        // A finer grid taken when the coarse one had settled: its own start decides.
        let finer = window(26.5, Some(20.0));
        assert!((from(finer) - 22.0).abs() < 0.11, "{finer:?}");
        // Until then nothing from the coarse grid is in the window.
        let changed = window(21.5, Some(20.0));
        assert!(changed.opened && !changed.settled);
        assert!((from(changed) - 20.0).abs() < 0.11, "{changed:?}");
    }

    /// Breathing with a period of 1.8, over noise that wanders slowly: what the drag of a canopy does. The interval must cover the mean in
    /// about 95 % of the trials, and not because it is useless.
    #[test]
    fn intervals_cover_the_mean_of_a_breathing_canopy() {
        let mut state = 7_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let batch = (BATCH * RATE as f64) as usize;
        for length in [6, 8, 12, 16, 24, 29, 48] {
            let (mut covered, mut widths) = (0, 0.0);
            for _ in 0..400 {
                let phase = uniform();
                let mut wander = 0.06 * (uniform() + uniform() + uniform());
                let series: Vec<f64> = (0..length * RATE)
                    .map(|k| {
                        let time = k as f64 / RATE as f64;
                        wander += -wander / (5.0 * RATE as f64)
                            + 0.055 * uniform() / (RATE as f64).sqrt();
                        let turn = std::f64::consts::TAU * (time / 1.8 + phase);
                        0.85 + 0.2 * turn.cos() + wander
                    })
                    .collect();
                let mean = mean_of(&series, batch);
                covered += usize::from((mean.value - 0.85).abs() <= mean.confidence.unwrap());
                widths += mean.confidence.unwrap() / 0.85 / 400.0;
            }
            assert!(covered >= 360, "{length}: {covered} of 400");
            assert!(widths < 0.1, "{length}: {widths}");
        }
    }
}
