//! Coupling of the air with fabric and bodies: `[coupling]`, and that markers and structure fit the air.

use glam::DVec3;

use super::air::Air;
use super::body::{Body, BodyKind};
use super::file::{self, File};
use super::problem::Problem;
use super::values::{at_once, positive, readable, within};
use super::{plate, rims, usual};
use crate::cloth::Structure;
use crate::cloth::covers::{self, Cover};
use crate::cloth::openings::{Opening, OpeningKind};
use crate::cloth::rims::RimInsets;
use crate::immersed::markers::{RIM_INSET_CELLS, SPACING_CELLS, SPACING_RANGE_CELLS};

/// Smallest number of cells along any axis around a structure: room for the kernel and the momentum box.
const SMALLEST_COUPLED_AXIS_CELLS: usize = 12;

/// Usual over-relaxation of the force.
const OVER_RELAXATION: f64 = 1.6;

/// Cells across holes, and across gaps and slots, below which air passes them by a law. From there on they pass what they should within 15 % (`ripstop validate openings`).
pub const NARROW_CELLS: [f64; 2] = [2.0, 3.0];

/// Most passes of forcing.
const PASSES_LIMIT: u32 = 20;

pub use super::file::{Friction, NarrowOpenings, Scheme};

/// Coupling of air with fabric and rigid bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// How.
    pub scheme: Scheme,
    /// Over-relaxation a on a flat sheet.
    pub over_relaxation: f64,
    /// Steps of the air per step of the fabric, where the case gives them; otherwise the plan chooses.
    pub structure_every: Option<u32>,
    /// Passes of multi-direct forcing; 1 unless all is rigid.
    pub passes: u32,
    /// Largest distance of neighbouring markers [cells].
    pub marker_spacing_cells: f64,
    /// How far inside rims markers stand [cells].
    pub rim_inset_cells: f64,
    /// Steps over which a running mean of u* is taken before the fabric feels it; 1 unless schemes are compared.
    pub averaging_steps: u32,
    /// How narrow openings pass air; `None` with markers, and without fabric.
    pub narrow_openings: Option<NarrowOpenings>,
}

impl Coupling {
    /// Triangles that shut openings because air passes these by a law, where cells are so large [m]; nothing of openings that it passes through cells.
    #[must_use]
    pub fn covers(&self, structure: &Structure, cell_size_m: f64) -> Vec<Option<Vec<Cover>>> {
        let is_narrow = |opening: &Opening| {
            let cells = match opening.kind {
                OpeningKind::Vent => NARROW_CELLS[0],
                OpeningKind::Gap | OpeningKind::Slot => NARROW_CELLS[1],
                // Before an intake the pressure changes within a cell: what cells let in is nearer to finer lattices.
                OpeningKind::Intake | OpeningKind::RibHole => return false,
            };
            opening.width_m < cells * cell_size_m
        };
        let openings = structure.openings.iter();
        if self.narrow_openings != Some(NarrowOpenings::Law) || !openings.clone().any(is_narrow) {
            return vec![None; structure.openings.len()];
        }
        let mut covers = covers::covers(structure, openings.clone());
        for (covers, opening) in covers.iter_mut().zip(openings) {
            if !is_narrow(opening) {
                *covers = None;
            }
        }
        covers
    }

    /// Largest spacing of markers on a triangle [m].
    #[must_use]
    pub fn marker_spacing_m(&self, air: &Air) -> f64 {
        self.marker_spacing_cells * air.units.cell_size_m
    }

    /// How far inside the rims of fabric markers stand.
    #[must_use]
    pub fn rim_insets(&self, structure: &Structure, air: &Air) -> RimInsets {
        RimInsets::new(structure, self.rim_inset_cells, air.units.cell_size_m)
    }
}

