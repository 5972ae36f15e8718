//! What a run keeps of itself after a fault.

use super::Run;
use super::fault::{Fault, caught};
use super::guard::{Failing, ON_PURPOSE};

impl Run<'_> {
    /// Panics, or gives the device up, if a test asks for it at this step and the state is whole as it asks for.
    #[allow(clippy::panic, reason = "what follows a panic is to be tested")]
    /// It stays a call of its own: traces without line tables name it, too.
    #[inline(never)]
    pub(super) fn fail_on_purpose(&self) {
        let Some(fault) = &self.on_purpose else {
            return;
        };
        // Steps of all air may be several of the fabric.
        let due = self.simulation.step_count() >= fault.step;
        match fault.what {
            Failing::Between if due && self.whole => {}
            Failing::Within if due && !self.whole => {}
            Failing::Device if due && self.whole => {
                self.simulation.give_device_up();
                return;
            }
            _ => return,
        }
        panic!("a fault on purpose, as {ON_PURPOSE} asks for");
    }

    /// After a fault: writes a checkpoint, if the state is whole.
    pub(super) fn rescue(&mut self, fault: &mut Fault) {
        if !self.whole {
            return;
        }
        let saved = caught(|| {
            self.simulation.catch_up()?;
            self.save()
        });
        if matches!(saved, Ok(Ok(()))) {
            fault.kept = format!(
                "a checkpoint was written at t = {:.6} s: --resume goes on from it",
                self.simulation.time_s()
            );
        }
    }
}
