//! The air: `[air]` and `[resolution]`.

use glam::DVec3;

use super::body::Body;
use super::density::{density_kg_m3, sound_m_s};
use super::faces::{check_sides, refuse_faces};
use super::file::{self, File};
use super::inlet;
use super::lattice_speed::{self, LATTICE_SPEED_LIMIT};
use super::problem::Problem;
use super::refinement::written;
use super::usual;
use super::usual_box;
use super::values::{absent, at_once, positive, readable, within};
use crate::lattice::eddy_viscosity::{EddyViscosity, EddyViscosityModel, UPDATE_EVERY};
use crate::lattice::grid::{InletProfile, Sides};
use crate::lattice::nest::{self, Level, Refinement};
use crate::lattice::{Operator, stability};
use crate::units::Units;

/// Most steps between two evaluations of the eddy viscosity: the wind passes a cell in so many at a lattice speed of 0.06.
const UPDATE_EVERY_LIMIT: u32 = 16;

/// Smallest number of cells along any axis of the air.
const SMALLEST_AXIS_CELLS: usize = 4;

/// The air.
#[derive(Debug, Clone)]
pub struct Air {
    /// Scales.
    pub units: Units,
    /// Kinematic viscosity [m²/s].
    pub kinematic_viscosity_m2_s: f64,
    /// The box along x, y, z, in cells of the size around the structure.
    pub cells: [usize; 3],
    /// Boxes of finer cells in the outermost lattice; without any all cells are alike.
    pub boxes: Vec<Refinement>,
    /// How often its cells can be doubled: the box of the air is made of whole cells of that size.
    pub most_levels: u32,
    /// Speed that is `lattice_speed` on the lattice [m/s].
    pub reference_speed_m_s: f64,
    /// Cells per step at the reference speed.
    pub lattice_speed: f64,
    /// Collision operator.
    pub operator: Operator,
    /// Eddy viscosity; `None` without one.
    pub eddy_viscosity: Option<EddyViscosity>,
    /// What the air does.
    pub flow: Flow,
}

impl Air {
    /// How often cells are halved from the outermost lattice to that around the structure.
    #[must_use]
    pub fn depth(&self) -> usize {
        nest::depth(&self.boxes)
    }

    /// True if it repeats along an axis.
    #[must_use]
    pub const fn repeats_somewhere(&self) -> bool {
        match &self.flow {
            Flow::WindTunnel { sides, .. } => {
                let [y, z] = sides.repeat();
                y || z
            }
            Flow::TaylorGreen { .. } => true,
        }
    }

    /// Size of the box [m].
    #[must_use]
    pub fn box_m(&self) -> DVec3 {
        DVec3::from_array(self.cells.map(|n| n as f64)) * self.units.cell_size_m
    }

    /// Its section across the wind [m²].
    #[must_use]
    pub fn section_m2(&self) -> f64 {
        let size = self.box_m();
        size.y * size.z
    }

    /// Speed of the undisturbed wind at a place over that of the tunnel: 1, or as the inlet has it.
    #[must_use]
    pub fn wind_ratio_at(&self, place_m: DVec3) -> f64 {
        let Flow::WindTunnel {
            inlet_profile: Some(profile),
            ..
        } = &self.flow
        else {
            return 1.0;
        };
        let shares = place_m / self.box_m();
        profile.ratio_at([shares.y, shares.z])
    }

    /// Cells of the outermost lattice.
    #[must_use]
    pub fn outer_cells(&self) -> [usize; 3] {
        self.cells.map(|n| n >> self.depth())
    }

    /// Edge length of its cells [m].
    #[must_use]
    pub fn outer_cell_size_m(&self) -> f64 {
        self.units.cell_size_m * (1_u32 << self.depth()) as f64
    }

    /// All lattices, the outermost first, then the box around the structure that it holds, and so on inwards.
    #[must_use]
    pub fn levels(&self) -> Vec<Level> {
        nest::levels(self.outer_cells(), &self.boxes)
    }

    /// The lattice around the structure; corner and cells in its own cells.
    #[must_use]
    pub fn finest(&self) -> Level {
        self.levels()[self.depth()]
    }

    /// Edge length of a level's cells, in cells of the size around the structure.
    #[must_use]
    pub fn finest_cells_across(&self, level: &Level) -> f64 {
        2f64.powi(self.depth() as i32 - level.depth as i32)
    }

    /// Relaxation time at a depth.
    #[must_use]
    pub fn relaxation_time(&self, depth: usize) -> f64 {
        let finest = self.units.relaxation_time(self.kinematic_viscosity_m2_s) - 0.5;
        0.5 + finest * 2f64.powi(depth as i32 - self.depth() as i32)
    }

    /// Cell updates of a step of the lattice around the structure, averaged over one of the outermost.
    #[must_use]
    pub fn updates_per_step(&self) -> f64 {
        let updates = |level: &Level| {
            let cells: f64 = level.cells.iter().map(|n| *n as f64).product();
            cells / self.finest_cells_across(level)
        };
        self.levels().iter().map(updates).sum()
    }

