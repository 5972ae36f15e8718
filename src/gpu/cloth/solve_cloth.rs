//! Stage `solve_cloth` on the device: the objective of `src/cpu/cloth/objective.rs`, minimised by the same L-BFGS or, in equilibria of
//! tension-only fabric, by the same Newton's method. In time steps with block-Jacobi the device decides between evaluations ([`super::batches`]).
//!
//! With p = x̂ + dt v̄ the prediction (v̄ = v̂, that of their supports at held nodes; x̂, v̂ and dt of [`crate::cpu::cloth::integration`]) and Δ = x − p, the
//! objective is
//!
//! Π = E(x) + ½ (1/dt² + β/dt) ΔᵀMΔ − (f − β M v̄)·Δ + ½ dt Σ_k K_k |Δ_k/dt + (v̄_k − u*_k)|² + constant,
//!
//! the same function as on the CPU. Where the fabric cuts the lattice, the reactions of its triangles stand in place of the markers'. Drag of a node, ½ dt c |Δ/dt + v̄ − u|², is added to its mass and load. The bracketed velocities and loads are computed on the host in `f64`.

use glam::DVec3;

use crate::cloth::Structure;
use crate::cpu::cloth::driver::newton_pays;
use crate::cpu::cloth::initial_hessian::FREE_NODE_STIFFNESS;
use crate::cpu::cloth::integration::StepBase;
use crate::cpu::cloth::loads::{add_pull_of_the_air, step_loads};
use crate::cpu::cloth::pressure;
use crate::cpu::cloth::settings::options;
use crate::cpu::cloth::{Cloth as State, InitialHessian, Probe, SolverSettings, StepInput};
use crate::gpu::error::DeviceError;
use crate::solve::lbfgs::{self, Options, Outcome, Stop, Watch};
use crate::solve::newton;
use crate::solve::{Landing, Step, VectorSpace};

use super::batches::{Solved, expected_next};
use super::decisions::LONGEST_HISTORY;
use super::elements::{joined, narrow, split};
use super::parameters::ClothStage;
use super::points::PointSlot;
use super::points::Points;
use super::slots::DRIVE;
use super::step_words::{cut_reactions, dashpot_states, permeability_words};
use super::vectors::{MultigridHessian, Space};
use super::workspace::Workspace;
use super::{AtMarkers, Cloth, Solution};

/// Displacement that positions on the device cannot hold [m]: half a unit of the last place of the largest remainder, 2⁻¹⁷ m in `f32`.
const ROUND_OFF_M: f64 = 1.0 / (1_u64 << 42) as f64;

