//! The bandwidth of a device, measured by copying: the bound that the streaming of populations is held against.

use std::time::Instant;

use super::device::Device;
use super::error::DeviceError;
use super::shaders;

/// Bytes read and written per second when a shader copies `bytes` `repeats` times; the best of three.
pub fn copy_bandwidth(device: &Device, bytes: u64, repeats: u32) -> Result<f64, DeviceError> {
    let source = device.storage("copy source", bytes)?;
    let target = device.storage("copy target", bytes)?;
    let [pipeline] = device.pipelines(&shaders::COPY, ["copy"], &[])?;
    let bound = device.bind(
        &pipeline,
        &[("copy_source", &source), ("copy_target", &target)],
    )?;
    let groups = device.workgroups(bytes / 16);
    let copy = |count: u32| -> Result<(), DeviceError> {
        let mut commands = device.record("copy");
        {
            let mut pass = commands.pass("copy");
            for _ in 0..count {
                bound.dispatch(&mut pass, groups);
            }
        }
        device.submit(commands);
        device.wait()
    };
    copy(1)?;
    let mut best: f64 = 0.0;
    for _ in 0..3 {
        let start = Instant::now();
        copy(repeats)?;
        let rate = 2.0 * bytes as f64 * f64::from(repeats) / start.elapsed().as_secs_f64();
        best = best.max(rate);
    }
    Ok(best)
}
