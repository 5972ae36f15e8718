//! Part of stage `solve_cloth`: the objective that an implicit step minimises, with the immersed-boundary reaction inside.
//!
//! Over the new positions x, with v = (x − x̂)/dt,
//!
//! Π(x) = ½ (v − v̂)ᵀ M (v − v̂) + E(x) − f·x + ½ dt β vᵀMv + ½ dt Σ_k K_k |v_k − u*_k|²  \[J\],
//!
//! x̂, v̂ and dt being those of [`super::integration`] (by backward Euler xⁿ, vⁿ and the step), f gravity and the pressure at the start of the step, β mass-proportional damping, v_k the velocity of marker k and K_k its
//! immersed-boundary stiffness \[kg/s\]; the fluid later gets exactly K_k (v_k − u*_k). Where air passes the fabric this term is another
//! ([`super::permeable`]), and where the fabric cuts the lattice ([`super::cut_reactions`]). Drag of single nodes adds ½ dt c |v_i − u|². Damped cables add their dissipation
//! ([`super::dashpots`]). In the static limit the terms of motion and reaction are absent, and pressure follows the fabric, −p V for
//! −f·x, or is renewed from solve to solve ([`super::pressure`]). Paper P0 (eqs. 5, 6) writes the objective for dt²·Π with the signs of E and β mixed up;
//! this is derived anew (gradient = M (v − v̂)/dt + ∇E − f + β M v + Σ K (v_k − u*_k)).
//!
//! Where the step spans k steps of the air, dt is that of all of them, and u*_k their mean (`simulation::Coupled`).

use std::convert::Infallible;

use glam::{DMat3, DVec3, Vec3};

use super::cut_reactions::CutSums;
use super::dashpots::{Dashpot, dashpots};
use super::gather::Gather;
use super::integration::StepBase;
use super::loads::{StepInput, add_pull_of_the_air, step_loads};
use super::marker_sums::MarkerSums;
use super::softened::Soft;
use super::vectors::{self, dot, each, each_summed, fill, longest_m};
use super::{Prepared, initial_hessian, nodal_forces, permeable, pressure, reactions, stiffness};
use crate::cloth::Structure;
use crate::solve::InitialHessian;
use crate::solve::block_cholesky::BlockCholesky;
use crate::solve::multigrid::Multigrid;
use crate::solve::{Attempt, Landing, Refreshed, Start, Step, VectorSpace};

/// The objective, on host vectors.
pub(super) struct Objective<'a> {
    structure: &'a Structure,
    prepared: &'a mut Prepared,
    base: StepBase<'a>,
    /// Over the base's time step.
    input: StepInput<'a>,
    /// Loads that stay [N].
    loads: Vec<DVec3>,
    /// From where the volume under pressure is seen [m]; `None` in a time step and without pressure.
    origin_m: Option<DVec3>,
    dashpots: Vec<Dashpot>,
    marker_sums: MarkerSums,
    cut_sums: CutSums,
    /// What is minimised in place of the structure while a solve stiffens it.
    soft: Option<Soft>,
    kind: InitialHessian,
    /// Of block-Jacobi.
    inverse_blocks: Vec<DMat3>,
    /// Where the gradient is added up [N].
    forces: Vec<DVec3>,
    /// H₀ g at the end, where positions cannot hold it; empty where they can [m].
    pub(super) remainder: Vec<Vec3>,
}

/// True if all nodes are held: what the air does to them need not be summed, nor block-Jacobi built.
fn nothing_moves(structure: &Structure) -> bool {
    structure.held.iter().all(|held| *held)
}

/// Legs in which the prediction of a step is approached while no fabric is in the way, each about an edge long.
const LEG_LIMIT: usize = 100;

/// Below this relative change, differences of the objective are round-off.
const ROUND_OFF: f64 = 1e-10;

