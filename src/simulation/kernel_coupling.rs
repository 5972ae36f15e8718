//! Markers between the air and fabric or rigid bodies: SI on their side, lattice units on the air's.
//!
//! The scheme, in a step of the air from tⁿ to tⁿ⁺¹ (docs/coupling.md compares it with others):
//!
//! 1. collide and stream under the body force of the last step ([`crate::cpu::fluid`]);
//! 2. u*_k = Σ_x φ_k(x) u*(x), the bare velocity of the streamed populations at marker k, and a_k = min(2.5 a, a (3/8)/D_k)
//!    ([`crate::cpu::immersed`]);
//! 3. every k-th step, at most ([`super::Cadence`]): the fabric minimises inertia, elastic energy and ½ k dt Σ_k K_k |v_k − ū_k|² over
//!    k dt, K_k = 2 a_k ρ A_k Δx/dt, ū_k the mean of u*_k over the steps since the last solve ([`crate::cpu::cloth::solve_cloth`]); between
//!    solves it keeps its velocity;
//! 4. the air gets g_k = K_k (v_k − u*_k) of this step, F(x) = Σ_k φ_k(x) g_k.
//!
//! Where a marker acts across its triangle alone (surfaces of a wing, [`super::across`]), v_k − u*_k is its part along the normal in both.
//!
//! With k = 1 what the air gets is what the fabric felt, to the solver's tolerance; with k > 1 momentum is exchanged exactly only in the
//! mean over many spans. *Departure from explicit coupling and from Inamuro's multi-direct forcing (paper P0)*: the reaction is part of
//! the implicit step, with the velocity that the step ends with, so that the ratio of masses does not decide on stability.

use glam::DVec3;

use super::across::Across;
use super::air::AirEngine;
use super::bodies::{BodyMarkers, Load, folds, normal_of};
use super::markers::MarkerEngine;
use super::permeable::PermeableMarkers;
use crate::case::Scene;
use crate::case::scene::{Air, Coupling};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{Cloth, MarkerReaction};
use crate::gpu::DeviceError;
use crate::gpu::cloth::{AtMarkers, MarkersInAir, NodesOnDevice};
use crate::gpu::immersed::LatticeInSpace;
use crate::immersed::markers::Marker;
use crate::immersed::permeable::Permeable;
use crate::immersed::touched::OutOfDomain;
use crate::lattice::nest::EXCHANGED_CELLS;
use crate::plan::place_markers;
use crate::units::Units;

/// Markers in the air: first those of the fabric, then those of the rigid bodies.
#[derive(Debug)]
pub struct KernelCoupling {
    units: Units,
    markers: Vec<Marker>,
    bodies: Vec<BodyMarkers>,
    /// Passes of forcing.
    passes: u32,
    /// Steps of the running mean of u*; 1 without.
    averaging_steps: u32,
    immersed: MarkerEngine,
    /// [cells]
    positions: Vec<[f64; 3]>,
    /// [cells per step]
    velocities: Vec<[f64; 3]>,
    /// What the markers let pass; absent where nothing does.
    permeable: Option<PermeableMarkers>,
    /// What acts across its triangle alone; absent where nothing does.
    across: Option<Across>,
    /// Sum of u* since the last solve, for the mean ū.
    air_velocity_sums: Vec<[f64; 3]>,
    sums: u32,
    reactions: Vec<MarkerReaction>,
    force_on_air: [f64; 3],
}

impl KernelCoupling {
    pub(super) fn new(
        scene: &Scene,
        air: &Air,
        engine: &AirEngine,
        coupling: &Coupling,
    ) -> Result<Self, DeviceError> {
        let markers = place_markers(scene);
        let cell_area = air.units.cell_size_m * air.units.cell_size_m;
        let (bodies, body_areas_m2) =
            BodyMarkers::place_all(scene, coupling.marker_spacing_m(air), markers.len());
        let areas: Vec<f64> = markers
            .iter()
            .map(|m| m.area_m2)
            .chain(body_areas_m2)
            .map(|area_m2| area_m2 / cell_area)
            .collect();
        let count = areas.len();
        let kept = if air.depth() > 0 { EXCHANGED_CELLS } else { 0 };
        let permeable = PermeableMarkers::new(
            scene,
            &air.units,
            &markers,
            &bodies,
            &areas,
            coupling.over_relaxation,
        );
        Ok(Self {
            permeable,
            across: Across::new(scene, &markers, count),
            units: air.units,
            markers,
            bodies,
            passes: coupling.passes,
            averaging_steps: coupling.averaging_steps,
            immersed: MarkerEngine::at_faces(
                engine,
                (folds(scene), kept),
                areas,
                coupling.over_relaxation,
            )?,
            positions: vec![[0.0; 3]; count],
            velocities: vec![[0.0; 3]; count],
            air_velocity_sums: vec![[0.0; 3]; count],
            sums: 0,
            reactions: Vec::with_capacity(count),
            force_on_air: [0.0; 3],
        })
    }

