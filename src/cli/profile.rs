//! What every stage of a step took, for `ripstop run --profile`.

use std::fmt::Write;

use crate::output::Summary;

/// Stage, calls, milliseconds per call, and share of the time of all stages.
pub(super) fn table(summary: &Summary) -> String {
    let whole: f64 = summary.stages.iter().map(|stage| stage.seconds).sum();
    let mut text = format!(
        "{:<22} {:>9} {:>13} {:>9} {:>8}\n",
        "stage", "calls", "ms per call", "s", "share"
    );
    for stage in &summary.stages {
        let _ = writeln!(
            text,
            "{:<22} {:>9} {:>13.4} {:>9.2} {:>6.1} %",
            stage.stage,
            stage.calls,
            1e3 * stage.seconds / stage.calls.max(1) as f64,
            stage.seconds,
            100.0 * stage.seconds / whole.max(f64::MIN_POSITIVE)
        );
    }
    text
}
