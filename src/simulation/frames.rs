//! Host snapshots of the running scene, in SI units.

use glam::DVec3;

use super::Simulation;
use crate::cpu::cloth::{Cloth, StepInput, read_outs};
use crate::frame::{BodiesFrame, FluidFrame, Frame, StructureFrame};
use crate::gpu::DeviceError;

impl Simulation {
    /// The scene now; the air only where asked for, since it is large.
    pub fn frame(&self, with_air: bool) -> Result<Frame, DeviceError> {
        let mut frame = self.structure_frame();
        if with_air {
            frame.fluid = self.fluid_frame()?;
        }
        Ok(frame)
    }

    /// The structure now, without the air.
    #[must_use]
    pub fn structure_frame(&self) -> Frame {
        Frame {
            time_s: self.time_s(),
            step: self.step,
            fluid: None,
            structure: self
                .cloth
                .as_ref()
                .map(|cloth| structure_frame(cloth, &self.static_input())),
            bodies: self.bodies_frame(),
        }
    }

    fn bodies_frame(&self) -> Option<BodiesFrame> {
        if self.scene.rigid_bodies.is_empty() {
            return None;
        }
        let mut frame = BodiesFrame::default();
        for (number, body) in self.scene.rigid_bodies.iter().enumerate() {
            let placement = body.motion.at(self.time_s());
            let first = frame.positions_m.len() as u32;
            for &point in &body.surface.positions_m {
                frame.positions_m.push(placement.position_m(point));
                frame.velocities_m_s.push(placement.velocity_m_s(point));
            }
            for nodes in &body.surface.triangles {
                frame.triangles.push(nodes.map(|node| first + node));
                frame.numbers.push(number as u32);
            }
        }
        Some(frame)
    }

    /// Pressure above the outlet's [Pa] and velocity [m/s] of single cells, of the size around the structure; empty without air.
    pub fn air_in_cells(&self, cells: &[[usize; 3]]) -> Result<Vec<(f64, DVec3)>, DeviceError> {
        let (Some(air), Some(settings)) = (&self.air, &self.scene.air) else {
            return Ok(Vec::new());
        };
        let units = settings.units;
        let states = air.states_of(&settings.levels(), cells)?;
        Ok(states
            .into_iter()
            .map(|(excess, u)| (excess * units.pressure_pa(), units.velocity_m_s(u)))
            .collect())
    }

    fn fluid_frame(&self) -> Result<Option<FluidFrame>, DeviceError> {
        let (Some(air), Some(settings)) = (&self.air, &self.scene.air) else {
            return Ok(None);
        };
        let units = settings.units;
        let (speed, pressure) = (units.speed_m_s() as f32, units.pressure_pa() as f32);
        let mut frames = Vec::new();
        for (engine, level) in air.engines().into_iter().zip(settings.levels()) {
            let states = engine.macroscopic()?;
            let across = settings.finest_cells_across(&level);
            let corner = DVec3::from_array(level.corner.map(|n| n as f64));
            frames.push(FluidFrame {
                origin_m: (corner + DVec3::splat(0.5 * across)) * units.cell_size_m,
                cell_size_m: across * units.cell_size_m,
                cells: level.cells,
                velocity_m_s: states.iter().map(|(_, u)| u.map(|c| c * speed)).collect(),
                pressure_pa: states.iter().map(|(excess, _)| excess * pressure).collect(),
                finer: Vec::new(),
            });
        }
        let finer = frames.split_off(1);
        Ok(frames
            .pop()
            .map(|outermost| FluidFrame { finer, ..outermost }))
    }
}

fn structure_frame(cloth: &Cloth, input: &StepInput) -> StructureFrame {
    let structure = &cloth.structure;
    let loads = read_outs::triangle_loads(structure, &cloth.positions_m);
    let thicknesses_m: Vec<f64> = structure
        .triangles
        .iter()
        .map(|triangle| structure.thickness_of_m(triangle))
        .collect();
    let mut reactions_n = vec![DVec3::ZERO; structure.node_count()];
    for (node, force) in cloth.reactions_n(input) {
        reactions_n[node as usize] = force;
    }
    StructureFrame {
        reactions_n,
        contact_forces_n: cloth.contact_state().map(|c| c.forces_n.clone()),
        positions_m: cloth.positions_m.clone(),
        velocities_m_s: cloth.velocities_m_s.clone(),
        triangles: structure.triangles.iter().map(|t| t.nodes).collect(),
        principal_tensions_n_m: loads.iter().map(|l| l.principal_tensions_n_m).collect(),
        tension_directions: loads.iter().map(|l| l.direction).collect(),
        stress_pa: loads
            .iter()
            .zip(&thicknesses_m)
            .map(|(l, thickness_m)| l.principal_tensions_n_m[0] / thickness_m)
            .collect(),
        true_stress_pa: loads
            .iter()
            .zip(&thicknesses_m)
            .map(|(l, thickness_m)| l.principal_tensions_n_m[0] * l.cloth_stretch / thickness_m)
            .collect(),
        von_mises_pa: loads
            .iter()
            .zip(&thicknesses_m)
            .map(|(l, thickness_m)| l.von_mises_n_m() / thickness_m)
            .collect(),
        shear_stress_pa: loads
            .iter()
            .zip(&thicknesses_m)
            .map(|(l, thickness_m)| l.shear_tension_n_m / thickness_m)
            .collect(),
        shear_strain: loads.iter().map(|l| l.shear_strain).collect(),
        principal_strains: loads.iter().map(|l| l.principal_strains).collect(),
        // One figure serves fabric of one kind only.
        yield_stress_pa: structure
            .yield_stress_pa
            .filter(|_| structure.further_fabrics.is_empty()),
        rest_areas_m2: structure.triangles.iter().map(|t| t.rest_area_m2).collect(),
        states: loads.iter().map(|l| l.state).collect(),
        cables: structure.cables.iter().map(|c| c.nodes).collect(),
        cable_kinds: structure.cables.iter().map(|c| c.kind).collect(),
        cable_tensions_n: (0..structure.cables.len())
            .map(|index| cloth.cable_tension_n(index))
            .collect(),
    }
}
