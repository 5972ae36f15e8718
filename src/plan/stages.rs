//! The order of a step: the only place that knows it.

use super::{Placement, steps_take_multigrid, structure_every};
use crate::case::Scene;
use crate::case::coupling::{Friction, NarrowOpenings, Scheme};
use crate::case::scene::Air;

/// A stage of a step. Its name is the same in the plan, in the engine's file and in reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Eddy viscosity from velocity gradients, for the steps until its next turn.
    EddyViscosity,
    /// Collide and stream all populations, under the body force of the last coupling.
    CollideStream,
    /// Steps of the lattices around that of the structure, where they are due, and what passes between them and their boxes.
    CoarserLevels,
    /// Links of the lattice that surfaces cut.
    FindLinks,
    /// What left along cut links.
    ReadLinks,
    /// Transfer: marker positions from host to device.
    SendMarkers,
    /// Air velocity u* at the markers.
    Interpolate,
    /// All cells of a device that the structure does not touch, a step ahead, while the host works on the structure.
    CollideAhead,
    /// Transfer: what left along cut links from device to host.
    FetchLinks,
    /// Transfer: u* and strengths from device to host.
    FetchAirVelocities,
    /// Transfer: node state, loads and reactions of the air from host to device.
    SendNodes,
    /// Implicit step of fabric and cables with the reaction of the air inside.
    SolveCloth,
    /// Transfer: node positions from device to host; with them u*, strengths and forces at markers, where the device forms reactions itself.
    FetchNodes,
    /// What comes back along cut links, with the velocity that the surfaces now have.
    Bounce,
    /// Transfer: forces on walls along whose cut links a device answers by itself, from device to host.
    FetchWallForces,
    /// Transfer: marker forces from host to device.
    SendMarkerForces,
    /// Exact opposite of that reaction, as a body force near the sheet.
    Spread,
    /// Further passes of multi-direct forcing: what slip is left is forced again.
    RepeatForcing,
    /// Transfer: marker forces after the last pass from device to host.
    FetchMarkerForces,
    /// Impulses of the three force routes; samples at their own cadence.
    Measure,
    /// Files and pictures, at their own cadence.
    Output,
}

impl Stage {
    /// All stages, in the order of a step; where the device forms reactions itself, `spread` comes before `fetch_nodes`.
    pub const ALL: [Self; 21] = [
        Self::EddyViscosity,
        Self::CollideStream,
        Self::CoarserLevels,
        Self::FindLinks,
        Self::ReadLinks,
        Self::SendMarkers,
        Self::Interpolate,
        Self::CollideAhead,
        Self::FetchLinks,
        Self::FetchAirVelocities,
        Self::SendNodes,
        Self::SolveCloth,
        Self::FetchNodes,
        Self::Bounce,
        Self::FetchWallForces,
        Self::SendMarkerForces,
        Self::Spread,
        Self::RepeatForcing,
        Self::FetchMarkerForces,
        Self::Measure,
        Self::Output,
    ];

    /// Name in files, labels and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::EddyViscosity => "eddy_viscosity",
            Self::CollideStream => "collide_stream",
            Self::CoarserLevels => "coarser_levels",
            Self::FindLinks => "find_links",
            Self::ReadLinks => "read_links",
            Self::Bounce => "bounce",
            Self::FetchWallForces => "fetch_wall_forces",
            Self::SendMarkers => "send_markers",
            Self::Interpolate => "interpolate",
            Self::CollideAhead => "collide_ahead",
            Self::FetchLinks => "fetch_links",
            Self::FetchAirVelocities => "fetch_air_velocities",
            Self::SendNodes => "send_nodes",
            Self::SolveCloth => "solve_cloth",
            Self::FetchNodes => "fetch_nodes",
            Self::SendMarkerForces => "send_marker_forces",
            Self::Spread => "spread",
            Self::RepeatForcing => "repeat_forcing",
            Self::FetchMarkerForces => "fetch_marker_forces",
            Self::Measure => "measure",
            Self::Output => "output",
        }
    }

    /// What it turns into what.
    #[must_use]
    pub const fn flow(self) -> &'static str {
        match self {
            Self::EddyViscosity => "populations -> eddy part of the relaxation times",
            Self::CollideStream => "populations, body force -> populations",
            Self::CoarserLevels => {
                "populations of coarser cells; those of both where boxes end -> the same"
            }
            Self::FindLinks => "node positions -> cut links, distances of the cuts",
            Self::ReadLinks => "populations, cut links -> what left along them",
            Self::Bounce => "what left, node velocities -> populations that come back, forces",
            Self::FetchWallForces => "forces on walls, device -> host",
            Self::SendMarkers => "marker positions, host -> device, sorted by cell",
            Self::CollideAhead => "populations away from the structure -> those of the next step",
            Self::FetchLinks => "what left along cut links, device -> host",
            Self::FetchAirVelocities => "air velocity at markers, device -> host",
            Self::SendNodes => "nodes, loads, reactions of the air, host -> device",
            Self::FetchNodes => {
                "node positions and what was not fetched at markers, device -> host"
            }
            Self::SendMarkerForces => "marker forces, host -> device",
            Self::Interpolate => "populations, marker positions -> air velocity at markers",
            Self::SolveCloth => {
                "loads, air velocity at markers if any -> node positions and velocities"
            }
            Self::Spread => "marker velocities, air velocity -> body force near the sheet",
            Self::RepeatForcing => {
                "body force, air velocity at markers -> marker forces, body force (every further pass)"
            }
            Self::FetchMarkerForces => "marker forces, device -> host",
            Self::Measure => "impulses, shape, tensions -> history",
            Self::Output => "frame -> files, pictures",
        }
    }
}

