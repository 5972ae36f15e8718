//! What a run will do, as data: stages, sizes, and what it leaves out. `ripstop check` prints it, [`crate::simulation`] executes it.

mod cadence;
pub mod capabilities;
mod descent;
mod disk;
mod estimate;
mod forecast;
mod initial_hessian;
mod meshes;
mod openings;
mod permeability;
pub mod phases;
mod placement;
mod report;
pub mod stages;
mod warnings;
mod wing;

pub use crate::lattice::Storage;
pub use cadence::{MARKER_MOTION_LIMIT, structure_every};
pub use disk::Disk;
pub use estimate::{MemoryRefusal, Sizes, free_memory};
pub use forecast::Evaluations;
pub use initial_hessian::multigrid_from_s;
pub use meshes::report as mesh_report;
pub use phases::{Phase, phases};
pub use placement::{AirPlacement, ClothPlacement, Placement};
pub use stages::{PlannedStage, Stage};

use crate::case::Scene;
use crate::case::scene::{Air, Body, BodyKind, Flow};
use crate::immersed::markers;
use crate::solve::InitialHessian;

/// Floating-point type of the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Precision {
    /// Double precision: the reference.
    F64,
    /// Single precision: fast, the default.
    F32,
}

impl Precision {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }

    /// Bytes of one number.
    #[must_use]
    pub const fn bytes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
        }
    }
}

/// Something that the scene does not need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skip {
    /// What is left out.
    pub what: &'static str,
    /// Why.
    pub why: String,
}

/// A run, worked out before it starts.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The stages of one step, in order.
    pub stages: Vec<PlannedStage>,
    /// Steps before release (the wind rises, the sheet is held).
    pub start_steps: u64,
    /// Steps from release to the end.
    pub steps: u64,
    /// Who computes what.
    pub placement: Placement,
    /// Sizes and bytes.
    pub sizes: Sizes,
    /// What the implicit steps of the fabric start from.
    pub step_hessian: InitialHessian,
    /// What a solve of a step is expected to take; `None` without steps of the fabric.
    pub evaluations: Option<Evaluations>,
    /// Evaluations that a solve may take.
    pub evaluation_limit: usize,
    /// What is left out.
    pub skips: Vec<Skip>,
}

impl Plan {
    /// Works out the plan of a scene.
    #[must_use]
    pub fn new(scene: &Scene, placement: impl Into<Placement>) -> Self {
        let placement: Placement = placement.into();
        let (start_steps, steps) = Self::step_counts(scene);
        let sizes = Sizes::new(scene, &placement);
        Self {
            stages: stages::stages(scene, &placement),
            start_steps,
            steps,
            sizes,
            step_hessian: initial_hessian::of_steps(scene, &placement),
            evaluations: forecast::of(scene),
            evaluation_limit: scene.solver.evaluation_limit,
            skips: skips(scene)
                .into_iter()
                .chain(initial_hessian::skipped(scene, &placement))
                .collect(),
            placement,
        }
    }

    /// How often a stage runs, once in so many steps; `None` where it is not in the plan. Engines take it from here.
    #[must_use]
    pub fn every(&self, stage: Stage) -> Option<u32> {
        let planned = self.stages.iter().find(|planned| planned.stage == stage);
        planned.map(|planned| planned.every)
    }

    /// Steps while the wind rises, and from release to the end.
    fn step_counts(scene: &Scene) -> (u64, u64) {
        match (scene.time, scene.air.map(|air| air.flow)) {
            (Some(time), Some(Flow::WindTunnel { start_time_s, .. })) => (
                (start_time_s / time.step_s).ceil() as u64,
                (time.end_s / time.step_s).ceil() as u64,
            ),
            (Some(time), _) => (0, (time.end_s / time.step_s).ceil() as u64),
            (None, _) => (0, 0),
        }
    }
}

/// Markers of the fabric; empty unless it is coupled with air.
#[must_use]
pub fn place_markers(scene: &Scene) -> Vec<markers::Marker> {
    let (Some(air), Some(body), Some(coupling)) = (&scene.air, &scene.body, &scene.coupling) else {
        return Vec::new();
    };
    let spacing_m = coupling.marker_spacing_m(air);
    match &body.kind {
        BodyKind::Plate(plate) => {
            plate.place_markers(spacing_m, coupling.rim_inset_cells * air.units.cell_size_m)
        }
        _ => {
            let insets = coupling.rim_insets(&body.structure, air);
            markers::place(body.structure.extents(&insets), spacing_m)
        }
    }
}

