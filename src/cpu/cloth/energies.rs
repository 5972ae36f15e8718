//! Energies of a structure in motion, and what is done to it in a step.
//!
//! Work is force times way, with the mean of the forces at both ends of the step: of second order, like BDF2. Held nodes have no kinetic and no
//! potential energy; what moves them does work.

use glam::DVec3;

use super::dashpots::dashpots;
use super::nodal_forces::elastic_gradient;
use super::{Cloth, StepBefore, StepInput};

/// What is done to a structure in a step [J].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepWork {
    /// By the air.
    pub of_air_j: f64,
    /// By supports that are moved.
    pub of_supports_j: f64,
    /// By the acceleration of the frame.
    pub of_frame_j: f64,
    /// What damping takes, of the mass and of lines.
    pub lost_to_damping_j: f64,
}

impl Cloth {
    /// Elastic energy of fabric, lines and guides where the structure is, that of contact included [J].
    #[must_use]
    pub fn elastic_energy_j(&self) -> f64 {
        let contact = self.contact_state().map_or(0.0, |contact| contact.energy_j);
        contact + self.elastic(&self.positions_m).0
    }

    /// Kinetic energy of nodes that can move [J].
    #[must_use]
    pub fn kinetic_energy_j(&self) -> f64 {
        self.free_nodes()
            .map(|node| {
                0.5 * self.structure.masses_kg[node] * self.velocities_m_s[node].length_squared()
            })
            .sum()
    }

    /// Potential energy of nodes that can move against where they were built, in gravity and under loads of single nodes [J].
    #[must_use]
    pub fn potential_energy_j(&self, gravity_m_s2: DVec3) -> f64 {
        self.free_nodes()
            .map(|node| {
                let way = self.positions_m[node] - self.structure.positions_m[node];
                let load_n = self
                    .structure
                    .loads_n
                    .get(node)
                    .copied()
                    .unwrap_or_default();
                -(gravity_m_s2 * self.structure.masses_kg[node] + load_n).dot(way)
            })
            .sum()
    }

    /// What was done in the step that came from `before`; `air_n` are the forces of the air at its start and at its end, `[node_count]`.
    #[must_use]
    pub fn work_j(
        &self,
        before: &StepBefore,
        (input, frame_m_s2): (&StepInput, DVec3),
        air_n: [&[DVec3]; 2],
    ) -> StepWork {
        let structure = &self.structure;
        let way = |node: usize| self.positions_m[node] - before.positions_m[node];
        let mut work = StepWork::default();
        for node in self.free_nodes() {
            let (way, mass) = (way(node), structure.masses_kg[node]);
            let air = air_n[0][node] + air_n[1][node];
            work.of_air_j += 0.5 * air.dot(way);
            work.of_frame_j += mass * frame_m_s2.dot(way);
            let speeds = before.velocities_m_s[node] + self.velocities_m_s[node];
            work.lost_to_damping_j += 0.5 * input.damping_1_s * mass * speeds.dot(way);
        }
        // In a unit of time displacements are velocities.
        for dashpot in dashpots(structure, &before.positions_m, Some(1.0)) {
            let [a, b] = dashpot.nodes.map(|n| n as usize);
            let rates = [&before.velocities_m_s, &self.velocities_m_s]
                .map(|velocities| (velocities[b] - velocities[a]).dot(dashpot.direction));
            let pull_n = 0.5 * dashpot.stiffness_n_m * (rates[0] + rates[1]);
            let [of_a, of_b] = [a, b].map(|node| pull_n * way(node).dot(dashpot.direction));
            work.lost_to_damping_j += of_b - of_a;
            // What a held end is pulled with is the support's.
            work.of_supports_j += f64::from(u8::from(structure.held[b])) * of_b;
            work.of_supports_j -= f64::from(u8::from(structure.held[a])) * of_a;
        }
        if !input.moved_supports.is_empty() {
            let pulls = [&before.positions_m, &self.positions_m].map(|x| self.elastic(x).1);
            for &(node, _) in input.moved_supports {
                let node = node as usize;
                if structure.held[node] {
                    work.of_supports_j += 0.5 * (pulls[0][node] + pulls[1][node]).dot(way(node));
                }
            }
        }
        work
    }

    fn free_nodes(&self) -> impl Iterator<Item = usize> {
        let held = self.structure.held.iter().enumerate();
        held.filter(|(_, held)| !**held).map(|(node, _)| node)
    }

    /// Energy [J] and gradient [N] of all elements.
    fn elastic(&self, positions_m: &[DVec3]) -> (f64, Vec<DVec3>) {
        let mut gradient = vec![DVec3::ZERO; self.structure.node_count()];
        let energy = elastic_gradient(
            &self.structure,
            &self.prepared.gather,
            positions_m,
            &mut super::Pulls::default(),
            &mut gradient,
        );
        (energy, gradient)
    }
}
