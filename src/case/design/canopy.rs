//! What follows from a canopy's design: tunnel or fall, lattice, folding, materials, time, outputs, references.

use toml::{Table, Value};

use super::super::file::{CanopyDesign, CanopyStart, CanopyType, Quality};
use super::super::problem::Problem;
use super::super::values::{positive, within};
use super::derived::Keys;
use super::handbook::{Published, SOURCE};
use super::materials;
use super::scales::Scales;
use super::shape;
use super::units::rounded;
use crate::case::scene::STANDARD_GRAVITY_M_S2;
use crate::lines::named::Cord;

/// The table of the design.
const TABLE: &str = "canopy";

/// Cells per D_0, rings of triangles, half width of the mean drag's interval over it.
const fn fineness(quality: Quality) -> (f64, usize, f64) {
    match quality {
        Quality::Draft => (16.0, 8, 0.10),
        Quality::Normal => (24.0, 12, 0.05),
        Quality::Fine => (32.0, 16, 0.03),
    }
}

/// Cells across a vent that are aimed at, and how many more of all that may take.
const VENT_CELLS: f64 = 2.05;
const MORE_CELLS: f64 = 1.35;

/// Cells per step at the speed of wind or release.
const LATTICE_SPEED: f64 = 0.08;

/// D_0/U in which the wind rises.
const START: f64 = 0.67;

/// Length of the sponge before the outlet over D_0.
const SPONGE: f64 = 1.5;

/// Longest run, in D_0/U: the wake settles for 18, means need 6.
const LENGTH: f64 = 60.0;

/// Length of a fall, in D_0 over the speed of release, and over that of balance: an opening and the loss of speed, not the breathing that follows
/// (docs/design.md).
const FALL: [f64; 2] = [6.0, 0.5];

/// Room in the innermost box around a canopy that falls, over D_0.
const FALL_MARGIN: f64 = 1.0;

/// D_0/U between samples, between files of the canopy.
const SAMPLES: f64 = 0.03;
const CANOPIES: f64 = 0.5;

/// D_0/U of pictures: of an opening, and of an open canopy.
const OPENING_PICTURES: [f64; 7] = [0.0, 0.7, 1.4, 2.0, 3.0, 5.0, 10.0];
const OPEN_PICTURES: [f64; 3] = [0.0, 2.0, 10.0];

/// Pressure that opens pleats to a mouth, over the dynamic pressure of the wind.
const LOADING: f64 = 0.04;

/// Stiffness of the apex guide over dynamic pressure and D_0.
const GUIDE: f64 = 20.0;

/// Drag coefficient of a round line across the wind.
const LINE_DRAG: f64 = 1.1;

/// All keys that follow from a design, and from what the case says beside it.
pub(super) fn derive(design: &CanopyDesign, case: &Table) -> Result<Keys, Problem> {
    let scales = &Scales::new(design, case)?;
    let quality = design.quality.unwrap_or(Quality::Normal);
    let (cells, rings, confidence) = fineness(quality);
    let start = design.start.unwrap_or({
        if scales.payload_kg.is_none() || scales.falls {
            CanopyStart::Folded
        } else if design.kind == CanopyType::Cruciform {
            // Folded arms open in some lengths and stay shut in others.
            CanopyStart::Open
        } else {
            CanopyStart::Hemispherical
        }
    });
    let mut keys = Keys::default();
    keys.set(
        "title",
        title(design, scales),
        "type, D_0, payload or speed",
    );
    air(scales, &mut keys);
    flow(design, scales, &mut keys)?;
    let (cells, why) = cells_per_diameter(design, quality, cells);
    keys.set("resolution.cells_per_diameter", cells, why);
    keys.set("resolution.lattice_speed", LATTICE_SPEED, "usual");
    keys.set("resolution.operator", "stabilised_regularised", "usual");
    let cloth = materials::cloth(TABLE, design.fabric.as_deref())?;
    shape::derive(design, scales, rings, &mut keys)?;
    folding(design, scales, start, &mut keys);
    materials::set_cloth(&cloth, &mut keys);
    lines(design, scales, &mut keys)?;
    let usual = "usual";
    keys.set("coupling.scheme", "links", usual);
    keys.set("coupling.structure_every", 1, usual);
    if scales.falls {
        let end = FALL[0] * scales.time_s() + FALL[1] * scales.final_time_s();
        keys.set(
            "time.end_s",
            end,
            "6 D_0/U, and half of one at the speed of balance: the opening",
        );
    } else {
        keys.set("time.end_s", LENGTH * scales.time_s(), "60 D_0/U");
        keys.set("steady.drag_confidence", confidence, "quality");
    }
    outputs(scales, start, &mut keys);
    comparisons(design, scales, start, &mut keys);
    Ok(keys)
}

