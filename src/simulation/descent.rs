//! A box that falls with what it holds: `[air.descent]`.
//!
//! The box moves along −x at the speed W. In its frame the air comes along +x, and every mass in it, air, fabric, cables and payload, feels
//! the uniform acceleration dW/dt along +x beside real forces: a constant in the collision of every cell, no field of forces, and part of
//! gravity for what hangs. The velocity at the inlet follows W. Any motion of the box gives the same physics; it only has to stay near what
//! falls:
//!
//! * with a payload, a point mass on the node where the lines meet, which the fabric's implicit step moves like any node, the box follows that
//!   node as a critically damped follower, dW/dt = −(2/T) v − x/T², x its way from its first place and v its velocity in the box; further masses
//!   may hang below it on tethers, and swing;
//! * with a rigid body the box is fixed to the body, (m + m_v) dW/dt = m g − F + m_v (dW/dt)ⁿ, F the force of the air by the last step. The
//!   virtual mass m_v = ρ S^{3/2}, more than the air that a disk carries along ((8/3) ρ R³; Lamb 1932), only delays the acceleration by m_v/m
//!   steps: without it the body's own added mass would make the explicit exchange unstable.
//!
//! *Left out*: buoyancy, and the change of density on the way.

use glam::DVec3;

use super::coupled::Coupled;
use crate::case::scene::{Carrier, Descent as Settings};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{Cloth, NodalDrag};
use crate::units::Units;

/// Time constant of the follower, in steps at release.
const FOLLOWING_STEPS: f64 = 50.0;

/// Motion of the box.
#[derive(Debug, Clone)]
pub struct Descent {
    settings: Settings,
    time_step_s: f64,
    /// Time constant of the follower [s]: it stays, or a change of the time step would shake the box.
    following_s: f64,
    /// W at the start of the step [m/s].
    speed_m_s: f64,
    /// dW/dt in the step [m/s²].
    acceleration_m_s2: f64,
    /// Way of the box since release [m].
    fallen_m: f64,
    /// Drag of the payload and of what hangs below it in the step; empty without drag areas.
    pub(super) drags: Vec<NodalDrag>,
}

/// What is known of the fall at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fall {
    /// Speed of the mass [m/s].
    pub speed_m_s: f64,
    /// Height fallen since release [m].
    pub fallen_m: f64,
}

impl Descent {
    pub(super) fn new(settings: Settings, units: &Units, release_speed_m_s: f64) -> Self {
        Self {
            settings,
            time_step_s: units.time_step_s,
            following_s: FOLLOWING_STEPS * units.time_step_s,
            speed_m_s: release_speed_m_s,
            acceleration_m_s2: 0.0,
            fallen_m: 0.0,
            drags: Vec::new(),
        }
    }

    /// The same motion, in steps of another length.
    pub(super) fn with_time_step(self, time_step_s: f64) -> Self {
        Self {
            time_step_s,
            ..self
        }
    }

    /// W at the start of the step [m/s].
    pub(super) const fn speed_m_s(&self) -> f64 {
        self.speed_m_s
    }

    /// W at its end [m/s].
    pub(super) fn next_speed_m_s(&self) -> f64 {
        self.speed_m_s + self.acceleration_m_s2 * self.time_step_s
    }

    /// Acceleration that all masses feel in the box beside real forces [m/s²].
    pub(super) fn apparent_m_s2(&self) -> DVec3 {
        DVec3::X * self.acceleration_m_s2
    }

    /// Chooses the acceleration of the step that begins.
    pub(super) fn begin_step(
        &mut self,
        cloth: Option<&Cloth>,
        coupled: Option<&Coupled>,
        density_kg_m3: f64,
    ) {
        match (self.settings.carrier, cloth, coupled) {
            (Carrier::Confluence { node, home_x_m }, Some(cloth), _) => {
                let node = node as usize;
                let time = self.following_s;
                let way = cloth.positions_m[node].x - home_x_m;
                let velocity = cloth.velocities_m_s[node];
                self.acceleration_m_s2 = -(2.0 * velocity.x / time + way / (time * time));
                self.drags.clear();
                let air = DVec3::X * self.next_speed_m_s();
                let bodies = self.settings.bodies.iter();
                let below = bodies.map(|body| (body.node, body.drag_area_m2));
                let all = std::iter::once((node as u32, self.settings.drag_area_m2)).chain(below);
                for (node, drag_area_m2) in all.filter(|(_, area)| *area > 0.0) {
                    let speed = (air - cloth.velocities_m_s[node as usize]).length();
                    self.drags.push(NodalDrag {
                        node,
                        coefficient_kg_s: 0.5 * density_kg_m3 * drag_area_m2 * speed,
                        air_velocity_m_s: air,
                    });
                }
            }
            (
                Carrier::RigidBody {
                    number,
                    virtual_mass_kg,
                },
                _,
                Some(coupled),
            ) => {
                let force = coupled
                    .body_loads(0.0)
                    .get(number)
                    .map_or(0.0, |load| load.force[0]);
                let Settings {
                    mass_kg,
                    gravity_m_s2,
                    ..
                } = self.settings;
                let pull = mass_kg * gravity_m_s2 - force * coupled.units().force_n()
                    + virtual_mass_kg * self.acceleration_m_s2;
                self.acceleration_m_s2 = pull / (mass_kg + virtual_mass_kg);
            }
            _ => {}
        }
    }

    /// Drag of the payload and of what hangs below it in the step.
    pub(super) fn drags(&self) -> &[NodalDrag] {
        &self.drags
    }

    /// The step is done.
    pub(super) fn end_step(&mut self) {
        let next = self.next_speed_m_s();
        self.fallen_m += 0.5 * (self.speed_m_s + next) * self.time_step_s;
        self.speed_m_s = next;
    }

    /// Speed of the mass and height fallen.
    pub(super) fn fall(&self, cloth: Option<&Cloth>) -> Fall {
        let (way, velocity) = match (self.settings.carrier, cloth) {
            (Carrier::Confluence { node, home_x_m }, Some(cloth)) => (
                cloth.positions_m[node as usize].x - home_x_m,
                cloth.velocities_m_s[node as usize].x,
            ),
            _ => (0.0, 0.0),
        };
        Fall {
            speed_m_s: self.speed_m_s - velocity,
            fallen_m: self.fallen_m - way,
        }
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put(
            "descent",
            &[
                self.speed_m_s,
                self.acceleration_m_s2,
                self.fallen_m,
                self.following_s,
            ],
        )
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let values: Vec<f64> = from.take_exactly("descent", 4)?;
        (self.speed_m_s, self.acceleration_m_s2) = (values[0], values[1]);
        (self.fallen_m, self.following_s) = (values[2], values[3]);
        Ok(())
    }
}
