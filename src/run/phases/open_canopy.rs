//! Phase `open_canopy`: loading pressure opens a folded canopy before the wind rises.

use super::stand::Next;
use crate::run::{Observer, Run, RunError};

impl Run<'_> {
    pub(super) fn open_canopy(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        observer.note("opening the folded canopy by loading pressure");
        self.whole = false;
        self.simulation.open_canopy()?;
        self.whole = true;
        if let Some(opening) = self.simulation.opening() {
            observer.note(&format!(
                "canopy opened by loading pressure: D_p/D_0 {:.3} -> {:.3} in {} steps",
                opening.folded_ratio, opening.opened_ratio, opening.steps
            ));
        }
        self.good = self.simulation.structure_frame();
        self.sampled = self.good.clone();
        Ok(Next::Phase)
    }
}