/// Cells per D_0, with two across the vent where few more than usual do that.
fn cells_per_diameter(design: &CanopyDesign, quality: Quality, usual: f64) -> (f64, &'static str) {
    let vent = design.vent_percent.filter(|percent| *percent > 0.0);
    let two_across = vent.map(|percent| (100.0 * VENT_CELLS / percent).ceil());
    match two_across {
        Some(cells)
            if quality != Quality::Draft && (usual..=MORE_CELLS * usual).contains(&cells) =>
        {
            (cells, "quality, and two cells across the vent")
        }
        _ => (usual, "quality"),
    }
}

fn title(design: &CanopyDesign, scales: &Scales) -> String {
    let name = Published::of(design.kind).name;
    let name = name[..1].to_uppercase() + &name[1..];
    let with = scales.payload_kg.map_or_else(
        || format!("{} m/s", rounded(scales.speed_m_s)),
        |mass| format!("{} kg", rounded(mass)),
    );
    let diameter = rounded(scales.diameter_m);
    format!("{name} canopy, D_0 {diameter} m, {with}")
}

fn air(scales: &Scales, keys: &mut Keys) {
    if !scales.falls {
        let why = "standard atmosphere at altitude_m";
        keys.set("air.density_kg_m3", scales.density_kg_m3, why);
    }
    let viscosity = scales.kinematic_viscosity_m2_s;
    let why = "standard atmosphere, Sutherland's law";
    keys.set("air.kinematic_viscosity_m2_s", viscosity, why);
    keys.set("air.refinement.around", "structure", "usual");
    if scales.falls {
        let why =
            "the wake overtakes a canopy that loses its speed, and pushes it towards the payload";
        keys.set("air.refinement.margin", FALL_MARGIN, why);
    }
}

/// The wind tunnel, or the fall; and the payload.
fn flow(design: &CanopyDesign, scales: &Scales, keys: &mut Keys) -> Result<(), Problem> {
    let (table, speed) = if scales.falls {
        ("air.descent", "release_speed_m_s")
    } else {
        ("air.wind_tunnel", "speed_m_s")
    };
    let why = if scales.falls || scales.payload_kg.is_none() {
        "speed"
    } else {
        "balance of payload and drag, by the handbook's drag coefficient"
    };
    let of = |name: &str| format!("{table}.{name}");
    keys.set(of(speed), scales.speed_m_s, why);
    keys.set(of("start_time_s"), START * scales.time_s(), "0.67 D_0/U");
    let sponge = SPONGE * scales.diameter_m;
    keys.set(of("sponge_length_m"), sponge, "1.5 D_0");
    let Some(payload_kg) = scales.payload_kg else {
        let written = design.payload_drag_area_m2;
        return match written {
            None => Ok(()),
            Some(_) => Err(Problem::new(
                "canopy.payload_drag_area_m2",
                "canopy.payload_drag_area_m2 has no effect: it needs canopy.payload_kg",
                "remove it, or add payload_kg",
            )),
        };
    };
    keys.set("payload.mass_kg", payload_kg, "payload");
    if let Some(area) = design.payload_drag_area_m2 {
        let area = positive("canopy.payload_drag_area_m2", area)?;
        keys.set("payload.drag_area_m2", area, "payload_drag_area_m2");
    }
    if scales.falls {
        keys.set(of("altitude_m"), scales.altitude_m, "altitude");
        let down = [-STANDARD_GRAVITY_M_S2, 0.0, 0.0].map(Value::from).to_vec();
        keys.set("gravity.acceleration_m_s2", down, "the air comes along +x");
    }
    Ok(())
}