impl Cloth {
    /// Stage `send_nodes`: the state of the nodes, their loads and the markers' reactions. The structure must be the one given to
    /// [`Cloth::new`] or [`Cloth::new_cut`], and the markers of `input` the same in the same order, or none.
    pub fn send_nodes(
        &mut self,
        state: &State,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<(), DeviceError> {
        self.prepare(&state.structure, (input, settings))?;
        self.constant_j = self.upload(state, input)?;
        Ok(())
    }

    /// Stage `solve_cloth`, on what [`Cloth::send_nodes`] sent. In time steps with block-Jacobi the device drives the minimiser; else the host does, as in
    /// [`Cloth::solve_watched`].
    pub fn solve_cloth(
        &mut self,
        structure: &Structure,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, DeviceError> {
        let by_device = input.time_step_s.is_some()
            && settings.initial_hessian == InitialHessian::BlockJacobi
            && settings.refresh_every.is_none()
            && settings.history <= LONGEST_HISTORY;
        if !by_device {
            return self.solve_driven_by_host(structure, input, settings, &mut |_| true);
        }
        let options = device_options(structure, input, settings);
        let mut space = self.space(self.constant_j, settings.initial_hessian)?;
        self.place_at_prediction(&space.point()?)?;
        let solved = space.minimise_in_batches(&options, self.expected_evaluations)?;
        drop(space);
        Ok(self.take(solved))
    }

    /// Begins stage `solve_cloth` where the markers are in the air of the device, in a time step with block-Jacobi. It is left to the next submission, and
    /// [`Cloth::react_back`] after it; [`Cloth::bring_solution`] waits.
    pub fn begin_solve(
        &mut self,
        structure: &Structure,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<(), DeviceError> {
        let options = device_options(structure, input, settings);
        let mut space = self.space(self.constant_j, InitialHessian::BlockJacobi)?;
        self.place_at_prediction(&space.point()?)?;
        space.begin(&options, self.expected_evaluations);
        drop(space);
        self.begun = Some(options);
        Ok(())
    }

    /// Forms the forces of the markers on the air, by where the minimiser stands.
    pub fn react_back(&self) -> Result<(), DeviceError> {
        if let Some(in_air) = &self.workspace()?.decisions.in_air {
            in_air.react_back(&self.device);
        }
        Ok(())
    }

    /// Waits for a solve that was begun: how it ended, and what the device found and did at the markers. `None` where it has not ended: then it goes on, and the forces are to be
    /// formed anew.
    pub fn bring_solution(&mut self) -> Result<Option<(Outcome, AtMarkers)>, DeviceError> {
        let options = self
            .begun
            .ok_or_else(|| DeviceError::Command("no solve of the fabric was begun".to_owned()))?;
        let space = self.space(self.constant_j, InitialHessian::BlockJacobi)?;
        let mut brought = space.bring()?;
        let at_markers = brought.at_markers.take().unwrap_or_default();
        let Some(solved) = space.solved(brought, &options) else {
            space.go_on();
            return Ok(None);
        };
        drop(space);
        self.begun = None;
        Ok(Some((self.take(solved), at_markers)))
    }

    /// Takes how a solve ended, until it is fetched.
    fn take(&mut self, solved: Solved) -> Outcome {
        let evaluations = solved.outcome.evaluations;
        self.expected_evaluations = expected_next(self.expected_evaluations, evaluations);
        self.remainder = solved.remainder;
        let finite = solved.outcome.stop != Stop::NotFinite;
        self.solution = finite.then_some(Solution::Positions(solved.positions_m));
        solved.outcome
    }

    /// The same, driven by the host; the solution stays on the device.
    fn solve_driven_by_host(
        &mut self,
        structure: &Structure,
        input: &StepInput,
        settings: &SolverSettings,
        watch: Watch,
    ) -> Result<Outcome, DeviceError> {
        if self.in_air.is_some() && input.time_step_s.is_some() {
            return Err(DeviceError::Command(
                "steps of fabric whose markers are in the air of the device are begun, not driven"
                    .to_owned(),
            ));
        }
        let mut space = self.space(self.constant_j, settings.initial_hessian)?;
        let mut point = space.point()?;
        self.place_at_prediction(&point)?;
        let options = device_options(structure, input, settings);
        let outcome = if newton_pays(structure, input, settings.initial_hessian) {
            newton::minimise_watched(&mut space, &mut point, &options, watch)?
        } else {
            lbfgs::minimise_watched(&mut space, &mut point, &options, watch)?
        };
        let remainder = std::mem::take(&mut space.remainder);
        drop(space);
        self.remainder = remainder;
        self.solution = (outcome.stop != Stop::NotFinite).then_some(Solution::Point(point));
        Ok(outcome)
    }

    /// Stage `fetch_nodes`: positions and velocities of `state` become those of the solution; the prediction where there is none.
    pub fn fetch_nodes(&mut self, state: &mut State, input: &StepInput) -> Result<(), DeviceError> {
        let base = base(state, input);
        let mut new = base.prediction(&state.structure, input);
        let remainder = std::mem::take(&mut self.remainder);
        let solved = match self.solution.take() {
            None => Vec::new(),
            Some(Solution::Point(point)) => self.positions(&point)?,
            Some(Solution::Positions(positions_m)) => positions_m,
            Some(Solution::Ended(positions_m)) => {
                // The device goes on from these.
                for (node, (new, ended)) in new.iter_mut().zip(positions_m).enumerate() {
                    if !state.structure.held[node] {
                        *new = ended;
                    }
                }
                Vec::new()
            }
        };
        for (node, (new, solved)) in new.iter_mut().zip(solved).enumerate() {
            // Held nodes are where the step puts them, to the last bit.
            if !state.structure.held[node] {
                // The device has the prediction rounded, and what moves from there.
                let uploaded = new.to_array().map(|x| {
                    let (whole, remainder) = split(x);
                    joined(whole, remainder)
                });
                *new += solved - DVec3::from_array(uploaded);
                if let Some(left) = remainder.get(node) {
                    *new -= DVec3::from_array(left.map(f64::from));
                }
            }
        }
        let velocity = |(node, place): (usize, &DVec3)| base.velocity_m_s(node, *place);
        let velocities = new.iter().enumerate().map(velocity).collect();
        state.end_step([new, velocities], input);
        Ok(())
    }

    /// A whole solve: sends, minimises, fetches.
    pub fn solve(
        &mut self,
        state: &mut State,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, DeviceError> {
        self.send_nodes(state, input, settings)?;
        let outcome = self.solve_cloth(&state.structure, input, settings)?;
        self.fetch_nodes(state, input)?;
        Ok(outcome)
    }

    /// A whole solve that the host drives, evaluation by evaluation; `watch` is told of every iteration, and may end it.
    pub fn solve_watched(
        &mut self,
        state: &mut State,
        input: &StepInput,
        settings: &SolverSettings,
        watch: Watch,
    ) -> Result<Outcome, DeviceError> {
        self.send_nodes(state, input, settings)?;
        let outcome = self.solve_driven_by_host(&state.structure, input, settings, watch)?;
        self.fetch_nodes(state, input)?;
        Ok(outcome)
    }

    /// One trial from the start of a step along `direction` [m], `[node_count]`, as [`State::probe`] makes it on the CPU; of the settings
    /// only the initial Hessian counts.
    pub fn probe(
        &mut self,
        state: &State,
        (input, settings): (&StepInput, &SolverSettings),
        direction: &[DVec3],
        [length, step_limit_m]: [f64; 2],
    ) -> Result<Probe, DeviceError> {
        let settings = SolverSettings {
            history: 1,
            ..*settings
        };
        self.prepare(&state.structure, (input, &settings))?;
        let constant_j = self.upload(state, input)?;
        let mut space = self.space(constant_j, settings.initial_hessian)?;
        let point = space.point()?;
        self.place_at_prediction(&point)?;
        let mut landed = space.point()?;
        let [mut g, mut h, d] = [space.vector()?, space.vector()?, space.vector()?];
        let [mut new_g, mut new_h] = [space.vector()?, space.vector()?];
        let start = space.start(&point, &mut g, &mut h)?;
        let vectors = &self.workspace()?.vectors;
        let direction: Vec<[f32; 3]> = direction.iter().map(narrow).collect();
        self.device
            .write(vectors, d.0 as usize * self.nodes, &direction);
        let from = Step {
            point: &point,
            gradient: &g,
            preconditioned: &h,
            direction: &d,
            length,
            step_limit_m,
        };
        let mut to = Landing {
            point: &mut landed,
            gradient: &mut new_g,
            preconditioned: &mut new_h,
        };
        let attempt = space.attempt(&from, &mut to, &[&h])?;
        let read = |slot: u32| {
            let first = slot as usize * self.nodes;
            let values: Vec<[f32; 3]> = self.device.read(vectors, first, self.nodes)?;
            let wide = values
                .iter()
                .map(|v| DVec3::from_array(v.map(f64::from)))
                .collect();
            Ok::<Vec<DVec3>, DeviceError>(wide)
        };
        Ok(Probe {
            start,
            attempt,
            gradient: read(new_g.0)?,
            preconditioned: read(new_h.0)?,
            positions_m: self.positions(&landed)?,
        })
    }

    pub(super) fn workspace(&self) -> Result<&Workspace, DeviceError> {
        self.workspace
            .as_ref()
            .ok_or_else(|| DeviceError::Command("the cloth is not prepared".to_owned()))
    }

    /// The objective of a step whose state was uploaded.
    pub(super) fn space(
        &self,
        constant_j: f64,
        kind: InitialHessian,
    ) -> Result<Space<'_>, DeviceError> {
        let workspace = self.workspace()?;
        let mut space = Space::new(
            &self.device,
            workspace,
            self.buffer("stage")?,
            self.stage,
            constant_j,
            self.nodes,
        );
        space.points = Some(self.points()?);
        if let (InitialHessian::Multigrid, Some(whole)) = (kind, &self.multigrid) {
            let mut buffers = self.named_buffers();
            buffers.push(("vectors", &workspace.vectors));
            space.multigrid = Some(MultigridHessian {
                multigrid: &whole.multigrid,
                stiffness: &whole.stiffness,
                gradient: whole.gradient.bind(&self.device, &buffers)?,
            });
        }
        Ok(space)
    }

    /// Uploads the prediction, the loads and the markers; returns the part of the objective that stays constant [J].
    fn upload(&mut self, state: &State, input: &StepInput) -> Result<f64, DeviceError> {
        let structure = &state.structure;
        if structure.node_count() != self.nodes
            || !(input.markers.is_empty() || input.markers.len() == self.markers.len())
            || (structure.permeability.is_some() && input.permeable.len() != input.markers.len())
        {
            return Err(DeviceError::Command(format!(
                "the device holds {} nodes and {} markers, the step has {} and {}",
                self.nodes,
                self.markers.len(),
                structure.node_count(),
                input.markers.len(),
            )));
        }
        if !input.cut_triangles.is_empty() && !self.triangles.cut {
            return Err(DeviceError::Command(
                "the step has triangles that cut links, the device holds none".to_owned(),
            ));
        }
        let base = base(state, input);
        let input = &base.input(input);
        let (start, counted_from) = (base.start_m, &base.positions_m);
        self.stage = ClothStage {
            stiffness_floor: FREE_NODE_STIFFNESS as f32,
            ..ClothStage::default()
        };
        if let Some(dt) = input.time_step_s {
            self.stage.inertia = ((1.0 / dt + input.damping_1_s) / dt) as f32;
            self.stage.rate = (1.0 / dt) as f32;
            self.stage.time_step = dt as f32;
        }
        let predicted = base.prediction(structure, input);
        // Of the prediction.
        let velocity = |node: usize| match input.time_step_s {
            None => DVec3::ZERO,
            Some(_) if structure.held[node] => base.velocity_m_s(node, predicted[node]),
            Some(_) => base.velocities_m_s[node],
        };
        let (whole, remainder): (Vec<i32>, Vec<f32>) = predicted
            .iter()
            .flat_map(|x| x.to_array())
            .map(split)
            .unzip();
        self.device
            .write(self.buffer("predicted_whole")?, 0, &whole);
        self.device
            .write(self.buffer("predicted_remainder")?, 0, &remainder);

        let mut loads = step_loads(structure, start, input);
        let mut drive = loads.clone();
        add_pull_of_the_air(structure, input, &mut drive);
        let mut constant_j = 0.0;
        if self.triangles.faces {
            let pressures: Vec<f32> = if input.pressure_follows() {
                self.refuse_open_edges(state, input)?;
                pressure::add_forces(structure, &predicted, input.pressure, &mut drive);
                constant_j += pressure::potential_j(structure, start, &predicted, input.pressure);
                let faces = 0..structure.triangles.len();
                faces.map(|t| input.pressure.at(t) as f32).collect()
            } else {
                vec![0.0; structure.triangles.len()]
            };
            self.device
                .write(self.buffer("face_pressures")?, 0, &pressures);
        }
        for node in 0..self.nodes {
            constant_j -= loads[node].dot(predicted[node] - counted_from[node]);
            if let Some(dt) = input.time_step_s {
                let mass = structure.masses_kg[node];
                let damping = input.damping_1_s * mass;
                constant_j += 0.5 * dt * damping * velocity(node).length_squared();
                let change = velocity(node) - base.velocities_m_s[node];
                constant_j += 0.5 * mass * change.length_squared();
                loads[node] -= velocity(node) * damping;
            }
        }
        if let (Some(dt), true) = (input.time_step_s, self.drags || !input.drags.is_empty()) {
            self.drags = !input.drags.is_empty();
            // ½ dt c |v − u|² with v = Δ/dt + v̄ is inertia of a mass c/dt over (1/dt² + β/dt), a load, and a constant.
            let mut masses = structure.masses_kg.clone();
            for drag in input.drags {
                let (node, c) = (drag.node as usize, drag.coefficient_kg_s);
                let slip = velocity(node) - drag.air_velocity_m_s;
                masses[node] += c / (1.0 / dt + input.damping_1_s);
                loads[node] -= slip * c;
                constant_j += 0.5 * dt * c * slip.length_squared();
            }
            let masses: Vec<f32> = masses.iter().map(|m| *m as f32).collect();
            self.device.write(self.buffer("masses")?, 0, &masses);
        }
        let loads: Vec<[f32; 3]> = loads.iter().map(narrow).collect();
        if loads != self.loads {
            self.device.write(self.buffer("loads")?, 0, &loads);
            self.loads = loads;
        }
        let drive: Vec<[f32; 3]> = drive.iter().map(narrow).collect();
        let at_marker = |(triangle, weights): &(u32, [f64; 3])| -> DVec3 {
            let nodes = structure.triangles[*triangle as usize].nodes;
            let corners = nodes.into_iter().zip(weights);
            corners
                .map(|(node, weight)| velocity(node as usize) * *weight)
                .sum()
        };
        if let (Some(in_air), true) = (&self.in_air, input.time_step_s.is_some()) {
            let velocities = self.markers.iter().map(at_marker);
            in_air.upload(&self.device, velocities, &drive);
            // The device writes the loads of the scale itself.
            self.drive.clear();
        } else {
            if drive != self.drive {
                let first = DRIVE as usize * self.nodes;
                self.device.write(&self.workspace()?.vectors, first, &drive);
                self.drive = drive;
            }
            let mut reactions = vec![[0.0_f32; 4]; self.markers.len()];
            if input.time_step_s.is_some() {
                for (reaction, marker) in reactions.iter_mut().zip(input.markers) {
                    let place = (marker.triangle, marker.weights);
                    let [x, y, z] = narrow(&(at_marker(&place) - marker.air_velocity_m_s));
                    *reaction = [x, y, z, marker.stiffness_kg_s as f32];
                }
            }
            self.device.write(self.buffer("reactions")?, 0, &reactions);
        }
        if structure.permeability.is_some() && !self.markers.is_empty() {
            let words = permeability_words(input.permeable, self.markers.len());
            self.device.write(self.buffer("permeabilities")?, 0, &words);
        }
        if self.triangles.cut {
            let (words, still_j) = cut_reactions(structure, &velocity, input);
            self.device.write(self.buffer("cut_reactions")?, 0, &words);
            constant_j += still_j;
        }
        let dashpots = dashpot_states(structure, start, &velocity, input.time_step_s);
        if !dashpots.is_empty() {
            let buffer = self.buffer("dashpot_states")?;
            self.device.write(buffer, 0, &dashpots);
        }
        Ok(constant_j)
    }

    /// Along open edges that move, the host corrects the loads of following pressure from solve to solve; the device does not.
    fn refuse_open_edges(&self, state: &State, input: &StepInput) -> Result<(), DeviceError> {
        if !input.pressure.lagged().is_none() {
            return Err(DeviceError::Command(
                "pressure that is taken from the last shape and renewed is computed on the host: use --cloth host".to_owned(),
            ));
        }
        let open = pressure::first_open_edge(&state.structure, &state.positions_m, input.pressure);
        match open {
            None => Ok(()),
            Some(node) => Err(DeviceError::Command(format!(
                "pressure that follows the fabric is computed on the host only where an edge of the loaded fabric moves, as at node \
                 {node}: hold the edge, or use --cloth host"
            ))),
        }
    }

    /// Copies the prediction to a point.
    fn place_at_prediction(&self, point: &PointSlot) -> Result<(), DeviceError> {
        let bytes = 12 * self.nodes as u64;
        let mut commands = self.device.record("cloth prediction");
        for (from, to) in [
            ("predicted_whole", "whole"),
            ("predicted_remainder", "remainder"),
        ] {
            let (from, to) = (self.buffer(from)?, self.buffer(to)?);
            commands
                .raw
                .copy_buffer_to_buffer(from, 0, to, u64::from(point.0) * bytes, bytes);
        }
        self.device.leave(commands);
        Ok(())
    }

    /// The points of the minimiser, to be read.
    fn points(&self) -> Result<Points<'_>, DeviceError> {
        Ok(Points {
            device: &self.device,
            staging: &self.staging,
            whole: self.buffer("whole")?,
            remainder: self.buffer("remainder")?,
            nodes: self.nodes,
        })
    }

    /// Positions of a point [m].
    fn positions(&self, point: &PointSlot) -> Result<Vec<DVec3>, DeviceError> {
        self.points()?.positions_m(point)
    }
}

/// The minimiser's options, with what positions on the device cannot hold.
pub(super) fn device_options(
    structure: &Structure,
    input: &StepInput,
    settings: &SolverSettings,
) -> Options {
    let mut options = options(structure, input, settings);
    options.displacement_floor_m = options.displacement_floor_m.max(ROUND_OFF_M);
    options
}

/// What velocities and accelerations of a step count from.
pub(super) fn base<'a>(state: &'a State, input: &StepInput) -> StepBase<'a> {
    let now = [&state.positions_m[..], &state.velocities_m_s];
    StepBase::new(now, state.step_before.as_ref(), input)
}
