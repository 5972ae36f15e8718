//! Checks of `[structure.wing]` and `[equilibrium.wing_pressure]`, and the building of the wing; `[equilibrium.trim]` is checked in `trim`.

use std::path::Path;

use super::fabric::{USUAL_RESIDUAL, check_fabric_at};
pub use super::file::HeldName;
use super::file::{self, File};
use super::problem::Problem;
use super::trim;
use super::usual;
use super::values::{count_within, points, positive, vector, wing_key as key, within};
use super::wing_design::{self, LoadTest, PanelShaping};
use super::wing_lines::{Materials, check_materials, check_row, material};
use super::wing_rods;
use super::wing_tunnel;
pub use super::wing_tunnel::{Pull, Tunnel};
use super::wing_vh_ribs;
use crate::cloth::Structure;
use crate::geometry::wing;
use crate::geometry::wing::frames::Station;
use crate::geometry::wing::plan::{Fineness, Hole, Intakes, PartFabrics, Plan, Tape, WingFault};
use crate::geometry::wing::pressure::{Distribution, jumps_pa};
pub use crate::geometry::wing::section::{Profile, Side};
pub use crate::geometry::wing::{BuiltWing, LineKind};
use crate::trim::Settings;

/// Distance of a hang point from the nose along an axis, at most [m]: beyond it stands in another unit.
const FARTHEST_HANG_POINT_M: f64 = 200.0;

/// Most nodes of a wing: some 6 GB.
const NODE_LIMIT: usize = 4_000_000;

/// A wing with what acts on it and what its lines bear.
#[derive(Debug, Clone)]
pub struct Wing {
    /// What was built from the plan, but for its structure, which is the body's.
    pub built: BuiltWing,
    /// How fine its mesh is.
    pub fineness: Fineness,
    /// What it was built from.
    pub plan: Plan,
    /// Prescribed pressure inside less that outside, along the normals of the triangles [Pa], `[triangle_count]`; `None`: none is prescribed.
    pub load_pa: Option<Vec<f64>>,
    /// Steady glide to be found; `None`: none is sought.
    pub trim: Option<Settings>,
    /// Its loads several times over; `None`: not asked for.
    pub load_test: Option<LoadTest>,
    /// Panels are to fly as they were designed; `None`: they are as the plan says.
    pub panel_shaping: Option<PanelShaping>,
    /// Whether a speed bar shortens risers.
    pub has_speed_bar: bool,
    /// How it stands in the wind; `None` without air.
    pub tunnel: Option<Tunnel>,
    /// Risers that are hauled in.
    pub pulls: Vec<Pull>,
    /// Breaking load of every cable segment [N], `[cable_count]`; `None` where it is not told.
    pub breaking_loads_n: Vec<Option<f64>>,
    /// Diameter of every cable segment [m], `[cable_count]`.
    pub line_diameters_m: Vec<f64>,
    /// The same wing on a coarser mesh, whose trim is sought first; `None`: none is.
    pub coarser: Option<Box<CoarserWing>>,
}

/// A wing on a coarser mesh.
#[derive(Debug, Clone)]
pub struct CoarserWing {
    /// The wing.
    pub wing: Wing,
    /// Its structure at its start.
    pub structure: Structure,
}

/// Refuses loads of a wing where there is none.
pub(super) fn check_loads(file: &File) -> Result<(), Problem> {
    if file.wing().is_some() {
        return Ok(());
    }
    wing_design::check_load_test(file)?;
    wing_design::check_panel_shaping(file)?;
    let of = |what: fn(&file::Equilibrium) -> bool| file.equilibrium.as_ref().is_some_and(what);
    for (key, present, remedy) in [
        (
            "equilibrium.wing_pressure",
            of(|e| e.wing_pressure.is_some()),
            "remove it, or use equilibrium.pressure_pa",
        ),
        ("equilibrium.trim", of(|e| e.trim.is_some()), "remove it"),
    ] {
        if present {
            return Err(Problem::new(
                key,
                format!("[{key}] has no effect: it needs [structure.wing]"),
                remedy,
            ));
        }
    }
    Ok(())
}

