//! Stage `solve_cloth` with its transfers, wherever the plan puts it, and the static equilibrium.

use std::time::Instant;

use glam::DVec3;

use super::coupled::Coupled;
use super::{Failure, Simulation};
use crate::case::Scene;
use crate::cpu::cloth::{Cloth, InitialHessian, NodalDrag, Pressure, SolverSettings, StepInput};
use crate::gpu::DeviceError;
use crate::plan::Plan;
use crate::solve::lbfgs::{HISTORY, Outcome, Stop, Watch};

/// Iterations after which multigrid takes the stiffness anew: more often costs cycles for what is stored, more seldom evaluations.
const REFRESH_EVERY: usize = 10;

/// The fabric before a solve that may be taken back.
pub(super) struct Before {
    positions_m: Vec<DVec3>,
    pub(super) velocities_m_s: Vec<DVec3>,
}

impl Before {
    /// Puts the fabric back to where it was.
    pub(super) fn put_back(&self, cloth: &mut Cloth) {
        cloth.positions_m.copy_from_slice(&self.positions_m);
        cloth.velocities_m_s.copy_from_slice(&self.velocities_m_s);
    }
}

impl Simulation {
    fn step_settings(&self) -> SolverSettings {
        step_settings(&self.scene, &self.plan)
    }

    /// True if the fabric is solved in this step: after release, in every step or where a span of several begins.
    pub(super) fn solves_now(&self) -> bool {
        self.step >= self.plan.start_steps
            && self.cadence.is_none_or(|cadence| cadence.begins(self.step))
    }

    /// Steps of the air that the present solve spans.
    fn every(&self) -> u32 {
        self.cadence.map_or(1, |cadence| cadence.every())
    }

    /// Takes the number of steps that the next solve spans, by how fast the fabric moves.
    fn begin_span(&mut self) {
        if let (Some(cadence), Some(coupled), Some(cloth)) =
            (&mut self.cadence, &self.coupled, &self.cloth)
        {
            cadence.begin(coupled.fastest_of_fabric(cloth));
        }
    }

    /// Goes back to where the fabric was, for a solve over fewer steps, if the one just done lets it move too far.
    fn take_back(&mut self, before: &Before) -> bool {
        let (Some(cadence), Some(coupled), Some(cloth)) =
            (&mut self.cadence, &self.coupled, &mut self.cloth)
        else {
            return false;
        };
        let too_far = cadence.shorten(coupled.fastest_of_fabric(cloth));
        if too_far {
            before.put_back(cloth);
        }
        too_far
    }

    /// Ends a solve over several steps: only the first is gone at once.
    fn end_span(&mut self, before: &Before) {
        let time_step_s = self.scene.time.map_or(0.0, |time| time.step_s);
        if let (Some(cadence), Some(cloth)) = (&mut self.cadence, &mut self.cloth) {
            for ((x, old), v) in cloth
                .positions_m
                .iter_mut()
                .zip(&before.positions_m)
                .zip(&cloth.velocities_m_s)
            {
                *x = *old + *v * time_step_s;
            }
            cadence.end(self.step);
        }
    }

    /// What a solve over several steps may have to be taken back to; `None` where every step is solved.
    fn before(&self) -> Option<Before> {
        self.cadence.is_some().then(|| self.state())
    }

    /// Where the fabric is, for solves that may be taken back.
    pub(super) fn state(&self) -> Before {
        self.cloth.as_ref().map_or_else(
            || Before {
                positions_m: Vec::new(),
                velocities_m_s: Vec::new(),
            },
            |cloth| Before {
                positions_m: cloth.positions_m.clone(),
                velocities_m_s: cloth.velocities_m_s.clone(),
            },
        )
    }