    /// The scales.
    #[must_use]
    pub const fn units(&self) -> &Units {
        &self.units
    }

    /// Force of fabric that is held on the air, each marker's by the shares of held nodes [lattice units].
    pub(super) fn held_force_on_air(&self, cloth: &Cloth) -> [f64; 3] {
        let structure = &cloth.structure;
        let mut on_air = [0.0; 3];
        for (k, marker) in self.markers.iter().enumerate() {
            let nodes = structure.triangles[marker.triangle as usize].nodes;
            let share: f64 = nodes
                .iter()
                .zip(marker.weights)
                .filter(|(node, _)| structure.held[**node as usize])
                .map(|(_, weight)| weight)
                .sum();
            if share != 0.0 {
                let force = self.immersed.force(k);
                for a in 0..3 {
                    on_air[a] += share * force[a];
                }
            }
        }
        on_air
    }

    /// The immersed boundary.
    #[must_use]
    pub const fn immersed(&self) -> &MarkerEngine {
        &self.immersed
    }

    /// Total force on the air of the last `spread` [lattice units].
    #[must_use]
    pub const fn force_on_air(&self) -> [f64; 3] {
        self.force_on_air
    }

    /// The markers, fixed points of the fabric's triangles.
    #[must_use]
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// Places of the markers [cells].
    pub(super) fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Places of the markers, and what the last `spread` owes the air there in the next step [cells, lattice units].
    pub(super) fn pending_forces(&self) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
        let forces = (0..self.positions.len()).map(|k| self.immersed.force(k));
        self.positions.iter().copied().zip(forces)
    }

    /// Goes on on another lattice at `time_s`, owing the air the forces of its first markers [cells, lattice units].
    pub(super) fn go_on(
        &mut self,
        air: &AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
        owed: &[([f64; 3], [f64; 3])],
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        self.place(cloth, time_s);
        self.take_velocities(cloth, time_s, true);
        let mut forces = vec![[0.0; 3]; self.positions.len()];
        for (force, (_, owed)) in forces.iter_mut().zip(owed) {
            *force = *owed;
        }
        self.force_on_air = forces.iter().fold([0.0; 3], |sum, force| {
            std::array::from_fn(|a| sum[a] + force[a])
        });
        self.immersed.go_on(air, &self.positions, &forces)
    }

    /// Force on the air by the fabric alone in the last `spread` [lattice units].
    #[must_use]
    pub fn fabric_force_on_air(&self) -> [f64; 3] {
        if self.bodies.is_empty() {
            return self.force_on_air;
        }
        (0..self.markers.len()).fold([0.0; 3], |sum, k| {
            let force = self.immersed.force(k);
            std::array::from_fn(|a| sum[a] + force[a])
        })
    }

    /// What the air does to every rigid body by the last `spread`, at `time_s` [lattice units].
    #[must_use]
    pub fn body_loads(&self, time_s: f64) -> Vec<Load> {
        let force = |k| self.immersed.force(k);
        self.bodies
            .iter()
            .map(|body| body.load(time_s, &self.units, &self.positions, force))
            .collect()
    }

    fn place(&mut self, cloth: Option<&Cloth>, time_s: f64) {
        if let Some(cloth) = cloth {
            for (position, marker) in self.positions.iter_mut().zip(&self.markers) {
                *position =
                    self.units
                        .position_to_lattice(at_marker(cloth, marker, &cloth.positions_m));
            }
        }
        for body in &self.bodies {
            body.positions(time_s, &self.units, &mut self.positions);
        }
        if let Some(permeable) = &mut self.permeable {
            permeable.turn(cloth, &self.markers, &self.bodies, time_s);
        }
        if let (Some(across), Some(cloth)) = (&mut self.across, cloth) {
            across.turn(cloth, &self.markers);
        }
    }

    /// Stage `send_markers`.
    pub(super) fn send_markers(
        &mut self,
        air: &AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        self.place(cloth, time_s);
        self.immersed.send_markers(air, &self.positions)
    }

    /// Stage `interpolate`; on the device the markers are where `send_markers` put them.
    pub(super) fn interpolate(
        &mut self,
        air: &AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        let on_host = matches!(self.immersed, MarkerEngine::Cpu(_));
        if on_host {
            self.place(cloth, time_s);
        }
        if let Err(left) = self.immersed.interpolate(air, &self.positions)? {
            return Ok(Err(left));
        }
        if on_host {
            self.add_air_velocities();
        }
        Ok(Ok(()))
    }

    /// Has a device begin with what the next stage but one takes.
    pub(super) fn ask_air_velocities(&mut self) {
        self.immersed.ask_air_velocities();
    }

    /// The markers for fabric on the device that has the air; `None` on the CPU.
    pub(super) fn in_air(&self) -> Option<MarkersInAir> {
        self.immersed.in_air(&self.units)
    }

    /// From now on the device may find the markers itself, at these nodes. False, and it may not, where kernels go on through sides or are folded at faces.
    pub(super) fn follow(&mut self, nodes: NodesOnDevice) -> Result<bool, DeviceError> {
        let lattice = LatticeInSpace {
            first_centre_m: self.units.position_m([0.0; 3]),
            cell_size_m: self.units.cell_size_m,
        };
        self.immersed.follow(nodes, lattice)
    }

    /// Lays a box around the markers, with so many cells of room to move in.
    pub(super) fn enclose(
        &mut self,
        air: &AirEngine,
        room: u32,
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        self.immersed.enclose(air, &self.positions, room)
    }

    /// Has the device find and sort the markers.
    pub(super) fn sort_markers(&self) {
        self.immersed.sort_markers();
    }

    /// Takes where the device had sorted them to in a step that began with the nodes of `cloth`.
    pub(super) fn take_sorted(
        &mut self,
        cloth: Option<&Cloth>,
        time_s: f64,
        order: &[u32],
    ) -> Result<(), OutOfDomain> {
        self.place(cloth, time_s);
        self.immersed.take_sorted(order, &self.positions)
    }

    /// Nothing is known of the air's reactions until the device tells of the next solve.
    pub(super) fn forget_reactions(&mut self) {
        self.reactions.clear();
    }

    /// Takes what a device found and did at the markers by itself, and makes the reactions that the fabric felt.
    pub(super) fn take_brought(&mut self, at_markers: &AtMarkers) {
        if let Some(total) = self.immersed.take_brought(at_markers) {
            self.force_on_air = total;
        }
        self.add_air_velocities();
        self.gather_reactions();
    }

    /// Stage `fetch_air_velocities`.
    pub(super) fn fetch_air_velocities(&mut self) -> Result<(), DeviceError> {
        self.immersed.fetch_air_velocities()?;
        self.add_air_velocities();
        Ok(())
    }

    /// u* counts towards the mean of the steps since the last solve, or moves the running mean.
    fn add_air_velocities(&mut self) {
        if self.averaging_steps > 1 {
            let share = if self.sums == 0 {
                1.0
            } else {
                1.0 / f64::from(self.averaging_steps)
            };
            let present = self.immersed.air_velocities();
            for (mean, u) in self.air_velocity_sums.iter_mut().zip(present) {
                for a in 0..3 {
                    mean[a] += share * (u[a] - mean[a]);
                }
            }
            self.sums = 1;
            return;
        }
        for (sum, u) in self
            .air_velocity_sums
            .iter_mut()
            .zip(self.immersed.air_velocities())
        {
            for a in 0..3 {
                sum[a] += u[a];
            }
        }
        self.sums += 1;
    }

    /// The markers as the fabric feels them in this solve.
    pub(super) fn reactions(&self) -> &[MarkerReaction] {
        &self.reactions
    }

    /// What they let pass; empty where nothing passes the fabric.
    pub(super) fn permeable(&self) -> &[Permeable] {
        self.permeable
            .as_ref()
            .map_or(&[], PermeableMarkers::of_fabric)
    }

    /// Makes them from the mean ū since the last solve and the present strengths.
    pub(super) fn gather_reactions(&mut self) {
        let mean = 1.0 / f64::from(self.sums.max(1));
        self.reactions.clear();
        for (k, marker) in self.markers.iter().enumerate() {
            self.reactions.push(MarkerReaction {
                triangle: marker.triangle,
                weights: marker.weights,
                stiffness_kg_s: self.immersed.stiffness(k) * self.units.stiffness_kg_s(),
                air_velocity_m_s: self
                    .units
                    .velocity_m_s(self.air_velocity_sums[k].map(|u| u * mean)),
                across: None,
            });
        }
        for (k, normal) in self.across.iter().flat_map(Across::normals) {
            self.reactions[k].across = Some(normal);
        }
        if let Some(permeable) = &mut self.permeable {
            permeable.gather(self.markers.len(), &self.immersed, &self.units);
        }
        if self.averaging_steps == 1 {
            self.air_velocity_sums.fill([0.0; 3]);
            self.sums = 0;
        }
    }

    /// Velocities for a step that ends at `time_s`; before release all is held.
    pub(super) fn take_velocities(&mut self, cloth: Option<&Cloth>, time_s: f64, released: bool) {
        if let Some(cloth) = cloth.filter(|_| released) {
            for (velocity, marker) in self.velocities.iter_mut().zip(&self.markers) {
                *velocity =
                    self.units
                        .velocity_to_lattice(at_marker(cloth, marker, &cloth.velocities_m_s));
            }
        }
        if released {
            for body in &self.bodies {
                body.velocities(time_s, &self.units, &mut self.velocities);
            }
        } else {
            self.velocities.fill([0.0; 3]);
        }
        if !released {
            self.air_velocity_sums.fill([0.0; 3]);
            self.sums = 0;
        }
        if let Some(permeable) = &mut self.permeable {
            permeable.aim(&self.velocities, &self.immersed);
        }
        if let Some(across) = &mut self.across {
            let aims = self.permeable.as_ref();
            let aims = aims.map_or(&self.velocities[..], PermeableMarkers::targets);
            across.aim(aims, &self.immersed);
        }
    }

    /// Mean velocity of the air through what is permeable, and what residual slip adds to it [m/s]; `None` where nothing is.
    #[must_use]
    pub fn through_velocities_m_s(&self) -> Option<[f64; 2]> {
        let means = self.permeable.as_ref()?.means();
        Some(means.map(|v| v * self.units.speed_m_s()))
    }

    /// Stage `send_marker_forces`.
    pub(super) fn send_marker_forces(
        &mut self,
        cloth: Option<&Cloth>,
        time_s: f64,
        released: bool,
    ) {
        self.take_velocities(cloth, time_s, released);
        let targets = targets((&self.permeable, &self.across), &self.velocities);
        if let Some(total) = self.immersed.send_marker_forces(targets) {
            self.force_on_air = total;
        }
    }

    /// Stage `spread` of forces that a device has formed itself.
    pub(super) fn spread_brought(&mut self) {
        // A device takes no targets.
        self.immersed.spread(&[]);
    }

    /// Stage `spread`.
    pub(super) fn spread(&mut self, cloth: Option<&Cloth>, time_s: f64, released: bool) {
        if matches!(self.immersed, MarkerEngine::Cpu(_)) {
            self.take_velocities(cloth, time_s, released);
        }
        let targets = targets((&self.permeable, &self.across), &self.velocities);
        if let Some(total) = self.immersed.spread(targets) {
            self.force_on_air = total;
        }
    }

    /// Stage `repeat_forcing`: all passes after the first.
    pub(super) fn repeat_forcing(&mut self) -> Result<(), DeviceError> {
        for _ in 1..self.passes {
            if let Some(total) = self.immersed.repeat_forcing(&self.velocities)? {
                self.force_on_air = total;
            }
        }
        Ok(())
    }

    /// Stage `fetch_marker_forces`.
    pub(super) fn fetch_marker_forces(&mut self) -> Result<(), DeviceError> {
        if let Some(total) = self.immersed.fetch_marker_forces()? {
            self.force_on_air = total;
        }
        Ok(())
    }

    /// Root mean square slip of the air at the markers, beside what passes them [m/s].
    pub fn slip_m_s(&self) -> Result<f64, DeviceError> {
        let targets = targets((&self.permeable, &self.across), &self.velocities);
        Ok(self.immersed.slip(targets)? * self.units.speed_m_s())
    }

    /// Fastest marker [cells per step].
    #[must_use]
    pub fn fastest_marker(&self) -> f64 {
        fastest(self.velocities.iter().copied())
    }

    /// Fastest marker of the fabric as its nodes move now [cells per step].
    pub(super) fn fastest_of_fabric(&self, cloth: &Cloth) -> f64 {
        let velocity = |marker| at_marker(cloth, marker, &cloth.velocities_m_s);
        let velocities = self.markers.iter().map(velocity);
        fastest(velocities.map(|v| self.units.velocity_to_lattice(v)))
    }

    /// Mean normal velocity of the air through all surfaces at `time_s`, relative to them and beside what they let pass, after the half
    /// force: positive along the triangles' normals, weighted by area \[m/s\].
    pub fn leakage_m_s(&self, cloth: Option<&Cloth>, time_s: f64) -> Result<f64, DeviceError> {
        let targets = targets((&self.permeable, &self.across), &self.velocities);
        let slips = self.immersed.slip_velocities(targets)?;
        let mut normals = vec![[0.0; 3]; slips.len()];
        if let Some(cloth) = cloth {
            for (normal, marker) in normals.iter_mut().zip(&self.markers) {
                let nodes = cloth.structure.triangles[marker.triangle as usize].nodes;
                *normal = normal_of(nodes.map(|n| cloth.positions_m[n as usize])).to_array();
            }
        }
        for body in &self.bodies {
            body.normals(time_s, &mut normals);
        }
        let (mut flow, mut whole) = (0.0, 0.0);
        for (k, (slip, normal)) in slips.iter().zip(&normals).enumerate() {
            let area = self.immersed.area(k);
            flow += area * (0..3).map(|a| slip[a] * normal[a]).sum::<f64>();
            whole += area;
        }
        Ok(flow / whole * self.units.speed_m_s())
    }
}

