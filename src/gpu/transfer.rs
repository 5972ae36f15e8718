//! Transfers from the device to the host.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};

use bytemuck::Pod;

use super::commands::Commands;
use super::device::{Device, TIMEOUT, TRANSFER_BYTES};
use super::error::DeviceError;

impl Device {
    /// Elements `first..first + count` of a buffer, after everything recorded so far. Buffers are whole words of four bytes, and `first` begins one.
    pub(super) fn read<T: Pod>(
        &self,
        buffer: &wgpu::Buffer,
        first: usize,
        count: usize,
    ) -> Result<Vec<T>, DeviceError> {
        let mut result = vec![T::zeroed(); count];
        let per_chunk = (TRANSFER_BYTES as usize / size_of::<T>()).max(1);
        for (index, chunk) in result.chunks_mut(per_chunk).enumerate() {
            let start = ((first + index * per_chunk) * size_of::<T>()) as u64;
            let whole_words =
                (size_of_val(chunk) as u64).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
            let staging = Staging::new(self, whole_words)?;
            let mut commands = self.record("read back");
            staging.copy(&mut commands, buffer, start, 0, whole_words);
            self.submit(commands);
            staging.read(self, |bytes| {
                let target: &mut [u8] = bytemuck::cast_slice_mut(chunk);
                let length = target.len();
                target.copy_from_slice(&bytes[..length]);
            })?;
        }
        Ok(result)
    }
}

/// A buffer on the host's side of a transfer, to be used again and again.
#[derive(Debug)]
pub(super) struct Staging {
    buffer: wgpu::Buffer,
    bytes: u64,
}

impl Staging {
    /// Room for `bytes`, a multiple of 4.
    pub(super) fn new(device: &Device, bytes: u64) -> Result<Self, DeviceError> {
        let buffer = device.buffer(
            "transfer",
            bytes,
            wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        )?;
        Ok(Self { buffer, bytes })
    }

    /// True if there is room for so many bytes.
    pub(super) const fn holds(&self, bytes: u64) -> bool {
        self.bytes >= bytes
    }

    /// Records a copy of `bytes` from `source` at byte `from` to byte `to` here.
    pub(super) fn copy(
        &self,
        commands: &mut Commands,
        source: &wgpu::Buffer,
        from: u64,
        to: u64,
        bytes: u64,
    ) {
        commands
            .raw
            .copy_buffer_to_buffer(source, from, &self.buffer, to, bytes);
    }

    /// Waits for what was submitted and shows the bytes.
    pub(super) fn read(
        &self,
        device: &Device,
        show: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceError> {
        self.read_first(device, self.bytes, show)
    }

    /// The same of the first `bytes`, a multiple of 4.
    pub(super) fn read_first(
        &self,
        device: &Device,
        bytes: u64,
        show: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceError> {
        self.read_when(device, |_| device.wait(), bytes, show)
    }

    /// The same, but waits for the submission that copies them alone: the device may work on what came after it.
    pub(super) fn read_of(
        &self,
        device: &Device,
        submitted: wgpu::SubmissionIndex,
        bytes: u64,
        show: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceError> {
        let wait = |done: &AtomicBool| device.wait_for(submitted, done);
        self.read_when(device, wait, bytes, show)
    }

    /// Shows the first `bytes` after a `wait`, which may look at the flag that is set once they are there.
    fn read_when(
        &self,
        device: &Device,
        wait: impl FnOnce(&AtomicBool) -> Result<(), DeviceError>,
        bytes: u64,
        show: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceError> {
        let (sender, receiver) = mpsc::channel();
        let done = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&done);
        self.buffer
            .map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
                // The receiver waits below, or has given up.
                let _ = sender.send(result.is_ok());
                set.store(true, Ordering::Release);
            });
        wait(&done)?;
        device.meter.mapped(bytes);
        // Another thread that polls at the same time may be the one that brings the answer, a little later.
        if receiver.recv_timeout(TIMEOUT) != Ok(true) {
            return Err(DeviceError::Lost(
                "results could not be read back".to_owned(),
            ));
        }
        self.show(device, bytes, show)
    }

    /// All of them, but `spin` waits for the flag that is set as soon as the bytes are there.
    pub(super) fn read_spinning(
        &self,
        device: &Device,
        spin: impl FnOnce(&AtomicBool) -> Result<(), DeviceError>,
    ) -> Result<(), DeviceError> {
        let done = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&done);
        // A failure is on record with the device.
        self.buffer
            .map_async(wgpu::MapMode::Read, 0..self.bytes, move |_| {
                set.store(true, Ordering::Release);
            });
        spin(&done)?;
        device.meter.mapped(self.bytes);
        self.show(device, self.bytes, |_| {})
    }

    fn show(
        &self,
        device: &Device,
        bytes: u64,
        show: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceError> {
        {
            let view = self
                .buffer
                .get_mapped_range(0..bytes)
                .map_err(|error| DeviceError::Command(format!("reading back: {error}")))?;
            show(&view);
        }
        self.buffer.unmap();
        device.check()
    }
}
