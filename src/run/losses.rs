//! Devices that are lost in the midst of a run: unplugged, reset by their driver, or silent. The device is opened anew, and the run goes on from its
//! last checkpoint.

use std::time::SystemTime;

use super::error::RunError;
use super::order::{Observer, Order};
use crate::checkpoint;
use crate::gpu::{Device, DeviceError};

/// What the losses of a run have left.
#[derive(Debug, Default)]
pub(super) struct Losses {
    /// When the checkpoint was written that the run went on from after the last one.
    gone_on_from: Option<SystemTime>,
    /// What is to be said of them at the end.
    pub(super) notes: Vec<String>,
}

impl Losses {
    /// Makes `order` go on after a loss, by its fallback where the device does not open any more.
    ///
    /// # Errors
    ///
    /// `error` itself where it is another than a loss, and where no checkpoint was written since the loss before: a device that is lost again and again
    /// gets no further.
    pub(super) fn survive(
        &mut self,
        order: &mut Order,
        error: RunError,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let newest = checkpoint::written_at(order.folder);
        let (RunError::Device(DeviceError::Lost(why)), Some(device), true) = (
            &error,
            &order.device,
            newest.is_some() && newest != self.gone_on_from,
        ) else {
            return Err(error);
        };
        let lost = format!("warning: the device was lost ({why})");
        let (note, going_on) = match (Device::open_again(device), &order.fallback) {
            (Ok(device), _) => (
                format!("{lost}; it opened again, and the run went on from its last checkpoint"),
                Order {
                    device: Some(device),
                    ..order.going_on()
                },
            ),
            (Err(refused), Some(plan)) => (
                format!(
                    "{lost}, and did not open again ({refused}); the CPU went on from the last checkpoint"
                ),
                order.on_cpu(plan).going_on(),
            ),
            (Err(_), None) => return Err(error),
        };
        observer.note(&note);
        self.notes.push(note);
        *order = going_on;
        self.gone_on_from = newest;
        Ok(())
    }
}
