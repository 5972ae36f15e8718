//! The checked scene: SI units, every value in its range, absent things `None`.

use std::path::Path;

use glam::DVec3;

pub use super::air::{Air, Flow};
pub use super::bare_wing::{BareProfile, BareWing};
pub use super::bodies::{MARKER_MOTION_LIMIT, RigidBody, Shape};
pub use super::body::{
    Airbag, Body, BodyKind, Canopy, Coupon, HangingCable, ImportedWing, LoadingPressure,
};
pub use super::comparison::Comparison;
pub use super::coupling::Coupling;
use super::coupling::Scheme;
pub use super::density::{LIQUID_KG_M3, SOUND_M_S};
pub use super::descent::{CarriedMass, Carrier, Descent};
pub use super::equilibrium::Equilibrium;
use super::file::File;
pub use super::friction::SurfaceFriction;
pub use super::lattice_speed::LATTICE_SPEED_LIMIT;
pub use super::mesh_examination::ExaminedMesh;
use super::mesh_examination::FromFiles;
pub use super::output::Output;
pub use super::payload_bodies::PayloadBody;
use super::problem::Problem;
pub use super::solver::Solver;
pub use super::supports::Support;
pub use super::time::{AdaptiveStep, Time};
use super::values::{absent, vector};
use super::wing::Wing;
use super::{
    air, bare_wing, bodies, comparison, coupling, descent, equilibrium, friction, output,
    refinement, shift, solver, steady, structure, supports, time, unused, usual, usual_box,
};
pub use crate::cloth::openings::{Opening, OpeningKind};
use crate::geometry::plate::Plate;

/// Standard acceleration of gravity [m/s²].
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// Everything that a run needs to know.
#[derive(Debug, Clone)]
pub struct Scene {
    /// One line for reports and pictures.
    pub title: String,
    /// A wing by itself; then there is nothing to simulate.
    pub bare_wing: Option<BareWing>,
    /// The air.
    pub air: Option<Air>,
    /// Fabric and cables, with what is known of their kind.
    pub body: Option<Body>,
    /// What the meshes of others in the case are made of.
    pub meshes: Vec<ExaminedMesh>,
    /// Rigid bodies in the air, by name.
    pub rigid_bodies: Vec<RigidBody>,
    /// Held nodes that are moved.
    pub supports: Vec<Support>,
    /// Coupling of the air with fabric and bodies; present if there is something to couple.
    pub coupling: Option<Coupling>,
    /// How the air passes along them; present with the coupling.
    pub friction: Option<SurfaceFriction>,
    /// Gravity [m/s²].
    pub gravity_m_s2: Option<DVec3>,
    /// What falls, and the box of the air with it; absent: the box stands.
    pub descent: Option<Descent>,
    /// What a canopy in a wind tunnel would carry.
    pub carried: Option<CarriedMass>,
    /// Solver of the fabric.
    pub solver: Solver,
    /// Simulated time; absent: equilibrium only.
    pub time: Option<Time>,
    /// Static equilibrium.
    pub equilibrium: Option<Equilibrium>,
    /// Relative half width of the 95 % interval of the mean drag at which the run may stop.
    pub steady_drag_confidence: Option<f64>,
    /// What to write.
    pub output: Output,
    /// Values of others that results are set beside.
    pub comparisons: Vec<Comparison>,
}

impl Scene {
    /// True if a rigid body passes through a face of the box of air.
    #[must_use]
    pub fn passes_through_a_face(&self) -> bool {
        self.rigid_bodies.iter().any(|body| !body.faces.is_empty())
    }

    /// True where the fabric is solved in steps. Fabric that is held everywhere is not, at cut links: there the air needs nothing but its velocity. Where fabric touches fabric is
    /// looked for in solves.
    #[must_use]
    pub fn fabric_is_solved(&self) -> bool {
        let Some(body) = &self.body else {
            return false;
        };
        let structure = &body.structure;
        let links = (self.coupling).is_some_and(|coupling| coupling.scheme == Scheme::Links);
        let is_pulled = (self.wing()).is_some_and(|wing| !wing.pulls.is_empty());
        !links
            || structure.held.iter().any(|held| !held)
            || structure.contact.is_some()
            || !self.supports.is_empty()
            || is_pulled
    }

