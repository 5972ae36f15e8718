//! Fabric and cables on the CPU, in `f64`.
//!
//! * [`gather`]: which elements meet at every node;
//! * [`nodal_forces`]: elastic energy and its gradient;
//! * [`initial_hessian`]: block-Jacobi approximation of the Hessian;
//! * [`stiffness`]: the whole Hessian, for multigrid;
//! * [`integration`]: what velocities of a step count from;
//! * [`membrane_lanes`], [`cone`]: membranes in the lanes of vectors, and how wrinkles are found there;
//! * [`loads`], [`pressure`]: what acts during a step;
//! * `energies`: energies, and the work of a step;
//! * [`line_drag`]: drag of suspension lines;
//! * `cut_reactions`, [`triangle_reaction`]: reactions of the air where the fabric cuts the lattice;
//! * `reactions`: all that the air does in a step;
//! * `marker_sums`: reactions of the air at markers, summed by triangle;
//! * [`permeable`]: reactions of the air where it passes the fabric;
//! * `softened`, `stiffened`: what the driver asks that stiffens slack structures step by step;
//! * [`read_outs`]: tensions and reactions;
//! * `residual`: what the residual stiffness carries;
//! * [`contact`]: fabric that meets itself;
//! * `objective`: what a step minimises;
//! * `driver`: which minimiser drives a solve;
//! * [`probe`]: one trial, for comparing engines;
//! * [`evaluator`]: energy and gradient one by one, for other minimisers;
//! * `whole_balance`: what a static solve of fabric on lines leaves over, as a whole;
//! * [`solve_cloth`]: the implicit step, or the static equilibrium, driven by [`crate::solve::lbfgs`], [`crate::solve::newton`] or [`crate::solve::stiffening`].

pub mod cone;
pub mod contact;
mod cut_reactions;
pub mod dashpots;
pub mod driver;
mod edges;
mod energies;
pub mod evaluator;
pub mod gather;
pub mod initial_hessian;
pub mod integration;
pub mod line_drag;
pub mod loads;
mod marker_sums;
pub mod membrane_lanes;
pub mod nodal_forces;
mod objective;
pub mod permeable;
pub mod pressure;
pub mod probe;
mod reactions;
pub mod read_outs;
mod residual;
pub mod settings;
mod softened;
pub mod solve_cloth;
mod stiffened;
pub mod stiffness;
pub mod triangle_reaction;
mod vectors;
mod whole_balance;

use std::time::Duration;

use glam::DVec3;

pub use contact::ContactState;
use contact::Contacts;
use gather::Gather;
use nodal_forces::Pulls;

use crate::cloth::Structure;
pub use crate::cloth::TimeIntegration;
use crate::solve::block_cholesky::BlockCholesky;
use crate::solve::multigrid::Multigrid;
pub use energies::StepWork;
pub use evaluator::Evaluator;
pub use integration::StepBefore;
pub use loads::{MarkerReaction, NodalDrag, StepInput};
pub use pressure::Pressure;
pub use probe::Probe;
pub use settings::SolverSettings;
pub use triangle_reaction::{MiddleReaction, TriangleReaction};

pub use crate::solve::InitialHessian;

/// Moving state of a structure.
#[derive(Debug, Clone)]
pub struct Cloth {
    /// What moves.
    pub structure: Structure,
    /// Positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Velocities [m/s], `[node_count]`.
    pub velocities_m_s: Vec<DVec3>,
    /// Where it was a step before; `None` where a step has nothing before it.
    pub step_before: Option<StepBefore>,
    /// Momentum that the last solve gave the nodes that can move, as its own balance has it, until somebody takes it [kg m/s].
    pub momentum_given_kg_m_s: DVec3,
    /// What can be prepared once for the structure.
    prepared: Prepared,
}

/// What serves all solves of a structure.
#[derive(Debug, Clone, Default)]
struct Prepared {
    gather: Gather,
    pulls: Pulls,
    /// Made when first asked for.
    multigrid: Option<Multigrid>,
    /// Made when first asked for.
    cholesky: Factor,
    /// `None` for a structure that passes through itself.
    contacts: Option<Contacts>,
}

/// A factorisation, which a copy makes anew.
#[derive(Debug, Default)]
struct Factor(Option<BlockCholesky>);

impl Clone for Factor {
    fn clone(&self) -> Self {
        Self(None)
    }
}

impl Prepared {
    /// The levels of the structure, made if they are not yet.
    fn multigrid(&mut self, structure: &Structure) -> &mut Multigrid {
        self.multigrid
            .get_or_insert_with(|| Multigrid::new(stiffness::graph(structure)))
    }
}

impl Cloth {
    /// The structure as it starts.
    #[must_use]
    pub fn new(structure: Structure) -> Self {
        Self {
            positions_m: structure.positions_m.clone(),
            velocities_m_s: if structure.start_velocities_m_s.is_empty() {
                vec![DVec3::ZERO; structure.node_count()]
            } else {
                structure.start_velocities_m_s.clone()
            },
            step_before: None,
            momentum_given_kg_m_s: DVec3::ZERO,
            prepared: Prepared {
                gather: Gather::new(&structure),
                contacts: Contacts::new(&structure),
                ..Prepared::default()
            },
            structure,
        }
    }

    /// Makes now what a solve with this initial Hessian would make when it is first needed.
    pub fn prepare(&mut self, initial_hessian: InitialHessian) {
        if initial_hessian == InitialHessian::Multigrid {
            self.prepared.multigrid(&self.structure);
        }
    }

    /// Multigrid cycles so far.
    #[must_use]
    pub fn multigrid_cycles(&self) -> u64 {
        self.prepared
            .multigrid
            .as_ref()
            .map_or(0, Multigrid::cycles)
    }

    /// What contact did at the end of the last solve; `None` for a structure that passes through itself.
    #[must_use]
    pub fn contact_state(&self) -> Option<&ContactState> {
        self.prepared.contacts.as_ref().map(|c| &c.state)
    }

    /// Takes what contact did from a checkpoint; its vectors are `[node_count]`.
    pub fn restore_contact_state(&mut self, state: ContactState) {
        if let Some(contacts) = &mut self.prepared.contacts {
            contacts.restore(state);
        }
    }

    /// Wall time that contact has taken so far.
    #[must_use]
    pub fn contact_time(&self) -> Duration {
        self.prepared
            .contacts
            .as_ref()
            .map_or(Duration::ZERO, |c| c.time)
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
}
