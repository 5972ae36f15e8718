//! Steps that a device makes by itself, where it has air and fabric. What every step found waits on the device until the host asks for several of them at once.
//!
//! *Departures from steps with the host*: positions are rounded to what both sides can hold ([`super::motion`]). A solve that does not end stands as it is, as
//! where the host has come to its limit of evaluations.

use std::collections::VecDeque;

use glam::DVec3;

use crate::cloth::Structure;
use crate::cloth::patches::Patches;
use crate::cpu::cloth::{Cloth as State, InitialHessian, SolverSettings, StepInput};
use crate::gpu::error::DeviceError;
use crate::gpu::transfer::Staging;
use crate::solve::lbfgs::{Outcome, REMAINDER, Stop};

use super::cut_fabric::{AirScales, AtCuts, CutFabric, LinksInAir};
use super::decisions::{copy, stop};
use super::motion::{NodesOnDevice, OwnStepPipelines, Series};
use super::parameters::{ClothStage, FabricMotion, Minimiser};
use super::solve_cloth::{base, device_options};
use super::{AtMarkers, Cloth, Solution};

/// Bytes that wait on the device at most.
const MOST_BYTES: u64 = 64 << 20;

impl Cloth {
    /// Where its nodes are while the device makes steps by itself; `None` where it cannot.
    #[must_use]
    pub fn nodes_on_device(&self) -> Option<NodesOnDevice> {
        let own_steps = self.in_air.as_ref()?.own_steps.as_ref()?;
        let decisions = &self.workspace.as_ref()?.decisions;
        let markers = self.buffer("markers").ok()?;
        (decisions.small.is_some()).then(|| own_steps.nodes(markers))
    }

    /// From now on the device may make steps by itself of fabric that cuts links of air with these scales. False, and it may not, where a step needs more of the host.
    pub fn follow_cuts(
        &mut self,
        structure: &Structure,
        (air, patches): (&AirScales, Option<&Patches>),
    ) -> Result<bool, DeviceError> {
        let is_small =
            (self.workspace.as_ref()).is_some_and(|workspace| workspace.decisions.small.is_some());
        if is_small && self.triangles.cut {
            self.cuts = CutFabric::new(&self.device, structure, (air, patches))?;
        }
        Ok(self.cuts.is_some())
    }

    /// Steps that can wait on the device together; 0 where it makes none by itself.
    #[must_use]
    pub fn most_own_steps(&self) -> u64 {
        match (self.own_step_pipelines(), self.own_step_bytes()) {
            (Some(_), Ok(bytes)) => MOST_BYTES / bytes.max(1),
            _ => 0,
        }
    }

    fn own_step_pipelines(&self) -> Option<&OwnStepPipelines> {
        match (&self.cuts, &self.in_air) {
            (Some(cuts), _) => Some(&cuts.own_steps),
            (None, Some(in_air)) => in_air.own_steps.as_ref(),
            (None, None) => None,
        }
    }

    /// Bytes that come back of a step of the device's own.
    fn own_step_bytes(&self) -> Result<u64, DeviceError> {
        let decisions = &self.workspace()?.decisions;
        Ok(match &self.cuts {
            Some(cuts) => MINIMISER_BYTES + cuts.brought_bytes(),
            None => decisions.own_step_bytes(),
        })
    }

