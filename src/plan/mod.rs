//! What a run will do, as data: stages, sizes, and what it leaves out. `ripstop check` prints it, [`crate::simulation`] executes it.

mod cadence;
pub mod capabilities;
mod descent;
mod disk;
mod duration;
mod estimate;
mod forecast;
mod friction;
mod initial_hessian;
mod levels;
mod meshes;
mod openings;
mod permeability;
pub mod phases;
mod placement;
mod report;
mod skips;
pub mod stages;
mod warnings;
mod wing;
mod wing_warnings;

pub use crate::lattice::Storage;
pub use cadence::{MARKER_MOTION_LIMIT, structure_every};
pub use disk::Disk;
pub use estimate::{MemoryRefusal, Sizes, free_memory};
pub use forecast::{Evaluations, steps_are_left_to_host};
pub use initial_hessian::{multigrid_from_s, steps_take_multigrid};
pub use meshes::report as mesh_report;
pub use phases::{Phase, phases};
pub use placement::{AirPlacement, ClothPlacement, Placement, Precision};
pub use skips::Skip;
pub use stages::{PlannedStage, STEPS_OF_A_SERIES, Stage};

use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Flow};
use crate::immersed::markers;
use crate::solve::InitialHessian;

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
            step_hessian: initial_hessian::of_steps(scene),
            evaluations: scene
                .fabric_is_solved()
                .then(|| forecast::of(scene, &placement))
                .flatten(),
            evaluation_limit: scene.solver.evaluation_limit,
            skips: skips::skips(scene)
                .into_iter()
                .chain(initial_hessian::skipped(scene).filter(|_| scene.fabric_is_solved()))
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

    /// True if a device that has air and fabric forms the reactions at markers itself: nothing that it interpolates has to be fetched before the fabric is solved.
    #[must_use]
    pub fn reacts_on_device(&self) -> bool {
        let has = |stage| self.every(stage).is_some();
        has(Stage::SendMarkers) && !has(Stage::FetchAirVelocities)
    }

    /// True if a device answers along cut links by itself, of walls that nobody solves for.
    #[must_use]
    pub fn answers_on_device(&self) -> bool {
        self.every(Stage::FetchWallForces).is_some()
    }

    /// True if a device may make series of steps of a scene by itself: nothing but the structure's state changes from step to step. Fabric must be small enough besides.
    #[must_use]
    pub fn may_make_series(&self, scene: &Scene) -> bool {
        let alone = scene.descent.is_none()
            && scene.supports.is_empty()
            && scene.wing().is_none_or(|wing| wing.pulls.is_empty());
        let walls = self.answers_on_device() && !scene.passes_through_a_face();
        walls
            || (self.reacts_on_device() || stages::cuts_on_device(scene, &self.placement)) && alone
    }

    /// Steps while the wind rises, and from release to the end.
    fn step_counts(scene: &Scene) -> (u64, u64) {
        let start_s = match scene.air.as_ref().map(|air| &air.flow) {
            Some(Flow::WindTunnel { start_time_s, .. }) => *start_time_s,
            _ => 0.0,
        };
        let step_s = scene.time.map_or(f64::INFINITY, |time| time.step_s);
        let steps = |time_s: f64| whole_steps(scene, (time_s / step_s).ceil() as u64);
        (
            steps(start_s),
            steps(scene.time.map_or(0.0, |time| time.end_s)),
        )
    }
}

/// At least so many steps that all lattices of the air make whole ones.
#[must_use]
pub fn whole_steps(scene: &Scene, steps: u64) -> u64 {
    let outer = scene.air.as_ref().map_or(1, Air::steps_per_outer);
    steps.div_ceil(outer).saturating_mul(outer)
}

/// Steps in an interval of time, at least one, and whole ones of all lattices of the air.
#[must_use]
pub fn steps_per(scene: &Scene, interval_s: f64) -> u64 {
    let step_s = scene.time.map_or(f64::INFINITY, |t| t.step_s);
    let outer = scene.air.as_ref().map_or(1, Air::steps_per_outer);
    let count = (interval_s / (outer as f64 * step_s)).round() as u64;
    count.max(1).saturating_mul(outer)
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
