//! What a run asked of its device, for `summary.json`.

use crate::gpu::DeviceWork;
use crate::output::{DeviceCounts, DeviceLatency, DevicePass, DeviceStage, DeviceUse};
use crate::simulation::Simulation;

fn counts(work: &DeviceWork) -> DeviceCounts {
    DeviceCounts {
        dispatches: work.dispatches as f64,
        passes: work.passes as f64,
        submits: work.submits as f64,
        writes: work.writes as f64,
        written_bytes: work.written_bytes as f64,
        maps: work.maps as f64,
        mapped_bytes: work.mapped_bytes as f64,
        waited_s: 1e-9 * work.waited_ns as f64,
    }
}

/// What was counted, and timed if it was; `None` where no device computes.
pub(super) fn of(simulation: &Simulation) -> Option<DeviceUse> {
    let device = simulation.device()?;
    let cost = simulation.cost();
    let mut in_stages = DeviceWork::default();
    let mut stages = Vec::new();
    for planned in &simulation.plan().stages {
        let work = cost.of(planned.stage).device;
        in_stages += work;
        if work != DeviceWork::default() {
            stages.push(DeviceStage {
                stage: planned.stage.name().to_owned(),
                counts: counts(&work),
            });
        }
    }
    let besides = device.work().since(&cost.device_before).since(&in_stages);
    // What cannot be fetched any more is left out: the run has its own report of a device that failed.
    let passes = device.pass_times().ok().flatten().map(|times| {
        let pass = |time: crate::gpu::PassTime| DevicePass {
            pass: time.pass,
            passes: time.passes,
            seconds: time.seconds,
        };
        times.into_iter().map(pass).collect()
    });
    let latencies = device.latencies().map(|latencies| {
        let row = |(name, seconds, meaning): (&str, f64, &str)| DeviceLatency {
            name: name.to_owned(),
            seconds,
            meaning: meaning.to_owned(),
        };
        latencies.rows().into_iter().map(row).collect()
    });
    Some(DeviceUse {
        steps: cost.steps,
        per_step: counts(&in_stages).per(cost.steps.max(1) as f64),
        stages,
        besides_the_stages: counts(&besides),
        passes,
        latencies,
    })
}