    /// Stage `send_nodes`; parts of steps send their own.
    pub(super) fn send_nodes(&mut self) -> Result<(), DeviceError> {
        if !self.solves_now() || self.adaptive.is_some() {
            return Ok(());
        }
        self.place_supports(self.time_at(self.step + 1));
        if let Some(coupled) = &mut self.coupled {
            coupled.gather_reactions();
        }
        self.begin_span();
        let felt = self.felt_gravity_m_s2();
        let every = self.every();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (felt, &self.drags, &self.moved_supports),
            every,
        );
        let settings = self.step_settings();
        if let (Some(cloth), Some(device_cloth)) = (&self.cloth, &mut self.device_cloth) {
            device_cloth.send_nodes(cloth, &input, &settings)?;
        }
        Ok(())
    }

    /// Stage `solve_cloth`; on the device the solution stays there.
    pub(super) fn solve_cloth(&mut self) -> Result<(), Failure> {
        if !self.solves_now() {
            let time_step_s = self.scene.time.map_or(0.0, |time| time.step_s);
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
        if let Some(adaptive) = self.adaptive {
            return self.solve_in_parts(adaptive);
        }
        if self.device_cloth.is_some() {
            let outcome = self.solve_on_device()?;
            return self.finite(outcome.as_ref());
        }
        if let Some(coupled) = &mut self.coupled {
            coupled.gather_reactions();
        }
        self.begin_span();
        self.place_supports(self.time_at(self.step + 1));
        let before = self.before();
        loop {
            let outcome = self.solve_on_host();
            self.finite(outcome.as_ref())?;
            match &before {
                Some(before) if self.take_back(before) => {}
                Some(before) => {
                    self.end_span(before);
                    break;
                }
                None => break,
            }
        }
        self.settle_solve();
        Ok(())
    }

    fn solve_on_host(&mut self) -> Option<Outcome> {
        let settings = self.step_settings();
        let felt = self.felt_gravity_m_s2();
        let every = self.every();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (felt, &self.drags, &self.moved_supports),
            every,
        );
        let cloth = self.cloth.as_mut()?;
        let contact = cloth.contact_time();
        let outcome = cloth.solve_cloth(&input, &settings);
        self.cost.contact += cloth.contact_time().saturating_sub(contact);
        self.count(&outcome);
        Some(outcome)
    }

    /// One part of a step, with its transfers where a device solves.
    pub(super) fn solve_part(
        &mut self,
        part_s: f64,
        initial_hessian: InitialHessian,
    ) -> Result<Outcome, Failure> {
        let settings = SolverSettings {
            refresh_every: refresh_every(initial_hessian),
            initial_hessian,
            ..self.step_settings()
        };
        let felt = self.felt_gravity_m_s2();
        let input = StepInput {
            time_step_s: Some(part_s),
            ..step_input(&self.scene, None, (felt, &[], &self.moved_supports), 1)
        };
        let Some(cloth) = &mut self.cloth else {
            return Err(Failure::Start("there is no fabric to solve".to_owned()));
        };
        let contact = cloth.contact_time();
        let outcome = match &mut self.device_cloth {
            Some(device_cloth) => device_cloth.solve(cloth, &input, &settings, &mut |_| true)?,
            None => cloth.solve_cloth(&input, &settings),
        };
        self.cost.contact += cloth.contact_time().saturating_sub(contact);
        self.count(&outcome);
        Ok(outcome)
    }

    /// On what `send_nodes` sent.
    fn solve_on_device(&mut self) -> Result<Option<Outcome>, DeviceError> {
        let settings = self.step_settings();
        let felt = self.felt_gravity_m_s2();
        let every = self.every();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (felt, &self.drags, &self.moved_supports),
            every,
        );
        let (Some(cloth), Some(device_cloth)) = (&self.cloth, &mut self.device_cloth) else {
            return Ok(None);
        };
        let outcome =
            device_cloth.solve_cloth(&cloth.structure, &input, &settings, &mut |_| true)?;
        self.count(&outcome);
        Ok(Some(outcome))
    }

    /// Notes what a solve did; the account counts it once it stands.
    fn count(&mut self, outcome: &Outcome) {
        let cost = &mut self.cost;
        cost.solves += 1;
        cost.iterations += outcome.iterations as u64;
        cost.evaluations += outcome.evaluations as u64;
        cost.unconverged += u64::from(!outcome.stop.reached());
        self.account.hold(outcome);
    }

    /// The last solve stands: it is not taken back any more.
    pub(super) fn settle_solve(&mut self) {
        let end_s = self.time_at(self.step + 1);
        self.account.settle(self.scene.solver.tolerance, end_s);
    }

    /// A solve that is not finite ends the run.
    pub(super) fn finite(&self, outcome: Option<&Outcome>) -> Result<(), Failure> {
        if outcome.is_none_or(|outcome| outcome.stop != Stop::NotFinite) {
            return Ok(());
        }
        // The fabric often only feels what the air has become.
        self.watch()?;
        let node = self
            .cloth
            .as_ref()
            .and_then(|c| c.positions_m.iter().position(|x| !x.is_finite()));
        let place = node.map_or_else(String::new, |node| format!(" at node {node}"));
        let what = format!("the fabric's energy is no longer finite{place}");
        Err(self.diverged(what).into())
    }

    /// Stage `fetch_nodes`; solves anew over fewer steps where the fabric moves too far.
    pub(super) fn fetch_nodes(&mut self) -> Result<(), Failure> {
        if !self.solves_now() || self.adaptive.is_some() {
            return Ok(());
        }
        let before = self.before();
        self.fetch_solution()?;
        let Some(before) = before else {
            self.settle_solve();
            return Ok(());
        };
        while self.take_back(&before) {
            let settings = self.step_settings();
            let felt = self.felt_gravity_m_s2();
            let every = self.every();
            let input = step_input(
                &self.scene,
                self.coupled.as_ref(),
                (felt, &self.drags, &self.moved_supports),
                every,
            );
            let (Some(cloth), Some(device_cloth)) = (&mut self.cloth, &mut self.device_cloth)
            else {
                break;
            };
            let outcome = device_cloth.solve(cloth, &input, &settings, &mut |_| true)?;
            self.count(&outcome);
            self.finite(Some(&outcome))?;
        }
        self.end_span(&before);
        self.settle_solve();
        Ok(())
    }

    fn fetch_solution(&mut self) -> Result<(), DeviceError> {
        let felt = self.felt_gravity_m_s2();
        let every = self.every();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (felt, &self.drags, &self.moved_supports),
            every,
        );
        match (&mut self.cloth, &mut self.device_cloth) {
            (Some(cloth), Some(device_cloth)) => device_cloth.fetch_nodes(cloth, &input),
            _ => Ok(()),
        }
    }

    /// Seeks the static equilibrium asked for by the case, from where the structure is; `None` if it asks for none. `watch` is told
    /// of every iteration and may end it.
    pub fn equilibrate(&mut self, watch: Watch) -> Option<Result<Outcome, Failure>> {
        let tolerance = self.scene.equilibrium?.tolerance;
        self.place_supports(self.time_s());
        self.pressure_acts = true;
        let solved = self.solve_static(tolerance, watch);
        if let Some(Ok(outcome)) = &solved {
            self.equilibrium_outcome = Some(*outcome);
        }
        solved
    }

    /// Solves the fabric under [`Simulation::static_loads`].
    pub(super) fn solve_static(
        &mut self,
        tolerance: f64,
        watch: Watch,
    ) -> Option<Result<Outcome, Failure>> {
        let equilibrium = self.scene.equilibrium?;
        let mut cloth = self.cloth.take()?;
        let mut device_cloth = self.device_cloth.take();
        let start = Instant::now();
        let (pressure, nodal_loads_n) = self.static_loads();
        let input = StepInput {
            gravity_m_s2: self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO),
            pressure,
            nodal_loads_n,
            moved_supports: &self.moved_supports,
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance,
            displacement_floor_m: if input.gravity_m_s2 == DVec3::ZERO && input.pressure.is_none() {
                // Nothing to be relative to but the mesh: supports drive the structure.
                tolerance * cloth.structure.smallest_element_m()
            } else {
                0.0
            },
            evaluation_limit: equilibrium.evaluation_limit,
            history: HISTORY,
            refresh_every: Some(REFRESH_EVERY),
            initial_hessian: InitialHessian::Multigrid,
        };
        let outcome = match &mut device_cloth {
            Some(device_cloth) => device_cloth.solve(&mut cloth, &input, &settings, watch),
            None => Ok(cloth.solve_cloth_watched(&input, &settings, watch)),
        };
        (self.cloth, self.device_cloth) = (Some(cloth), device_cloth);
        self.cost.equilibrium += start.elapsed();
        Some(match outcome {
            Err(error) => Err(error.into()),
            Ok(outcome) if outcome.stop == Stop::NotFinite => {
                let what = "the fabric's energy is no longer finite".to_owned();
                Err(self.diverged(what).into())
            }
            Ok(outcome) => Ok(outcome),
        })
    }
}

