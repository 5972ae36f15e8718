//! Stage `solve_cloth` with its transfers, wherever the plan puts it, and the static equilibrium.

use std::time::Instant;

use glam::DVec3;

use super::coupled::Coupled;
use super::{Cost, Failure, Simulation};
use crate::case::Scene;
use crate::cpu::cloth::{InitialHessian, NodalDrag, Pressure, SolverSettings, StepInput};
use crate::gpu::DeviceError;
use crate::plan::Plan;
use crate::solve::lbfgs::{HISTORY, Outcome, Stop, Watch};

/// Displacement of a step below which the fabric counts as solved, whatever the loads [m].
const DISPLACEMENT_FLOOR_M: f64 = 1e-9;

/// Iterations after which multigrid takes the stiffness anew: more often costs cycles for what is stored, more seldom evaluations.
const REFRESH_EVERY: usize = 10;

impl Simulation {
    fn step_settings(&self) -> SolverSettings {
        step_settings(&self.scene, &self.plan)
    }

    /// True if the fabric is solved in this step: after release, every `every` steps.
    fn solves_now(&self, every: u32) -> bool {
        self.step >= self.plan.start_steps
            && (self.step - self.plan.start_steps).is_multiple_of(u64::from(every))
    }

    /// Stage `send_nodes`.
    pub(super) fn send_nodes(&mut self, every: u32) -> Result<(), DeviceError> {
        if !self.solves_now(every) {
            return Ok(());
        }
        if let Some(coupled) = &mut self.coupled {
            coupled.gather_reactions();
        }
        let felt = self.felt_gravity_m_s2();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (felt, &self.drags),
            every,
        );
        let settings = self.step_settings();
        if let (Some(cloth), Some(device_cloth)) = (&self.cloth, &mut self.device_cloth) {
            device_cloth.send_nodes(cloth, &input, &settings)?;
        }
        Ok(())
    }

    /// Stage `solve_cloth`; on the device the solution stays there.
    pub(super) fn solve_cloth(&mut self, every: u32) -> Result<(), Failure> {
        let time_step_s = self.scene.time.map_or(0.0, |time| time.step_s);
        if !self.solves_now(every) {
            if let Some(cloth) = self
                .cloth
                .as_mut()
                .filter(|_| self.step >= self.plan.start_steps)
            {
                // Between solves the sheet keeps its velocity.
                for (x, v) in cloth.positions_m.iter_mut().zip(&cloth.velocities_m_s) {
                    *x += *v * time_step_s;
                }
            }
            return Ok(());
        }
        let settings = self.step_settings();
        let felt = self.felt_gravity_m_s2();
        let Some(cloth) = &mut self.cloth else {
            return Ok(());
        };
        let outcome = match &mut self.device_cloth {
            Some(device_cloth) => {
                let input = step_input(
                    &self.scene,
                    self.coupled.as_ref(),
                    (felt, &self.drags),
                    every,
                );
                device_cloth.solve_cloth(&cloth.structure, &input, &settings, &mut |_| true)?
            }
            None => {
                if let Some(coupled) = &mut self.coupled {
                    coupled.gather_reactions();
                }
                let input = step_input(
                    &self.scene,
                    self.coupled.as_ref(),
                    (felt, &self.drags),
                    every,
                );
                let before = (every > 1).then(|| cloth.positions_m.clone());
                let contact = cloth.contact_time();
                let outcome = cloth.solve_cloth(&input, &settings);
                self.cost.contact += cloth.contact_time().saturating_sub(contact);
                if let Some(before) = before {
                    step_from(&before, cloth, time_step_s);
                }
                outcome
            }
        };
        count(&mut self.cost, &outcome);
        if outcome.stop == Stop::NotFinite {
            // The fabric often only feels what the air has become.
            self.watch()?;
            let node = self
                .cloth
                .as_ref()
                .and_then(|c| c.positions_m.iter().position(|x| !x.is_finite()));
            let place = node.map_or_else(String::new, |node| format!(" at node {node}"));
            let what = format!("the fabric's energy is no longer finite{place}");
            return Err(self.diverged(what).into());
        }
        Ok(())
    }

    /// Stage `fetch_nodes`.
    pub(super) fn fetch_nodes(&mut self, every: u32) -> Result<(), DeviceError> {
        if !self.solves_now(every) {
            return Ok(());
        }
        let felt = self.felt_gravity_m_s2();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (felt, &self.drags),
            every,
        );
        if let (Some(cloth), Some(device_cloth)) = (&mut self.cloth, &mut self.device_cloth) {
            let before = (every > 1).then(|| cloth.positions_m.clone());
            device_cloth.fetch_nodes(cloth, &input)?;
            if let Some(before) = before {
                step_from(
                    &before,
                    cloth,
                    self.scene.time.map_or(0.0, |time| time.step_s),
                );
            }
        }
        Ok(())
    }

    /// Seeks the static equilibrium asked for by the case, from where the structure is; `None` if it asks for none. `watch` is told
    /// of every iteration and may end it.
    pub fn equilibrate(&mut self, watch: Watch) -> Option<Result<Outcome, Failure>> {
        let equilibrium = self.scene.equilibrium?;
        let cloth = self.cloth.as_mut()?;
        self.pressure_acts = true;
        let start = Instant::now();
        let input = StepInput {
            gravity_m_s2: self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO),
            pressure: prescribed_pressure(&self.scene),
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: equilibrium.tolerance,
            displacement_floor_m: if input.gravity_m_s2 == DVec3::ZERO && input.pressure.is_none() {
                // Nothing to be relative to but the mesh: supports drive the structure.
                equilibrium.tolerance * cloth.structure.smallest_element_m()
            } else {
                0.0
            },
            evaluation_limit: equilibrium.evaluation_limit,
            history: HISTORY,
            refresh_every: Some(REFRESH_EVERY),
            initial_hessian: InitialHessian::Multigrid,
        };
        let outcome = match &mut self.device_cloth {
            Some(device_cloth) => match device_cloth.solve(cloth, &input, &settings, watch) {
                Ok(outcome) => outcome,
                Err(error) => return Some(Err(error.into())),
            },
            None => cloth.solve_cloth_watched(&input, &settings, watch),
        };
        self.cost.equilibrium += start.elapsed();
        if outcome.stop == Stop::NotFinite {
            let diverged = self.diverged("the fabric's energy is no longer finite".to_owned());
            return Some(Err(diverged.into()));
        }
        Some(Ok(outcome))
    }
}