impl<'a> Objective<'a> {
    pub(super) fn new(
        structure: &'a Structure,
        prepared: &'a mut Prepared,
        base: StepBase<'a>,
        input: &StepInput<'a>,
        kind: InitialHessian,
    ) -> Self {
        let input = base.input(input);
        let start = base.start_m;
        let loads = step_loads(structure, start, &input);
        if let Some(contacts) = &mut prepared.contacts {
            contacts.begin(structure, start, &input, &loads);
        }
        let cut_sums = if nothing_moves(structure) {
            CutSums::default()
        } else {
            CutSums::new(structure, &prepared.gather, &input)
        };
        Self {
            structure,
            prepared,
            loads,
            origin_m: input.pressure_follows().then(|| pressure::middle(start)),
            dashpots: dashpots(structure, start, input.time_step_s),
            marker_sums: MarkerSums::new(structure, &input),
            cut_sums,
            soft: None,
            base,
            input,
            kind,
            inverse_blocks: Vec::new(),
            forces: Vec::new(),
            remainder: Vec::new(),
        }
    }

    pub(super) fn evaluate(&mut self, point: &[DVec3], gradient: &mut [Vec3]) -> f64 {
        let mut forces = std::mem::take(&mut self.forces);
        forces.resize(point.len(), DVec3::ZERO);
        let value = self.evaluate_double(point, &mut forces);
        fill(gradient, |i| forces[i].as_vec3());
        self.forces = forces;
        value
    }

    /// The objective; writes its gradient.
    pub(super) fn evaluate_double(&mut self, point: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        let structure = self.structure;
        let Prepared { gather, pulls, .. } = &mut *self.prepared;
        let (elements, of_elements) = match &self.soft {
            Some(soft) => (&soft.structure, &soft.gather),
            None => (structure, &*gather),
        };
        let elastic = nodal_forces::elastic(elements, of_elements, point, pulls);
        let mut value = elastic.energy_j;
        let (start, loads) = (&self.base.positions_m, &self.loads);
        if let Some(dt) = self.input.time_step_s {
            let damping = self.input.damping_1_s;
            let (velocities, cuts) = (&self.base.velocities_m_s, &self.cut_sums);
            // All that a node tells by itself and its neighbours, in one pass.
            value += each_summed(gradient, |node, gradient| {
                let way = point[node] - start[node];
                let velocity = way / dt;
                let change = velocity - velocities[node];
                let mass = structure.masses_kg[node];
                let square = change.length_squared() + dt * damping * velocity.length_squared();
                let (of_air, energy) = cuts.at([start, point], dt, node);
                *gradient = elastic.at(node) - loads[node]
                    + (change / dt + velocity * damping) * mass
                    + of_air;
                0.5 * mass * square - loads[node].dot(way) + energy
            });
            value += cuts.rest_j(dt);
            let (base, sums) = ((&start[..], dt), &self.marker_sums);
            value += reactions::add_reactions(structure, sums, base, &self.input, point, gradient);
            for dashpot in &self.dashpots {
                let (dissipation, pull) = dashpot.energy_and_gradient(start, point);
                value += dissipation;
                let [a, b] = dashpot.nodes.map(|n| n as usize);
                gradient[a] -= pull;
                gradient[b] += pull;
            }
        } else {
            value += each_summed(gradient, |node, gradient| {
                *gradient = elastic.at(node) - loads[node];
                -loads[node].dot(point[node] - start[node])
            });
        }
        let jump = self.input.pressure.following();
        if let (Some(origin), false) = (self.origin_m, jump.is_none()) {
            value += pressure::add_potential(structure, gather, point, origin, jump, gradient);
        }
        if let Some(contacts) = &mut self.prepared.contacts {
            value += contacts.add_gradient(point, gradient);
        }
        for (g, &held) in gradient.iter_mut().zip(&structure.held) {
            if held {
                *g = DVec3::ZERO;
            }
        }
        value
    }

    /// Takes what the potential of following pressure lacks at `point`, and pressure that lags, into the loads, beside the `dead` ones; returns the largest change
    /// of a node's load over the largest load of pressure, or where pressure lags the root of the mean squares of both.
    pub(super) fn correct_edges(&mut self, dead: &[DVec3], point: &[DVec3]) -> f64 {
        let Some(origin) = self.origin_m else {
            return 0.0;
        };
        let jump = self.input.pressure;
        let (following, lagged) = (jump.following(), jump.lagged());
        let gather = &self.prepared.gather;
        let mut correction =
            pressure::edge_correction(self.structure, gather, point, origin, following);
        pressure::add_forces(self.structure, point, lagged, &mut correction);
        let mut pulls = vec![DVec3::ZERO; point.len()];
        pressure::add_forces(self.structure, point, jump, &mut pulls);
        let sum = |(dead, correction): (&DVec3, &DVec3)| *dead + *correction;
        let new = dead.iter().zip(&correction).map(sum).collect();
        let old = std::mem::replace(&mut self.loads, new);
        pressure::relative_change([&old, &self.loads], &pulls, !lagged.is_none())
    }