fn folding(design: &CanopyDesign, scales: &Scales, start: CanopyStart, keys: &mut Keys) {
    let table = shape::table(design.kind);
    let of = |name: &str| format!("structure.{table}.{name}");
    let [folded, opened] = match start {
        CanopyStart::Folded => [0.15, 0.2],
        CanopyStart::Hemispherical => [0.3, 0.6],
        CanopyStart::Open => [0.6, 0.6],
    };
    keys.set(of("folding.folded_diameter_ratio"), folded, "start");
    keys.set(of("folding.opened_diameter_ratio"), opened, "start");
    let q = scales.dynamic_pressure_pa(scales.final_speed_m_s);
    let (pressure, why) = match start {
        CanopyStart::Hemispherical => {
            let drag_coefficient = Published::of(design.kind).mean_drag_coefficient();
            let why = "pulls at the lines as the handbook's drag does";
            (drag_coefficient * q / (opened * opened), why)
        }
        CanopyStart::Folded | CanopyStart::Open => (
            LOADING * scales.dynamic_pressure_pa(scales.speed_m_s),
            "0.04 times ½ ρ U²: opens pleats, and hardly pulls",
        ),
    };
    keys.set(of("folding.loading_pressure_pa"), pressure, why);
    if design.guided.unwrap_or(true) {
        let stiffness = GUIDE * q * scales.diameter_m;
        keys.set(of("apex_guide_n_m"), stiffness, "20 times ½ ρ U² D_0");
    }
}

fn lines(design: &CanopyDesign, scales: &Scales, keys: &mut Keys) -> Result<(), Problem> {
    let gores = shape::gores(design, scales);
    let count = shape::line_count(design, gores);
    let usual_ratio = match design.kind {
        CanopyType::DiskGapBand => 1.7,
        _ => 1.0,
    };
    let ratio = design.line_length_ratio.unwrap_or(usual_ratio);
    let ratio = within("canopy.line_length_ratio", ratio, 0.3, 10.0)?;
    let why = match design.line_count {
        Some(_) => "line_count",
        None => "one per gore; cruciform: 16",
    };
    keys.set("lines.count", count as i64, why);
    keys.set(
        "lines.length_m",
        ratio * scales.diameter_m,
        "line_length_ratio",
    );
    let published = Published::of(design.kind);
    let load_n = published.opening_force_factor[1]
        * published.mean_drag_coefficient()
        * scales.dynamic_pressure_pa(scales.speed_m_s.max(scales.final_speed_m_s))
        * scales.area_m2
        * scales.opening_load_reduction(published.mean_drag_coefficient());
    let (cord, why) = materials::line(
        TABLE,
        design.lines.as_deref(),
        (scales.diameter_m, count, load_n),
    )?;
    let strength = |cord: &Cord| ("breaking_load_n", cord.strength_n(), cord.source);
    let diameter = ("diameter_m", cord.diameter_m(), "half of it fibre");
    let more = [strength(&cord), diameter];
    materials::set_cord("lines", (&cord, &why), &more, keys);
    keys.set("lines.drag_coefficient", LINE_DRAG, "a round line");
    let tape = materials::tape(TABLE, design.tapes.as_deref())?;
    materials::set_cord("belts", (&tape, tape.name), &[strength(&tape)], keys);
    Ok(())
}

fn outputs(scales: &Scales, start: CanopyStart, keys: &mut Keys) {
    let [first, last] = [scales.time_s(), scales.final_time_s()];
    let sample = SAMPLES * first.min(last);
    keys.set("output.sample_interval_s", sample, "0.03 D_0/U");
    keys.set("output.canopy_interval_s", CANOPIES * last, "0.5 D_0/U");
    let times: &[f64] = match start {
        CanopyStart::Folded => &OPENING_PICTURES,
        CanopyStart::Hemispherical | CanopyStart::Open => &OPEN_PICTURES,
    };
    let times: Vec<Value> = times.iter().map(|t| Value::from(t * first)).collect();
    keys.set("output.picture_times_s", times, "multiples of D_0/U");
    keys.set("output.history_plots", true, "usual");
}

fn comparisons(design: &CanopyDesign, scales: &Scales, start: CanopyStart, keys: &mut Keys) {
    let published = Published::of(design.kind);
    let band = |range: [f64; 2]| {
        let range = Value::from(range.map(Value::from).to_vec());
        Table::from_iter([
            ("range".to_owned(), range),
            ("source".to_owned(), Value::from(SOURCE)),
        ])
    };
    let why = "what is published of canopies of the type";
    if !scales.falls {
        let drag = band(published.drag_coefficient);
        keys.set("comparison.drag_coefficient", drag, why);
        if start == CanopyStart::Folded {
            let factor = band(published.opening_force_factor);
            keys.set("comparison.opening_force_factor", factor, why);
        }
    }
    let diameter = band(published.projected_diameter_ratio);
    keys.set("comparison.projected_diameter_ratio", diameter, why);
}