/// Builds the wing of a case with its structure at the start; files are looked up relative to `folder`.
pub(super) fn check(
    file: &File,
    table: &file::Wing,
    folder: &Path,
) -> Result<(Wing, Structure), Problem> {
    let equilibrium = file.equilibrium.as_ref();
    let prescribed = equilibrium.and_then(|e| e.wing_pressure.as_ref());
    let sought = equilibrium.and_then(|e| e.trim.as_ref());
    let load_test = wing_design::check_load_test(file)?;
    let panel_shaping = wing_design::check_panel_shaping(file)?;
    if prescribed.is_some() && sought.is_some() {
        return Err(Problem::new(
            "equilibrium.trim",
            "pressure is both prescribed by [equilibrium.wing_pressure] and to be found by [equilibrium.trim]",
            "remove one of them (`--set equilibrium.trim=absent` does so for one run)",
        ));
    }
    wing_tunnel::check_air(file, table)?;
    if file
        .equilibrium
        .as_ref()
        .is_some_and(|e| e.pressure_pa.is_some())
    {
        return Err(Problem::new(
            "equilibrium.pressure_pa",
            "equilibrium.pressure_pa would push on one side of ribs and diagonals, too",
            "use [equilibrium.trim] or [equilibrium.wing_pressure]: the same pressure in all cells is inside = 1.0 with that dynamic_pressure_pa and upper = lower = [[0.0, 0.0]]",
        ));
    }
    let materials = check_materials(table)?;
    let trim = sought
        .map(|written| trim::check(file, written, table))
        .transpose()?;
    let mut plan = check_plan(table, &materials, folder)?;
    if trim.is_some() {
        // Moved along with the wing until it carries nothing.
        plan.pitch_guide_n_m.get_or_insert(trim::GUIDE_N_M);
    }
    let distribution = prescribed
        .map(|pressure| check_pressure(pressure, table.cells))
        .transpose()?;
    let material_of = |kind: &LineKind| {
        let name = match *kind {
            LineKind::Line { row, level } => &plan.rows[row].levels[level].material,
            LineKind::Riser { row } => &table.rows.values().nth(row)?.riser_material,
            LineKind::Tape(number) => &table.tapes.values().nth(number)?.material,
        };
        materials.get(name)
    };
    let diameter = |kind: &LineKind| {
        let area_m2 = material_of(kind).map_or(0.0, |material| material.area_m2);
        (area_m2 / std::f64::consts::FRAC_PI_4).sqrt()
    };
    let meshed = |fineness: Fineness| {
        let built = wing::build(&plan, fineness)?;
        let cables = &built.structure.cables;
        Ok(Wing {
            fineness,
            load_pa: distribution.as_ref().map(|d| jumps_pa(&built, d)),
            trim: trim.clone(),
            breaking_loads_n: cables.iter().map(|cable| cable.breaking_load_n).collect(),
            line_diameters_m: built.line_kinds.iter().map(diameter).collect(),
            load_test: None,
            panel_shaping: None,
            has_speed_bar: table.speed_bar.is_some(),
            tunnel: None,
            pulls: Vec::new(),
            built,
            plan: plan.clone(),
            coarser: None,
        })
    };
    let mut whole = meshed(check_fineness(table)?).map_err(refused)?;
    whole.tunnel = (table.tunnel.as_ref())
        .map(|written| {
            let lines = (&mut whole.built, &whole.line_diameters_m[..]);
            wing_tunnel::place(lines, table, written)
        })
        .transpose()?;
    whole.pulls = wing_tunnel::pulls(file, table, &whole.built)?;
    if trim.as_ref().is_some_and(|trim| trim.from_coarser_meshes) {
        let mut finest = &mut whole;
        while let Some(fineness) = finest.fineness.halved() {
            // A mesh that coarse may have no room for what the plan asks for.
            let Ok(mut wing) = meshed(fineness) else {
                break;
            };
            let structure = std::mem::take(&mut wing.built.structure);
            let coarser = finest
                .coarser
                .insert(Box::new(CoarserWing { wing, structure }));
            finest = &mut coarser.wing;
        }
    }
    // Only the mesh asked for is tested and shaped.
    (whole.load_test, whole.panel_shaping) = (load_test, panel_shaping);
    let structure = std::mem::take(&mut whole.built.structure);
    Ok((whole, structure))
}

