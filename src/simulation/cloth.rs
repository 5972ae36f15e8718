//! Stage `solve_cloth` with its transfers, wherever the plan puts it.

use glam::DVec3;

use super::coupled::Coupled;
use super::{ClothEngine, Failure, Simulation, StructureState};
use crate::case::Scene;
use crate::cpu::cloth::{Cloth, InitialHessian, NodalDrag, Pressure, SolverSettings, StepInput};
use crate::gpu::DeviceError;
use crate::solve::lbfgs::{HISTORY, Outcome, Stop};

/// Iterations after which multigrid takes the stiffness anew: more often costs cycles for what is stored, more seldom evaluations.
pub(super) const REFRESH_EVERY: usize = 10;

impl Simulation {
    /// How hard the minimiser tries in a step, from the initial Hessian that the plan has chosen.
    pub(super) fn step_settings(&self) -> SolverSettings {
        SolverSettings {
            tolerance: self.scene.solver.tolerance,
            displacement_floor_m: 0.0,
            evaluation_limit: self.scene.solver.evaluation_limit,
            history: HISTORY,
            refresh_every: refresh_every(self.plan.step_hessian),
            initial_hessian: self.plan.step_hessian,
        }
    }

    /// A device leaves no solve of the fabric to the host, solved or not: for a benchmark of the device.
    pub fn leave_nothing_to_host(&mut self) {
        self.cloth_engine.keep_all();
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
    fn take_back(&mut self, before: &StructureState) -> bool {
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
    fn end_span(&mut self, before: &StructureState) {
        if let (Some(cadence), Some(cloth)) = (&mut self.cadence, &mut self.cloth) {
            let share = 1.0 / f64::from(cadence.every());
            for (x, old) in cloth.positions_m.iter_mut().zip(&before.positions_m) {
                *x = *old + (*x - *old) * share;
            }
            cadence.end(self.step);
        }
    }

    /// A step between two solves: the sheet goes on as far as in the step before.
    fn move_on(&mut self) {
        let (Some(cadence), Some(cloth)) = (&self.cadence, &mut self.cloth) else {
            return;
        };
        if let Some(before) = &cloth.step_before {
            let further = 1.0 / f64::from(cadence.gone(self.step).max(1));
            for (x, old) in cloth.positions_m.iter_mut().zip(&before.positions_m) {
                *x += (*x - *old) * further;
            }
        }
    }

    /// What a solve over several steps may have to be taken back to; `None` where every step is solved.
    fn before(&self) -> Option<StructureState> {
        self.cadence.is_some().then(|| self.structure_state())
    }

    /// Stage `send_nodes`; parts of steps send their own.
    pub(super) fn send_nodes(&mut self) -> Result<(), DeviceError> {
        if !self.solves_now() || self.adaptive.is_some() || self.starts_in_parts() {
            return Ok(());
        }
        self.begin_solve();
        self.with_fabric(|engine, cloth, input, settings| engine.send_nodes(cloth, input, settings))
            .unwrap_or(Ok(()))
    }

    /// Stage `solve_cloth`; on the device the solution stays there.
    pub(super) fn solve_cloth(&mut self) -> Result<(), Failure> {
        if !self.solves_now() {
            if self.step >= self.plan.start_steps {
                self.move_on();
            }
            return Ok(());
        }
        if let Some(adaptive) = self.adaptive {
            return self.solve_in_parts(adaptive);
        }
        if self.starts_in_parts() {
            return self.solve_first_parts();
        }
        if self.plan.reacts_on_device() {
            return self.begin_on_device();
        }
        let on_device = self.cloth_engine.is_device();
        if !on_device {
            self.begin_solve();
        }
        let before = if on_device { None } else { self.before() };
        let solved = self.with_fabric(|engine, cloth, input, settings| {
            engine.solve_cloth(cloth, input, settings)
        });
        self.judge(solved.transpose()?.flatten())?;
        if on_device {
            return Ok(());
        }
        self.end_solve(before)
    }

    /// Stage `fetch_nodes`.
    pub(super) fn fetch_nodes(&mut self) -> Result<(), Failure> {
        if !self.solves_now() || self.adaptive.is_some() || self.starts_in_parts() {
            return Ok(());
        }
        if self.plan.reacts_on_device() {
            return self.fetch_from_device();
        }
        let before = self.before();
        let left = self.take_nodes()?;
        self.judge(left)?;
        self.end_solve(before)
    }

    /// Takes the nodes from the device, or solves what it left to the host; then the outcome of that.
    pub(super) fn take_nodes(&mut self) -> Result<Option<Outcome>, DeviceError> {
        let left = self.with_fabric(|engine, cloth, input, settings| {
            engine.fetch_nodes(cloth, input, settings)
        });
        let left = left.transpose()?.flatten();
        self.cost.left_to_host += u64::from(left.is_some());
        Ok(left)
    }

    /// Gathers what the next solve needs to know.
    pub(super) fn begin_solve(&mut self) {
        self.begin_energy();
        self.begin_span();
        self.haul_to_the_end_of_the_span();
        match &mut self.coupled {
            Some(Coupled::Kernel(kernel)) if self.plan.reacts_on_device() => {
                kernel.forget_reactions();
            }
            Some(coupled) => coupled.gather_reactions(),
            None => {}
        }
    }

    /// Supports and risers are where they are when the span ends, which one solve covers.
    fn haul_to_the_end_of_the_span(&mut self) {
        let end = self.step + u64::from(self.every());
        self.place_supports_at_work(self.time_at(end));
    }

    /// Solves anew over fewer steps where the fabric moves too far; then the solution stands.
    pub(super) fn end_solve(&mut self, before: Option<StructureState>) -> Result<(), Failure> {
        if let Some(before) = before {
            while self.take_back(&before) {
                self.haul_to_the_end_of_the_span();
                let solved = self.with_fabric(|engine, cloth, input, settings| {
                    engine.solve(cloth, input, settings)
                });
                let solved = solved.transpose()?;
                self.cost.left_to_host += u64::from(solved.is_some_and(|s| s.left_to_host));
                self.judge(solved.map(|solved| solved.outcome))?;
            }
            self.add_energy(self.every());
            self.end_span(&before);
        } else {
            self.add_energy(1);
        }
        self.settle_solve();
        Ok(())
    }

    /// Notes the work of the solve that stands, over so many steps.
    pub(super) fn add_energy(&mut self, every: u32) {
        let frame_m_s2 = self.frame_m_s2();
        let input = step_input(
            &self.scene,
            self.coupled.as_ref(),
            (None, &self.drags, &self.moved_supports),
            every,
        );
        if let Some(cloth) = &self.cloth {
            self.energy.add(cloth, &input, frame_m_s2);
            // Until the span is gone the nodes are on their way to where the work was done.
            let gravity_m_s2 = self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO);
            self.energy
                .hold((every > 1).then_some((cloth, gravity_m_s2)));
        }
    }

    /// Counts a solve, and ends the run where it is not finite.
    pub(super) fn judge(&mut self, outcome: Option<Outcome>) -> Result<(), Failure> {
        if let Some(outcome) = &outcome {
            self.count(outcome);
        }
        self.finite(outcome.as_ref())
    }

    /// Gives the engine, the fabric, what acts on it in the present span, and how hard to try; `None` where there is no fabric.
    pub(super) fn with_fabric<R>(
        &mut self,
        act: impl FnOnce(&mut ClothEngine, &mut Cloth, &StepInput, &SolverSettings) -> R,
    ) -> Option<R> {
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
        let acted = act(&mut self.cloth_engine, cloth, &input, &settings);
        self.cost.contact += cloth.contact_time().saturating_sub(contact);
        Some(acted)
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
        let solved = self.cloth_engine.solve(cloth, &input, &settings)?;
        self.cost.left_to_host += u64::from(solved.left_to_host);
        let outcome = solved.outcome;
        self.cost.contact += cloth.contact_time().saturating_sub(contact);
        self.count(&outcome);
        Ok(outcome)
    }

    /// Notes what a solve did; the account counts it once it stands.
    fn count(&mut self, outcome: &Outcome) {
        let cost = &mut self.cost;
        cost.solves += 1;
        cost.iterations += outcome.iterations as u64;
        cost.evaluations += outcome.evaluations as u64;
        cost.unconverged += u64::from(!outcome.stop.reached());
        self.account.hold(outcome);
        let border = self.border_behind(self.step + 1);
        if let Some(own_steps) = &mut self.own_steps {
            own_steps.note(border, outcome);
        }
    }

    /// The last solve stands: it is not taken back any more.
    pub(super) fn settle_solve(&mut self) {
        let end_s = self.time_at(self.step + 1);
        self.account.settle(self.scene.solver.tolerance, end_s);
    }

    /// A solve that is not finite ends the run.
    pub(super) fn finite(&mut self, outcome: Option<&Outcome>) -> Result<(), Failure> {
        if outcome.is_none_or(|outcome| outcome.stop != Stop::NotFinite) {
            return Ok(());
        }
        // The fabric often only feels what the air has become; cells that are ahead cannot be looked at.
        if !self.is_ahead() {
            self.look()?;
        }
        let node = self
            .cloth
            .as_ref()
            .and_then(|c| c.positions_m.iter().position(|x| !x.is_finite()));
        let place = node.map_or_else(String::new, |node| format!(" at node {node}"));
        let what = format!("the fabric's energy is no longer finite{place}");
        Err(self.diverged(what).into())
    }
}

/// What acts in a step; with k > 1 the implicit step spans k steps of the air, but the positions advance step by step.
pub(super) fn step_input<'a>(
    scene: &Scene,
    coupled: Option<&'a Coupled>,
    (gravity_m_s2, drags, moved_supports): (Option<DVec3>, &'a [NodalDrag], &'a [(u32, DVec3)]),
    every: u32,
) -> StepInput<'a> {
    StepInput {
        time_step_s: scene.time.map(|time| time.step_s * f64::from(every)),
        integration: scene.time.map(|time| time.integration).unwrap_or_default(),
        gravity_m_s2: gravity_m_s2.unwrap_or(DVec3::ZERO),
        drags,
        pressure: Pressure::None,
        moved_supports,
        nodal_loads_n: &[],
        damping_1_s: scene.solver.damping_1_s,
        markers: coupled.map(Coupled::reactions).unwrap_or_default(),
        permeable: coupled.map(Coupled::permeable).unwrap_or_default(),
        cut_triangles: coupled.map(Coupled::cut_triangles).unwrap_or_default(),
    }
}

const fn refresh_every(initial_hessian: InitialHessian) -> Option<usize> {
    match initial_hessian {
        InitialHessian::BlockJacobi => None,
        InitialHessian::Multigrid => Some(REFRESH_EVERY),
    }
}
