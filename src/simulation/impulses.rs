//! The force of the air on the structure, by three routes that share no data, as impulses since release.
//!
//! * markers: the sum of what `spread` delivered to the air, reversed;
//! * momentum box: storage and fluxes of populations through a box around the structure, reversed;
//! * supports: pull of the lines on their supports, or of a plate on its held edge, plus the change of the structure's own momentum, minus gravity and guides, plus the numerical damping's.
//!   With a kernel the air gets a step later what the fabric feels; what it is owed is left out, so that all three tell of the same.
//!
//! The mean force over any window is a difference of impulses over its length: exact, and free of sampling noise.

use glam::DVec3;

use super::air::{AirEngine, Balance};
use super::bodies::{Load, inner_momentum};
use super::coupled::Coupled;
use super::reach::{body_reach, reach};
use crate::case::Scene;
use crate::case::coupling::Scheme;
use crate::case::scene::{Air, BodyKind, RigidBody};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{Cloth, NodalDrag, StepInput};
use crate::gpu::DeviceError;
use crate::lattice::control_volume::{ControlVolume, MassMomentum};
use crate::lattice::nest::EXCHANGED_CELLS;
use crate::units::Units;

/// Cells between the momentum box and the faces of a box of finer cells, at least: shell and band, and one more.
const LEAST_GAP_IN_BOX: i64 = EXCHANGED_CELLS as i64 + 1;

/// Impulses of the air on the structure since release.
#[derive(Debug)]
pub struct Impulses {
    units: Units,
    balance: Balance,
    /// Steps that are not accounted for, but what crossed its faces in them is added already.
    outflows_ahead: u64,
    /// Cells touched by markers stayed inside the box so far; never where a body passes through a face.
    contained: bool,
    /// The box's mass is known only while it holds the surfaces: what leaves along links that they cut across its faces comes back unseen.
    cut_links_leave: bool,
    markers: [f64; 3],
    /// Force of the fabric on the air that was delivered last [lattice units].
    delivered: [f64; 3],
    /// Of every rigid body.
    bodies: Vec<Load>,
    initial: MassMomentum,
    /// Pull of the supports, with what else belongs to that route, and what the structure has gained of momentum since release.
    supports: DVec3,
    /// Numbers of the cable segments at supports.
    support_cables: Vec<usize>,
    /// Momentum that the apparent acceleration of a falling box has given the air in the momentum box; mass excess there, as last stored.
    apparent: [f64; 3],
    mass_excess: f64,
    /// Whose forces are those of the supports; `None` where they are not known.
    support: Option<Support>,
    /// From before the last change of the lattice; zero without one.
    carried: Carried,
}

/// Impulses up to a change of the lattice, in SI units.
#[derive(Debug, Clone, Default)]
pub(super) struct Carried {
    /// What the markers delivered, reversed [N·s].
    markers: DVec3,
    /// Force and moment on every rigid body by its markers [N·s, N·m·s].
    bodies: Vec<(DVec3, DVec3)>,
    /// What left and what was stored in the momentum box, reversed [N·s].
    momentum_box: DVec3,
    /// Markers have left a momentum box.
    left: bool,
    /// Pull of the supports, with what else belongs to that route [N·s].
    supports: DVec3,
}

/// What supports feel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Support {
    /// Cables alone touch held nodes: their tensions.
    Cables,
    /// The elements at the held edge of a plate, and the air on that edge.
    HeldEdge,
}

/// What acts on air and structure in a step beside their exchange.
#[derive(Debug, Clone, Copy)]
pub(super) struct Acting<'a> {
    /// Gravity of the structure with the apparent acceleration [m/s²].
    pub gravity_m_s2: Option<DVec3>,
    /// Apparent acceleration of all masses in a box that falls [m/s²].
    pub apparent_m_s2: Option<DVec3>,
    /// Mass-proportional damping [1/s].
    pub damping_1_s: f64,
    /// Drag of payload and lines.
    pub drags: &'a [NodalDrag],
}

/// Force of the air on nodes by their own drag, after the solve [N].
pub(super) fn drag_n(drags: &[NodalDrag], cloth: &Cloth) -> DVec3 {
    drags
        .iter()
        .filter(|drag| !cloth.structure.held[drag.node as usize])
        .map(|drag| {
            let velocity = cloth.velocities_m_s[drag.node as usize];
            (drag.air_velocity_m_s - velocity) * drag.coefficient_kg_s
        })
        .sum()
}