/// Most steps that a device makes by itself before it tells the host of them.
pub const STEPS_OF_A_SERIES: u64 = 64;

/// A stage and how often it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedStage {
    /// The stage.
    pub stage: Stage,
    /// Once in so many steps; `solve_cloth` and its transfers more often where the fabric moves fast.
    pub every: u32,
}

/// The stages of one step of `scene`, in order. What the scene lacks is not in the list, and nothing is moved that is where it is
/// needed.
#[must_use]
pub fn stages(scene: &Scene, placement: &Placement) -> Vec<PlannedStage> {
    let mut stages = Vec::new();
    let mut add = |stage, every| stages.push(PlannedStage { stage, every });
    let scheme = scene.coupling.map(|coupling| coupling.scheme);
    let (kernel, links) = (
        scheme == Some(Scheme::Kernel),
        scheme == Some(Scheme::Links),
    );
    let air_on_device = kernel && placement.air_on_device();
    if scene.time.is_some() {
        if let Some(air) = &scene.air {
            if let Some(eddy_viscosity) = air.eddy_viscosity
                && eddy_viscosity.gradient_model().is_some()
            {
                // In a box both lattices must stand at one time: in between its shell is spoilt, and so would be gradients next to it.
                let every = match air.boxes.is_empty() {
                    true => eddy_viscosity.update_every,
                    false => eddy_viscosity.update_every.next_multiple_of(2),
                };
                add(Stage::EddyViscosity, every);
            }
            add(Stage::CollideStream, 1);
            if air.depth() > 0 {
                add(Stage::CoarserLevels, 2);
            }
        }
        if links {
            add(Stage::FindLinks, 1);
            add(Stage::ReadLinks, 1);
        }
        if air_on_device {
            add(Stage::SendMarkers, 1);
        }
        if kernel {
            add(Stage::Interpolate, 1);
        }
        if collides_ahead(scene, placement) {
            add(Stage::CollideAhead, 1);
        }
        let answers = answers_on_device(scene, placement);
        if links && placement.air_on_device() && !answers {
            add(Stage::FetchLinks, 1);
        }
        let reacts = reacts_on_device(scene, placement);
        if air_on_device && !reacts {
            add(Stage::FetchAirVelocities, 1);
        }
        if scene.fabric_is_solved() {
            let every = structure_every(scene);
            if placement.cloth_on_device() {
                add(Stage::SendNodes, every);
            }
            add(Stage::SolveCloth, every);
            if reacts {
                add(Stage::Spread, 1);
            }
            if placement.cloth_on_device() {
                add(Stage::FetchNodes, every);
            }
        }
        if air_on_device && !reacts {
            add(Stage::SendMarkerForces, 1);
        }
        if links {
            add(Stage::Bounce, 1);
        }
        if answers {
            add(Stage::FetchWallForces, 1);
        }
        if kernel && !reacts {
            add(Stage::Spread, 1);
        }
        if scene.coupling.is_some_and(|c| c.passes > 1) {
            add(Stage::RepeatForcing, 1);
            if air_on_device {
                add(Stage::FetchMarkerForces, 1);
            }
        }
    }
    add(Stage::Measure, 1);
    add(Stage::Output, 1);
    stages
}

