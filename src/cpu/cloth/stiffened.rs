//! Part of stage `solve_cloth`: the objective as [`crate::solve::stiffening`] sees it.

use glam::DVec3;

use super::objective::Objective;
use super::softened::{Soft, second_order};
use super::stiffness;
use crate::solve::stiffening::Stiffened;

/// Stiffness that every node has beside its own, so that one that nothing holds can be solved for [N/m].
const LEAST_STIFFNESS_N_M: f64 = 1e-9;

/// Three numbers per node as vectors.
fn vectors(numbers: &[f64]) -> &[DVec3] {
    bytemuck::cast_slice(numbers)
}

fn vectors_mut(numbers: &mut [f64]) -> &mut [DVec3] {
    bytemuck::cast_slice_mut(numbers)
}

impl Stiffened for Objective<'_> {
    fn soften(&mut self, share: f64) {
        let structure = self.structure();
        self.set_soft((share < 1.0).then(|| Soft::new(structure, share)));
    }

    fn evaluate(&mut self, point: &[f64], gradient: &mut [f64]) -> f64 {
        self.evaluate_double(vectors(point), vectors_mut(gradient))
    }

    fn round_off(&self, objective: f64) -> f64 {
        Self::round_off(objective)
    }

    fn factorise(&mut self, point: &[f64], shift: f64) -> bool {
        self.factorise_at(vectors(point), shift)
    }

    fn solve(&mut self, vector: &mut [f64]) {
        if let Some(cholesky) = self.cholesky() {
            cholesky.solve(vector);
        }
    }

    fn second_order(&mut self, point: &[f64], direction: &[f64], force: &mut [f64]) {
        let (structure, _) = self.elements();
        let force = vectors_mut(force);
        second_order(structure, vectors(point), vectors(direction), force);
    }

    fn loads(&mut self, point: &[f64], loads: &mut [f64]) {
        let found = self.acting_loads(vectors(point));
        vectors_mut(loads).copy_from_slice(&found);
    }

    fn square(&self, vector: &[f64]) -> f64 {
        let masses = self.structure().masses_kg.iter();
        let pairs = vectors(vector).iter().zip(masses);
        pairs.map(|(v, mass)| mass * v.length_squared()).sum()
    }

    fn positions_m(&self, point: &[f64]) -> Option<Vec<DVec3>> {
        Some(vectors(point).to_vec())
    }
}

impl Objective<'_> {
    /// Factorises the projected Hessian with a shift [1/s²] times the masses.
    fn factorise_at(&mut self, point: &[DVec3], shift: f64) -> bool {
        let Some(mut cholesky) = self.take_cholesky() else {
            return false;
        };
        let (structure, gather) = self.elements();
        let extra = stiffness::Extra {
            dashpots: self.dashpots(),
            contact: None,
        };
        let from = [self.counted_from_m(), point];
        stiffness::assemble(
            structure,
            gather,
            (self.input(), extra),
            from,
            &mut cholesky.matrix,
        );
        let held = &structure.held;
        let is_definite = cholesky.factorise(|row| {
            if held[row] {
                1.0
            } else {
                shift * structure.masses_kg[row] + LEAST_STIFFNESS_N_M
            }
        });
        self.put_cholesky(cholesky);
        is_definite
    }
}