fn fastest(velocities: impl Iterator<Item = [f64; 3]>) -> f64 {
    velocities
        .map(|v| v.iter().map(|c| c * c).sum::<f64>())
        .fold(0.0, f64::max)
        .sqrt()
}

/// Velocities that the air is to have at the markers: their own, and what passes them or flows along them.
fn targets<'a>(
    (permeable, across): (&'a Option<PermeableMarkers>, &'a Option<Across>),
    velocities: &'a [[f64; 3]],
) -> &'a [[f64; 3]] {
    match (across, permeable) {
        (Some(across), _) => across.targets(),
        (None, Some(permeable)) => permeable.targets(),
        (None, None) => velocities,
    }
}

/// Value of a nodal field at a marker.
pub(super) fn at_marker(cloth: &Cloth, marker: &Marker, field: &[DVec3]) -> DVec3 {
    let nodes = cloth.structure.triangles[marker.triangle as usize].nodes;
    nodes
        .iter()
        .zip(marker.weights)
        .map(|(&node, weight)| field[node as usize] * weight)
        .sum()
}

impl KernelCoupling {
    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("marker_positions", &self.positions)?;
        out.put("marker_velocities", &self.velocities)?;
        out.put("air_velocity_sums", &self.air_velocity_sums)?;
        out.put("air_velocity_sum_count", &[u64::from(self.sums)])?;
        out.put("force_on_air", &self.force_on_air)?;
        if let Some(permeable) = &self.permeable {
            permeable.save(out)?;
        }
        if let Some(across) = &self.across {
            across.save(out)?;
        }
        self.immersed.save(out)
    }

    pub(super) fn restore(
        &mut self,
        from: &Reader,
        air: &AirEngine,
    ) -> Result<(), CheckpointError> {
        let count = self.positions.len();
        self.positions = from.take_exactly("marker_positions", count)?;
        self.velocities = from.take_exactly("marker_velocities", count)?;
        self.air_velocity_sums = from.take_exactly("air_velocity_sums", count)?;
        self.sums = from.take_exactly::<u64>("air_velocity_sum_count", 1)?[0] as u32;
        self.force_on_air
            .copy_from_slice(&from.take_exactly::<f64>("force_on_air", 3)?);
        if let Some(permeable) = &mut self.permeable {
            permeable.restore(from)?;
        }
        if let Some(across) = &mut self.across {
            across.restore(from)?;
        }
        self.immersed.restore(from, &self.positions, air)
    }
}