    pub(super) fn rebuild(&mut self, point: &[DVec3]) {
        if let Some(contacts) = &mut self.prepared.contacts {
            contacts.build(point);
        }
        match self.kind {
            InitialHessian::BlockJacobi => self.rebuild_blocks(point),
            InitialHessian::Multigrid => {
                let (structure, input) = (self.structure, &self.input);
                self.prepared.multigrid(structure);
                let Prepared {
                    gather,
                    multigrid,
                    contacts,
                    ..
                } = &mut *self.prepared;
                let start = &self.base.positions_m;
                let rows = contacts.as_ref().map(|c| c.rows(structure.node_count()));
                let extra = stiffness::Extra {
                    dashpots: &self.dashpots,
                    contact: rows.as_ref(),
                };
                if let Some(multigrid) = multigrid {
                    multigrid.refresh(|matrix| {
                        stiffness::assemble(
                            structure,
                            gather,
                            (input, extra),
                            [start, point],
                            matrix,
                        );
                    });
                }
            }
        }
    }

    /// Moves `point` from the start of the step, where no fabric has passed through itself, as far towards where it is as none does.
    pub(super) fn keep_apart(&mut self, point: &mut [DVec3]) {
        let Some(contacts) = &mut self.prepared.contacts else {
            return;
        };
        let mut place = self.base.start_m.to_vec();
        for _ in 0..LEG_LIMIT {
            let free = contacts.free_share(&place, |i| point[i] - place[i]);
            if free.share >= 1.0 {
                return;
            }
            each(&mut place, |i, place| {
                *place += (point[i] - *place) * free.share
            });
            if free.in_the_way {
                break;
            }
        }
        point.copy_from_slice(&place);
    }

    /// Writes where a step leads, clipped; returns its length.
    pub(super) fn move_along(
        &mut self,
        from: &Step<'_, Vec<DVec3>, Vec<Vec3>>,
        point: &mut [DVec3],
    ) -> f64 {
        let reach = from.length * longest_m(from.direction);
        let length = if reach > from.step_limit_m {
            from.length * (from.step_limit_m / reach)
        } else {
            from.length
        };
        let length = match &mut self.prepared.contacts {
            Some(contacts) => {
                let step = |i: usize| from.direction[i].as_dvec3() * length;
                length * contacts.free_share(from.point, step).share
            }
            None => length,
        };
        fill(point, |i| {
            from.point[i] + from.direction[i].as_dvec3() * length
        });
        length
    }

