//! Measures what asking a device costs. Times are medians, by the host's clock unless they say otherwise.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::commands::Commands;
use super::device::{Device, TIMEOUT};
use super::error::DeviceError;
use super::latency::Latencies;
use super::pipeline::Bound;
use super::shaders;
use super::transfer::Staging;

/// Dispatches or passes whose number a latency is the slope over.
const MANY: usize = 256;

/// Median time of one of many runs of `work`, which take `limit` together.
fn median(
    limit: Duration,
    mut work: impl FnMut() -> Result<Duration, DeviceError>,
) -> Result<f64, DeviceError> {
    work()?;
    let mut times = Vec::new();
    let start = Instant::now();
    while times.len() < 5 || (times.len() < 1000 && start.elapsed() < limit) {
        times.push(work()?);
    }
    times.sort_unstable();
    Ok(times[times.len() / 2].as_secs_f64())
}

fn timed(work: impl FnOnce() -> Result<(), DeviceError>) -> Result<Duration, DeviceError> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed())
}

impl Device {
    /// Measures the latencies, `limit` for each, and keeps them. Passes that are being timed are forgotten.
    pub fn measure_latencies(self: &Arc<Self>, limit: Duration) -> Result<&Latencies, DeviceError> {
        let measured = measure(self, limit)?;
        Ok(self.latencies.get_or_init(|| measured))
    }

    /// The latencies, if they were measured.
    #[must_use]
    pub fn latencies(&self) -> Option<&Latencies> {
        self.latencies.get()
    }
}

fn measure(device: &Arc<Device>, limit: Duration) -> Result<Latencies, DeviceError> {
    let untouched = device.storage("untouched", 64)?;
    let [pipeline] = device.pipelines(&shaders::EMPTY, ["empty"], &[])?;
    let empty = device.bind(&pipeline, &[("untouched", &untouched)])?;
    let staging = Staging::new(device, 16)?;
    let submit = |passes: usize, dispatches: usize| {
        let mut commands = device.record("empty");
        record(&mut commands, &empty, passes, dispatches);
        device.submit(commands);
    };
    let whole = |passes: usize, dispatches: usize| {
        median(limit / 2, || {
            timed(|| {
                submit(passes, dispatches);
                device.wait()
            })
        })
    };
    let one = whole(1, 1)?;
    let slope = |many: f64| ((many - one) / (MANY - 1) as f64).max(0.0);
    let dispatch_s = slope(whole(1, MANY)?);
    let pass_s = slope(whole(MANY, 1)?);
    let submit_s = median(limit, || {
        let took = timed(|| {
            submit(1, 1);
            Ok(())
        })?;
        device.wait()?;
        Ok(took)
    })?;
    let write_s = median(limit, || {
        let took = timed(|| {
            for _ in 0..16 {
                device.write(&untouched, 0, &[0u32; 16]);
            }
            Ok(())
        })?;
        submit(1, 1);
        device.wait()?;
        Ok(took / 16)
    })?;
    let wait_s = median(limit, || {
        timed(|| {
            submit(1, 1);
            device.sleep()
        })
    })?;
    let spin_s = median(limit, || {
        timed(|| {
            submit(1, 1);
            let done = flag();
            let set = Arc::clone(&done);
            device
                .queue
                .on_submitted_work_done(move || set.store(true, Ordering::Release));
            spin(device, &done)
        })
    })?;
    let copy = || {
        let mut commands = device.record("empty");
        record(&mut commands, &empty, 1, 1);
        staging.copy(&mut commands, &untouched, 0, 0, 16);
        device.submit(commands);
    };
    let map_s = median(limit, || {
        timed(|| {
            copy();
            device.sleep()?;
            staging.read(device, |_| {})
        })
    })?;
    let map_spin_s = median(limit, || {
        timed(|| {
            copy();
            staging.read_spinning(device, |done| spin(device, done))
        })
    })?;
    let dispatch_on_device_s = on_device(device, &empty)?;
    Ok(Latencies {
        dispatch_s,
        dispatch_on_device_s,
        pass_s,
        submit_s,
        write_s,
        wait_s,
        spin_s,
        map_s,
        map_spin_s,
    })
}

fn record(commands: &mut Commands, empty: &Bound, passes: usize, dispatches: usize) {
    for _ in 0..passes {
        let mut pass = commands.pass("empty");
        for _ in 0..dispatches {
            empty.dispatch(&mut pass, [1, 1]);
        }
    }
}

fn flag() -> Arc<AtomicBool> {
    Arc::default()
}

/// Asks the device again and again until `done`.
fn spin(device: &Device, done: &AtomicBool) -> Result<(), DeviceError> {
    let start = Instant::now();
    while !done.load(Ordering::Acquire) {
        device.check()?;
        if start.elapsed() > TIMEOUT || device.raw.poll(wgpu::PollType::Poll).is_err() {
            return Err(DeviceError::Lost("no answer to a poll".to_owned()));
        }
        std::hint::spin_loop();
    }
    Ok(())
}

/// One more dispatch by the device's clock: the medians of passes of one and of many, one fetched at a time.
fn on_device(device: &Device, empty: &Bound) -> Result<Option<f64>, DeviceError> {
    let mut medians = [0.0; 2];
    for (median, dispatches) in medians.iter_mut().zip([1, MANY]) {
        let mut times = Vec::new();
        for _ in 0..15 {
            if !device.time_passes() {
                return Ok(None);
            }
            let mut commands = device.record("empty");
            record(&mut commands, empty, 1, dispatches);
            device.submit(commands);
            let passes = device.pass_times()?.unwrap_or_default();
            times.extend(passes.iter().map(|pass| pass.seconds));
        }
        times.sort_by(f64::total_cmp);
        *median = times.get(times.len() / 2).copied().unwrap_or_default();
    }
    device.stop_timing_passes();
    let slope = (medians[1] - medians[0]) / (MANY - 1) as f64;
    Ok(Some(slope.max(0.0)))
}
