//! How many cells of bare air CPU threads and a device update per second: which of the two is the faster on this machine.
//!
//! An integrated GPU shares the memory of the CPU, and air is bound by memory, so neither is the faster everywhere. The box is larger than caches.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::cpu;
use crate::cpu::fluid::BodyForce;
use crate::gpu::{self, Device, DeviceError};
use crate::lattice::grid::Setup;
use crate::lattice::{Operator, Storage};

/// Cells along an edge of the box: 67 MB of populations in f32.
const SIDE: usize = 96;

/// Steps timed together, of which the quickest count: others had to wait for the machine.
const TOGETHER: usize = 2;

/// How long steps are timed.
const TIME: Duration = Duration::from_millis(200);

/// The air of canopies, without a model of its eddies.
fn setup() -> Setup {
    Setup::periodic([SIDE; 3], 0.6, Operator::StabilisedRegularised)
}

/// Updates per second of `steps`, which makes so many and waits for them; the first ones are not timed.
fn updates_per_s<E>(mut steps: impl FnMut(usize) -> Result<(), E>) -> Result<f64, E> {
    steps(1)?;
    let (began, mut quickest) = (Instant::now(), f64::INFINITY);
    while began.elapsed() < TIME || quickest.is_infinite() {
        let start = Instant::now();
        steps(TOGETHER)?;
        quickest = quickest.min(start.elapsed().as_secs_f64());
    }
    Ok((TOGETHER * SIDE.pow(3)) as f64 / quickest)
}

/// Updates per second of the threads that compute, in f32.
#[must_use]
pub fn of_cpu() -> f64 {
    let mut fluid = cpu::fluid::Fluid::<f32>::new(setup(), None);
    let Ok(pace) = updates_per_s(|count| {
        (0..count).for_each(|_| fluid.collide_stream(&BodyForce::default()));
        Ok::<(), std::convert::Infallible>(())
    });
    pace
}

/// Updates per second of a device, in f32.
///
/// # Errors
///
/// When the device fails, or cannot hold the box.
pub fn of_device(device: &Arc<Device>) -> Result<f64, DeviceError> {
    let mut fluid = gpu::fluid::Fluid::new(device, setup(), Storage::F32, None)?;
    updates_per_s(|count| {
        fluid.collide_stream_steps(count)?;
        device.wait()
    })
}
