//! Checks of `[air]`, `[resolution]` and `[coupling]`.

use glam::DVec3;

use super::file::{self, File};
use super::scene::{Air, Body, BodyKind, Coupling, Flow, absent, positive, readable, within};
use super::{Problem, bodies, descent, plate, rims, usual, wing_tunnel};
use crate::immersed::markers::{RIM_INSET_CELLS, SPACING_CELLS, SPACING_RANGE_CELLS};
use crate::lattice::eddy_viscosity::{EddyViscosity, EddyViscosityModel, UPDATE_EVERY};
use crate::lattice::{Operator, stability};
use crate::units::Units;

/// Smallest number of cells along any axis around a structure: room for the kernel and the momentum box.
const SMALLEST_COUPLED_AXIS_CELLS: usize = 12;

/// Most steps between two evaluations of the eddy viscosity: the wind passes a cell in so many at a lattice speed of 0.06.
const UPDATE_EVERY_LIMIT: u32 = 16;

/// Smallest number of cells along any axis of the air.
const SMALLEST_AXIS_CELLS: usize = 4;

/// Most passes of forcing.
const PASSES_LIMIT: u32 = 20;

/// Largest lattice speed allowed: Mach 0.26, where the error of weak compressibility, of order Ma², reaches 7 %.
pub const LATTICE_SPEED_LIMIT: f64 = 0.15;

