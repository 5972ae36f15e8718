//! Checks of `[air.descent]`, `[payload]` and bodies in free fall: one mass falls, and the box with it.

use glam::DVec3;

use super::air::Air;
use super::bodies::RigidBody;
use super::body::{Body, BodyKind};
use super::file::{File, Payload};
use super::payload_bodies::{self, PayloadBody};
use super::problem::Problem;
use super::usual;
use super::values::positive;

/// A mass that falls along −x, followed by the box of the air.
#[derive(Debug, Clone, PartialEq)]
pub struct Descent {
    /// Its mass [kg].
    pub mass_kg: f64,
    /// Drag area of the mass itself [m²].
    pub drag_area_m2: f64,
    /// Gravity along −x [m/s²].
    pub gravity_m_s2: f64,
    /// What carries the mass.
    pub carrier: Carrier,
    /// What hangs below it.
    pub bodies: Vec<PayloadBody>,
}

/// What carries a falling mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Carrier {
    /// The node where a canopy's lines meet, or the lower end of its riser.
    Confluence {
        /// The node.
        node: u32,
        /// Where it is at release [m].
        home_x_m: f64,
    },
    /// A rigid body without volume, which stays in its place in the box.
    RigidBody {
        /// Its number.
        number: usize,
        /// Virtual mass of its equation of motion [kg].
        virtual_mass_kg: f64,
    },
}

/// A mass that a canopy in a wind tunnel would carry. It does not act there: the run tells how fast the two would descend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedMass {
    /// Its mass [kg].
    pub mass_kg: f64,
    /// Drag area of the mass itself [m²].
    pub drag_area_m2: f64,
}

/// The payload of a canopy in a wind tunnel; `None` where there is none, or where it falls.
pub(super) fn carried(file: &File, body: Option<&Body>) -> Result<Option<CarriedMass>, Problem> {
    let in_tunnel = file
        .air
        .as_ref()
        .is_some_and(|air| air.wind_tunnel.is_some());
    let has_canopy = body.is_some_and(|body| body.canopy().is_some());
    let Some(payload) = file.payload.as_ref().filter(|_| in_tunnel && has_canopy) else {
        return Ok(None);
    };
    if let Some(name) = payload.bodies.keys().next() {
        return Err(Problem::new(
            format!("payload.bodies.{name}"),
            format!(
                "[payload.bodies.{name}] has no effect: bodies swing below a payload only where it falls"
            ),
            "remove it, or replace [air.wind_tunnel] by [air.descent]",
        ));
    }
    let (mass_kg, drag_area_m2) = mass_and_drag_area(payload)?;
    Ok(Some(CarriedMass {
        mass_kg,
        drag_area_m2,
    }))
}

fn mass_and_drag_area(payload: &Payload) -> Result<(f64, f64), Problem> {
    let mass_kg = positive("payload.mass_kg", payload.mass_kg)?;
    let drag_area_m2 = match payload.drag_area_m2 {
        None => usual::noted("payload.drag_area_m2", 0.0),
        Some(area) => positive("payload.drag_area_m2", area)?,
    };
    Ok((mass_kg, drag_area_m2))
}

impl Descent {
    /// Mass of the payload and of all that hangs below it, without tethers [kg].
    #[must_use]
    pub fn all_masses_kg(&self) -> f64 {
        self.mass_kg + self.bodies.iter().map(|body| body.mass_kg).sum::<f64>()
    }
}