fn refused(fault: WingFault) -> Problem {
    let message = format!("the wing cannot be meshed: {fault}");
    match fault {
        WingFault::TooCoarse { places, .. } => Problem::new(
            key("mesh.along_chord"),
            message,
            format!("give at least {places}, or move rows and intakes onto each other"),
        ),
        WingFault::Rib { .. } => Problem::new(
            key("profiles"),
            message,
            "thicken the profile, make holes smaller, or raise mesh.along_chord",
        ),
        WingFault::MiniRib { .. } => Problem::new(
            key("mini_ribs"),
            message,
            "make mini-ribs longer, thicken the profile, or raise mesh.along_chord",
        ),
        WingFault::Degenerate { .. } => Problem::new(
            key("stations"),
            message,
            "chords and cell widths must not vanish, nor diagonals collapse",
        ),
        WingFault::BelowRiser { row, .. } => Problem::new(
            key(&format!("rows.{row}.levels")),
            message,
            "shorten `to_sail_m` to less than that of the node below, or the riser, or hang the wing lower (`hang_point_m`); in a drawing of LEparagliding these are sections 11, 8 and 10",
        ),
    }
}

fn check_fineness(table: &file::Wing) -> Result<Fineness, Problem> {
    let mesh = &table.mesh;
    let range = |name: &str, value: usize, low: usize, high: usize| {
        count_within(&key(&format!("mesh.{name}")), value, low, high)
    };
    let along_chord = range("along_chord", mesh.along_chord, 6, 2000)?;
    let across_cell = range("across_cell", mesh.across_cell, 2, 200)?;
    if !across_cell.is_multiple_of(2) {
        let key = key("mesh.across_cell");
        return Err(Problem::new(
            &key,
            format!("{key} = {across_cell} is odd"),
            "an even number has nodes in the middle of each cell and makes both halves alike",
        ));
    }
    let nodes = table.cells.saturating_mul(2 * along_chord * across_cell);
    if nodes > NODE_LIMIT {
        return Err(Problem::new(
            key("mesh"),
            format!("the panels alone would have some {nodes} nodes"),
            format!("allowed are {NODE_LIMIT}; divide chord or cells less"),
        ));
    }
    Ok(Fineness {
        along_chord,
        across_cell,
    })
}

fn check_pressure(written: &file::WingPressure, cells: usize) -> Result<Distribution, Problem> {
    const KEY: &str = "equilibrium.wing_pressure";
    let key = |name: &str| format!("{KEY}.{name}");
    let coefficient = |key: &str, value: f64| within(key, value, -20.0, 20.0);
    let inside = match (written.inside, &written.inside_per_cell) {
        (Some(all), None) => vec![coefficient(&key("inside"), all)?],
        (None, Some(each)) if each.len() == cells => each
            .iter()
            .map(|&c| coefficient(&key("inside_per_cell"), c))
            .collect::<Result<_, _>>()?,
        (None, Some(each)) => {
            return Err(Problem::new(
                key("inside_per_cell"),
                format!(
                    "{} has {} coefficients for {cells} cells",
                    key("inside_per_cell"),
                    each.len()
                ),
                "give one per cell from the left tip to the right one, or `inside` for all",
            ));
        }
        _ => {
            return Err(Problem::new(
                KEY,
                "the pressure inside the cells is not given, or given twice",
                "give one of `inside` (1 at a stagnation point) and `inside_per_cell`",
            ));
        }
    };
    Ok(Distribution {
        dynamic_pressure_pa: positive(&key("dynamic_pressure_pa"), written.dynamic_pressure_pa)?,
        inside,
        upper: points(&key("upper"), &written.upper, [-20.0, 20.0])?,
        lower: points(&key("lower"), &written.lower, [-20.0, 20.0])?,
        along_span: match &written.along_span {
            Some(table) => points(&key("along_span"), table, [-10.0, 10.0])?,
            None => usual::noted(key("along_span"), vec![[0.0, 1.0]]),
        },
    })
}