    /// The canopy, if the structure is one.
    #[must_use]
    pub fn canopy(&self) -> Option<&Canopy> {
        self.body.as_ref().and_then(Body::canopy)
    }

    /// The plate of fabric, if the structure is one.
    #[must_use]
    pub fn plate(&self) -> Option<&Plate> {
        self.body.as_ref().and_then(Body::plate)
    }

    /// The wing, if the structure is one.
    #[must_use]
    pub fn wing(&self) -> Option<&Wing> {
        self.body.as_ref().and_then(Body::wing)
    }

    /// The wing of another program, if the structure is one.
    #[must_use]
    pub fn imported_wing(&self) -> Option<&ImportedWing> {
        self.body.as_ref().and_then(Body::imported_wing)
    }
}

/// Checks a case.
pub fn check(file: &File, folder: &Path) -> Result<Scene, Problem> {
    if file.version != 1 {
        return Err(Problem::new(
            "version",
            format!("version = {} is not known", file.version),
            "this program reads version 1",
        ));
    }
    let gravity_m_s2 = file
        .gravity
        .as_ref()
        .map(|g| vector("gravity.acceleration_m_s2", g.acceleration_m_s2))
        .transpose()?;
    unused::refuse(file)?;
    let bare_wing = bare_wing::check(file, folder)?;
    let file = &*usual_box::complete(file);
    let mut files = FromFiles::new(folder);
    let mut body = structure::check(file, &mut files, gravity_m_s2)?;
    let mut air = file
        .air
        .as_ref()
        .map(|air| air::check_air(file, air, body.as_ref()))
        .transpose()?;
    if air.is_none() && body.is_none() && file.bodies.is_empty() && bare_wing.is_none() {
        return Err(Problem::new(
            "version",
            "the case holds neither air nor a structure: there is nothing to simulate",
            "add an [air] table, a [structure] table, or both",
        ));
    }
    let shift_m = shift::check(file, air.as_ref())?;
    if let Some(body) = &mut body {
        shift::move_structure(shift_m, body);
    }
    let file = &shift::with_moved_bodies(file, shift_m);
    let solver = solver::check(file)?;
    let time = time::check(file, air.as_ref())?;
    let supports = supports::check(file, body.as_ref(), time.as_ref(), &files)?;
    let rigid_bodies = bodies::check(file, &mut files, air.as_ref(), time.as_ref())?;
    if let Some(air) = &mut air {
        refinement::check(file, air, body.as_ref(), &rigid_bodies, time.as_ref())?;
    }
    let coupling = coupling::check(file, air.as_ref(), body.as_mut())?;
    let friction = friction::check(file, (air.as_ref(), body.as_ref()), coupling.as_ref())?;
    let carried = descent::carried(file, body.as_ref())?;
    let descent = descent::check(
        file,
        air.as_ref(),
        body.as_mut(),
        &rigid_bodies,
        gravity_m_s2,
        carried.is_some(),
    )?;
    let equilibrium = equilibrium::check(file)?;
    if time.is_none() && equilibrium.is_none() && bare_wing.is_none() {
        return Err(absent(
            "time",
            "a run needs [time], or [equilibrium] for a structure without air",
        ));
    }
    let end_s = time.map_or(1.0, |t| t.end_s);
    let output = output::check(file, end_s)?;
    let steady_drag_confidence = steady::check(
        file,
        air.as_ref(),
        body.as_ref(),
        &rigid_bodies,
        descent.is_some(),
    )?;
    let title = usual::or("title", file.title.clone(), "untitled".to_owned());
    Ok(Scene {
        title,
        bare_wing,
        air,
        body,
        meshes: files.meshes,
        rigid_bodies,
        supports,
        coupling,
        friction,
        gravity_m_s2,
        descent,
        carried,
        solver,
        time,
        equilibrium,
        steady_drag_confidence,
        output,
        comparisons: comparison::check(file)?,
    })
}