    pub(super) const fn structure(&self) -> &'a Structure {
        self.structure
    }

    pub(super) const fn input(&self) -> &StepInput<'a> {
        &self.input
    }

    pub(super) const fn kind(&self) -> InitialHessian {
        self.kind
    }

    /// The elements that are minimised now.
    pub(super) fn elements(&self) -> (&Structure, &Gather) {
        match &self.soft {
            Some(soft) => (&soft.structure, &soft.gather),
            None => (self.structure, &self.prepared.gather),
        }
    }

    pub(super) fn set_soft(&mut self, soft: Option<Soft>) {
        self.soft = soft;
    }

    pub(super) fn dashpots(&self) -> &[Dashpot] {
        &self.dashpots
    }

    /// x̂ [m].
    pub(super) fn counted_from_m(&self) -> &[DVec3] {
        &self.base.positions_m
    }

    /// The factorisation of the whole Hessian, if it was prepared.
    pub(super) const fn cholesky(&mut self) -> Option<&mut BlockCholesky> {
        self.prepared.cholesky.0.as_mut()
    }

    pub(super) const fn take_cholesky(&mut self) -> Option<BlockCholesky> {
        self.prepared.cholesky.0.take()
    }

    pub(super) fn put_cholesky(&mut self, cholesky: BlockCholesky) {
        self.prepared.cholesky.0 = Some(cholesky);
    }

    /// True once there is a factorisation; false where memory does not suffice.
    pub(super) fn prepare_cholesky(&mut self) -> bool {
        let cholesky = &mut self.prepared.cholesky.0;
        if cholesky.is_none() {
            *cholesky = BlockCholesky::new(&stiffness::graph(self.structure).pattern);
        }
        cholesky.is_some()
    }

    /// Estimate of the error of an objective.
    pub(super) fn round_off(objective: f64) -> f64 {
        ROUND_OFF * objective.abs()
    }

    pub(super) fn multigrid(&self) -> Option<&Multigrid> {
        self.prepared.multigrid.as_ref()
    }

    /// Adds to a product with multigrid's matrix what contact has beyond it.
    pub(super) fn add_between_sides(&self, vector: &[Vec3], product: &mut [Vec3]) {
        if let Some(contacts) = &self.prepared.contacts {
            contacts.add_between_sides(&self.structure.held, vector, product);
        }
    }

    fn rebuild_blocks(&mut self, point: &[DVec3]) {
        let structure = self.structure;
        self.inverse_blocks.clear();
        self.inverse_blocks
            .resize(structure.node_count(), DMat3::ZERO);
        if nothing_moves(structure) {
            return;
        }
        initial_hessian::add_elastic_blocks(structure, point, &mut self.inverse_blocks);
        if let Some(dt) = self.input.time_step_s {
            for (block, &mass) in self.inverse_blocks.iter_mut().zip(&structure.masses_kg) {
                let stiffness = mass / dt * (1.0 / dt + self.input.damping_1_s);
                *block += DMat3::from_diagonal(DVec3::splat(stiffness));
            }
            for drag in self.input.drags {
                self.inverse_blocks[drag.node as usize] +=
                    DMat3::IDENTITY * (drag.coefficient_kg_s / dt);
            }
            permeable::add_blocks(
                structure,
                &self.base.positions_m,
                point,
                dt,
                &self.input,
                &mut self.inverse_blocks,
            );
            for marker in self.input.impermeable_markers() {
                let nodes = structure.triangles[marker.triangle as usize].nodes;
                for (node, weight) in nodes.into_iter().zip(marker.weights) {
                    let stiffness = marker.stiffness_kg_s / dt * weight * weight;
                    self.inverse_blocks[node as usize] += marker.projection() * stiffness;
                }
            }
            self.cut_sums.add_blocks(dt, &mut self.inverse_blocks);
        }
        if let Some(contacts) = &self.prepared.contacts {
            contacts.add_blocks(&mut self.inverse_blocks);
        }
        for dashpot in &self.dashpots {
            for node in dashpot.nodes {
                self.inverse_blocks[node as usize] += dashpot.block();
            }
        }
        initial_hessian::invert(
            &mut self.inverse_blocks,
            &structure.held,
            initial_hessian::FREE_NODE_STIFFNESS,
        );
    }

    pub(super) fn apply_inverse(&mut self, vector: &[Vec3], result: &mut [Vec3]) {
        match (self.kind, &mut self.prepared.multigrid) {
            (InitialHessian::Multigrid, Some(multigrid)) => multigrid.apply(vector, result),
            _ => {
                let blocks = &self.inverse_blocks;
                fill(result, |i| (blocks[i] * vector[i].as_dvec3()).as_vec3());
            }
        }
    }

    /// The applied loads \[N\], zero where nodes are held: those that stay, pressure that follows, and the pull of the air on a sheet at rest.
    pub(super) fn acting_loads(&self, point: &[DVec3]) -> Vec<DVec3> {
        let mut loads = self.loads.clone();
        if self.origin_m.is_some() {
            let following = self.input.pressure.following();
            pressure::add_forces(self.structure, point, following, &mut loads);
        }
        add_pull_of_the_air(self.structure, &self.input, &mut loads);
        for (load, &held) in loads.iter_mut().zip(&self.structure.held) {
            if held {
                *load = DVec3::ZERO;
            }
        }
        loads
    }

    /// √(bᵀ H₀ b) of the applied loads b.
    pub(super) fn load_norm(&mut self, point: &[DVec3]) -> f64 {
        let loads = vectors::single(&self.acting_loads(point));
        let mut displacements = vec![Vec3::ZERO; loads.len()];
        self.apply_inverse(&loads, &mut displacements);
        dot(&loads, &displacements).max(0.0).sqrt()
    }
}