    /// Cells in which boxes and the lattices around them exchange what they know, in a step of the lattice around the structure, averaged alike.
    #[must_use]
    pub fn exchanged_per_step(&self) -> f64 {
        let exchanged =
            |level: &Level| level.shell_cells() / (2.0 * self.finest_cells_across(level));
        self.levels().iter().map(exchanged).sum()
    }

    /// Steps of the lattice around the structure in one of the outermost.
    #[must_use]
    pub fn steps_per_outer(&self) -> u64 {
        1 << self.depth()
    }

    /// Wind speed, to which coefficients and times refer; without wind the speed that the lattice is scaled with [m/s].
    #[must_use]
    pub const fn wind_or_reference_m_s(&self) -> f64 {
        match self.flow {
            Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0 => speed_m_s,
            _ => self.reference_speed_m_s,
        }
    }
}

/// What the air does.
#[derive(Debug, Clone, PartialEq)]
pub enum Flow {
    /// Wind along +x.
    WindTunnel {
        /// Wind speed [m/s].
        speed_m_s: f64,
        /// Time in which the wind rises, before t = 0 [s].
        start_time_s: f64,
        /// Length of the viscous sponge before the outlet [m].
        sponge_length_m: Option<f64>,
        /// What lies beside, below and above.
        sides: Sides,
        /// Wind at the inlet over `speed_m_s`; `None` where it is the same everywhere.
        inlet_profile: Option<InletProfile>,
    },
    /// Decaying Taylor–Green vortices in a periodic box.
    TaylorGreen {
        /// Largest initial speed [m/s].
        speed_m_s: f64,
        /// Period along x and y [m].
        side_m: f64,
    },
}

/// Checks `[air]` and `[resolution]`.
pub(super) fn check_air(file: &File, air: &file::Air, body: Option<&Body>) -> Result<Air, Problem> {
    let density_kg_m3 = density_kg_m3(air)?;
    let kinematic_viscosity_m2_s =
        positive("air.kinematic_viscosity_m2_s", air.kinematic_viscosity_m2_s)?;
    let resolution = file
        .resolution
        .as_ref()
        .ok_or_else(|| absent("resolution", "air needs a lattice"))?;
    let diameter = body
        .and_then(Body::canopy)
        .map(|canopy| canopy.nominal_diameter_m);
    let diameter = diameter.or_else(|| file.only_diameter_m());
    let of_chord = resolution
        .cells_per_chord
        .map(|cells| cell_of_chord_m(file, cells))
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
    let tunnels = match (&air.wind_tunnel, &air.descent) {
        (Some(tunnel), None) => Some((tunnel.clone(), "air.wind_tunnel", "speed_m_s")),
        (None, Some(descent)) => Some((descent.tunnel(), "air.descent", "release_speed_m_s")),
        _ => None,
    };
    let both = air.wind_tunnel.is_some() && air.descent.is_some();
    let length_m = diameter.or_else(|| file.wing().map(largest_chord_m));
    let most_levels = written::most_levels(air, cell_size_m, length_m)?;
    // The box of the air is made of whole cells of the outermost lattice.
    let across = f64::from(1_u32 << most_levels);
    let outermost = |size_m| whole_cells(size_m, across * cell_size_m);
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
            let size_m = tunnel
                .size_m
                .ok_or_else(|| usual_box::unknown_size(&key("size_m")))?;
            for size in size_m {
                at_once(|| positive(&key("size_m"), size))?;
            }
            if cell_size_m > 0.5 * size_m[0] {
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
                        readable(size_m[0])
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
                        0.5 * size_m[0],
                    )
                })
                .transpose()?;
            at_once(|| positive(&key("start_time_s"), tunnel.start_time_s))?;
            let sides = check_sides(air, air.descent.is_some())?;
            let (cells, across_m) = (outermost(size_m), cell_size_m * across);
            let flow = Flow::WindTunnel {
                speed_m_s: tunnel.speed_m_s,
                start_time_s: tunnel.start_time_s,
                sponge_length_m,
                sides,
                inlet_profile: inlet::check_inlet(air, cells, across_m, sides)?,
            };
            (size_m, tunnel.speed_m_s, flow)
        }
        (None, Some(vortices)) if !both => {
            refuse_faces(air)?;
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
    let lattice_speed = lattice_speed::check(
        resolution.lattice_speed,
        reference_speed_m_s,
        sound_m_s(air, density_kg_m3),
    )?;
    let wind_on_lattice = speed_m_s / reference_speed_m_s * lattice_speed;
    let mut fastest_m_s = speed_m_s;
    if let Flow::WindTunnel {
        inlet_profile: Some(profile),
        ..
    } = &flow
    {
        inlet::refuse_too_fast(profile, wind_on_lattice, LATTICE_SPEED_LIMIT)?;
        fastest_m_s *= profile.largest();
    }
    if wind_on_lattice > LATTICE_SPEED_LIMIT {
        return Err(Problem::new(
            "resolution.reference_speed_m_s",
            format!(
                "the wind of {speed_m_s} m/s is too fast on a lattice scaled for {reference_speed_m_s} m/s"
            ),
            "raise reference_speed_m_s to the wind speed, or leave it out",
        ));
    }
    let cells = outermost(size_m).map(|n| n << most_levels);
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
        boxes: Vec::new(),
        most_levels,
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
    let viscous_part = air.units.relaxation_time(kinematic_viscosity_m2_s) - 0.5;
    written::refuse_unfit(most_levels, air.operator, viscous_part)?;
    let has_bodies = body.is_some() || !file.bodies.is_empty();
    check_stability(&air, fastest_m_s, has_bodies)?;
    Ok(air)
}

