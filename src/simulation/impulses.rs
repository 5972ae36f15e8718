//! The force of the air on the structure, by three routes that share no data, as impulses since release.
//!
//! * markers: the sum of what `spread` delivered to the air, reversed;
//! * momentum box: storage and fluxes of populations through a box around the structure, reversed;
//! * supports: pull of the lines on their supports, plus the change of the structure's own momentum, minus gravity and guides, plus the numerical damping's.
//!
//! The mean force over any window is a difference of impulses over its length: exact, and free of sampling noise.

use glam::DVec3;

use super::air::{AirEngine, Balance};
use super::coupled::Coupled;
use crate::case::scene::{Air, BodyKind};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cloth::CableSegment;
use crate::cpu::cloth::{Cloth, nodal_forces};
use crate::gpu::DeviceError;
use crate::lattice::control_volume::{ControlVolume, MassMomentum};
use crate::units::Units;

/// Margin of the momentum box around the fabric's reach, in nominal diameters (or sizes).
const LATERAL_REACH: f64 = 0.7;

/// Impulses of the air on the structure since release.
#[derive(Debug)]
pub struct Impulses {
    units: Units,
    balance: Balance,
    /// Cells touched by markers stayed inside the box so far.
    contained: bool,
    markers: [f64; 3],
    initial: MassMomentum,
    supports: DVec3,
    initial_momentum: DVec3,
    support_cables: Vec<CableSegment>,
    /// True if cables alone touch held nodes, so that their tensions are all support forces.
    supported_by_cables: bool,
}

/// Impulses at one instant [N·s], and the mass balance of the box.
#[derive(Debug, Clone, Copy)]
pub struct ImpulseSample {
    /// Route 1.
    pub markers: DVec3,
    /// Route 2; `None` if the fabric left the box.
    pub momentum_box: Option<DVec3>,
    /// Route 3; `None` where fabric itself is held.
    pub supports: Option<DVec3>,
    /// (mass in the box now − mass then + net outflow) / mass.
    pub mass_defect: f64,
}

impl Impulses {
    pub(super) fn new(
        air: &Air,
        kind: Option<&BodyKind>,
        engine: &AirEngine,
        cloth: &Cloth,
    ) -> Result<Self, DeviceError> {
        let structure = &cloth.structure;
        let (low, high) = reach(kind, cloth);
        let cell = air.units.cell_size_m;
        let first = std::array::from_fn(|a| {
            ((low[a] / cell).floor() as i64).clamp(3, air.cells[a] as i64 / 2 - 1) as usize
        });
        let end = std::array::from_fn(|a| {
            ((high[a] / cell).ceil() as i64)
                .clamp(air.cells[a] as i64 / 2 + 1, air.cells[a] as i64 - 3) as usize
        });
        let support_cables = structure
            .cables
            .iter()
            .copied()
            .filter(|c| c.nodes.iter().any(|&n| structure.held[n as usize]))
            .collect();
        let supported_by_cables = !structure
            .triangles
            .iter()
            .flat_map(|t| t.nodes)
            .chain(structure.springs.iter().flat_map(|s| s.nodes))
            .any(|n| structure.held[n as usize]);
        Ok(Self {
            units: air.units,
            balance: Balance::new(engine, ControlVolume::new(&engine.grid(), first, end))?,
            contained: true,
            markers: [0.0; 3],
            initial: MassMomentum::default(),
            supports: DVec3::ZERO,
            initial_momentum: DVec3::ZERO,
            support_cables,
            supported_by_cables,
        })
    }

    /// Begins at release.
    pub(super) fn start(&mut self, air: &AirEngine, cloth: &Cloth) -> Result<(), DeviceError> {
        self.initial = air.storage(self.balance.volume())?;
        self.initial_momentum = cloth.momentum_kg_m_s();
        self.markers = [0.0; 3];
        self.balance.restart(air, MassMomentum::default())?;
        self.supports = DVec3::ZERO;
        Ok(())
    }

    /// The air has just been collided under `force` [lattice units].
    pub(super) fn add_delivered(&mut self, force: [f64; 3]) {
        for a in 0..3 {
            self.markers[a] -= force[a];
        }
    }

