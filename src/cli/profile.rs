//! What every stage of a step took, for `ripstop run --profile`: by the host's clock, by the device's own, and in round trips.

use std::fmt::Write;
use std::time::Duration;

use crate::output::{DeviceCounts, DeviceUse, Summary};

/// Time for which each latency of the device is measured before the run.
pub(super) const LATENCY_TIME: Duration = Duration::from_millis(30);

/// All that is known of a run's time.
pub(super) fn text(summary: &Summary) -> String {
    let mut text = stages(summary);
    if let Some(device) = &summary.device_use {
        text.push_str(&counts(device));
        text.push_str(&passes(device, summary));
        text.push_str(&latencies(device));
    }
    text
}

/// Rows of a table: name, calls, seconds, with milliseconds per call and the share of `whole_s`. Writing to a String cannot fail.
fn times<'a>(
    [name, calls, share]: [&str; 3],
    whole_s: f64,
    rows: impl Iterator<Item = (&'a str, u64, f64)>,
) -> String {
    let mut text = format!(
        "{name:<22} {calls:>9} {:>13} {:>9} {share:>8}\n",
        "ms per call", "s"
    );
    for (name, calls, seconds) in rows {
        let _ = writeln!(
            text,
            "{name:<22} {calls:>9} {:>13.4} {seconds:>9.2} {:>6.1} %",
            1e3 * seconds / calls.max(1) as f64,
            100.0 * seconds / whole_s.max(f64::MIN_POSITIVE)
        );
    }
    text
}

/// What the stages took by the host's clock.
fn stages(summary: &Summary) -> String {
    let stages = summary.stages.iter();
    let whole_s = stages.clone().map(|stage| stage.seconds).sum();
    let rows = stages.map(|stage| (stage.stage.as_str(), stage.calls, stage.seconds));
    times(["stage", "calls", "share"], whole_s, rows)
}

/// What every stage asks of the device, per step.
fn counts(device: &DeviceUse) -> String {
    let mut text = format!(
        "\nasked of the device, per step, over {} steps since release\n{:<22} {:>10} {:>8} {:>8} {:>8} {:>9} {:>6} {:>9} {:>10}\n",
        device.steps,
        "stage",
        "dispatches",
        "passes",
        "submits",
        "writes",
        "kB to it",
        "maps",
        "kB back",
        "ms waited"
    );
    let mut row = |name: &str, counts: DeviceCounts| {
        let _ = writeln!(
            text,
            "{name:<22} {:>10.2} {:>8.2} {:>8.2} {:>8.2} {:>9.2} {:>6.2} {:>9.2} {:>10.4}",
            counts.dispatches,
            counts.passes,
            counts.submits,
            counts.writes,
            1e-3 * counts.written_bytes,
            counts.maps,
            1e-3 * counts.mapped_bytes,
            1e3 * counts.waited_s,
        );
    };
    let steps = device.steps.max(1) as f64;
    for stage in &device.stages {
        row(&stage.stage, stage.counts.per(steps));
    }
    row("a step", device.per_step);
    row("besides", device.besides_the_stages.per(steps));
    text
}

/// What the passes took by the device's own clock.
fn passes(device: &DeviceUse, summary: &Summary) -> String {
    let Some(passes) = &device.passes else {
        return "\nthe device has no clock of its own\n".to_owned();
    };
    let rows = passes.iter();
    let rows = rows.map(|pass| (pass.pass.as_str(), pass.passes, pass.seconds));
    let table = times(["pass", "passes", "of run"], summary.wall_s, rows);
    format!("\nby the device's own clock\n{table}")
}

fn latencies(device: &DeviceUse) -> String {
    let Some(latencies) = &device.latencies else {
        return String::new();
    };
    let mut text = "\nlatencies of the device, medians [µs]\n".to_owned();
    for latency in latencies {
        let _ = writeln!(
            text,
            "{:<22} {:>9.2}   {}",
            latency.name,
            1e6 * latency.seconds,
            latency.meaning
        );
    }
    text
}
