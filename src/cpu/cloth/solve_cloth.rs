//! Stage `solve_cloth`: the implicit step, or the static equilibrium, as a minimisation of the objective (`objective.rs`) from a predicted shape.

use glam::DVec3;

use super::Cloth;
use super::driver::minimise;
use super::loads::{StepInput, dead_loads, prediction};
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
        let start = std::mem::take(&mut self.positions_m);
        let structure = &self.structure;
        let mut point = prediction(structure, &start, &self.velocities_m_s, input);
        let mut objective = Objective::new(
            structure,
            &mut self.prepared,
            [&start, &self.velocities_m_s],
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
        match input.time_step_s {
            Some(dt) => {
                for ((v, new), old) in self.velocities_m_s.iter_mut().zip(&point).zip(&start) {
                    *v = (*new - *old) / dt;
                }
                // A step so short that round-off of positions is a part of its motion.
                for (v, left) in self.velocities_m_s.iter_mut().zip(&remainder) {
                    *v -= left.as_dvec3() / dt;
                }
            }
            None => self.velocities_m_s.fill(DVec3::ZERO),
        }
        self.positions_m = point;
        outcome
    }
}