fn skips(scene: &Scene) -> Vec<Skip> {
    let mut skips = Vec::new();
    let mut skip = |what: &'static str, why: String| skips.push(Skip { what, why });
    match &scene.air {
        None => {
            skip(
                "air (populations, boundaries, body force)",
                "the case has no [air]".into(),
            );
            skip(
                "markers, interpolation, spreading",
                "there is no air to couple with".into(),
            );
        }
        Some(air) => skip_air(scene, air, &mut skip),
    }
    match &scene.body {
        None => skip(
            "structure (nodes, elements, solver)",
            "the case has no [structure]".into(),
        ),
        Some(body) => {
            let structure = &body.structure;
            if structure.membrane.is_none() || structure.triangles.is_empty() {
                skip(
                    "membrane elements",
                    "no fabric modelled by membranes".into(),
                );
            }
            if structure.springs.is_empty() {
                skip(
                    "spring network and bending",
                    "no sheet with model = \"network\"".into(),
                );
            }
            if structure.cables.is_empty() {
                skip("cables", "the structure has no lines and no belts".into());
            }
            if structure.guides.is_empty() {
                skip("guides", "no apex_guide_n_m, no pitch_guide_n_m".into());
            }
            if structure.contact.is_none() && !structure.triangles.is_empty() {
                skip(
                    "contact of fabric with itself",
                    "the case has no [contact]: fabric passes through itself".into(),
                );
            }
            if scene.gravity_m_s2.is_none() {
                skip("gravity", "the case has no [gravity]".into());
            }
            if let BodyKind::Canopy(_) = &body.kind
                && scene.steady_drag_confidence.is_none()
            {
                skip(
                    "steady-state detection",
                    "the case has no [steady]: the run goes to time.end_s".into(),
                );
            }
            if scene.supports.is_empty() && scene.air.is_none() {
                skip("motion of supports", "the case has no [supports]".into());
            }
            if let (Some(time), None) = (scene.time, &scene.air)
                && time.adaptive.is_none()
            {
                skip(
                    "division of steps by accuracy",
                    format!("no [time.adaptive]: every step takes {:e} s", time.step_s),
                );
            }
            if scene.time.is_none() {
                skip(
                    "motion (inertia, time steps)",
                    "the case has no [time]: only the equilibrium is sought".into(),
                );
            }
        }
    }
    skips
}

fn skip_air(scene: &Scene, air: &Air, skip: &mut impl FnMut(&'static str, String)) {
    if scene.coupling.is_none() {
        skip(
            "markers, interpolation, spreading, body force",
            "the case has neither [structure] nor [bodies]".into(),
        );
    } else if scene.rigid_bodies.is_empty() {
        skip("rigid bodies", "the case has no [bodies]".into());
    } else if scene.coupling.is_some_and(|c| c.passes == 1) {
        skip("further passes of forcing", "no coupling.passes".into());
    }
    let fabric = scene.body.as_ref();
    let permeable = fabric.is_some_and(|body| body.structure.permeability.is_some())
        || scene.rigid_bodies.iter().any(|b| b.permeability.is_some());
    if scene.coupling.is_some() && !permeable {
        skip(
            "air through surfaces",
            "no fabric.permeability, no bodies.NAME.permeability".into(),
        );
    }
    if scene.coupling.is_some() && scene.descent.is_none() {
        skip("a fall (accelerated box)", "no [air.descent]".into());
    }
    let has_line_drag = fabric.is_some_and(|body| body.structure.line_drag.is_some());
    if let Some(BodyKind::Canopy(_)) = fabric.map(|body| &body.kind)
        && !has_line_drag
    {
        let why = if scene.body.as_ref().is_some_and(Body::is_from_mesh) {
            "lines of a table have none"
        } else {
            "no lines.drag_coefficient"
        };
        skip("drag of lines", why.into());
    }
    match air.flow {
        Flow::TaylorGreen { .. } => skip("inlet, outlet, walls", "the box is periodic".into()),
        Flow::WindTunnel {
            sponge_length_m: None,
            ..
        } => {
            skip("outlet sponge", "no air.wind_tunnel.sponge_length_m".into());
        }
        Flow::WindTunnel { .. } => {}
    }
    match air.eddy_viscosity {
        None => skip("eddy viscosity", "no resolution.eddy_viscosity".into()),
        Some(eddy_viscosity) if eddy_viscosity.gradient_model().is_none() => skip(
            "stage eddy_viscosity, velocity gradients",
            "Smagorinsky's model takes the stress of each cell".into(),
        ),
        Some(_) => {}
    }
    if scene.coupling.is_some() {
        skip(
            "body force away from markers",
            "it is read only near the cells under a marker's kernel".into(),
        );
    }
}