/// Pressure that acts in the equilibrium that the case asks for.
pub(super) fn prescribed_pressure(scene: &Scene) -> Pressure<'_> {
    if let Some(load) = scene.wing.as_ref().and_then(|wing| wing.load.as_ref()) {
        return Pressure::Parted {
            following: &load.inside_pa,
            lagged: &load.rest_pa,
        };
    }
    scene
        .equilibrium
        .and_then(|equilibrium| equilibrium.pressure_pa)
        .map_or(Pressure::None, Pressure::Uniform)
}

/// What acts in a step; with k > 1 the implicit step spans k steps of the air, but the positions advance step by step.
fn step_input<'a>(
    scene: &Scene,
    coupled: Option<&'a Coupled>,
    (gravity_m_s2, drags): (Option<DVec3>, &'a [NodalDrag]),
    every: u32,
) -> StepInput<'a> {
    StepInput {
        time_step_s: scene.time.map(|time| time.step_s * f64::from(every)),
        gravity_m_s2: gravity_m_s2.unwrap_or(DVec3::ZERO),
        drags,
        pressure: Pressure::None,
        moved_supports: &[],
        damping_1_s: scene.solver.damping_1_s,
        markers: coupled.map(Coupled::reactions).unwrap_or_default(),
        permeable: coupled.map(Coupled::permeable).unwrap_or_default(),
    }
}

/// Takes back a solve over several steps but its first.
fn step_from(before: &[DVec3], cloth: &mut crate::cpu::cloth::Cloth, time_step_s: f64) {
    for ((x, old), v) in cloth
        .positions_m
        .iter_mut()
        .zip(before)
        .zip(&cloth.velocities_m_s)
    {
        *x = *old + *v * time_step_s;
    }
}

/// How hard the minimiser tries in a step, from the initial Hessian that the plan has chosen.
pub(super) fn step_settings(scene: &Scene, plan: &Plan) -> SolverSettings {
    SolverSettings {
        tolerance: scene.solver.tolerance,
        displacement_floor_m: DISPLACEMENT_FLOOR_M,
        evaluation_limit: scene.solver.evaluation_limit,
        history: HISTORY,
        refresh_every: match plan.step_hessian {
            InitialHessian::BlockJacobi => None,
            InitialHessian::Multigrid => Some(REFRESH_EVERY),
        },
        initial_hessian: plan.step_hessian,
    }
}

fn count(cost: &mut Cost, outcome: &Outcome) {
    cost.solves += 1;
    cost.iterations += outcome.iterations as u64;
    cost.evaluations += outcome.evaluations as u64;
    if outcome.stop != Stop::Converged {
        cost.unconverged += 1;
    }
}