/// Pressure that acts in the equilibrium that the case asks for.
pub(super) fn prescribed_pressure(scene: &Scene) -> Pressure<'_> {
    if let Some(jumps_pa) = scene.wing.as_ref().and_then(|wing| wing.load_pa.as_ref()) {
        return Pressure::Lagged(jumps_pa);
    }
    if let Some(wing) = &scene.imported {
        return Pressure::PerTriangle(&wing.inside_pa);
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
    (gravity_m_s2, drags, moved_supports): (Option<DVec3>, &'a [NodalDrag], &'a [(u32, DVec3)]),
    every: u32,
) -> StepInput<'a> {
    StepInput {
        time_step_s: scene.time.map(|time| time.step_s * f64::from(every)),
        gravity_m_s2: gravity_m_s2.unwrap_or(DVec3::ZERO),
        drags,
        pressure: Pressure::None,
        moved_supports,
        nodal_loads_n: &[],
        damping_1_s: scene.solver.damping_1_s,
        markers: coupled.map(Coupled::reactions).unwrap_or_default(),
        permeable: coupled.map(Coupled::permeable).unwrap_or_default(),
    }
}

/// How hard the minimiser tries in a step, from the initial Hessian that the plan has chosen.
pub(super) fn step_settings(scene: &Scene, plan: &Plan) -> SolverSettings {
    SolverSettings {
        tolerance: scene.solver.tolerance,
        displacement_floor_m: 0.0,
        evaluation_limit: scene.solver.evaluation_limit,
        history: HISTORY,
        refresh_every: refresh_every(plan.step_hessian),
        initial_hessian: plan.step_hessian,
    }
}

const fn refresh_every(initial_hessian: InitialHessian) -> Option<usize> {
    match initial_hessian {
        InitialHessian::BlockJacobi => None,
        InitialHessian::Multigrid => Some(REFRESH_EVERY),
    }
}
