//! When is the mean drag known well enough, and from when on does it count?

use crate::measure::Record;
use crate::measure::statistics::{Mean, batch_mean, first_peak};

/// Averaging starts this many D₀/U after the first peak of the projected diameter.
const SETTLING: f64 = 4.0;

/// Shortest averaging window that may end a run [D₀/U].
pub const SHORTEST_WINDOW: f64 = 12.0;

/// Length of a batch, long against the breathing period of about 1.8 D₀/U.
const BATCH: f64 = 2.5;

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
    let settled = peak.map(|i| i + samples(SETTLING)).filter(|&i| i + 1 < end);
    // A run too short to settle still shows its second half, marked as such.
    let first = settled.unwrap_or_else(|| released + (end - released) / 2);
    Some(Window {
        first,
        end,
        batch: samples(BATCH),
        length: (times[end - 1] - times[first]) / unit_s,
        settled: settled.is_some(),
    })
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

/// A sentence saying why the run may stop now, or `None` to go on.
#[must_use]
pub fn reason_to_stop(record: &Record, unit_s: f64, drag_confidence: f64) -> Option<String> {
    let window = window(record, unit_s)?;
    if !window.settled || window.length < SHORTEST_WINDOW {
        return None;
    }
    let drag = mean(record, "drag_coefficient", &window);
    let confidence = drag.confidence? / drag.value.abs();
    (confidence <= drag_confidence).then(|| {
        format!(
            "steady: the mean drag coefficient {:.3} is known to ±{:.1} % (95 %, asked for {:.1} %) over {:.1} D_0/U",
            drag.value,
            100.0 * confidence,
            100.0 * drag_confidence,
            window.length
        )
    })
}