/// Cells of a box, which has whole ones.
fn whole_cells(size_m: [f64; 3], cell_size_m: f64) -> [usize; 3] {
    size_m.map(|size| (size / cell_size_m).round().max(0.0) as usize)
}

/// Size of a cell of which `cells` make the largest chord [m].
fn cell_of_chord_m(file: &File, cells: f64) -> Result<f64, Problem> {
    const KEY: &str = "resolution.cells_per_chord";
    let resolution = file.resolution.as_ref();
    if resolution.is_some_and(|r| r.cell_size_m.is_some()) {
        return Err(Problem::new(
            KEY,
            "cells_per_chord and cell_size_m are both given",
            "keep one of the two",
        ));
    }
    let Some(table) = file.wing() else {
        return Err(Problem::new(
            KEY,
            "cells_per_chord needs [structure.wing]",
            "give resolution.cell_size_m instead",
        ));
    };
    Ok(largest_chord_m(table) / positive(KEY, cells)?)
}

/// Largest chord of a wing [m].
fn largest_chord_m(table: &file::Wing) -> f64 {
    table.stations.iter().map(|s| s.chord_m).fold(0.0, f64::max)
}

/// Refuses a flow that the operator did not survive when the stability maps were measured: free turbulence, and where something stands in
/// the wind, bodies as well.
fn check_stability(air: &Air, speed_m_s: f64, has_bodies: bool) -> Result<(), Problem> {
    let speed = if speed_m_s > 0.0 {
        speed_m_s
    } else {
        air.reference_speed_m_s
    };
    let mach = speed / air.units.speed_m_s() * 3f64.sqrt();
    // In the outermost lattice viscosity counts least.
    let finest = air.units.relaxation_time(air.kinematic_viscosity_m2_s) - 0.5;
    let viscous_part = finest / f64::from(1_u32 << air.most_levels);
    let of_turbulence = |operator: Operator, eddy_viscosity: Option<EddyViscosity>| {
        stability::largest_mach(operator, eddy_viscosity, "f32", viscous_part)
    };
    let of_bodies = |operator: Operator, eddy_viscosity: Option<EddyViscosity>| {
        // No wind beyond the fastest one tried was measured.
        stability::largest_mach_at_bodies(operator, eddy_viscosity, viscous_part)
            .filter(|limit| has_bodies && *limit < stability::FASTEST_AT_BODIES)
    };
    let breaks_down = |limit: Option<f64>| limit.filter(|survived| mach > *survived);
    let (survived, flow) =
        if let Some(survived) = breaks_down(of_turbulence(air.operator, air.eddy_viscosity)) {
            (survived, "in the stability map")
        } else if let Some(survived) = breaks_down(of_bodies(air.operator, air.eddy_viscosity)) {
            (survived, "past bodies in the stability map")
        } else {
            return Ok(());
        };
    let smagorinsky = Some(stability::measured(EddyViscosityModel::Smagorinsky));
    let help = [
        (
            Operator::StabilisedRegularised,
            None,
            "resolution.operator = \"stabilised_regularised\", without an eddy viscosity",
        ),
        (
            Operator::RecursiveRegularised,
            smagorinsky,
            "resolution.operator = \"recursive_regularised\" and resolution.eddy_viscosity = { model = \"smagorinsky\", constant = 0.15 }",
        ),
    ]
    .into_iter()
    .find(|(operator, eddy_viscosity, _)| {
        breaks_down(of_turbulence(*operator, *eddy_viscosity)).is_none()
            && breaks_down(of_bodies(*operator, *eddy_viscosity)).is_none()
    })
    .map_or_else(
        || "lower resolution.lattice_speed, or use smaller cells".to_owned(),
        |(_, _, keys)| format!("use {keys}, which survives that"),
    );
    Err(Problem::new(
        "resolution.operator",
        format!(
            "at tau - 1/2 = {viscous_part:.1e} and Mach {mach:.2} this operator breaks down: {flow} it survives Mach {survived:.2}"
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
