//! The checked scene: SI units, every value in its range, absent things `None`.

use std::path::Path;

use glam::DVec3;

use super::file::{self, File};
use super::{Problem, structure};
use crate::cloth::Structure;
use crate::cpu::fluid::Operator;
use crate::geometry::mesh::quality::Quality;
use crate::immersed::markers;
use crate::units::Units;

/// Largest lattice speed allowed: Mach 0.26, where the error of weak compressibility, of order Ma², reaches 7 %.
pub const LATTICE_SPEED_LIMIT: f64 = 0.15;

/// Smallest number of cells along any axis of the air.
const SMALLEST_AXIS_CELLS: usize = 4;

/// Everything that a run needs to know.
#[derive(Debug, Clone)]
pub struct Scene {
    /// One line for reports and pictures.
    pub title: String,
    /// The air.
    pub air: Option<Air>,
    /// Fabric and cables.
    pub body: Option<Body>,
    /// Coupling of the two; present if both are.
    pub coupling: Option<Coupling>,
    /// Gravity [m/s²].
    pub gravity_m_s2: Option<DVec3>,
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
}

/// The air.
#[derive(Debug, Clone, Copy)]
pub struct Air {
    /// Scales.
    pub units: Units,
    /// Kinematic viscosity [m²/s].
    pub kinematic_viscosity_m2_s: f64,
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// Speed that is `lattice_speed` on the lattice [m/s].
    pub reference_speed_m_s: f64,
    /// Cells per step at the reference speed.
    pub lattice_speed: f64,
    /// Collision operator.
    pub operator: Operator,
    /// Smagorinsky constant.
    pub smagorinsky_constant: Option<f64>,
    /// What the air does.
    pub flow: Flow,
}

/// What the air does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flow {
    /// Wind along +x between frictionless walls.
    WindTunnel {
        /// Wind speed [m/s].
        speed_m_s: f64,
        /// Time in which the wind rises, before t = 0 [s].
        start_time_s: f64,
        /// Length of the viscous sponge before the outlet [m].
        sponge_length_m: Option<f64>,
    },
    /// Decaying Taylor–Green vortices in a periodic box.
    TaylorGreen {
        /// Largest initial speed [m/s].
        speed_m_s: f64,
        /// Period along x and y [m].
        side_m: f64,
    },
}

/// Fabric and cables with what reports need to know of them.
#[derive(Debug, Clone)]
pub struct Body {
    /// The structure at its start.
    pub structure: Structure,
    /// Quality of the fabric's mesh at rest.
    pub quality: Option<Quality>,
    /// What kind of structure it is.
    pub kind: BodyKind,
}

/// Kinds of structures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BodyKind {
    /// A parachute canopy.
    Canopy(Canopy),
    /// A sheet of fabric.
    Sheet,
    /// A hanging cable between two ends.
    Cable {
        /// Distance of the ends [m].
        span_m: f64,
        /// Rest length [m].
        length_m: f64,
        /// Weight per length [N/m].
        weight_n_m: f64,
    },
    /// A mesh from a file.
    Mesh,
}

/// What is measured on a canopy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Canopy {
    /// Nominal area S₀ [m²].
    pub nominal_area_m2: f64,
    /// Nominal diameter D₀ [m].
    pub nominal_diameter_m: f64,
    /// Canopy nodes come first; the rest is the confluence.
    pub canopy_node_count: usize,
    /// Projected-diameter ratio to which the folded canopy is opened before the wind starts.
    pub opened_diameter_ratio: f64,
    /// Pressure that opens it [Pa].
    pub loading_pressure_pa: f64,
}

/// Coupling of air and fabric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Over-relaxation a on a flat sheet.
    pub over_relaxation: f64,
    /// Fluid steps per cloth step.
    pub structure_every: u32,
}

/// Solver of the fabric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// Tolerance of one step, relative to the loads.
    pub tolerance: f64,
    /// Evaluations allowed in one step.
    pub evaluation_limit: usize,
    /// Mass-proportional damping [1/s].
    pub damping_1_s: f64,
}

/// Simulated time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Time {
    /// End [s].
    pub end_s: f64,
    /// Step of the structure (without air) or of the air [s].
    pub step_s: f64,
}

/// Static equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium {
    /// Tolerance relative to the loads.
    pub tolerance: f64,
    /// Evaluations allowed.
    pub evaluation_limit: usize,
}

/// What to write.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Time between rows of `history.csv` [s].
    pub sample_interval_s: f64,
    /// Time between `canopy_*.vtp` files; absent: only the last.
    pub canopy_interval_s: Option<f64>,
    /// Time between `flow_*.vti` files; absent: only the last.
    pub flow_interval_s: Option<f64>,
    /// Times of pictures besides the last [s].
    pub picture_times_s: Vec<f64>,
}

/// Refuses values that are not positive and finite.
pub(super) fn positive(key: &str, value: f64) -> Result<f64, Problem> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Problem::new(
            key,
            format!("{key} = {value} must be positive"),
            "give a number greater than zero",
        ))
    }
}