/// Checks `[air]` and `[resolution]`.
pub(super) fn check_air(file: &File, air: &file::Air, body: Option<&Body>) -> Result<Air, Problem> {
    let density_kg_m3 = descent::density_kg_m3(air)?;
    let kinematic_viscosity_m2_s =
        positive("air.kinematic_viscosity_m2_s", air.kinematic_viscosity_m2_s)?;
    let resolution = file
        .resolution
        .as_ref()
        .ok_or_else(|| absent("resolution", "air needs a lattice"))?;
    let diameter = body.and_then(|b| match b.kind {
        BodyKind::Canopy(canopy) => Some(canopy.nominal_diameter_m),
        _ => None,
    });
    let diameter = diameter.or_else(|| bodies::only_diameter_m(file));
    let of_chord = resolution
        .cells_per_chord
        .map(|cells| wing_tunnel::cell_size_m(file, cells))
        .transpose()?;
    let cell_size_m = match (
        resolution.cells_per_diameter,
        resolution.cell_size_m.or(of_chord),
        diameter,
    ) {
        (Some(_), Some(_), _) => {
            return Err(Problem::new(
                "resolution.cell_size_m",
                if of_chord.is_some() {
                    "cells_per_chord and cells_per_diameter are both given"
                } else {
                    "cell_size_m and cells_per_diameter are both given"
                },
                "keep one of the two",
            ));
        }
        (Some(cells), None, Some(diameter)) => {
            diameter / positive("resolution.cells_per_diameter", cells)?
        }
        (Some(_), None, None) => {
            return Err(Problem::new(
                "resolution.cells_per_diameter",
                "cells_per_diameter needs a canopy with a nominal diameter, or one rigid body with a diameter",
                "give resolution.cell_size_m instead, or structure.mesh.nominal_area_m2 to a canopy from a mesh",
            ));
        }
        (None, Some(size), _) => positive("resolution.cell_size_m", size)?,
        (None, None, _) => {
            return Err(absent(
                "resolution.cell_size_m",
                "give it or cells_per_diameter",
            ));
        }
    };
    if resolution.cell_size_m.is_none() {
        usual::noted("resolution.cell_size_m", cell_size_m);
    }
    let lattice_speed = positive("resolution.lattice_speed", resolution.lattice_speed)?;
    if lattice_speed > LATTICE_SPEED_LIMIT {
        return Err(Problem::new(
            "resolution.lattice_speed",
            format!(
                "resolution.lattice_speed = {lattice_speed} is Mach {:.2}: too high for a weakly compressible method",
                lattice_speed * 3f64.sqrt()
            ),
            format!("choose at most {LATTICE_SPEED_LIMIT} (Mach 0.26); 0.08 is usual"),
        ));
    }
    let tunnels = match (&air.wind_tunnel, &air.descent) {
        (Some(tunnel), None) => Some((tunnel.clone(), "air.wind_tunnel", "speed_m_s")),
        (None, Some(descent)) => Some((descent.tunnel(), "air.descent", "release_speed_m_s")),
        _ => None,
    };
    let both = air.wind_tunnel.is_some() && air.descent.is_some();
    let (size_m, speed_m_s, flow) = match (&tunnels, &air.taylor_green) {
        (Some((tunnel, table, speed)), None) => {
            let key = |name: &str| format!("{table}.{name}");
            if !(0.0..=1e3).contains(&tunnel.speed_m_s) {
                return Err(Problem::new(
                    key(speed),
                    format!(
                        "{} = {} is no wind that can be computed",
                        key(speed),
                        readable(tunnel.speed_m_s)
                    ),
                    "the wind blows along +x; give 0 to 1000 m/s (and mind that the air is treated as incompressible)",
                ));
            }
            for size in tunnel.size_m {
                positive(&key("size_m"), size)?;
            }
            if cell_size_m > 0.5 * tunnel.size_m[0] {
                let key = if resolution.cell_size_m.is_some() {
                    "resolution.cell_size_m"
                } else {
                    "resolution.cells_per_diameter"
                };
                return Err(Problem::new(
                    key,
                    format!(
                        "{key} makes cells of {} m in a tunnel {} m long",
                        readable(cell_size_m),
                        readable(tunnel.size_m[0])
                    ),
                    "choose smaller cells: 20 to 40 per D_0 are usual",
                ));
            }
            let sponge_length_m = tunnel
                .sponge_length_m
                .map(|length| {
                    within(
                        &key("sponge_length_m"),
                        length,
                        cell_size_m,
                        0.5 * tunnel.size_m[0],
                    )
                })
                .transpose()?;
            positive(&key("start_time_s"), tunnel.start_time_s)?;
            let flow = Flow::WindTunnel {
                speed_m_s: tunnel.speed_m_s,
                start_time_s: tunnel.start_time_s,
                sponge_length_m,
            };
            (tunnel.size_m, tunnel.speed_m_s, flow)
        }
        (None, Some(vortices)) if !both => {
            let side_m = positive("air.taylor_green.side_m", vortices.side_m)?;
            let depth_m = positive("air.taylor_green.depth_m", vortices.depth_m)?;
            let speed_m_s = positive("air.taylor_green.speed_m_s", vortices.speed_m_s)?;
            if body.is_some() {
                return Err(Problem::new(
                    "air.taylor_green",
                    "Taylor–Green vortices are a test of the air alone, but the case has a structure",
                    "remove [structure], or use [air.wind_tunnel]",
                ));
            }
            (
                [side_m, side_m, depth_m],
                speed_m_s,
                // The period is a whole number of cells.
                Flow::TaylorGreen {
                    speed_m_s,
                    side_m: (side_m / cell_size_m).round().max(1.0) * cell_size_m,
                },
            )
        }
        _ => {
            return Err(Problem::new(
                "air",
                "[air] needs exactly one flow inside",
                "keep or add just one of [air.wind_tunnel], [air.descent] and [air.taylor_green]",
            ));
        }
    };
    let reference_speed_m_s = match resolution.reference_speed_m_s {
        Some(speed) => positive("resolution.reference_speed_m_s", speed)?,
        None if speed_m_s > 0.0 => usual::noted("resolution.reference_speed_m_s", speed_m_s),
        None => {
            return Err(absent(
                "resolution.reference_speed_m_s",
                "without wind the lattice needs a speed to scale with",
            ));
        }
    };
    if speed_m_s / reference_speed_m_s * lattice_speed > LATTICE_SPEED_LIMIT {
        return Err(Problem::new(
            "resolution.reference_speed_m_s",
            format!(
                "the wind of {speed_m_s} m/s is too fast on a lattice scaled for {reference_speed_m_s} m/s"
            ),
            "raise reference_speed_m_s to the wind speed, or leave it out",
        ));
    }
    let cells = size_m.map(|size| (size / cell_size_m).round().max(0.0) as usize);
    if cells.iter().any(|&n| n < SMALLEST_AXIS_CELLS) {
        return Err(Problem::new(
            "resolution",
            format!(
                "the air would have only {} × {} × {} cells",
                cells[0], cells[1], cells[2]
            ),
            format!(
                "at least {SMALLEST_AXIS_CELLS} cells are needed along every axis: choose smaller cells"
            ),
        ));
    }
    // Whole cells make the box.
    usual::noted("air.cells", cells);
    usual::noted("air.box_m", cells.map(|n| n as f64 * cell_size_m));
    let air = Air {
        units: Units::from_speed(
            cell_size_m,
            reference_speed_m_s,
            lattice_speed,
            density_kg_m3,
        ),
        kinematic_viscosity_m2_s,
        cells,
        reference_speed_m_s,
        lattice_speed,
        operator: resolution.operator,
        eddy_viscosity: resolution
            .eddy_viscosity
            .as_ref()
            .map(check_eddy_viscosity)
            .transpose()?,
        flow,
    };
    check_stability(&air, speed_m_s)?;
    Ok(air)
}

/// Refuses a flow that the operator did not survive when the stability map was measured. Flow around bodies is faster than the wind:
/// the plan warns of that.
fn check_stability(air: &Air, speed_m_s: f64) -> Result<(), Problem> {
    let speed = if speed_m_s > 0.0 {
        speed_m_s
    } else {
        air.reference_speed_m_s
    };
    let mach = speed / air.units.speed_m_s() * 3f64.sqrt();
    let viscous_part = air.units.relaxation_time(air.kinematic_viscosity_m2_s) - 0.5;
    let limit = |operator: Operator, eddy_viscosity: Option<EddyViscosity>| {
        stability::largest_mach(operator, eddy_viscosity, "f32", viscous_part)
    };
    let own = limit(air.operator, air.eddy_viscosity);
    let Some(survived) = own.filter(|survived| mach > *survived) else {
        return Ok(());
    };
    let help = [
        (None, "resolution.operator = \"recursive_regularised\""),
        (
            Some(stability::measured(EddyViscosityModel::Smagorinsky)),
            "resolution.operator = \"recursive_regularised\" and resolution.eddy_viscosity = { model = \"smagorinsky\", constant = 0.15 }",
        ),
    ]
    .into_iter()
    .find_map(|(eddy_viscosity, keys)| {
        let survived = limit(Operator::RecursiveRegularised, eddy_viscosity)?;
        (mach <= survived).then(|| format!("use {keys}, which survives Mach {survived:.2}"))
    })
    .unwrap_or_else(|| "lower resolution.lattice_speed, or use smaller cells".to_owned());
    Err(Problem::new(
        "resolution.operator",
        format!(
            "at tau - 1/2 = {viscous_part:.1e} and Mach {mach:.2} this operator breaks down: in the stability map it survives Mach {survived:.2}"
        ),
        help,
    ))
}