    pub(super) fn add_step(
        &mut self,
        air: &AirEngine,
        cloth: &Cloth,
        gravity: Option<DVec3>,
        damping_1_s: f64,
        coupled: &Coupled,
    ) -> Result<(), DeviceError> {
        self.balance.add_step(air)?;
        let volume = self.balance.volume();
        self.contained &= coupled.immersed().touches_only(volume.first, volume.end);
        let mut pull = DVec3::ZERO;
        let structure = &cloth.structure;
        for cable in &self.support_cables {
            let [a, b] = cable.nodes.map(|n| n as usize);
            // Direction from the supported end to the support.
            let (free, held) = if structure.held[a] { (b, a) } else { (a, b) };
            let direction = (cloth.positions_m[held] - cloth.positions_m[free]).normalize_or_zero();
            pull += direction * nodal_forces::cable_tension_n(cable, &cloth.positions_m);
        }
        for guide in &structure.guides {
            pull -= guide.stiffness_n_m * (cloth.positions_m[guide.node as usize] - guide.anchor_m);
        }
        pull -= cloth.momentum_kg_m_s() * damping_1_s;
        if let Some(gravity) = gravity {
            let mass: f64 = structure
                .masses_kg
                .iter()
                .zip(&structure.held)
                .filter(|(_, held)| !**held)
                .map(|(m, _)| m)
                .sum();
            pull += gravity * mass;
        }
        self.supports -= pull * self.units.time_step_s;
        Ok(())
    }

    /// Impulses now.
    pub(super) fn sample(
        &mut self,
        air: &AirEngine,
        cloth: &Cloth,
    ) -> Result<ImpulseSample, DeviceError> {
        let stored = air.storage(self.balance.volume())?;
        let outflow = self.balance.outflow(air)?;
        let scale = self.units.impulse_n_s();
        let momentum_box = self.contained.then(|| {
            DVec3::from_array(std::array::from_fn(|a| {
                -scale * (stored.momentum[a] - self.initial.momentum[a] + outflow.momentum[a])
            }))
        });
        let mass = self.balance.volume().cell_count() as f64 + self.initial.mass_excess;
        Ok(ImpulseSample {
            markers: DVec3::from_array(self.markers) * scale,
            momentum_box,
            supports: self
                .supported_by_cables
                .then(|| self.supports + cloth.momentum_kg_m_s() - self.initial_momentum),
            mass_defect: (stored.mass_excess - self.initial.mass_excess + outflow.mass_excess)
                / mass,
        })
    }
}

/// Corners of the box that the structure is expected to stay in [m].
fn reach(kind: Option<&BodyKind>, cloth: &Cloth) -> (DVec3, DVec3) {
    let positions = &cloth.positions_m;
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    match kind {
        Some(BodyKind::Canopy(canopy)) => {
            let diameter = canopy.nominal_diameter_m;
            let confluence = positions[canopy.canopy_node_count];
            let skirt = positions[..canopy.canopy_node_count]
                .iter()
                .map(|p| p.x)
                .fold(f64::INFINITY, f64::min);
            let lateral = DVec3::new(0.0, LATERAL_REACH * diameter, LATERAL_REACH * diameter);
            let line = skirt - confluence.x;
            (
                confluence - lateral + DVec3::X * (0.3 * line),
                confluence + lateral + DVec3::X * (1.1 * line + 0.65 * diameter),
            )
        }
        _ => {
            let margin = DVec3::splat(0.5 * (high - low).max_element());
            (low - margin, high + margin)
        }
    }
}

impl Impulses {
    pub(super) fn save(&mut self, out: &mut Writer, air: &AirEngine) -> std::io::Result<()> {
        let outflow = self.balance.outflow(air).map_err(std::io::Error::other)?;
        let balance =
            |m: &MassMomentum| [m.mass_excess, m.momentum[0], m.momentum[1], m.momentum[2]];
        out.put("impulse_contained", &[u64::from(self.contained)])?;
        out.put("impulse_markers", &self.markers)?;
        out.put("impulse_outflow", &balance(&outflow))?;
        out.put("impulse_initial", &balance(&self.initial))?;
        out.put("impulse_supports", &[self.supports, self.initial_momentum])
    }

    pub(super) fn restore(
        &mut self,
        from: &Reader,
        air: &AirEngine,
    ) -> Result<(), CheckpointError> {
        let balance = |name: &str| -> Result<MassMomentum, CheckpointError> {
            let values: Vec<f64> = from.take_exactly(name, 4)?;
            Ok(MassMomentum {
                mass_excess: values[0],
                momentum: [values[1], values[2], values[3]],
            })
        };
        self.contained = from.take_exactly::<u64>("impulse_contained", 1)?[0] == 1;
        self.markers
            .copy_from_slice(&from.take_exactly::<f64>("impulse_markers", 3)?);
        let outflow = balance("impulse_outflow")?;
        self.balance
            .restart(air, outflow)
            .map_err(|error| from.damaged(error.to_string()))?;
        self.initial = balance("impulse_initial")?;
        let vectors: Vec<DVec3> = from.take_exactly("impulse_supports", 2)?;
        (self.supports, self.initial_momentum) = (vectors[0], vectors[1]);
        Ok(())
    }
}