fn check_stations(table: &file::Wing, names: &[&String]) -> Result<Vec<Station>, Problem> {
    let key = key("stations");
    let refuse = |message: String, help: &str| Err(Problem::new(&key, message, help));
    if table.stations.len() < 2 {
        return refuse(
            format!("{key} needs at least two stations"),
            "give one in the middle (span_m = 0) and one at the tip",
        );
    }
    let mut stations: Vec<Station> = Vec::new();
    for (number, written) in table.stations.iter().enumerate() {
        let place = number + 1;
        let last = stations.last().map_or(-1.0, |s| s.span_m);
        if !(written.span_m > last && written.span_m < 1e3) {
            return refuse(
                format!("{key}: station {place} does not lie farther out than the one before"),
                "order the stations from the middle (span_m = 0) to the tip",
            );
        }
        if number == 0 && (written.span_m != 0.0 || written.roll_deg != 0.0) {
            return refuse(
                format!("{key}: the first station is not the upright middle of the wing"),
                "give it span_m = 0 and roll_deg = 0",
            );
        }
        let Some(profile) = names.iter().position(|name| **name == written.profile) else {
            return refuse(
                format!(
                    "{key}: station {place} names the profile `{}`, which does not exist",
                    written.profile
                ),
                "name one of [structure.wing.profiles]",
            );
        };
        let named = |name: &str| format!("{key}, station {place}: {name}");
        let located = |result: Result<f64, Problem>| {
            result.map_err(|problem| Problem {
                key: key.clone(),
                ..problem
            })
        };
        stations.push(Station {
            span_m: written.span_m,
            chord_m: located(within(&named("chord_m"), written.chord_m, 1e-3, 1e3))?,
            sweep_m: located(within(&named("sweep_m"), written.sweep_m, -1e3, 1e3))?,
            roll_rad: located(within(&named("roll_deg"), written.roll_deg, -120.0, 120.0))?
                .to_radians(),
            twist_rad: located(within(&named("twist_deg"), written.twist_deg, -45.0, 45.0))?
                .to_radians(),
            profile,
        });
    }
    Ok(stations)
}

fn check_holes(table: &file::Wing) -> Result<Vec<Hole>, Problem> {
    let key = key("holes");
    let mut last = 0.02;
    let mut holes = Vec::new();
    for (number, hole) in table.holes.iter().enumerate() {
        let place = number + 1;
        let from = hole.position - 0.5 * hole.width;
        let to = hole.position + 0.5 * hole.width;
        let fits = hole.width > 0.0 && from > last && to < 0.97;
        if !fits || !(0.05..=0.9).contains(&hole.height) {
            return Err(Problem::new(
                &key,
                format!(
                    "{key}: hole {place} does not fit: it reaches from {from:.3} to {to:.3} of the chord and over {} of the height",
                    hole.height
                ),
                "holes must lie between 0.02 and 0.97 of the chord, one behind the other with fabric between them, and take 0.05 to 0.9 of the height",
            ));
        }
        last = to + 0.005;
        holes.push(Hole {
            position: hole.position,
            width: hole.width,
            height: hole.height,
        });
    }
    Ok(holes)
}

fn check_plan(table: &file::Wing, materials: &Materials, folder: &Path) -> Result<Plan, Problem> {
    if !(1..=400).contains(&table.cells) {
        return Err(Problem::new(
            key("cells"),
            format!("{} = {} is out of range", key("cells"), table.cells),
            "a wing has 1 to 400 cells",
        ));
    }
    let names: Vec<&String> = table.profiles.keys().collect();
    let profiles = wing_design::check_profiles(table, folder)?;
    let stations = check_stations(table, &names)?;
    let intakes = table.intakes.as_ref().map(check_intakes).transpose()?;
    let fabrics = check_fabrics(&table.fabrics)?;
    let ballooning = match &table.ballooning {
        Some(written) => wing_design::check_ballooning(&key("ballooning"), written)?,
        None => [Vec::new(), Vec::new()],
    };
    let rows = table
        .rows
        .iter()
        .map(|(name, row)| check_row(table, (name, row), materials))
        .collect::<Result<_, _>>()?;
    let tapes = table
        .tapes
        .iter()
        .map(|(name, tape)| {
            let key = key(&format!("tapes.{name}"));
            Ok(Tape {
                side: match tape.side {
                    file::SideName::Upper => Side::Upper,
                    file::SideName::Lower => Side::Lower,
                },
                position: within(&format!("{key}.position"), tape.position, 0.0, 1.0)?,
                sewn: tape.sewn,
                cable: material(materials, &format!("{key}.material"), &tape.material)?,
            })
        })
        .collect::<Result<_, _>>()?;
    let hang_point_m = vector(&key("hang_point_m"), table.hang_point_m)?;
    if hang_point_m.abs().max_element() > FARTHEST_HANG_POINT_M {
        return Err(Problem::new(
            key("hang_point_m"),
            format!(
                "{} = [{}, {}, {}] lies farther than {FARTHEST_HANG_POINT_M} m from the wing's nose",
                key("hang_point_m"),
                hang_point_m.x,
                hang_point_m.y,
                hang_point_m.z
            ),
            "lengths are in metres: chord, half the distance of both hang points, and height below the wing",
        ));
    }
    positive(&key("hang_point_m"), hang_point_m.y).map_err(|problem| Problem {
        message: format!("{} must lie on the right half, y > 0", key("hang_point_m")),
        help: "the left half is its mirror image".to_owned(),
        ..problem
    })?;
    let rib_places_m = check_rib_places(table, &stations)?;
    Ok(Plan {
        profiles,
        rib_places_m,
        stations,
        cells: table.cells,
        tip_cell_width_ratio: within(
            &key("tip_cell_width_ratio"),
            usual::or(key("tip_cell_width_ratio"), table.tip_cell_width_ratio, 1.0),
            0.1,
            3.0,
        )?,
        ballooning,
        intakes,
        holes: check_holes(table)?,
        mini_ribs_from: table
            .mini_ribs_from
            .map(|from| within(&key("mini_ribs_from"), from, 0.5, 0.95))
            .transpose()?,
        rows,
        tapes,
        vh_ribs: wing_vh_ribs::check(table)?,
        rods: wing_rods::check(table)?,
        hang_point_m,
        pitch_guide_n_m: table
            .pitch_guide_n_m
            .map(|k| positive(&key("pitch_guide_n_m"), k))
            .transpose()?,
        fabrics,
    })
}

