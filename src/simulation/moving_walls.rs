//! Rigid bodies that move in the air of a device, which finds the links that they cut and answers along them by itself ([`crate::gpu::fluid::moving_walls`]). The host tells it where they
//! are, and learns what the air does to them.

use glam::DVec3;

use super::air::AirEngine;
use super::on_device::OnDevice;
use super::surface_box::{cells_of, corners_of, within};
use super::{Coupled, Failure, LinkCoupling, Simulation};
use crate::cpu::cloth::Cloth;
use crate::cut_links::search::GENERAL_POSITION;
use crate::gpu::DeviceError;
use crate::gpu::fluid::Fluid;
use crate::gpu::fluid::moving_answers::MovingWalls;
use crate::gpu::fluid::moving_tables::WallNode;
use crate::plan::STEPS_OF_A_SERIES;

impl LinkCoupling {
    /// Corners of a box that holds the surface at `time_s` [cells].
    fn corners_at(&self, time_s: f64) -> [DVec3; 2] {
        let lattice = |place_m| DVec3::from_array(self.units().position_to_lattice(place_m));
        let moved = self.bodies.iter().flat_map(|body| {
            let placement = body.motion.at(time_s);
            let [low, high] = corners_of(body.positions_m.iter().copied());
            (0..8).map(move |corner| {
                let place = |a: usize| {
                    if corner >> a & 1 == 0 {
                        low[a]
                    } else {
                        high[a]
                    }
                };
                placement.position_m(DVec3::new(place(0), place(1), place(2)))
            })
        });
        let triangles = self.surface().triangles().iter().flatten();
        let fabric = (self.bodies.first()).map_or(usize::MAX, |body| body.nodes.start);
        let still = triangles.filter(|node| (**node as usize) < fabric);
        corners_of(
            moved
                .map(lattice)
                .chain(still.map(|node| self.positions[*node as usize])),
        )
    }

    /// True if all cells that it touches at `time_s` lie in the box of cells `first..end`.
    pub(super) fn touches_only_at(&self, time_s: f64, first: [usize; 3], end: [usize; 3]) -> bool {
        if self.on_device != OnDevice::Moving {
            return self.surface().touches_only(first, end);
        }
        let [low, high] = cells_of(self.corners_at(time_s));
        (0..3).all(|a| low[a] > first[a] as i32 && high[a] + 1 < end[a] as i32)
    }

    /// Has a device lay the box of cells whose links it looks at in the steps that end at `times_s`.
    fn enclose(
        &self,
        fluid: &mut Fluid,
        times_s: impl Iterator<Item = f64>,
    ) -> Result<(), DeviceError> {
        let corners = corners_of(times_s.flat_map(|time_s| self.corners_at(time_s)));
        let (first, size) = within(cells_of(corners), 1, fluid.setup().cells);
        fluid.enclose_walls(first, size)
    }

    fn lay_walls(&self, fluid: &mut Fluid) -> Result<(), DeviceError> {
        let triangles = self.surface().triangles();
        let bodies: Vec<u32> = (0..triangles.len() as u32)
            .map(|triangle| self.body_of(triangle).map_or(0, |body| 1 + body as u32))
            .collect();
        let area = triangles.iter().map(|nodes| {
            let [a, b, c] = nodes.map(|node| self.positions[node as usize]);
            0.5 * (b - a).cross(c - a).length()
        });
        let walls = MovingWalls {
            triangles,
            bodies: &bodies,
            count: 1 + self.bodies.len(),
            nodes: self.positions.len(),
            area: area.sum(),
            growth: 1.0,
        };
        fluid.lay_moving_walls(&walls, STEPS_OF_A_SERIES as usize)
    }

    /// Stage `find_links`, where a device finds them, for a surface that was placed at `time_s`. In a series its box is laid already.
    fn find_on_device(
        &mut self,
        air: &mut AirEngine,
        (cloth, time_s): (Option<&Cloth>, f64),
        (released, in_series): (bool, bool),
    ) -> Result<(), DeviceError> {
        let AirEngine::Gpu(fluid) = air else {
            return Ok(());
        };
        if !in_series {
            self.lay_walls(fluid)?;
            self.enclose(fluid, std::iter::once(time_s))?;
        }
        self.take_velocities(cloth, time_s, released);
        let nodes: Vec<WallNode> = (self.positions.iter().zip(&self.velocities))
            .map(|(position, velocity)| {
                WallNode::new(
                    (*position + GENERAL_POSITION).to_array(),
                    velocity.to_array(),
                )
            })
            .collect();
        let node = |point: DVec3| WallNode::new((point + GENERAL_POSITION).to_array(), [0.0; 3]);
        // Moments are those of bodies alone.
        let points: Vec<WallNode> = std::iter::once(DVec3::ZERO)
            .chain(self.moment_points(time_s))
            .map(node)
            .collect();
        fluid.find_moving_links(&nodes, &points)
    }
}

impl Coupled {
    /// True if all that the structure touches at `time_s`, where its motion is known, lies in the box of cells `first..end`.
    pub(super) fn touches_only_at(&self, time_s: f64, first: [usize; 3], end: [usize; 3]) -> bool {
        match self {
            Self::Kernel(_) => self.touches_only(first, end),
            Self::Links(links) => links.touches_only_at(time_s, first, end),
        }
    }
}

impl Simulation {
    /// Stage `find_links` where a device finds them, in the step that follows `step`.
    pub(super) fn find_links_on_device(
        &mut self,
        step: u64,
        in_series: bool,
    ) -> Result<(), DeviceError> {
        let time_s = self.time_at(step + 1);
        let released = self.released();
        let (Some(air), Some(Coupled::Links(links))) = (&mut self.air, &mut self.coupled) else {
            return Ok(());
        };
        if links.on_device != OnDevice::Moving {
            return Ok(());
        }
        let placed = (self.cloth.as_ref(), time_s);
        links.find_on_device(air.finest_mut(), placed, (released, in_series))
    }

    /// Lays the box of cells for a series of so many steps.
    pub(super) fn enclose_walls(&mut self, steps: u64) -> Result<(), DeviceError> {
        let times_s: Vec<f64> = (1..=steps)
            .map(|step| self.time_at(self.step + step))
            .collect();
        let (Some(air), Some(Coupled::Links(links))) = (&mut self.air, &self.coupled) else {
            return Ok(());
        };
        match (links.on_device, air.finest_mut()) {
            (OnDevice::Moving, AirEngine::Gpu(fluid)) => {
                links.lay_walls(fluid)?;
                links.enclose(fluid, times_s.into_iter())
            }
            _ => Ok(()),
        }
    }

    /// Puts the surfaces where they are in the step that follows `step`, and finds the links that they cut, unless a device does.
    pub(super) fn place_surfaces(&mut self, step: u64) -> Result<(), Failure> {
        let time_s = self.time_at(step + 1);
        let Some(coupled) = &mut self.coupled else {
            return Ok(());
        };
        let found = coupled.find_links(self.cloth.as_ref(), time_s);
        self.still_inside(found)
    }
}
