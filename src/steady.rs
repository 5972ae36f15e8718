//! When is the mean drag known well enough, and from when on does it count?

use crate::measure::Record;
use crate::measure::statistics::{Mean, batch_mean, first_peak};

/// Averaging starts this many D₀/U after the first peak of the projected diameter.
const SETTLING: f64 = 4.0;

/// Averaging starts at least this many D₀/U after a change to a finer grid.
const SETTLING_ON_FINER_GRID: f64 = 3.0;

/// Window that a coarser grid of a sequence is given after its flow has settled [D₀/U].
const COARSE_WINDOW: f64 = 2.0;

/// Shortest averaging window that may end a run [D₀/U].
pub const SHORTEST_WINDOW: f64 = 12.0;

/// Ratio of successive window lengths at which a run may end. A test at every sample would stop at the first lucky interval and
/// so understate the error; with few looks the interval keeps most of its meaning.
const LOOK_RATIO: f64 = 1.25;

/// Length of a batch, long against the breathing period of about 1.8 D₀/U.
const BATCH: f64 = 2.0;

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
    /// True if the window starts only after the opening has settled.
    pub settled: bool,
}

/// Chooses the averaging window of a canopy's record; `unit_s` is D₀/U. `None` before two samples exist after release.
#[must_use]
pub fn window(record: &Record, unit_s: f64) -> Option<Window> {
    let times = record.column("time_s");
    let ratios = record.column("projected_diameter_ratio");
    let released = times.iter().position(|&t| t > 0.0)?;
    let end = times.len();
    if end < released + 2 {
        return None;
    }
    let interval = (times[end - 1] - times[released]) / (end - 1 - released) as f64;
    let samples = |units: f64| (units * unit_s / interval).round().max(1.0) as usize;
    let peak = first_peak(&ratios[released..], 0.8, samples(0.5)).map(|i| released + i);
    // On a finer grid the flow of the coarser one settles anew.
    let after_change = record.grid_changed_s().map_or(0, |changed| {
        let from_s = changed + SETTLING_ON_FINER_GRID * unit_s;
        times.partition_point(|&time| time < from_s)
    });
    let settled = peak
        .map(|i| (i + samples(SETTLING)).max(after_change))
        .filter(|&i| i + 1 < end);
    // A run too short to settle still shows its second half, marked as such.
    let first = settled.unwrap_or_else(|| released + (end - released) / 2);
    Some(Window {
        first,
        end,
        batch: samples(BATCH),
        length: (times[end - 1] - times[first]) / unit_s,
        peak,
        settled: settled.is_some(),
    })
}

/// True if a coarser grid of a sequence has done its part: the canopy is open and the flow around it has settled.
#[must_use]
pub fn coarse_grid_is_done(record: &Record, unit_s: f64) -> bool {
    window(record, unit_s).is_some_and(|window| window.settled && window.length >= COARSE_WINDOW)
}

/// Mean of a column over the window.
#[must_use]
pub fn mean(record: &Record, name: &str, window: &Window) -> Mean {
    let column = record.column(name);
    batch_mean(
        &column[window.first..window.end.min(column.len())],
        window.batch,
    )
}

/// Decides at a few window lengths whether a run may stop.
#[derive(Debug, Clone)]
pub struct Detector {
    unit_s: f64,
    drag_confidence: f64,
    /// Window length of the next look [D₀/U].
    next_look: f64,
}

impl Detector {
    /// Detector for a run whose D₀/U is `unit_s`, stopping at a relative half width `drag_confidence` of the mean drag.
    #[must_use]
    pub const fn new(unit_s: f64, drag_confidence: f64) -> Self {
        Self {
            unit_s,
            drag_confidence,
            next_look: SHORTEST_WINDOW,
        }
    }

    /// Passes over the looks that a record from a checkpoint has had already.
    pub fn skip_looks(&mut self, record: &Record) {
        if let Some(window) = window(record, self.unit_s).filter(|w| w.settled) {
            while window.length >= self.next_look {
                self.next_look *= LOOK_RATIO;
            }
        }
    }

    /// A sentence saying why the run may stop now, or `None` to go on.
    pub fn reason_to_stop(&mut self, record: &Record) -> Option<String> {
        let window = window(record, self.unit_s)?;
        if !window.settled || window.length < self.next_look {
            return None;
        }
        while window.length >= self.next_look {
            self.next_look *= LOOK_RATIO;
        }
        let drag = mean(record, "drag_coefficient", &window);
        let confidence = drag.confidence? / drag.value.abs();
        (confidence <= self.drag_confidence).then(|| {
            format!(
                "steady: the mean drag coefficient {:.3} is known to ±{:.1} % (batch means, 95 %; asked for {:.1} %) over {:.1} D_0/U",
                drag.value,
                100.0 * confidence,
                100.0 * self.drag_confidence,
                window.length
            )
        })
    }
}
