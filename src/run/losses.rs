//! Devices that are lost in the midst of a run: unplugged, reset by their driver, or silent. The device is opened anew, and the run goes on from its
//! last checkpoint.

use super::error::RunError;
use super::order::{Observer, Order};
use crate::checkpoint;
use crate::gpu::{Device, DeviceError};
use crate::plan::{Plan, free_memory};

/// True if the host has the memory that a plan needs: where a device was to hold the air, this was not asked before.
pub(super) fn has_room(plan: &Plan) -> bool {
    plan.sizes.fit_into(free_memory()).is_ok()
}

/// What the losses of a run have left.
#[derive(Debug, Default)]
pub(super) struct Losses {
    /// Step at which the last one was.
    last: Option<u64>,
    /// What is to be said of them at the end.
    pub(super) notes: Vec<String>,
}

impl Losses {
    /// Makes `order` go on after a loss at `step`, by its fallback where the device does not open any more.
    ///
    /// # Errors
    ///
    /// `error` itself where it is another than a loss, without a checkpoint, and where the run has come no further than at the loss before: a device that
    /// is lost again and again at one place is given up.
    pub(super) fn survive(
        &mut self,
        order: &mut Order,
        step: u64,
        error: RunError,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let further = self.last.is_none_or(|last| step > last);
        let (RunError::Device(DeviceError::Lost(why)), Some(device), true) = (
            &error,
            &order.device,
            further && checkpoint::exists(order.folder),
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
            (Err(refused), Some(plan)) if has_room(plan) => (
                format!(
                    "{lost}, and did not open again ({refused}); the CPU went on from the last checkpoint"
                ),
                order.on_cpu(plan).going_on(),
            ),
            (Err(_), _) => return Err(error),
        };
        observer.note(&note);
        self.notes.push(note);
        *order = going_on;
        self.last = Some(step);
        Ok(())
    }
}