/// True where a device that has air and fabric forms the reactions at markers itself, and their forces on the air. All that happens at a marker is the plain reaction then: one
/// pass, u* of the step itself, fabric alone that air neither passes nor slides along. The device decides in the solve, too.
fn reacts_on_device(scene: &Scene, placement: &Placement) -> bool {
    let (Some(body), Some(coupling)) = (&scene.body, &scene.coupling) else {
        return false;
    };
    let slides =
        (scene.friction.as_ref()).is_some_and(|friction| friction.fabric.contains(&Friction::None));
    coupling.scheme == Scheme::Kernel
        && placement.air_on_device()
        && placement.cloth_on_device()
        && coupling.passes == 1
        && coupling.averaging_steps == 1
        && structure_every(scene) == 1
        && scene.rigid_bodies.is_empty()
        && body.structure.permeability.is_none()
        && !slides
        && !steps_take_multigrid(scene)
}

/// Longest edge of triangles whose links a device finds by itself [cells]. A thread goes over all lines that may pass one, and places on it are in single precision.
const LONGEST_EDGE: f64 = 16.0;

/// True where the triangles of all surfaces are so small.
fn are_small(scene: &Scene) -> bool {
    let Some(air) = &scene.air else {
        return false;
    };
    let longest_m2 = (LONGEST_EDGE * air.units.cell_size_m).powi(2);
    let fabric = scene.body.iter().flat_map(|body| &body.structure.triangles);
    let mut of_fabric = fabric.flat_map(|triangle| triangle.rest_squares_m2);
    let mut of_bodies = scene.rigid_bodies.iter().flat_map(|body| {
        let corners = body.surface.triangles.iter();
        corners.flat_map(|nodes| {
            let [a, b, c] = body.surface.corners(*nodes);
            [(a, b), (b, c), (c, a)].map(|(from, to)| from.distance_squared(to))
        })
    });
    of_fabric.all(|square| square <= longest_m2) && of_bodies.all(|square| square <= longest_m2)
}

/// True where a device answers along cut links by itself: no fabric is solved, air neither passes a surface nor meets it in layers that are modelled. Where bodies move, it finds the links,
/// too: air sticks to all of them, and they stay away from faces that they could pass through, and from sides that repeat, and their triangles are small.
fn answers_on_device(scene: &Scene, placement: &Placement) -> bool {
    let links = (scene.coupling).is_some_and(|coupling| {
        coupling.scheme == Scheme::Links && coupling.narrow_openings != Some(NarrowOpenings::Law)
    });
    let has = |wanted| (scene.friction.as_ref()).is_some_and(|friction| friction.has(wanted));
    let moves = scene.rigid_bodies.iter().any(|body| body.motion.moves());
    let finds = !has(Friction::None)
        && !scene.passes_through_a_face()
        && !(scene.air.as_ref()).is_some_and(Air::repeats_somewhere)
        && are_small(scene);
    links
        && placement.air_on_device()
        && !scene.fabric_is_solved()
        && (scene.body.as_ref()).is_none_or(|body| body.structure.permeability.is_none())
        && scene.descent.is_none()
        && !has(Friction::Model)
        && scene
            .rigid_bodies
            .iter()
            .all(|body| body.permeability.is_none())
        && (!moves || finds)
}

/// True where a device that has air and fabric may find the links that the fabric cuts, and answer along them, by itself: fabric alone, to which the air sticks and which lets nothing through, away
/// from sides that repeat.
pub(super) fn cuts_on_device(scene: &Scene, placement: &Placement) -> bool {
    let (Some(body), Some(coupling), Some(air)) = (&scene.body, &scene.coupling, &scene.air) else {
        return false;
    };
    let slides = (scene.friction.as_ref())
        .is_some_and(|friction| friction.has(Friction::None) || friction.has(Friction::Model));
    coupling.scheme == Scheme::Links
        && placement.air_on_device()
        && placement.cloth_on_device()
        && scene.fabric_is_solved()
        && structure_every(scene) == 1
        && scene.rigid_bodies.is_empty()
        && body.structure.permeability.is_none()
        && coupling.narrow_openings != Some(NarrowOpenings::Law)
        && !slides
        && !air.repeats_somewhere()
        && are_small(scene)
        && !steps_take_multigrid(scene)
}

/// True where a device may begin the next step of cells that the structure does not touch. The host must have something to do meanwhile, and nothing that the
/// structure does may act on all cells: no fall, no eddy viscosity from the gradients of all.
fn collides_ahead(scene: &Scene, placement: &Placement) -> bool {
    let (Some(air), Some(coupling)) = (&scene.air, &scene.coupling) else {
        return false;
    };
    let host_works = coupling.scheme == Scheme::Links || !placement.cloth_on_device();
    let of_gradients = air
        .eddy_viscosity
        .is_some_and(|eddy_viscosity| eddy_viscosity.gradient_model().is_some());
    placement.air_on_device()
        && !answers_on_device(scene, placement)
        && host_works
        && coupling.passes == 1
        && scene.descent.is_none()
        && !of_gradients
        && !scene.passes_through_a_face()
}