/// Refuses values outside a closed range.
pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Result<f64, Problem> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(Problem::new(
            key,
            format!("{key} = {value} is out of range"),
            format!("allowed are values from {low} to {high}"),
        ))
    }
}

pub(super) fn absent(key: &str, why: &str) -> Problem {
    Problem::new(
        key,
        format!("{key} is missing: {why}"),
        format!("add `{key}`"),
    )
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
        .map(|g| DVec3::from_array(g.acceleration_m_s2));
    if let Some(g) = gravity_m_s2
        && !g.is_finite()
    {
        return Err(Problem::new(
            "gravity.acceleration_m_s2",
            "gravity is not finite",
            "give three finite numbers",
        ));
    }
    let mut body = structure::check(file, folder, gravity_m_s2)?;
    let air = file
        .air
        .as_ref()
        .map(|air| check_air(file, air, body.as_ref()))
        .transpose()?;
    if air.is_none() && body.is_none() {
        return Err(Problem::new(
            "version",
            "the case holds neither air nor a structure: there is nothing to simulate",
            "add an [air] table, a [structure] table, or both",
        ));
    }
    let coupling = check_coupling(file, air.as_ref(), body.as_mut())?;
    let solver = check_solver(file)?;
    let time = check_time(file, air.as_ref())?;
    let equilibrium = file
        .equilibrium
        .as_ref()
        .map(|e| {
            if air.is_some() {
                return Err(Problem::new(
                    "equilibrium",
                    "a static equilibrium is not defined in moving air",
                    "remove [equilibrium] or [air]",
                ));
            }
            Ok(Equilibrium {
                tolerance: within("equilibrium.tolerance", e.tolerance, 1e-12, 0.5)?,
                evaluation_limit: e.evaluation_limit,
            })
        })
        .transpose()?;
    if time.is_none() && equilibrium.is_none() {
        return Err(absent(
            "time",
            "a run needs [time], or [equilibrium] for a structure without air",
        ));
    }
    let end_s = time.map_or(1.0, |t| t.end_s);
    let written = file.output.clone().unwrap_or_default();
    let optional = |key: &str, value: Option<f64>| value.map(|v| positive(key, v)).transpose();
    let output = Output {
        sample_interval_s: optional("output.sample_interval_s", written.sample_interval_s)?
            .unwrap_or(end_s / 500.0),
        canopy_interval_s: optional("output.canopy_interval_s", written.canopy_interval_s)?,
        flow_interval_s: optional("output.flow_interval_s", written.flow_interval_s)?,
        picture_times_s: written.picture_times_s.unwrap_or_default(),
    };
    let steady_drag_confidence = file
        .steady
        .as_ref()
        .map(|s| within("steady.drag_confidence", s.drag_confidence, 1e-4, 0.5))
        .transpose()?;
    let title = file.title.clone().unwrap_or_else(|| "untitled".to_owned());
    Ok(Scene {
        title,
        air,
        body,
        coupling,
        gravity_m_s2,
        solver,
        time,
        equilibrium,
        steady_drag_confidence,
        output,
    })
}

