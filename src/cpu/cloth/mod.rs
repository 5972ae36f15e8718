//! Fabric and cables on the CPU, in `f64`.
//!
//! * [`nodal_forces`]: elastic energy and its gradient;
//! * [`initial_hessian`]: block-Jacobi approximation of the Hessian;
//! * [`solve_cloth`]: the implicit step, or the static equilibrium, driven by [`crate::solve::lbfgs`].

pub mod initial_hessian;
pub mod nodal_forces;
pub mod solve_cloth;

use glam::DVec3;

use crate::cloth::Structure;
pub use solve_cloth::{MarkerReaction, Probe, SolverSettings, StepInput};

/// Moving state of a structure.
#[derive(Debug, Clone)]
pub struct Cloth {
    /// What moves.
    pub structure: Structure,
    /// Positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Velocities [m/s], `[node_count]`.
    pub velocities_m_s: Vec<DVec3>,
}

impl Cloth {
    /// The structure at rest in its start position.
    #[must_use]
    pub fn new(structure: Structure) -> Self {
        Self {
            positions_m: structure.positions_m.clone(),
            velocities_m_s: vec![DVec3::ZERO; structure.node_count()],
            structure,
        }
    }

    /// Linear momentum of all nodes that can move [kg m/s].
    #[must_use]
    pub fn momentum_kg_m_s(&self) -> DVec3 {
        self.velocities_m_s
            .iter()
            .zip(&self.structure.masses_kg)
            .map(|(v, &m)| *v * m)
            .sum()
    }

    /// Kinetic energy [J].
    #[must_use]
    pub fn kinetic_energy_j(&self) -> f64 {
        self.velocities_m_s
            .iter()
            .zip(&self.structure.masses_kg)
            .map(|(v, &m)| 0.5 * m * v.length_squared())
            .sum()
    }
}
