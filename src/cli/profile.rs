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

/// Stage, calls, milliseconds per call, and share of the time of all stages. Writing to a String cannot fail.
fn stages(summary: &Summary) -> String {
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
    let mut text = format!(
        "\nby the device's own clock\n{:<22} {:>9} {:>13} {:>9} {:>8}\n",
        "pass", "passes", "ms per pass", "s", "of run"
    );
    for pass in passes {
        let _ = writeln!(
            text,
            "{:<22} {:>9} {:>13.4} {:>9.2} {:>6.1} %",
            pass.pass,
            pass.passes,
            1e3 * pass.seconds / pass.passes.max(1) as f64,
            pass.seconds,
            100.0 * pass.seconds / summary.wall_s.max(f64::MIN_POSITIVE)
        );
    }
    text
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