/// Impulse on a rigid body and its moment, since release.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyImpulse {
    /// Impulse of the air outside [N·s].
    pub force: DVec3,
    /// Angular impulse about the moment point [N·m·s]; that of the air inside a closed body is not taken off.
    pub moment: DVec3,
}

/// Impulses at one instant [N·s], and the mass balance of the box.
#[derive(Debug, Clone)]
pub struct ImpulseSample {
    /// Route 1: on the fabric, or without any on all rigid bodies.
    pub markers: DVec3,
    /// On every rigid body, by its markers.
    pub bodies: Vec<BodyImpulse>,
    /// Route 2, of the same; `None` if markers left the box.
    pub momentum_box: Option<DVec3>,
    /// Route 3; `None` where fabric itself is held.
    pub supports: Option<DVec3>,
    /// (mass in the box now − mass then + net outflow) / mass; NaN once a surface that cuts links has left it.
    pub mass_defect: f64,
}

impl Impulses {
    pub(super) fn new(
        air: &Air,
        scene: &Scene,
        engine: &AirEngine,
        cloth: Option<&Cloth>,
    ) -> Result<Self, DeviceError> {
        let kind = scene.body.as_ref().map(|body| &body.kind);
        let mut reaches: Vec<(DVec3, DVec3)> =
            cloth.iter().map(|cloth| reach(kind, cloth)).collect();
        let end_s = scene.time.map_or(0.0, |time| time.end_s);
        let bodies = &scene.rigid_bodies;
        reaches.extend(
            bodies
                .iter()
                .map(|body| body_reach(body, end_s, air.units.cell_size_m)),
        );
        let (low, high) = reaches.into_iter().fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(low, high), reach| (low.min(reach.0), high.max(reach.1)),
        );
        let [low, high] =
            [low, high].map(|corner| (corner - air.units.origin_m) / air.units.cell_size_m);
        let cells = engine.grid().cells.map(|n| n as i64);
        // In a box of finer cells, beside what is exchanged with those around it.
        let spans = air.finest().spans;
        let least = |a: usize| match air.depth() > 0 && !spans[a] {
            true => LEAST_GAP_IN_BOX,
            false => 3,
        };
        let first = std::array::from_fn(|a| {
            (low[a].floor() as i64).clamp(least(a), cells[a] / 2 - 1) as usize
        });
        let end = std::array::from_fn(|a| {
            (high[a].ceil() as i64).clamp(cells[a] / 2 + 1, cells[a] - least(a)) as usize
        });
        let structure = cloth.map(|cloth| &cloth.structure);
        let support_cables = structure.map_or_else(Vec::new, |structure| {
            let held = |&cable: &usize| {
                let nodes = structure.cables[cable].nodes;
                nodes.iter().any(|&n| structure.held[n as usize])
            };
            (0..structure.cables.len()).filter(held).collect()
        });
        let by_cables = structure.is_some_and(|structure| {
            !structure
                .triangles
                .iter()
                .flat_map(|t| t.nodes)
                .chain(structure.springs.iter().flat_map(|s| s.nodes))
                .any(|n| structure.held[n as usize])
        });
        let support = match kind {
            Some(BodyKind::Plate(_)) => Some(Support::HeldEdge),
            _ => by_cables.then_some(Support::Cables),
        };
        Ok(Self {
            units: air.units,
            balance: Balance::new(engine, ControlVolume::new(&engine.grid(), first, end))?,
            outflows_ahead: 0,
            // Markers at a face stand outside the box, which keeps three cells from all faces.
            contained: !scene.passes_through_a_face(),
            cut_links_leave: scene.coupling.is_some_and(|c| c.scheme == Scheme::Links)
                && !scene.passes_through_a_face(),
            markers: [0.0; 3],
            delivered: [0.0; 3],
            bodies: vec![Load::default(); bodies.len()],
            initial: MassMomentum::default(),
            supports: DVec3::ZERO,
            support_cables,
            apparent: [0.0; 3],
            mass_excess: 0.0,
            support,
            carried: Carried {
                bodies: vec![Default::default(); bodies.len()],
                ..Carried::default()
            },
        })
    }

    /// What another lattice has to know of the impulses so far.
    pub(super) fn into_carried(mut self, air: &AirEngine) -> Result<Carried, DeviceError> {
        let stored = air.storage(self.balance.volume())?;
        let outflow = self.balance.outflow(air)?;
        let momentum_box = self.momentum_box(&stored, &outflow);
        let (markers, bodies) = self.markers_and_bodies();
        Ok(Carried {
            markers,
            bodies,
            momentum_box,
            left: self.carried.left || !self.contained,
            supports: self.supports,
        })
    }

    /// Impulses go on from those on another lattice.
    pub(super) fn carry(&mut self, carried: Carried) {
        self.supports = carried.supports;
        self.carried = carried;
    }

    /// Impulses by the markers since release, on the fabric (without any: on all), and on every rigid body with their moments [SI].
    fn markers_and_bodies(&self) -> (DVec3, Vec<(DVec3, DVec3)>) {
        let scale = self.units.impulse_n_s();
        let bodies = self.bodies.iter().zip(&self.carried.bodies);
        (
            DVec3::from_array(self.markers) * scale + self.carried.markers,
            bodies
                .map(|(load, (force, moment))| {
                    (
                        DVec3::from_array(load.force) * scale + *force,
                        DVec3::from_array(load.moment) * (scale * self.units.cell_size_m) + *moment,
                    )
                })
                .collect(),
        )
    }

    /// Impulse on all that is in the momentum box, since release [N·s].
    fn momentum_box(&self, stored: &MassMomentum, outflow: &MassMomentum) -> DVec3 {
        let scale = self.units.impulse_n_s();
        DVec3::from_array(std::array::from_fn(|a| {
            let gained = stored.momentum[a] - self.initial.momentum[a] + outflow.momentum[a];
            -scale * (gained - self.apparent[a])
        })) + self.carried.momentum_box
    }

    /// Begins at release.
    pub(super) fn start(&mut self, air: &AirEngine) -> Result<(), DeviceError> {
        self.initial = air.storage(self.balance.volume())?;
        self.apparent = [0.0; 3];
        self.mass_excess = self.initial.mass_excess;
        self.markers = [0.0; 3];
        self.bodies.fill(Load::default());
        self.balance.restart(air, MassMomentum::default())?;
        self.supports = DVec3::ZERO;
        Ok(())
    }

    /// The air has just been given what the structure does to it: collided under the forces of the last `spread`, or bounced; formed at `time_s`.
    pub(super) fn add_delivered(&mut self, coupled: &Coupled, time_s: f64) {
        self.delivered = coupled.fabric_force_on_air();
        self.markers = std::array::from_fn(|a| self.markers[a] - self.delivered[a]);
        for (sum, load) in self.bodies.iter_mut().zip(coupled.body_loads(time_s)) {
            sum.add(&load);
        }
    }

    /// True unless cut links may change what crosses the faces of the box.
    pub(super) fn holds(&self, coupled: &Coupled) -> bool {
        let volume = self.balance.volume();
        coupled.kernel().is_some() || coupled.touches_only(volume.first, volume.end)
    }

    /// The same in the step that ends at `time_s`, where the motion of the structure is known.
    pub(super) fn holds_at(&self, coupled: &Coupled, time_s: f64) -> bool {
        let volume = self.balance.volume();
        coupled.touches_only_at(time_s, volume.first, volume.end)
    }

    /// Adds what crosses the faces of the box in this step, before the stage `bounce`. False, and nothing is done, where cut links may change that.
    pub(super) fn add_outflow(
        &mut self,
        air: &AirEngine,
        coupled: &Coupled,
    ) -> Result<bool, DeviceError> {
        let holds = self.holds(coupled);
        if holds {
            self.balance.add_step(air)?;
            self.outflows_ahead += 1;
        }
        Ok(holds)
    }

    /// Adds what crosses the faces of the box in a step, after the stage `bounce`, for a step that is accounted for later.
    pub(super) fn add_outflow_after_bounce(&mut self, air: &AirEngine) -> Result<(), DeviceError> {
        self.balance.add_step(air)?;
        self.outflows_ahead += 1;
        Ok(())
    }

    pub(super) fn add_step(
        &mut self,
        air: &AirEngine,
        (cloth, given_kg_m_s): (Option<&Cloth>, DVec3),
        acting: &Acting,
        coupled: &Coupled,
    ) -> Result<(), DeviceError> {
        match self.outflows_ahead.checked_sub(1) {
            Some(fewer) => self.outflows_ahead = fewer,
            None => self.balance.add_step(air)?,
        }
        let volume = self.balance.volume();
        if let Some(apparent) = acting.apparent_m_s2 {
            // What is stored now and then of the box's air hardly changes its mass.
            let mass = volume.cell_count() as f64 + self.mass_excess;
            let gain = self
                .units
                .velocity_to_lattice(apparent * self.units.time_step_s);
            for a in 0..3 {
                self.apparent[a] += mass * gain[a];
            }
        }
        self.contained &= coupled.touches_only(volume.first, volume.end);
        let Some(cloth) = cloth else {
            return Ok(());
        };
        let mut pull = DVec3::ZERO;
        let structure = &cloth.structure;
        for &cable in &self.support_cables {
            let [a, b] = structure.cables[cable].nodes.map(|n| n as usize);
            // Direction from the supported end to the support.
            let (free, held) = if structure.held[a] { (b, a) } else { (a, b) };
            let direction = (cloth.positions_m[held] - cloth.positions_m[free]).normalize_or_zero();
            pull += direction * cloth.cable_tension_n(cable);
        }
        if self.support == Some(Support::HeldEdge) {
            pull += self.held_edge_n(cloth, coupled);
        }
        for guide in &structure.guides {
            pull -= guide.stiffness_n_m * (cloth.positions_m[guide.node as usize] - guide.anchor_m);
        }
        pull -= cloth.momentum_kg_m_s() * acting.damping_1_s;
        pull += drag_n(acting.drags, cloth);
        if let Some(gravity) = acting.gravity_m_s2 {
            let mass: f64 = structure
                .masses_kg
                .iter()
                .zip(&structure.held)
                .filter(|(_, held)| !**held)
                .map(|(m, _)| m)
                .sum();
            pull += gravity * mass;
        }
        let loads = structure.loads_n.iter().zip(&structure.held);
        pull += (loads.filter(|(_, held)| !**held))
            .map(|(load, _)| *load)
            .sum::<DVec3>();
        self.supports += given_kg_m_s - pull * self.units.time_step_s;
        // What the fabric felt now, the air may still be owed; what it was owed before, it has got.
        let [owed, got] = [coupled.fabric_force_on_air(), self.delivered].map(DVec3::from_array);
        self.supports += (owed - got) * self.units.impulse_n_s();
        Ok(())
    }

    /// Force of the held edge on a plate, less what the air does to held nodes directly [N].
    fn held_edge_n(&self, cloth: &Cloth, coupled: &Coupled) -> DVec3 {
        let reactions = cloth.reactions_n(&StepInput::default());
        let elastic: DVec3 = reactions.iter().map(|(_, force)| *force).sum();
        let on_air = coupled.held_force_on_air(cloth);
        let scale = self.units.impulse_n_s() / self.units.time_step_s;
        elastic + DVec3::from_array(on_air) * scale
    }

    /// Impulses now.
    pub(super) fn sample(
        &mut self,
        air: &AirEngine,
        cloth: Option<&Cloth>,
        bodies: &[RigidBody],
        time_s: f64,
    ) -> Result<ImpulseSample, DeviceError> {
        let stored = air.storage(self.balance.volume())?;
        let outflow = self.balance.outflow(air)?;
        self.mass_excess = stored.mass_excess;
        let mut momentum_box =
            (self.contained && !self.carried.left).then(|| self.momentum_box(&stored, &outflow));
        let (mut markers, by_markers) = self.markers_and_bodies();
        let mut inner = DVec3::ZERO;
        let on_bodies: Vec<BodyImpulse> = bodies
            .iter()
            .zip(by_markers)
            .map(|(body, (force, moment))| {
                // What the air inside has taken up is not the outer air's doing.
                let own = inner_momentum(body, self.units.density_kg_m3, time_s);
                inner += own;
                BodyImpulse {
                    force: force + own,
                    moment,
                }
            })
            .collect();
        let on_all: DVec3 = on_bodies.iter().map(|body| body.force).sum();
        momentum_box = momentum_box.map(|all| all + inner);
        if cloth.is_some() {
            // The box holds fabric and bodies.
            momentum_box = momentum_box.map(|all| all - on_all);
        } else {
            markers = on_all;
        }
        let mass = self.balance.volume().cell_count() as f64 + self.initial.mass_excess;
        Ok(ImpulseSample {
            markers,
            bodies: on_bodies,
            momentum_box,
            supports: cloth
                .filter(|_| self.support.is_some())
                .map(|_| self.supports),
            mass_defect: if self.cut_links_leave && !self.contained {
                f64::NAN
            } else {
                (stored.mass_excess - self.initial.mass_excess + outflow.mass_excess) / mass
            },
        })
    }
}