/// Checks `[coupling]`, and that markers and structure fit the air.
pub(super) fn check(
    file: &File,
    air: Option<&Air>,
    body: Option<&mut Body>,
) -> Result<Option<Coupling>, Problem> {
    let has_fabric = body.is_some();
    let has_bodies = !file.bodies.is_empty();
    let (Some(air), true) = (air, has_fabric || has_bodies) else {
        if file.coupling.is_some() {
            return Err(Problem::new(
                "coupling",
                "[coupling] needs both air and a structure or a rigid body",
                "remove [coupling], or add what is missing",
            ));
        }
        return Ok(None);
    };
    let written = file.coupling.as_ref().ok_or_else(|| {
        if has_fabric {
            return Problem::new(
                "structure",
                "[coupling] is missing: the case has air and a structure, but does not say how they are coupled",
                "add [coupling], which may be empty",
            );
        }
        Problem::new(
            "bodies",
            "[coupling] is missing: the case has air and rigid bodies, but does not say how they are coupled",
            "add [coupling], which may be empty",
        )
    })?;
    let scheme = usual::or("coupling.scheme", written.scheme, Scheme::Kernel);
    if scheme == Scheme::Links {
        refuse_keys_of_markers(written)?;
    }
    let rim_inset_cells = match scheme {
        Scheme::Kernel => within(
            "coupling.rim_inset_cells",
            usual::or(
                "coupling.rim_inset_cells",
                written.rim_inset_cells,
                RIM_INSET_CELLS,
            ),
            if has_fabric { 0.0 } else { -1.0 },
            1.0,
        )?,
        Scheme::Links => 0.0,
    };
    let structure_every = match body {
        Some(body) => {
            let structure_every = check_fabric_coupling(written, air, body)?;
            match (&body.kind, scheme) {
                (_, Scheme::Links) => {}
                (BodyKind::Plate(shape), _) => plate::check_cells(shape, air, rim_inset_cells)?,
                _ => rims::check(body, air, rim_inset_cells)?,
            }
            structure_every
        }
        None => {
            for (key, given) in [
                (
                    "coupling.structure_every",
                    written.structure_every.is_some(),
                ),
                ("coupling.mass_factor", written.mass_factor.is_some()),
            ] {
                if given {
                    return Err(Problem::new(
                        key,
                        format!("{key} has no effect: it needs [structure]"),
                        format!("remove {key}"),
                    ));
                }
            }
            None
        }
    };
    if written.surface_inset_cells.is_some() && !has_bodies {
        return Err(Problem::new(
            "coupling.surface_inset_cells",
            "coupling.surface_inset_cells has no effect: it needs [bodies]",
            "remove coupling.surface_inset_cells",
        ));
    }
    let passes = usual::or("coupling.passes", written.passes, 1);
    if !(1..=PASSES_LIMIT).contains(&passes) {
        return Err(Problem::new(
            "coupling.passes",
            format!("coupling.passes = {passes} is out of range"),
            format!(
                "allowed are 1 to {PASSES_LIMIT} passes of forcing; 1 is usual with over_relaxation = 1.6, 5 with 1.0"
            ),
        ));
    }
    if passes > 1 && has_fabric {
        return Err(Problem::new(
            "coupling.passes",
            format!(
                "coupling.passes = {passes}, but the case has fabric, which feels the air inside its own implicit step, once"
            ),
            "remove coupling.passes; several passes are for rigid bodies alone",
        ));
    }
    if air.cells.iter().any(|&n| n < SMALLEST_COUPLED_AXIS_CELLS) {
        return Err(Problem::new(
            "resolution",
            format!(
                "the air has only {} x {} x {} cells: too few around a {}",
                air.cells[0],
                air.cells[1],
                air.cells[2],
                if has_fabric { "structure" } else { "body" }
            ),
            format!(
                "at least {SMALLEST_COUPLED_AXIS_CELLS} cells are needed along every axis: choose smaller cells"
            ),
        ));
    }
    Ok(Some(Coupling {
        scheme,
        over_relaxation: within(
            "coupling.over_relaxation",
            usual::or(
                "coupling.over_relaxation",
                written.over_relaxation,
                OVER_RELAXATION,
            ),
            0.1,
            8.0 / 3.0 + 1e-9,
        )?,
        structure_every,
        passes,
        marker_spacing_cells: check_marker_spacing(written)?,
        rim_inset_cells,
        averaging_steps: 1,
        narrow_openings: check_narrow_openings(written, scheme, has_fabric)?,
    }))
}

/// Refuses what only markers have.
fn refuse_keys_of_markers(written: &file::Coupling) -> Result<(), Problem> {
    let keys = [
        ("over_relaxation", written.over_relaxation.is_some()),
        ("passes", written.passes.is_some()),
        ("surface_inset_cells", written.surface_inset_cells.is_some()),
        ("rim_inset_cells", written.rim_inset_cells.is_some()),
        (
            "marker_spacing_cells",
            written.marker_spacing_cells.is_some(),
        ),
    ];
    for (name, given) in keys {
        if given {
            let key = format!("coupling.{name}");
            return Err(Problem::new(
                key.as_str(),
                format!("{key} has no effect with scheme = \"links\": it belongs to markers"),
                format!("remove {key} (--set {key}=absent), or take scheme = \"kernel\""),
            ));
        }
    }
    if let Some(every @ 2..) = written.structure_every {
        return Err(Problem::new(
            "coupling.structure_every",
            format!(
                "coupling.structure_every = {every}, but with scheme = \"links\" other links are cut in every step, each of which the fabric answers"
            ),
            "remove coupling.structure_every, or take scheme = \"kernel\"",
        ));
    }
    Ok(())
}

