//! What of a simulation goes into a checkpoint: everything that the next step reads and that the scene does not define.

use std::io;

use super::energy_account::EnergyAccount;
use super::{Opening, Origin, Simulation, SolverAccount};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{ContactState, StepBefore};

/// Where the nodes are.
pub const POSITIONS_SECTION: &str = "positions";

impl Simulation {
    /// Writes the state.
    pub fn save(&mut self, out: &mut Writer) -> io::Result<()> {
        out.put("step", &[self.step])?;
        out.put("origin_step", &[self.origin.step, self.plan.start_steps])?;
        out.put("origin_time", &[self.origin.time_s])?;
        if let Some(air) = &self.air {
            air.save(out)?;
        }
        if let Some(cloth) = &self.cloth {
            out.put(POSITIONS_SECTION, &cloth.positions_m)?;
            out.put("velocities", &cloth.velocities_m_s)?;
            if let Some(before) = &cloth.step_before {
                out.put("step_before_positions", &before.positions_m)?;
                out.put("step_before_velocities", &before.velocities_m_s)?;
                out.put("step_before", &[before.time_step_s])?;
            }
            if let Some(contact) = cloth.contact_state() {
                out.put("contact_forces", &contact.forces_n)?;
                out.put("contact_searched", &contact.searched_m)?;
                let numbers = [
                    contact.energy_j,
                    contact.smallest_gap_m,
                    contact.room_m,
                    contact.vain,
                ];
                out.put("contact", &numbers)?;
            }
        }
        if self.cloth.is_some() {
            self.account.save(out)?;
            self.energy.save(out)?;
        }
        if let Some(opening) = &self.opening {
            opening.save(out)?;
        }
        if let Some(coupled) = &self.coupled {
            coupled.save(out)?;
            out.put("largest_marker_motion", &[self.largest_marker_motion])?;
        }
        if let Some(cadence) = &self.cadence {
            cadence.save(out)?;
        }
        if let Some(adaptive) = &self.adaptive {
            adaptive.save(out)?;
        }
        if let Some(descent) = &self.descent {
            descent.save(out)?;
        }
        if let Some(own_steps) = &self.own_steps {
            own_steps.save(out)?;
        }
        if self.has_drags() {
            self.save_drags(out)?;
        }
        if let (Some(impulses), Some(air)) = (&mut self.impulses, &self.air) {
            impulses.save(out, air.finest())?;
        }
        Ok(())
    }

    /// Takes the state from a checkpoint of the same case.
    pub fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        self.step = from.take_exactly("step", 1)?[0];
        self.sound_step = self.step;
        let steps: Vec<u64> = from.take_exactly("origin_step", 2)?;
        self.plan.start_steps = steps[1];
        self.origin = Origin {
            step: steps[0],
            time_s: from.take_exactly("origin_time", 1)?[0],
        };
        if self.origin.time_s > 0.0 && self.origin.step < self.plan.start_steps {
            return Err(from.damaged("its steps are counted from before the release".to_owned()));
        }
        self.count_steps();
        if let Some(air) = &mut self.air {
            air.restore(from)?;
        }
        if let Some(cloth) = &mut self.cloth {
            let nodes = cloth.structure.node_count();
            cloth.positions_m = from.take_exactly(POSITIONS_SECTION, nodes)?;
            cloth.velocities_m_s = from.take_exactly("velocities", nodes)?;
            cloth.step_before = if from.has("step_before") {
                Some(StepBefore {
                    positions_m: from.take_exactly("step_before_positions", nodes)?,
                    velocities_m_s: from.take_exactly("step_before_velocities", nodes)?,
                    time_step_s: from.take_exactly("step_before", 1)?[0],
                })
            } else {
                None
            };
            if cloth.contact_state().is_some() {
                let forces_n = from.take_exactly("contact_forces", nodes)?;
                let numbers: Vec<f64> = from.take_exactly("contact", 4)?;
                cloth.restore_contact_state(ContactState {
                    forces_n,
                    energy_j: numbers[0],
                    smallest_gap_m: numbers[1],
                    searched_m: from.take_exactly("contact_searched", nodes)?,
                    room_m: numbers[2],
                    vain: numbers[3],
                });
            }
        }
        if self.cloth.is_some() {
            self.account = SolverAccount::restore(from)?;
            self.energy = EnergyAccount::restore(from)?;
        }
        self.opening = Opening::restore(from)?;
        let mut hauled_to = self.step;
        if let Some(cadence) = &mut self.cadence {
            cadence.restore(from)?;
            hauled_to = cadence.end_of_span(self.step);
        }
        self.haul_risers(self.time_at(hauled_to));
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.restore(from)?;
        }
        if let Some(descent) = &mut self.descent {
            descent.restore(from)?;
        }
        if let Some(own_steps) = &mut self.own_steps {
            own_steps.restore(from)?;
        }
        if self.has_drags() {
            self.restore_drags(from)?;
        }
        if let Some(air) = &self.air {
            if let Some(coupled) = &mut self.coupled {
                coupled.restore(from, air.finest())?;
                self.largest_marker_motion = from.take_exactly("largest_marker_motion", 1)?[0];
            }
            if let Some(impulses) = &mut self.impulses {
                impulses.restore(from, air.finest())?;
            }
        }
        Ok(())
    }

    /// Counts solves from here on, as a run does that begins with a state of another one.
    pub fn count_anew(&mut self) {
        self.account = SolverAccount::default();
        self.energy = EnergyAccount::default();
        self.largest_marker_motion = 0.0;
        if let Some(cadence) = &mut self.cadence {
            cadence.count_anew();
        }
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.count_anew();
        }
    }
}