/// Section of a checkpoint with the first cell of the momentum box and the cell behind its last.
const MOMENTUM_BOX: &str = "momentum_box";

impl Impulses {
    pub(super) fn save(&mut self, out: &mut Writer, air: &AirEngine) -> std::io::Result<()> {
        let outflow = self.balance.outflow(air).map_err(std::io::Error::other)?;
        let balance =
            |m: &MassMomentum| [m.mass_excess, m.momentum[0], m.momentum[1], m.momentum[2]];
        out.put("impulse_contained", &[u64::from(self.contained)])?;
        out.put("impulse_markers", &self.markers)?;
        let bodies: Vec<[f64; 3]> = self
            .bodies
            .iter()
            .flat_map(|load| [load.force, load.moment])
            .collect();
        out.put("impulse_bodies", &bodies)?;
        let volume = self.balance.volume();
        let corners = volume.first.iter().chain(&volume.end);
        let corners: Vec<u64> = corners.map(|corner| *corner as u64).collect();
        out.put(MOMENTUM_BOX, &corners)?;
        out.put("impulse_outflow", &balance(&outflow))?;
        out.put("impulse_initial", &balance(&self.initial))?;
        out.put(
            "impulse_apparent",
            &[
                self.apparent[0],
                self.apparent[1],
                self.apparent[2],
                self.mass_excess,
            ],
        )?;
        out.put("impulse_supports", &[self.supports])?;
        let Carried {
            markers,
            momentum_box,
            left,
            ..
        } = self.carried;
        let left = DVec3::splat(f64::from(u8::from(left)));
        let bodies = self.carried.bodies.iter();
        let bodies = bodies.flat_map(|(force, moment)| [*force, *moment]);
        let carried: Vec<DVec3> = [markers, momentum_box, left]
            .into_iter()
            .chain(bodies)
            .collect();
        out.put("impulse_carried", &carried)
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
        let bodies: Vec<[f64; 3]> = from.take_exactly("impulse_bodies", 2 * self.bodies.len())?;
        for (load, pair) in self.bodies.iter_mut().zip(bodies.chunks_exact(2)) {
            (load.force, load.moment) = (pair[0], pair[1]);
        }
        let outflow = balance("impulse_outflow")?;
        // A box that was laid around the structure after a change of the lattice is not that of its start.
        let corners: Vec<u64> = from.take_exactly(MOMENTUM_BOX, 6)?;
        let [first, end] = [0, 3].map(|k| [0, 1, 2].map(|a| corners[k + a] as usize));
        let cells = air.grid().cells;
        if (0..3).any(|a| first[a] < 1 || first[a] >= end[a] || end[a] >= cells[a]) {
            return Err(from.damaged(format!(
                "the momentum box {first:?} to {end:?} does not lie in {cells:?} cells"
            )));
        }
        let refused = |error: DeviceError| from.damaged(error.to_string());
        self.balance =
            Balance::new(air, ControlVolume::new(&air.grid(), first, end)).map_err(refused)?;
        self.balance.restart(air, outflow).map_err(refused)?;
        self.initial = balance("impulse_initial")?;
        let apparent: Vec<f64> = from.take_exactly("impulse_apparent", 4)?;
        self.apparent.copy_from_slice(&apparent[..3]);
        self.mass_excess = apparent[3];
        self.supports = from.take_exactly::<DVec3>("impulse_supports", 1)?[0];
        let carried: Vec<DVec3> =
            from.take_exactly("impulse_carried", 3 + 2 * self.bodies.len())?;
        self.carried = Carried {
            markers: carried[0],
            momentum_box: carried[1],
            left: carried[2].x != 0.0,
            bodies: carried[3..]
                .chunks_exact(2)
                .map(|pair| (pair[0], pair[1]))
                .collect(),
            ..Carried::default()
        };
        Ok(())
    }
}