fn check_narrow_openings(
    written: &file::Coupling,
    scheme: Scheme,
    has_fabric: bool,
) -> Result<Option<NarrowOpenings>, Problem> {
    const KEY: &str = "coupling.narrow_openings";
    if scheme == Scheme::Links && has_fabric {
        return Ok(Some(usual::or(
            KEY,
            written.narrow_openings,
            NarrowOpenings::Cells,
        )));
    }
    match written.narrow_openings {
        None => Ok(None),
        Some(_) => Err(Problem::new(
            KEY,
            format!("{KEY} has no effect: it needs [structure] and scheme = \"links\""),
            format!("remove {KEY}"),
        )),
    }
}

fn check_marker_spacing(written: &file::Coupling) -> Result<f64, Problem> {
    const KEY: &str = "coupling.marker_spacing_cells";
    let spacing = usual::or(KEY, written.marker_spacing_cells, SPACING_CELLS);
    let [least, most] = SPACING_RANGE_CELLS;
    if (least..=most).contains(&spacing) {
        return Ok(spacing);
    }
    let why = if spacing > most {
        ": air would pass between the markers"
    } else {
        ""
    };
    Err(Problem::new(
        KEY,
        format!("{KEY} = {} is out of range{why}", readable(spacing)),
        format!(
            "allowed are {least} to {most} cells; {SPACING_CELLS} is usual, and what holds without this key"
        ),
    ))
}

/// Checks what concerns fabric alone; returns the steps of the air per step of the fabric, if they are given.
fn check_fabric_coupling(
    written: &file::Coupling,
    air: &Air,
    body: &mut Body,
) -> Result<Option<u32>, Problem> {
    if body.structure.triangles.is_empty() {
        return Err(Problem::new(
            "structure",
            "cables alone do not feel the air",
            "remove [air], or choose a structure with fabric",
        ));
    }
    if let Some(factor) = written.mass_factor {
        at_once(|| positive("coupling.mass_factor", factor))?;
        for mass in &mut body.structure.masses_kg {
            *mass *= factor;
        }
    } else {
        usual::noted("coupling.mass_factor", 1.0);
    }
    if let Some(structure_every) = written.structure_every
        && !(1..=10).contains(&structure_every)
    {
        return Err(Problem::new(
            "coupling.structure_every",
            format!("coupling.structure_every = {structure_every} is out of range"),
            "allowed are 1 to 10 steps of the air per step of the fabric; 1 is fastest and quietest, and what holds without this key",
        ));
    }
    let size = DVec3::from_array(air.cells.map(|n| n as f64)) * air.units.cell_size_m;
    let margin = 2.0 * air.units.cell_size_m;
    let from_mesh = body.is_from_mesh() || matches!(body.kind, BodyKind::Mesh);
    let mut is_fabric = vec![false; body.structure.node_count()];
    for node in body.structure.triangles.iter().flat_map(|t| t.nodes) {
        is_fabric[node as usize] = true;
    }
    for (node, position) in body.structure.positions_m.iter().enumerate() {
        // Only fabric has markers; of what is held, a plate's edge may stand in a wall.
        let free = match &body.kind {
            BodyKind::Wing(_) => !is_fabric[node],
            _ => body.structure.held[node],
        };
        if free {
            continue;
        }
        if position.min_element() < margin || (size - *position).min_element() < margin {
            return Err(Problem::new(
                "air.wind_tunnel.size_m",
                format!(
                    "the structure does not fit: node {node} at ({:.3}, {:.3}, {:.3}) m lies outside or within two cells \
                     of the walls of the tunnel of {:.3} × {:.3} × {:.3} m{}",
                    position.x,
                    position.y,
                    position.z,
                    size.x,
                    size.y,
                    size.z,
                    if from_mesh {
                        large(&body.structure.positions_m)
                    } else {
                        String::new()
                    }
                ),
                if from_mesh {
                    "enlarge the tunnel, move the structure, or give the unit of its file (structure.mesh.scale)"
                } else {
                    "enlarge the tunnel or move the structure (structure.*.confluence_m, structure.wing.tunnel.place_m)"
                },
            ));
        }
    }
    Ok(written.structure_every)
}

/// Says how large a mesh is, whose unit may be another.
fn large(places_m: &[DVec3]) -> String {
    let (low, high) = places_m.iter().fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(low, high), place| (low.min(*place), high.max(*place)),
    );
    let own = high - low;
    format!("; it is {:.3} × {:.3} × {:.3} m large", own.x, own.y, own.z)
}