    /// Begins steps of fabric that cuts links, as [`Cloth::begin_own_steps`] does: `faces` have the density excess on both faces of every node, `air` its buffers.
    pub fn begin_cut_steps(
        &mut self,
        (state, input): (&State, &StepInput),
        settings: &SolverSettings,
        most: usize,
        (faces, air): (&[[f64; 2]], &LinksInAir<'_>),
    ) -> Result<(), DeviceError> {
        self.begin_own_steps((state, input), settings, most)?;
        let mut cuts = self.cuts.take().ok_or_else(not_begun)?;
        let workspace = self.workspace()?;
        let mut own = self.named_buffers();
        own.push(("vectors", &workspace.vectors));
        own.extend(workspace.decisions.named());
        cuts.bind(&self.device, &own, air)?;
        // The device adds the pull of the air.
        cuts.upload(&self.device, &self.drive, faces);
        self.drive.clear();
        self.cuts = Some(cuts);
        Ok(())
    }

    /// Records where the nodes of fabric that cuts links stand among the cells, in the next step.
    pub fn place_among_cells(&self) -> Result<(), DeviceError> {
        let cuts = self.cuts.as_ref().ok_or_else(not_begun)?;
        let mut commands = self.device.record("find_links");
        cuts.place(&self.device, &mut commands.pass("find_links"))?;
        self.device.leave(commands);
        Ok(())
    }

    /// Has the device make at most so many steps by itself from a `state` on, in each of which acts what `input` says. [`Cloth::make_own_step`] records each of them.
    pub fn begin_own_steps(
        &mut self,
        (state, input): (&State, &StepInput),
        settings: &SolverSettings,
        most: usize,
    ) -> Result<(), DeviceError> {
        self.send_nodes(state, input, settings)?;
        // The device writes the loads of every step itself.
        self.loads.clear();
        let options = device_options(&state.structure, input, settings);
        let base = base(state, input);
        let parameters = FabricMotion {
            share: base.share as f32,
            rate: base.time_step_s.map_or(0.0, |h| 1.0 / h) as f32,
            damping: input.damping_1_s as f32,
            longest_remainder: (REMAINDER * options.displacement_floor_m) as f32,
        };
        let own_steps = self.own_step_pipelines().ok_or_else(not_begun)?;
        own_steps.upload(&self.device, state, &base, parameters);
        let last = self.series.take();
        let space = self.space(0.0, settings.initial_hessian)?;
        let (stage, minimiser) = space.start_of(&options);
        let step_bytes = self.own_step_bytes()?;
        let bytes = step_bytes * most as u64;
        let device = &self.device;
        let (start, staging) = match last {
            Some(Series { start, staging, .. }) if staging.holds(bytes) => (start, staging),
            _ => (
                device.storage("start of a solve", STAGE_BYTES + MINIMISER_BYTES)?,
                Staging::new(device, bytes)?,
            ),
        };
        device.write(&start, 0, &[stage]);
        let words: &[u32] = bytemuck::cast_slice(std::slice::from_ref(&minimiser));
        device.write(&start, STAGE_BYTES as usize / 4, words);
        let series = Series {
            options,
            start,
            staging,
            step_bytes,
            steps: 0,
            submitted: None,
            brought: VecDeque::new(),
        };
        drop(space);
        self.series = Some(series);
        Ok(())
    }

    /// Records the next step of the fabric: at markers whose air is known, with the forces of the markers on the air, or at cut links of which is known what left.
    pub fn make_own_step(&mut self) -> Result<(), DeviceError> {
        let workspace = self.workspace.as_ref().ok_or_else(not_begun)?;
        let series = self.series.as_ref().ok_or_else(not_begun)?;
        let decisions = &workspace.decisions;
        let small = decisions.small.as_ref().ok_or_else(not_begun)?;
        let cuts = self.cuts.as_ref();
        let in_air = decisions.in_air.as_ref();
        let own_steps = match cuts.and_then(|cuts| cuts.bound.as_ref()) {
            Some(bound) => Some(&bound.own_steps),
            None => in_air.and_then(|in_air| in_air.own_steps.as_ref()),
        };
        let own_steps = own_steps.ok_or_else(not_begun)?;
        let device = &self.device;
        let nodes = device.workgroups(decisions.nodes as u64);
        let buffer = |wanted: &str| self.buffer(wanted);
        let node_bytes = 12 * decisions.nodes as u64;
        let mut commands = device.record("own step");
        {
            let mut pass = commands.pass("predict");
            own_steps.predict.dispatch(&mut pass, nodes);
            if let (Some(in_air), Some(velocities)) = (in_air, &own_steps.marker_velocities) {
                let markers = device.workgroups(in_air.marker_count() as u64);
                velocities.dispatch(&mut pass, markers);
            }
        }
        // A solve starts at the prediction, which is point 0.
        for (from, at, to, bytes) in [
            (&series.start, 0, buffer("stage")?, STAGE_BYTES),
            (
                &series.start,
                STAGE_BYTES,
                &decisions.minimiser,
                MINIMISER_BYTES,
            ),
            (buffer("predicted_whole")?, 0, buffer("whole")?, node_bytes),
            (
                buffer("predicted_remainder")?,
                0,
                buffer("remainder")?,
                node_bytes,
            ),
        ] {
            commands.raw.copy_buffer_to_buffer(from, at, to, 0, bytes);
        }
        {
            let mut pass = commands.pass("cloth minimise");
            match (cuts, in_air) {
                (Some(cuts), _) => cuts.react(device, &mut pass)?,
                (None, Some(in_air)) => in_air.react(device, &mut pass),
                (None, None) => {}
            }
            workspace.blocks.dispatch(&mut pass);
            for _ in 0..small.dispatches(series.options.evaluation_limit) {
                small.bound.dispatch(&mut pass, [1, 1]);
            }
        }
        {
            let mut pass = commands.pass("react_back");
            own_steps.end_step.dispatch(&mut pass, nodes);
            match (cuts, in_air) {
                (Some(cuts), _) => cuts.move_nodes(device, &mut pass)?,
                (None, Some(in_air)) => in_air.record_back(device, &mut pass),
                (None, None) => {}
            }
        }
        let at = series.step_bytes * series.steps as u64;
        match cuts {
            Some(cuts) => {
                let mut parts = vec![(&decisions.minimiser, MINIMISER_BYTES)];
                parts.extend(cuts.parts()?);
                copy(&mut commands, &parts, &series.staging, at);
            }
            None => decisions.bring_own_step(&mut commands, &series.staging, at),
        }
        device.leave(commands);
        if let Some(series) = &mut self.series {
            series.steps += 1;
        }
        Ok(())
    }

    /// Has the device begin with the steps that were recorded.
    pub fn submit_own_steps(&mut self) -> Result<(), DeviceError> {
        let series = self.series.as_mut().ok_or_else(not_begun)?;
        let commands = self.device.record("own steps");
        series.submitted = Some(self.device.submit_alone(commands));
        Ok(())
    }

    /// Takes the next of the steps that were made: how the solve ended, and what the device found and did at the markers. Waits for all of them before the first.
    pub fn take_own_step(&mut self) -> Result<(Outcome, AtMarkers), DeviceError> {
        let (state, rest) = self.next_brought()?;
        let decisions = &self.workspace()?.decisions;
        let in_air = decisions.in_air.as_ref().ok_or_else(not_begun)?;
        let own_steps = in_air.own_steps.as_ref().ok_or_else(not_begun)?;
        let (at_markers, of_nodes) =
            rest.split_at((in_air.brought_bytes() + in_air.sorted_bytes()) as usize);
        let at_markers = in_air.brought(at_markers);
        let ended = own_steps.brought(of_nodes);
        Ok((self.ended(&state, ended)?, at_markers))
    }

    /// The same of fabric that cuts links: what the air did to its triangles.
    pub fn take_cut_step(&mut self) -> Result<(Outcome, AtCuts), DeviceError> {
        let (state, rest) = self.next_brought()?;
        let cuts = self.cuts.as_ref().ok_or_else(not_begun)?;
        let (at_cuts, ended) = cuts.brought(&rest)?;
        Ok((self.ended(&state, ended)?, at_cuts))
    }

    /// Where the minimiser stood at the end of the next step, and what else was brought of it.
    fn next_brought(&mut self) -> Result<(Minimiser, Vec<u8>), DeviceError> {
        let series = self.series.as_mut().ok_or_else(not_begun)?;
        if let Some(submitted) = series.submitted.take() {
            let bytes = series.step_bytes * series.steps as u64;
            let steps = &mut series.brought;
            series
                .staging
                .read_of(&self.device, submitted, bytes, |bytes| {
                    let of_steps = bytes.chunks_exact(series.step_bytes as usize);
                    steps.extend(of_steps.map(<[u8]>::to_vec));
                })?;
        }
        let mut state = series.brought.pop_front().ok_or_else(not_begun)?;
        let rest = state.split_off(MINIMISER_BYTES as usize);
        Ok((bytemuck::pod_read_unaligned(&state), rest))
    }

    /// Notes where the nodes are at the end of a step.
    fn ended(&mut self, state: &Minimiser, ended: Vec<DVec3>) -> Result<Outcome, DeviceError> {
        let stop = stop(state).unwrap_or(Stop::LimitReached);
        let outcome = self
            .space(0.0, InitialHessian::BlockJacobi)?
            .outcome(state, stop);
        self.solution = (stop != Stop::NotFinite).then_some(Solution::Ended(ended));
        Ok(outcome)
    }
}

const STAGE_BYTES: u64 = size_of::<ClothStage>() as u64;
const MINIMISER_BYTES: u64 = size_of::<Minimiser>() as u64;

fn not_begun() -> DeviceError {
    DeviceError::Command("no steps of the device's own were begun".to_owned())
}
