//! The phases of a run, a file each, executed in the plan's order ([`crate::plan::phases`]).

mod change_lattice;
mod equilibrium;
mod lattice;
mod load_test;
mod march;
mod open_canopy;
mod panel_shaping;
mod stand;
mod trim;

use std::time::Instant;

pub(super) use lattice::{Lattice, detector};
pub(super) use stand::Stand;

use super::fault::caught;
use super::{INTERRUPTED, Observer, Run, RunError};
use crate::plan::{Phase, phases};
use stand::Next;

/// Parts that the progress of a phase without time is told in.
const PARTS: u64 = 1000;

impl Run<'_> {
    /// Executes the phases that are left; returns why the run ended.
    pub(super) fn drive(&mut self, observer: &mut dyn Observer) -> Result<String, RunError> {
        let (scene, coarser) = (&self.case.scene, &self.case.coarser);
        let phases = phases(scene, coarser);
        self.last_checkpoint = Instant::now();
        self.detector = if self.to_the_end {
            None
        } else {
            detector(scene)
        };
        // Windows that were looked at before an interrupt.
        if let Some(detector) = &mut self.detector {
            detector.skip_looks(&self.record);
        }
        while let Some(&phase) = phases.get(self.stand.phase) {
            observer.phase_begins();
            let next = match phase {
                Phase::OpenCanopy => self.open_canopy(observer)?,
                Phase::RaiseWind => self.raise_wind(observer)?,
                Phase::March { .. } => self.march(observer)?,
                Phase::ChangeLattice { .. } => self.change_grid(observer)?,
                Phase::Equilibrium => self.seek_equilibrium(observer)?,
                Phase::Trim => self.seek_trim(observer)?,
                Phase::PanelShaping => self.shape_panels(observer)?,
                Phase::LoadTest => self.test_loads(observer)?,
            };
            match next {
                Next::Phase => self.stand.phase += 1,
                Next::AfterTime => {
                    let is_march = |phase: &Phase| matches!(phase, Phase::March { .. });
                    let last = phases.iter().rposition(is_march);
                    self.stand.phase = last.unwrap_or(self.stand.phase) + 1;
                }
                Next::Interrupted => {
                    self.statics.leave(scene, &mut self.simulation)?;
                    return Ok(INTERRUPTED.to_owned());
                }
                Next::End(reason) => return Ok(reason),
            }
        }
        Ok(self.stand.reason.clone())
    }

    /// After an error: brings back what the results are read from, the wing's own mesh under the loads of its equilibrium.
    pub(super) fn leave_phase(&mut self) {
        let scene = &self.case.scene;
        // The error is the cause, whatever fails now.
        let _ = caught(|| self.statics.leave(scene, &mut self.simulation));
    }

    /// Between two parts of a phase: writes a checkpoint if one is due; true if the run is to stop, with its checkpoint written.
    fn pause(&mut self, observer: &mut dyn Observer) -> Result<bool, RunError> {
        if self.requests.to_stop() {
            self.save()?;
            return Ok(true);
        }
        let asked = self.requests.takes_checkpoint();
        if asked || self.is_checkpoint_due() {
            let saved = self.try_save(observer)?;
            self.last_checkpoint = Instant::now();
            if asked && saved {
                let time_s = self.simulation.time_s();
                observer.note(&format!("checkpoint at t = {time_s:.6} s, as asked for"));
            }
        }
        Ok(false)
    }

    fn is_checkpoint_due(&self) -> bool {
        self.last_checkpoint.elapsed() >= self.checkpoint_interval
    }

    /// True if the next [`Run::pause`] will read the state.
    fn is_to_pause(&self) -> bool {
        self.requests.to_stop() || self.requests.wants_checkpoint() || self.is_checkpoint_due()
    }

    /// Seeks the trim, or the equilibrium, that the case asks for.
    fn balance(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        observer.phase_begins();
        let wing = self.case.scene.wing();
        if wing.is_some_and(|wing| wing.trim.is_some()) {
            self.seek_trim(observer)
        } else {
            self.seek_equilibrium(observer)
        }
    }

    /// Notes how an equilibrium or a trim ended; `out_of_balance`: why the results are not those of one.
    fn settle_balance(
        &mut self,
        reason: String,
        out_of_balance: Option<String>,
        observer: &mut dyn Observer,
    ) -> Result<Next, RunError> {
        observer.note(&reason);
        self.stand.reason = reason;
        self.stand.unbalanced = out_of_balance.is_some();
        self.stand.balance_notes = out_of_balance.into_iter().collect();
        self.whole = false;
        self.sample(observer)?;
        Ok(Next::Phase)
    }
}
