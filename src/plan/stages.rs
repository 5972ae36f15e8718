//! The order of a step: the only place that knows it.

use crate::case::Scene;

/// A stage of a step. Its name is the same in the plan, in the engine's file and in reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Collide and stream all populations, under the body force of the last coupling.
    CollideStream,
    /// Air velocity u* at the markers.
    Interpolate,
    /// Implicit step of fabric and cables with the reaction of the air inside.
    SolveCloth,
    /// Exact opposite of that reaction, as a body force near the sheet.
    Spread,
    /// Impulses of the three force routes; samples at their own cadence.
    Measure,
    /// Files and pictures, at their own cadence.
    Output,
}

impl Stage {
    /// Name in files, labels and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CollideStream => "collide_stream",
            Self::Interpolate => "interpolate",
            Self::SolveCloth => "solve_cloth",
            Self::Spread => "spread",
            Self::Measure => "measure",
            Self::Output => "output",
        }
    }

    /// What it turns into what.
    #[must_use]
    pub const fn flow(self) -> &'static str {
        match self {
            Self::CollideStream => "populations, body force -> populations",
            Self::Interpolate => "populations, marker positions -> air velocity at markers",
            Self::SolveCloth => {
                "loads, air velocity at markers if any -> node positions and velocities"
            }
            Self::Spread => "marker velocities, air velocity -> body force near the sheet",
            Self::Measure => "impulses, shape, tensions -> history",
            Self::Output => "frame -> files, pictures",
        }
    }
}

/// A stage and how often it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedStage {
    /// The stage.
    pub stage: Stage,
    /// Once in so many steps.
    pub every: u32,
}

/// The stages of one step of `scene`, in order. What the scene lacks is not in the list.
#[must_use]
pub fn stages(scene: &Scene) -> Vec<PlannedStage> {
    let mut stages = Vec::new();
    let mut add = |stage, every| stages.push(PlannedStage { stage, every });
    if scene.time.is_some() {
        if scene.air.is_some() {
            add(Stage::CollideStream, 1);
        }
        if scene.coupling.is_some() {
            add(Stage::Interpolate, 1);
        }
        if scene.body.is_some() {
            add(
                Stage::SolveCloth,
                scene.coupling.map_or(1, |c| c.structure_every),
            );
        }
        if scene.coupling.is_some() {
            add(Stage::Spread, 1);
        }
    }
    add(Stage::Measure, 1);
    add(Stage::Output, 1);
    stages
}
