//! Results of what falls.

use super::column_max;
use crate::measure::Record;
use crate::output::{Quantity, Results};

/// What falls: largest load factor, speed at the end, height.
pub(super) fn results(results: &mut Results, record: &Record) {
    let times = record.column("time_s");
    let released = times.iter().position(|&t| t >= 0.0).unwrap_or(0);
    let (time, factor) = column_max(record, "load_factor_g", released);
    results.insert(
        "peak_load_factor_g",
        if factor.is_finite() {
            Quantity::new(factor, "1")
                .with_note(&format!("mean of a sample interval, at {time:.4} s"))
        } else {
            Quantity::missing("1", "the run ended before two samples")
        },
    );
    let speeds = record.column("descent_speed_m_s");
    let last = times
        .len()
        .saturating_sub((times.len() - released).div_ceil(4));
    if let Some(end) = speeds.get(last..).filter(|end| !end.is_empty()) {
        let mean = end.iter().sum::<f64>() / end.len() as f64;
        let change = end.last().unwrap_or(&mean) - end.first().unwrap_or(&mean);
        results.insert(
            "terminal_speed_m_s",
            Quantity::new(mean, "m/s").with_note(&format!(
                "mean of the last quarter of the run, in which it changed by {change:.3} m/s"
            )),
        );
    }
    if let Some(height) = record.latest("height_fallen_m") {
        results.insert("height_fallen_m", Quantity::new(height, "m"));
    }
}