/// Checks `[resolution.eddy_viscosity]`. The ranges hardly overlap, so that a constant meant for another model is noticed.
fn check_eddy_viscosity(written: &file::EddyViscosity) -> Result<EddyViscosity, Problem> {
    let model = written.model;
    let (lowest, highest, usual) = match model {
        EddyViscosityModel::Smagorinsky => (0.01, 0.3, "0.1 to 0.2; 0.15 is usual"),
        EddyViscosityModel::Wale => (
            0.2,
            1.0,
            "0.325 (channels) to 0.6; 0.325 suits recursive_regularised",
        ),
        EddyViscosityModel::Vreman => (
            0.01,
            0.12,
            "0.025 to 0.07; 0.025 suits recursive_regularised",
        ),
    };
    let constant = written.constant;
    if !(lowest..=highest).contains(&constant) {
        let (name, symbol) = (model.name(), model.symbol());
        return Err(Problem::new(
            "resolution.eddy_viscosity.constant",
            format!(
                "resolution.eddy_viscosity.constant = {} is no {symbol} of the {name} model",
                readable(constant)
            ),
            format!("allowed are {lowest} to {highest}; published values are {usual}"),
        ));
    }
    let mut eddy_viscosity = EddyViscosity::new(model, constant);
    if let Some(every) = written.update_every {
        let key = "resolution.eddy_viscosity.update_every";
        if eddy_viscosity.gradient_model().is_none() {
            return Err(Problem::new(
                key,
                format!("{key} has no effect: Smagorinsky's model is evaluated in every collision"),
                format!("remove {key}"),
            ));
        }
        if !(1..=UPDATE_EVERY_LIMIT).contains(&every) {
            return Err(Problem::new(
                key,
                format!("{key} = {every} is out of range"),
                format!(
                    "allowed are 1 to {UPDATE_EVERY_LIMIT} steps; {UPDATE_EVERY} is usual, and what holds without this key"
                ),
            ));
        }
        eddy_viscosity.update_every = every;
    } else if eddy_viscosity.gradient_model().is_some() {
        usual::noted(
            "resolution.eddy_viscosity.update_every",
            eddy_viscosity.update_every,
        );
    }
    Ok(eddy_viscosity)
}

/// Checks `[coupling]`, and that markers and structure fit the air.
pub(super) fn check_coupling(
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
                "add [coupling] with over_relaxation = 1.6",
            );
        }
        Problem::new(
            "bodies",
            "[coupling] is missing: the case has air and rigid bodies, but does not say how they are coupled",
            "add [coupling] with over_relaxation = 1.6",
        )
    })?;
    let rim_inset_cells = within(
        "coupling.rim_inset_cells",
        usual::or(
            "coupling.rim_inset_cells",
            written.rim_inset_cells,
            RIM_INSET_CELLS,
        ),
        if has_fabric { 0.0 } else { -1.0 },
        1.0,
    )?;
    let structure_every = match body {
        Some(body) => {
            let structure_every = check_fabric_coupling(written, air, body)?;
            match body.kind {
                BodyKind::Plate(shape) => plate::check_cells(&shape, air, rim_inset_cells)?,
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
        over_relaxation: within(
            "coupling.over_relaxation",
            written.over_relaxation,
            0.1,
            8.0 / 3.0 + 1e-9,
        )?,
        structure_every,
        passes,
        marker_spacing_cells: check_marker_spacing(written)?,
        rim_inset_cells,
        averaging_steps: 1,
    }))
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
        positive("coupling.mass_factor", factor)?;
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
    let mut is_fabric = vec![false; body.structure.node_count()];
    for node in body.structure.triangles.iter().flat_map(|t| t.nodes) {
        is_fabric[node as usize] = true;
    }
    for (node, position) in body.structure.positions_m.iter().enumerate() {
        // Only fabric has markers; of what is held, a plate's edge may stand in a wall.
        let free = match body.kind {
            BodyKind::Wing => !is_fabric[node],
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
                     of the walls of the tunnel of {:.3} × {:.3} × {:.3} m",
                    position.x, position.y, position.z, size.x, size.y, size.z
                ),
                "enlarge the tunnel or move the structure (structure.*.confluence_m, structure.wing.tunnel.place_m)",
            ));
        }
    }
    Ok(written.structure_every)
}