fn check_air(file: &File, air: &file::Air, body: Option<&Body>) -> Result<Air, Problem> {
    let density_kg_m3 = positive("air.density_kg_m3", air.density_kg_m3)?;
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
    let cell_size_m = match (
        resolution.cells_per_diameter,
        resolution.cell_size_m,
        diameter,
    ) {
        (Some(_), Some(_), _) => {
            return Err(Problem::new(
                "resolution.cell_size_m",
                "cell_size_m and cells_per_diameter are both given",
                "keep one of the two",
            ));
        }
        (Some(cells), None, Some(diameter)) => {
            diameter / positive("resolution.cells_per_diameter", cells)?
        }
        (Some(_), None, None) => {
            return Err(Problem::new(
                "resolution.cells_per_diameter",
                "cells_per_diameter needs a canopy with a nominal diameter",
                "give resolution.cell_size_m instead",
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
    let (size_m, speed_m_s, flow) = match (&air.wind_tunnel, &air.taylor_green) {
        (Some(tunnel), None) => {
            if !(tunnel.speed_m_s >= 0.0 && tunnel.speed_m_s.is_finite()) {
                return Err(Problem::new(
                    "air.wind_tunnel.speed_m_s",
                    format!(
                        "air.wind_tunnel.speed_m_s = {} must not be negative",
                        tunnel.speed_m_s
                    ),
                    "the wind blows along +x; give zero or a positive speed",
                ));
            }
            for size in tunnel.size_m {
                positive("air.wind_tunnel.size_m", size)?;
            }
            let sponge_length_m = tunnel
                .sponge_length_m
                .map(|length| {
                    within(
                        "air.wind_tunnel.sponge_length_m",
                        length,
                        cell_size_m,
                        0.5 * tunnel.size_m[0],
                    )
                })
                .transpose()?;
            positive("air.wind_tunnel.start_time_s", tunnel.start_time_s)?;
            let flow = Flow::WindTunnel {
                speed_m_s: tunnel.speed_m_s,
                start_time_s: tunnel.start_time_s,
                sponge_length_m,
            };
            (tunnel.size_m, tunnel.speed_m_s, flow)
        }
        (None, Some(vortices)) => {
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
                Flow::TaylorGreen { speed_m_s, side_m },
            )
        }
        _ => {
            return Err(Problem::new(
                "air",
                "[air] needs exactly one flow",
                "add either [air.wind_tunnel] or [air.taylor_green]",
            ));
        }
    };
    let reference_speed_m_s = match resolution.reference_speed_m_s {
        Some(speed) => positive("resolution.reference_speed_m_s", speed)?,
        None if speed_m_s > 0.0 => speed_m_s,
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
    Ok(Air {
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
        smagorinsky_constant: resolution
            .smagorinsky_constant
            .map(|c| within("resolution.smagorinsky_constant", c, 0.01, 0.5))
            .transpose()?,
        flow,
    })
}

fn check_coupling(
    file: &File,
    air: Option<&Air>,
    body: Option<&mut Body>,
) -> Result<Option<Coupling>, Problem> {
    let (Some(air), Some(body)) = (air, body) else {
        if file.coupling.is_some() {
            return Err(Problem::new(
                "coupling",
                "[coupling] needs both air and a structure",
                "remove [coupling], or add what is missing",
            ));
        }
        return Ok(None);
    };
    let written = file
        .coupling
        .as_ref()
        .ok_or_else(|| absent("coupling", "air and structure must be coupled somehow"))?;
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
    }
    if !(1..=10).contains(&written.structure_every) {
        return Err(Problem::new(
            "coupling.structure_every",
            format!(
                "coupling.structure_every = {} is out of range",
                written.structure_every
            ),
            "allowed are 1 to 10 steps of the air per step of the fabric; 1 is fastest and quietest",
        ));
    }
    let size = DVec3::from_array(air.cells.map(|n| n as f64)) * air.units.cell_size_m;
    let margin = 2.0 * air.units.cell_size_m;
    for (node, position) in body.structure.positions_m.iter().enumerate() {
        if body.structure.held[node] {
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
                "enlarge the tunnel or move the structure (structure.*.confluence_m)",
            ));
        }
    }
    let spacing = body
        .structure
        .triangles
        .iter()
        .map(|t| {
            t.rest_area_m2.sqrt()
                / markers::subdivisions(t.rest_area_m2, air.units.cell_size_m) as f64
        })
        .fold(0.0, f64::max)
        / air.units.cell_size_m;
    if spacing > markers::SPACING_LIMIT_CELLS {
        return Err(Problem::new(
            "resolution",
            format!("markers would be {spacing:.2} cells apart"),
            format!("at most {} is tight", markers::SPACING_LIMIT_CELLS),
        ));
    }
    Ok(Some(Coupling {
        over_relaxation: within(
            "coupling.over_relaxation",
            written.over_relaxation,
            0.1,
            8.0 / 3.0 + 1e-9,
        )?,
        structure_every: written.structure_every,
    }))
}

fn check_solver(file: &File) -> Result<Solver, Problem> {
    let written = file.solver.as_ref();
    let damping_1_s = written.and_then(|s| s.damping_1_s).unwrap_or(0.0);
    if !(damping_1_s >= 0.0 && damping_1_s.is_finite()) {
        return Err(Problem::new(
            "solver.damping_1_s",
            format!("solver.damping_1_s = {damping_1_s} must not be negative"),
            "damping takes energy out; give zero or a positive rate",
        ));
    }
    Ok(Solver {
        tolerance: within(
            "solver.tolerance",
            written.and_then(|s| s.tolerance).unwrap_or(1e-2),
            1e-12,
            0.5,
        )?,
        evaluation_limit: written.and_then(|s| s.evaluation_limit).unwrap_or(2_000),
        damping_1_s,
    })
}

fn check_time(file: &File, air: Option<&Air>) -> Result<Option<Time>, Problem> {
    let Some(time) = &file.time else {
        return if air.is_some() {
            Err(absent("time.end_s", "air needs an end time"))
        } else {
            Ok(None)
        };
    };
    let end_s = positive("time.end_s", time.end_s)?;
    let step_s = match (air, time.step_s) {
        (Some(air), None) => air.units.time_step_s,
        (None, Some(step)) => positive("time.step_s", step)?,
        (Some(_), Some(_)) => {
            return Err(Problem::new(
                "time.step_s",
                "with air the time step follows from cell size and lattice speed",
                "remove time.step_s",
            ));
        }
        (None, None) => {
            return Err(absent(
                "time.step_s",
                "without air the structure needs a time step",
            ));
        }
    };
    Ok(Some(Time { end_s, step_s }))
}