impl VectorSpace for Objective<'_> {
    type Point = Vec<DVec3>;
    type Vector = Vec<Vec3>;
    type Error = Infallible;

    fn point(&mut self) -> Result<Vec<DVec3>, Infallible> {
        Ok(vec![DVec3::ZERO; self.structure.node_count()])
    }

    fn positions_m(&self, point: &Vec<DVec3>) -> Option<Vec<DVec3>> {
        Some(point.clone())
    }

    fn vector(&mut self) -> Result<Vec<Vec3>, Infallible> {
        Ok(vec![Vec3::ZERO; self.structure.node_count()])
    }

    fn start(
        &mut self,
        point: &Vec<DVec3>,
        gradient: &mut Vec<Vec3>,
        preconditioned: &mut Vec<Vec3>,
    ) -> Result<Start, Infallible> {
        // A solve must not depend on what was solved before it: a run that is resumed goes on as it would have.
        if let Some(multigrid) = &mut self.prepared.multigrid {
            multigrid.forget();
        }
        self.rebuild(point);
        let objective = self.evaluate(point, gradient);
        self.apply_inverse(gradient, preconditioned);
        Ok(Start {
            objective,
            round_off: Self::round_off(objective),
            norm_square: dot(gradient, preconditioned),
            longest_m: longest_m(preconditioned),
            reference: self.load_norm(point),
        })
    }

    fn attempt(
        &mut self,
        from: &Step<'_, Vec<DVec3>, Vec<Vec3>>,
        to: &mut Landing<'_, Vec<DVec3>, Vec<Vec3>>,
        stored: &[&Vec<Vec3>],
    ) -> Result<Attempt, Infallible> {
        let length = self.move_along(from, to.point);
        let objective = self.evaluate(to.point, to.gradient);
        self.apply_inverse(to.gradient, to.preconditioned);
        let stored: Vec<&[Vec3]> = stored.iter().map(|v| v.as_slice()).collect();
        let found = vectors::products(
            [to.gradient, from.gradient],
            [to.preconditioned, from.preconditioned],
            from.direction,
            &stored,
        );
        Ok(Attempt {
            objective,
            round_off: Self::round_off(objective),
            length,
            slope: found.slope,
            slope_change: found.slope_change,
            norm_square: found.norm_square,
            gradient_change: found.gradient_change,
            change_square: found.change_square,
            longest_m: found.longest_m,
            stored: found.stored,
        })
    }

    fn refresh(
        &mut self,
        point: &Vec<DVec3>,
        gradient: &Vec<Vec3>,
        preconditioned: &mut Vec<Vec3>,
        pairs: &mut [(&Vec<Vec3>, &mut Vec<Vec3>)],
    ) -> Result<Refreshed, Infallible> {
        self.rebuild(point);
        self.apply_inverse(gradient, preconditioned);
        for (change, preconditioned_change) in &mut *pairs {
            self.apply_inverse(change, preconditioned_change);
        }
        Ok(Refreshed {
            reference: self.load_norm(point),
            norm_square: dot(gradient, preconditioned),
            longest_m: longest_m(preconditioned),
            gradient_change: pairs.iter().map(|(_, z)| dot(gradient, z)).collect(),
            change_change: (0..pairs.len())
                .flat_map(|i| (0..=i).map(move |j| (i, j)))
                .map(|(i, j)| dot(pairs[i].0, pairs[j].1))
                .collect(),
        })
    }

    fn remainder(&mut self, preconditioned: &Vec<Vec3>) -> Result<(), Infallible> {
        self.remainder.clone_from(preconditioned);
        Ok(())
    }

    fn combine(
        &mut self,
        result: &mut Vec<Vec3>,
        terms: &[(f64, &Vec<Vec3>)],
    ) -> Result<(), Infallible> {
        let terms: Vec<(f64, &[Vec3])> = terms.iter().map(|(c, v)| (*c, v.as_slice())).collect();
        vectors::combine(result, &terms);
        Ok(())
    }
}
