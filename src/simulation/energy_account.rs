//! Account of the structure's energy since release.
//!
//! What the air, supports that are moved and the acceleration of the frame put in is found again as kinetic, elastic and potential energy, or is lost: to damping,
//! or to the integration in time and the solver's tolerance. This last part is the rest of the balance, and falls with the time step.

use std::io;

use glam::DVec3;

use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{Cloth, StepInput, StepWork};

const SECTION: &str = "energy_account";
const FORCES_SECTION: &str = "energy_account_forces";

/// Sums since the first solve.
#[derive(Debug, Clone, Default)]
pub(super) struct EnergyAccount {
    /// Kinetic, elastic and potential energy before the first solve [J].
    initial_j: Option<f64>,
    /// Work done.
    pub(super) work: StepWork,
    /// Forces of the air on every node at the end of the last solve [N], `[node_count]`; empty before the first.
    air_n: Vec<DVec3>,
    /// Kinetic, elastic and potential energy at the end of a solve over several steps [J]; `None` where every step is solved.
    held_j: Option<[f64; 3]>,
}

/// Where the energy of fabric and lines is, and where it came from [J].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energies {
    /// Of nodes that can move.
    pub kinetic_j: f64,
    /// Of fabric, lines, guides and contact.
    pub elastic_j: f64,
    /// Against where the structure was built.
    pub potential_j: f64,
    /// What was done to the structure since release.
    pub work: StepWork,
    /// What the integration in time and the solver's tolerance have taken since release.
    pub numerical_loss_j: f64,
}

/// Kinetic, elastic and potential energy.
fn parts_j(cloth: &Cloth, gravity_m_s2: DVec3) -> [f64; 3] {
    [
        cloth.kinetic_energy_j(),
        cloth.elastic_energy_j(),
        cloth.potential_energy_j(gravity_m_s2),
    ]
}

impl EnergyAccount {
    /// Notes what the structure has before its first solve.
    pub(super) fn begin(&mut self, cloth: &Cloth, gravity_m_s2: DVec3) {
        if self.initial_j.is_none() {
            self.initial_j = Some(parts_j(cloth, gravity_m_s2).iter().sum());
        }
    }

    /// Adds what was done in the last solve.
    pub(super) fn add(&mut self, cloth: &Cloth, input: &StepInput, frame_m_s2: DVec3) {
        let Some(before) = &cloth.step_before else {
            return;
        };
        let now_n = cloth.forces_of_the_air_n(input);
        if self.air_n.len() != now_n.len() {
            self.air_n.clone_from(&now_n);
        }
        let work = cloth.work_j(before, (input, frame_m_s2), [&self.air_n, &now_n]);
        self.work.of_air_j += work.of_air_j;
        self.work.of_supports_j += work.of_supports_j;
        self.work.of_frame_j += work.of_frame_j;
        self.work.lost_to_damping_j += work.lost_to_damping_j;
        self.air_n = now_n;
    }

    /// Keeps the energies at the end of a solve over several steps.
    pub(super) fn hold(&mut self, solved: Option<(&Cloth, DVec3)>) {
        self.held_j = solved.map(|(cloth, gravity_m_s2)| parts_j(cloth, gravity_m_s2));
    }

    pub(super) fn energies(&self, cloth: &Cloth, gravity_m_s2: DVec3) -> Energies {
        let [kinetic_j, elastic_j, potential_j] =
            self.held_j.unwrap_or_else(|| parts_j(cloth, gravity_m_s2));
        let now_j = kinetic_j + elastic_j + potential_j;
        let work = self.work;
        let put_in_j = work.of_air_j + work.of_supports_j + work.of_frame_j;
        let gained_j = now_j - self.initial_j.unwrap_or(now_j);
        Energies {
            kinetic_j,
            elastic_j,
            potential_j,
            work,
            numerical_loss_j: put_in_j - work.lost_to_damping_j - gained_j,
        }
    }

    pub(super) fn save(&self, out: &mut Writer) -> io::Result<()> {
        let work = &self.work;
        let [kinetic_j, elastic_j, potential_j] = self.held_j.unwrap_or([f64::NAN; 3]);
        out.put(
            SECTION,
            &[
                self.initial_j.unwrap_or(f64::NAN),
                kinetic_j,
                elastic_j,
                potential_j,
                work.of_air_j,
                work.of_supports_j,
                work.of_frame_j,
                work.lost_to_damping_j,
            ],
        )?;
        out.put(FORCES_SECTION, &self.air_n)
    }

    pub(super) fn restore(from: &Reader) -> Result<Self, CheckpointError> {
        let sums: Vec<f64> = from.take_exactly(SECTION, 8)?;
        Ok(Self {
            initial_j: (!sums[0].is_nan()).then_some(sums[0]),
            work: StepWork {
                of_air_j: sums[4],
                of_supports_j: sums[5],
                of_frame_j: sums[6],
                lost_to_damping_j: sums[7],
            },
            held_j: (!sums[1].is_nan()).then_some([sums[1], sums[2], sums[3]]),
            air_n: from.take(FORCES_SECTION)?,
        })
    }
}