/// What falls, and what it needs; nothing where a payload is carried in a wind tunnel; frees the confluence of a canopy that carries a payload.
pub(super) fn check(
    file: &File,
    air: Option<&Air>,
    body: Option<&mut Body>,
    rigid_bodies: &[RigidBody],
    gravity_m_s2: Option<DVec3>,
    is_carried: bool,
) -> Result<Option<Descent>, Problem> {
    let falling: Vec<(usize, &String, f64)> = file
        .bodies
        .iter()
        .enumerate()
        .filter_map(|(number, (name, table))| {
            let fall = table.free_fall()?;
            Some((number, name, fall.mass_kg))
        })
        .collect();
    let has_descent = file.air.as_ref().is_some_and(|air| air.descent.is_some());
    let (Some(air), true) = (air, has_descent) else {
        let key = match (&file.payload, falling.first()) {
            (Some(_), None) if is_carried => return Ok(None),
            (Some(_), _) => "payload".to_owned(),
            (None, Some((_, name, _))) => format!("bodies.{name}.motion.free_fall"),
            (None, None) => return Ok(None),
        };
        return Err(Problem::new(
            key.as_str(),
            format!("[{key}] has no effect: it needs [air.descent]"),
            format!(
                "remove [{key}], or replace [air.wind_tunnel] by [air.descent]; a canopy in a wind tunnel may have a payload"
            ),
        ));
    };
    let every = file.coupling.as_ref().and_then(|c| c.structure_every);
    if every.is_some_and(|every| every > 1) {
        return Err(Problem::new(
            "coupling.structure_every",
            "in [air.descent] the acceleration of the box changes in every step of the air, and fabric must feel every one",
            "set coupling.structure_every = 1",
        ));
    }
    let gravity = gravity_m_s2.unwrap_or(DVec3::ZERO);
    if !(gravity.x < 0.0 && gravity.y == 0.0 && gravity.z == 0.0) {
        return Err(Problem::new(
            if gravity_m_s2.is_some() {
                "gravity.acceleration_m_s2"
            } else {
                "air.descent"
            },
            "what falls in [air.descent] falls along −x: the air comes along +x, as in a wind tunnel",
            "give [gravity] with acceleration_m_s2 = [-9.81, 0.0, 0.0]",
        ));
    }
    if let (Some(_), Some((_, name, _))) = (&file.payload, falling.first()) {
        return Err(two_masses(&format!("bodies.{name}.motion.free_fall")));
    }
    if let [_, (_, name, _), ..] = falling[..] {
        return Err(two_masses(&format!("bodies.{name}.motion.free_fall")));
    }
    if let Some(payload) = &file.payload {
        let (mass_kg, drag_area_m2) = mass_and_drag_area(payload)?;
        let Some((body, canopy)) = body.and_then(|body| match body.kind {
            BodyKind::Canopy(canopy) => Some((body, canopy)),
            _ => None,
        }) else {
            return Err(Problem::new(
                "payload",
                "[payload] hangs where the lines of a canopy meet, but the case has no canopy",
                "add [structure.flat_circular], or structure.mesh.nominal_area_m2 to a mesh, or let a body fall (bodies.NAME.motion.free_fall)",
            ));
        };
        let Some(node) = canopy.lower_end else {
            return Err(Problem::new(
                "payload",
                "[payload] hangs where all lines meet, but those of structure.mesh.lines end in several places",
                "let all lines of the table end at one place, or remove [payload] and use [air.wind_tunnel]",
            ));
        };
        body.structure.held[node] = false;
        if let Some(held) = body.structure.held.iter().position(|held| *held) {
            return Err(Problem::new(
                "structure.mesh.held_nodes",
                format!(
                    "node {} is held, so that the payload would not fall but hang on it",
                    held + 1
                ),
                "hold nothing of a canopy with a payload: held_nodes = []",
            ));
        }
        body.structure.masses_kg[node] += mass_kg;
        let bodies = payload_bodies::hang(&payload.bodies, node, &mut body.structure)?;
        return Ok(Some(Descent {
            mass_kg,
            drag_area_m2,
            gravity_m_s2: -gravity.x,
            carrier: Carrier::Confluence {
                node: node as u32,
                home_x_m: body.structure.positions_m[node].x,
            },
            bodies,
        }));
    }
    let Some((number, name, mass_kg)) = falling.first() else {
        return Err(Problem::new(
            "air.descent",
            "nothing falls in [air.descent]",
            "add [payload] to a canopy, or bodies.NAME.motion.free_fall; or use [air.wind_tunnel]",
        ));
    };
    let key = format!("bodies.{name}.motion.free_fall");
    let falls = &rigid_bodies[*number];
    if falls.volume_m3.is_some() {
        return Err(Problem::new(
            key.as_str(),
            format!("{key}: the air inside a closed body would fall with it"),
            "let an open surface fall (disk, plate, open cylinder or mesh)",
        ));
    }
    let mass_kg = positive(&format!("{key}.mass_kg"), *mass_kg)?;
    Ok(Some(Descent {
        mass_kg,
        drag_area_m2: 0.0,
        gravity_m_s2: -gravity.x,
        carrier: Carrier::RigidBody {
            number: *number,
            virtual_mass_kg: air.units.density_kg_m3 * falls.reference_area_m2.powf(1.5),
        },
        bodies: Vec::new(),
    }))
}

fn two_masses(key: &str) -> Problem {
    Problem::new(
        key,
        format!("[{key}] is a second mass that falls: the box follows only one"),
        "keep one of them",
    )
}