/// Places of the ribs, which end where the stations do.
fn check_rib_places(table: &file::Wing, stations: &[Station]) -> Result<Option<Vec<f64>>, Problem> {
    let Some(places) = &table.rib_places_m else {
        return Ok(None);
    };
    let key = key("rib_places_m");
    let refuse = |why: String, what: &str| Err(Problem::new(key.as_str(), why, what));
    if table.tip_cell_width_ratio.is_some() {
        return refuse(
            format!("{key} and structure.wing.tip_cell_width_ratio both say where ribs stand"),
            "keep one of the two",
        );
    }
    let is_even = table.cells.is_multiple_of(2);
    let count = table.cells / 2 + 1;
    let grows = places.windows(2).all(|pair| pair[1] > pair[0]);
    let begins = places
        .first()
        .is_some_and(|first| if is_even { *first == 0.0 } else { *first > 0.0 });
    if places.len() != count || !grows || !begins {
        return refuse(
            format!(
                "{key} are not the {count} places of ribs of {} cells",
                table.cells
            ),
            "list them outwards, from 0 for an even number of cells, from half the width of the middle cell for an odd one",
        );
    }
    let span_m = stations.last().map_or(0.0, |station| station.span_m);
    let tip_m = places[count - 1];
    if (tip_m / span_m - 1.0).abs() > 1e-6 {
        return refuse(
            format!("{key} end at {tip_m} m, and the stations at {span_m} m"),
            "let the last rib stand at the last station",
        );
    }
    Ok(Some(places.clone()))
}

fn check_fabrics(written: &file::WingFabrics) -> Result<PartFabrics, Problem> {
    let of = |name: &str, fabric: &file::Fabric| {
        let key = key(&format!("fabrics.{name}"));
        if fabric.permeability.is_some() {
            return Err(Problem::new(
                format!("{key}.permeability"),
                "a wing's fabric cannot be permeable yet",
                "remove the table",
            ));
        }
        if fabric.friction.is_some() {
            return Err(Problem::new(
                format!("{key}.friction"),
                "the air passes along the parts of a wing as structure.wing.tunnel says, which tells outside from inside",
                "remove it; give structure.wing.tunnel.friction and inner_friction",
            ));
        }
        check_fabric_at(&key, fabric, USUAL_RESIDUAL)
    };
    let optional = |name: &str, fabric: &Option<file::Fabric>| {
        fabric.as_ref().map(|fabric| of(name, fabric)).transpose()
    };
    let upper = of("upper", &written.upper)?;
    let ribs = optional("ribs", &written.ribs)?.unwrap_or(upper);
    Ok(PartFabrics {
        upper,
        lower: optional("lower", &written.lower)?.unwrap_or(upper),
        ribs,
        diagonals: optional("diagonals", &written.diagonals)?.unwrap_or(ribs),
    })
}

fn check_intakes(written: &file::Intakes) -> Result<Intakes, Problem> {
    let from = within(&key("intakes.from"), written.from, 0.0, 0.3)?;
    let to = within(&key("intakes.to"), written.to, 0.0, 0.3)?;
    if to < from + 1e-3 {
        return Err(Problem::new(
            key("intakes.to"),
            format!("the intakes end at {to} of the chord and begin at {from}"),
            "give places on the lower side with `to` behind `from`",
        ));
    }
    Ok(Intakes {
        from,
        to,
        closed_tip_cells: usual::or(key("intakes.closed_tip_cells"), written.closed_tip_cells, 0),
    })
}
