//! Stage `solve_cloth`: the implicit step, or the static equilibrium, as a minimisation of the objective (`objective.rs`) from a predicted shape.

use glam::DVec3;

use super::Cloth;
use super::driver::minimise;
use super::integration::{StepBase, StepBefore, momentum_given_kg_m_s};
use super::loads::{StepInput, dead_loads};
use super::objective::Objective;
use super::settings::{SolverSettings, options, round_off_m};
use crate::solve::lbfgs::{Outcome, Stop, Watch};

/// Solves with corrected loads along edges under pressure, or renewed pressure that lags.
const EDGE_PASS_LIMIT: usize = 30;

impl Cloth {
    /// Advances positions and velocities by one implicit step, or to the static equilibrium.
    pub fn solve_cloth(&mut self, input: &StepInput, settings: &SolverSettings) -> Outcome {
        self.solve_cloth_watched(input, settings, &mut |_| true)
    }

    /// [`Cloth::solve_cloth`] that tells `watch` of every iteration.
    pub fn solve_cloth_watched(
        &mut self,
        input: &StepInput,
        settings: &SolverSettings,
        watch: Watch,
    ) -> Outcome {
        let structure = &self.structure;
        let state = [&self.positions_m[..], &self.velocities_m_s];
        let base = StepBase::new(state, self.step_before.as_ref(), input);
        let mut point = base.prediction(structure, input);
        let mut objective = Objective::new(
            structure,
            &mut self.prepared,
            base.clone(),
            input,
            settings.initial_hessian,
        );
        let mut options = options(structure, input, settings);
        options.displacement_floor_m = options.displacement_floor_m.max(round_off_m(&point));
        objective.keep_apart(&mut point);
        let dead = dead_loads(structure, input);
        objective.correct_edges(&dead, &point);
        let mut outcome = minimise(&mut objective, &mut point, &options, watch);
        // Edges of patches of equal pressure, and pressure that lags, until what they add stands still.
        for pass in 0..=EDGE_PASS_LIMIT {
            let change = objective.correct_edges(&dead, &point);
            if !outcome.stop.reached() || change <= settings.tolerance {
                break;
            }
            if pass == EDGE_PASS_LIMIT {
                outcome.stop = Stop::Stalled;
                break;
            }
            options.evaluation_limit = settings
                .evaluation_limit
                .saturating_sub(outcome.evaluations);
            let next = minimise(&mut objective, &mut point, &options, watch);
            outcome = Outcome {
                iterations: outcome.iterations + next.iterations,
                evaluations: outcome.evaluations + next.evaluations,
                ..next
            };
        }
        let remainder = std::mem::take(&mut objective.remainder);
        if let Some(contacts) = &mut self.prepared.contacts {
            contacts.finish(&point);
        }
        let velocity = |(node, place): (usize, &DVec3)| base.velocity_m_s(node, *place);
        let mut velocities: Vec<DVec3> = point.iter().enumerate().map(velocity).collect();
        // A step so short that round-off of positions is a part of its motion.
        if let Some(h) = base.time_step_s {
            for (v, left) in velocities.iter_mut().zip(&remainder) {
                *v -= left.as_dvec3() / h;
            }
        }
        self.end_step([point, velocities], input);
        outcome
    }

    /// The structure is at the end of a step, or at rest; what the next step counts from is kept.
    pub fn end_step(&mut self, [positions_m, velocities_m_s]: [Vec<DVec3>; 2], input: &StepInput) {
        let between = [&self.velocities_m_s[..], &velocities_m_s];
        self.momentum_given_kg_m_s =
            momentum_given_kg_m_s(&self.structure, between, self.step_before.as_ref(), input);
        let positions = std::mem::replace(&mut self.positions_m, positions_m);
        let velocities = std::mem::replace(&mut self.velocities_m_s, velocities_m_s);
        self.step_before = input.time_step_s.map(|time_step_s| StepBefore {
            positions_m: positions,
            velocities_m_s: velocities,
            time_step_s,
        });
    }
}
