//! What follows from a paraglider by span, cells and class: a whole plan with lines and materials, and its trim.

use std::f64::consts::FRAC_PI_2;

use toml::{Table, Value};

use super::super::density::standard_density_kg_m3;
use super::super::file::{Quality, WingClass, WingDesign};
use super::super::problem::Problem;
use super::super::text::{lookup, number};
use super::super::values::{absent, positive, within};
use super::derived::Keys;
use super::units::{altitude_m, length, mass, rounded};
use crate::case::scene::STANDARD_GRAVITY_M_S2;
use crate::geometry::wing::rib_spans_m;

/// The table of the design.
const TABLE: &str = "wing";

/// What wings of a class have in common. Those of A and C are the shipped plans `wing-school` and `wing-27`, B lies between them, D goes on in
/// the same direction: proportions that are usual in the class, not those of anybody's wing.
struct Proportions {
    name: &'static str,
    aspect_ratio: f64,
    cells: usize,
    /// Thickness of the middle profile over the chord [%].
    thickness_percent: u32,
    /// Chord at the tip over that in the middle.
    tip_chord: f64,
    /// Width of the outermost cell over that of the middlemost.
    tip_cell: f64,
    /// Lean of the rib at the tip [°], and the power of the place along the span with which it grows.
    tip_roll_deg: f64,
    roll_power: f64,
    /// Height of the wing over the risers, over the flat span.
    height: f64,
    /// Place of the risers behind the leading edge, over the middle chord.
    hang_place: f64,
}

impl Proportions {
    const fn of(class: WingClass) -> Self {
        match class {
            WingClass::EnA => Self {
                name: "EN A",
                aspect_ratio: 4.9,
                cells: 38,
                thickness_percent: 17,
                tip_chord: 0.32,
                tip_cell: 0.7,
                tip_roll_deg: 60.0,
                roll_power: 1.3,
                height: 0.63,
                hang_place: 0.416,
            },
            WingClass::EnB => Self {
                name: "EN B",
                aspect_ratio: 5.5,
                cells: 48,
                thickness_percent: 17,
                tip_chord: 0.26,
                tip_cell: 0.62,
                tip_roll_deg: 69.0,
                roll_power: 1.4,
                height: 0.585,
                hang_place: 0.425,
            },
            WingClass::EnC => Self {
                name: "EN C",
                aspect_ratio: 6.2,
                cells: 60,
                thickness_percent: 16,
                tip_chord: 0.20,
                tip_cell: 0.55,
                tip_roll_deg: 78.0,
                roll_power: 1.5,
                height: 0.54,
                hang_place: 0.435,
            },
            WingClass::EnD => Self {
                name: "EN D",
                aspect_ratio: 6.8,
                cells: 70,
                thickness_percent: 15,
                tip_chord: 0.18,
                tip_cell: 0.5,
                tip_roll_deg: 80.0,
                roll_power: 1.5,
                height: 0.52,
                hang_place: 0.44,
            },
        }
    }
}

/// Flat spans that a wing may have [m].
const SPANS_M: [f64; 2] = [1.0, 40.0];

/// Sections from the middle to the tip, spaced as a cosine; from this number on with the profile of the tip.
const STATIONS: usize = 8;
const TIP_FROM: usize = 7;

/// How far the leading edge lies behind, over what the chord is shorter: a straight line of places at two fifths of the chord.
const SWEEP: f64 = 0.4;

/// By how much the profile at the tip is thinner [%].
const THINNER_PERCENT: u32 = 2;

/// Half the distance of the risers [m].
const HALF_RISERS_M: f64 = 0.21;

/// Pilot and harness per flat area [kg/m²].
const PILOT_KG_M2: f64 = 3.9;

/// The least and most of that [kg/m²].
const PILOTS_KG_M2: [f64; 2] = [0.3, 12.0];

/// C_D A of pilot and harness [m²] of a mass [kg]; it grows as surfaces do with masses.
const PILOT_DRAG_AREA_M2: f64 = 0.45;
const OF_PILOT_KG: f64 = 95.0;

/// Cells between attached ribs, and how far apart that may bring these, over the chord in the middle: of rows of lines, of brakes. The sail does
/// not hold its shape between ribs that are farther apart.
const SPACING: [(usize, f64); 4] = [(4, 0.28), (3, 0.38), (2, 0.38), (1, f64::INFINITY)];
const BRAKE_SPACING: [(usize, f64); 4] = [(4, 0.4), (3, 0.4), (2, 0.4), (1, f64::INFINITY)];

/// Most lines that meet at a riser.
const MOST_MAIN_LINES: usize = 3;

/// Heights of the nodes of cascades of one, two and three levels, over the way from the riser to the wing.
const HEIGHTS: [&[f64]; 4] = [&[], &[0.75], &[0.75, 0.45], &[0.8, 0.55, 0.35]];
const BRAKE_HEIGHTS: [&[f64]; 4] = [&[], &[0.5], &[0.6, 0.35], &[0.65, 0.45, 0.25]];

/// Rows: name, place along the chord, width of diagonals at the upper seam over the chord.
const ROWS: [(&str, f64, f64); 3] = [("A", 0.1, 0.1), ("B", 0.32, 0.12), ("C", 0.6, 0.1)];

/// Edges along the chord and across a cell, tolerance of the fabric, panels along each side of a section.
const fn fineness(quality: Quality) -> ([usize; 2], f64, Option<usize>) {
    match quality {
        Quality::Draft => ([14, 2], 3e-2, Some(10)),
        Quality::Normal => ([24, 4], 3e-2, None),
        Quality::Fine => ([40, 8], 4e-2, None),
    }
}

/// All keys that follow from a design.
pub(super) fn derive(design: &WingDesign, case: &Table) -> Result<Keys, Problem> {
    let class = &Proportions::of(design.class);
    let aspect = design.aspect_ratio.unwrap_or(class.aspect_ratio);
    let aspect = within("wing.aspect_ratio", aspect, 2.5, 9.0)?;
    let span = length(TABLE, "span", [design.span_m, design.span_ft])?;
    let area = design.area_m2.map(|area| positive("wing.area_m2", area));
    let (span_m, area_m2) = match (span, area.transpose()?) {
        (Some(span), None) => {
            let span_m = span.within(SPANS_M[0], SPANS_M[1])?;
            (span_m, span_m * span_m / aspect)
        }
        (None, Some(area)) => {
            let [least, most] = SPANS_M.map(|span| span * span / aspect);
            let area = within("wing.area_m2", area, rounded(least), rounded(most))?;
            ((aspect * area).sqrt(), area)
        }
        (Some(span), Some(_)) => {
            return Err(Problem::new(
                "wing.area_m2",
                format!(
                    "{} and wing.area_m2 are both written, and each follows from the other with aspect_ratio",
                    span.key
                ),
                "keep one of the two",
            ));
        }
        (None, None) => return Err(absent("wing.span_m", "a wing has a flat span, or area_m2")),
    };
    let cells = design.cells.unwrap_or(class.cells);
    let cells = within("wing.cells", cells as f64, 6.0, 200.0)? as usize;
    let pilot = mass(TABLE, "pilot", [design.pilot_kg, design.pilot_lb])?;
    let altitude = altitude_m(TABLE, [design.altitude_m, design.altitude_ft])?;
    let mut keys = Keys::default();
    let title = format!(
        "Paraglider of {} m2 with {cells} cells, {}, in trim",
        rounded((10.0 * area_m2).round() / 10.0),
        class.name
    );
    keys.set("title", title, "area, cells, class");
    let chord_m = planform(design, class, (span_m, area_m2, cells), &mut keys)?;
    keys.set("structure.wing.cells", cells as i64, "cells");
    let hang = [
        class.hang_place * chord_m,
        HALF_RISERS_M,
        -class.height * span_m,
    ];
    let hang = hang.map(Value::from).to_vec();
    let why_hang = "class: place along the chord, height over the flat span";
    keys.set("structure.wing.hang_point_m", hang, why_hang);
    openings(class, cells, &mut keys);
    sewn_of(INTAKES[1], &mut keys);
    usual_ballooning(&mut keys);
    rows(cells, (span_m, chord_m), &mut keys);
    speed_bar(&mut keys);
    let quality = design.quality.unwrap_or(Quality::Normal);
    let [least, most] = pilots_kg(area_m2);
    let pilot_kg = pilot.map(|pilot| pilot.within(least, most)).transpose()?;
    // One that is written elsewhere than in the design has its own drag.
    let written = lookup(case, "equilibrium.trim.pilot_mass_kg").and_then(number);
    let pilots = [pilot_kg, written.filter(|mass| *mass > 0.0)];
    trim_of((area_m2, pilots), altitude, quality, &mut keys)?;
    Ok(keys)
}

/// The least and most that may hang on a wing of some area [kg].
fn pilots_kg(area_m2: f64) -> [f64; 2] {
    PILOTS_KG_M2.map(|per_area| per_area * area_m2)
}

/// Mesh, gravity, and the glide of a wing of some area with a pilot, or with as much as the area usually carries, who has the drag of another where one is told [m², kg].
pub(in crate::case) fn trim_of(
    (area_m2, [pilot_kg, drags_like_kg]): (f64, [Option<f64>; 2]),
    altitude_m: f64,
    quality: Quality,
    keys: &mut Keys,
) -> Result<(), Problem> {
    let (pilot_kg, why) = match pilot_kg {
        Some(mass) => (mass, "pilot"),
        None => (PILOT_KG_M2 * area_m2, "3.9 kg per m² of flat area"),
    };
    let [least, most] = pilots_kg(area_m2);
    let pilot_kg = within("wing.pilot_kg", pilot_kg, least, most)?;
    let ([along, across], tolerance, panels) = fineness(quality);
    keys.set("structure.wing.mesh.along_chord", along as i64, "quality");
    keys.set("structure.wing.mesh.across_cell", across as i64, "quality");
    let down = [0.0, 0.0, -STANDARD_GRAVITY_M_S2].map(Value::from).to_vec();
    keys.set("gravity.acceleration_m_s2", down, "standard gravity");
    keys.set("equilibrium.tolerance", tolerance, "quality");
    keys.set("equilibrium.evaluation_limit", 6000, "usual");
    let trim = |name: &str| format!("equilibrium.trim.{name}");
    let density = standard_density_kg_m3(altitude_m);
    let why_air = "standard atmosphere at its altitude";
    keys.set(trim("air_density_kg_m3"), density, why_air);
    keys.set(trim("pilot_mass_kg"), pilot_kg, why);
    let drag_area_m2 =
        PILOT_DRAG_AREA_M2 * (drags_like_kg.unwrap_or(pilot_kg) / OF_PILOT_KG).powf(2.0 / 3.0);
    let why = "0.45 m² of 95 kg, with the mass to the power of 2/3";
    keys.set(trim("pilot_drag_area_m2"), drag_area_m2, why);
    if let Some(panels) = panels {
        keys.set(trim("panels_per_side"), panels as i64, "quality");
    }
    Ok(())
}

/// Stations and profiles; returns the chord in the middle [m].
fn planform(
    design: &WingDesign,
    class: &Proportions,
    (span_m, area_m2, cells): (f64, f64, usize),
    keys: &mut Keys,
) -> Result<f64, Problem> {
    let thickness = design.thickness_percent.unwrap_or(class.thickness_percent);
    let thickness = within("wing.thickness_percent", f64::from(thickness), 10.0, 22.0)? as u32;
    // Chords are those of an ellipse upon a rectangle; between ribs the wing is straight.
    let chord_at = |place: f64| {
        let ellipse = (1.0 - place * place).max(0.0).sqrt();
        class.tip_chord + (1.0 - class.tip_chord) * ellipse
    };
    let spans = rib_spans_m(cells, 0.5 * span_m, class.tip_cell);
    let chords = |rib: f64| chord_at(2.0 * rib / span_m);
    let cell = |ribs: &[f64]| 0.5 * (ribs[1] - ribs[0]) * (chords(ribs[0]) + chords(ribs[1]));
    let chord_m = area_m2 / spans.windows(2).map(cell).sum::<f64>();
    let stations = (0..=STATIONS).map(|k| {
        let place = (FRAC_PI_2 * k as f64 / STATIONS as f64).sin();
        let chord = chord_m * chord_at(place);
        let profile = if k < TIP_FROM { "middle" } else { "tip" };
        let numbers = [
            ("span_m", 0.5 * span_m * place),
            ("chord_m", chord),
            ("sweep_m", SWEEP * (chord_m - chord)),
            (
                "roll_deg",
                class.tip_roll_deg * place.powf(class.roll_power),
            ),
            ("twist_deg", 0.0),
        ];
        let numbers = numbers.map(|(name, number)| (name.to_owned(), Value::from(rounded(number))));
        let mut station: Table = numbers.into_iter().collect();
        station.insert("profile".to_owned(), Value::from(profile));
        Value::Table(station)
    });
    let why = "span, area; class: chord at the tip, arc";
    keys.set("structure.wing.stations", stations.collect::<Vec<_>>(), why);
    for (name, percent) in [("middle", thickness), ("tip", thickness - THINNER_PERCENT)] {
        let key = format!("structure.wing.profiles.{name}.naca");
        keys.set(key, format!("24{percent:02}"), "thickness_percent");
    }
    Ok(chord_m)
}

/// Intake of the shipped wings, over the chord.
const INTAKES: [f64; 2] = [0.004, 0.03];

/// Widths of cells, mini-ribs, intakes.
fn openings(class: &Proportions, cells: usize, keys: &mut Keys) {
    let of = |name: &str| format!("structure.wing.{name}");
    keys.set(of("tip_cell_width_ratio"), class.tip_cell, "class");
    keys.set(of("mini_ribs_from"), 0.8, AS_SHIPPED);
    keys.set(of("intakes.from"), INTAKES[0], AS_SHIPPED);
    keys.set(of("intakes.to"), INTAKES[1], AS_SHIPPED);
    let closed = (cells as f64 / 12.0).round() as i64;
    keys.set(
        of("intakes.closed_tip_cells"),
        closed,
        "a twelfth of the cells",
    );
}

/// What follows the shipped wings.
const AS_SHIPPED: &str = "as of the shipped wings";
const SHIPPED: &str = "the shipped wings";

/// Holes of ribs, materials, and tapes along the rear edge of the intakes and at the trailing edge.
pub(in crate::case) fn sewn_of(intake_to: f64, keys: &mut Keys) {
    let of = |name: &str| format!("structure.wing.{name}");
    let hole = |position: f64, width: f64| {
        let numbers = [("position", position), ("width", width), ("height", 0.5)];
        let numbers = numbers.map(|(name, number)| (name.to_owned(), Value::from(number)));
        Value::Table(numbers.into_iter().collect())
    };
    let holes = vec![hole(0.2, 0.12), hole(0.45, 0.14)];
    keys.set(of("holes"), holes, AS_SHIPPED);
    materials(keys);
    for (name, position) in [("intake", intake_to), ("trailing_edge", 1.0)] {
        let of = |key: &str| format!("structure.wing.tapes.{name}.{key}");
        keys.set(of("side"), "lower", AS_SHIPPED);
        keys.set(of("position"), position, AS_SHIPPED);
        keys.set(of("sewn"), true, AS_SHIPPED);
        keys.set(of("material"), "tape", AS_SHIPPED);
    }
}

/// How far panels stand out between their ribs.
pub(in crate::case) fn usual_ballooning(keys: &mut Keys) {
    let upper = [
        [0.0, 0.02],
        [0.1, 0.06],
        [0.5, 0.05],
        [0.85, 0.02],
        [1.0, 0.0],
    ];
    let lower = [
        [0.0, 0.02],
        [0.1, 0.04],
        [0.5, 0.03],
        [0.85, 0.015],
        [1.0, 0.0],
    ];
    for (name, points) in [("upper", upper), ("lower", lower)] {
        let points = points.map(|point| Value::from(point.map(Value::from).to_vec()));
        let key = format!("structure.wing.ballooning.{name}");
        keys.set(key, points.to_vec(), AS_SHIPPED);
    }
}

/// Cloths, lines and webbing.
fn materials(keys: &mut Keys) {
    let why = "ripstop of 38 and 41 g/m², as of the shipped wings";
    for (part, numbers) in [
        ("upper", [5e-5, 760.0, 6e8, 0.15, 8e7, 0.03]),
        ("ribs", [5.5e-5, 745.0, 8e8, 0.15, 1.2e8, 0.03]),
    ] {
        let names = [
            "thickness_m",
            "density_kg_m3",
            "youngs_modulus_pa",
            "poisson_ratio",
            "shear_modulus_pa",
            "residual_stiffness",
        ];
        let constants = names.into_iter().zip(numbers);
        let constants = constants.map(|(name, number)| (name, Value::from(number), why));
        let table = format!("structure.wing.fabrics.{part}");
        keys.set_material(SHIPPED, &table, constants);
    }
    let why = "aramid and polyester as of the shipped wings";
    for (name, [diameter, mass, stiffness], strength) in [
        ("gallery", [0.0008, 0.00045, 25_000.0], Some(800.0)),
        ("main", [0.0015, 0.0013, 70_000.0], Some(2300.0)),
        ("webbing", [0.006, 0.015, 300_000.0], Some(9000.0)),
        ("tape", [0.002, 0.003, 20_000.0], None),
    ] {
        let constants = [
            ("diameter_m", Some(diameter)),
            ("mass_per_length_kg_m", Some(mass)),
            ("axial_stiffness_n", Some(stiffness)),
            ("breaking_load_n", strength),
        ];
        let constants = constants
            .into_iter()
            .filter_map(|(key, number)| Some((key, number?)));
        let constants = constants.map(|(key, number)| (key, Value::from(number), why));
        let table = format!("structure.wing.line_materials.{name}");
        keys.set_material(SHIPPED, &table, constants);
    }
}

/// Three rows of lines, and the brakes.
fn rows(cells: usize, (span_m, chord_m): (f64, f64), keys: &mut Keys) {
    // Ribs of a half count from 1 to the tip, which no line is attached to; 0 is one in the middle.
    let tip = cells.div_ceil(2);
    let width = span_m / cells as f64 / chord_m;
    let spacing = |known: &[(usize, f64)]| {
        let fits = |(step, most): &&(usize, f64)| *step as f64 * width <= *most && 2 * step < tip;
        known.iter().find(fits).map_or(1, |(step, _)| *step)
    };
    let step = spacing(&SPACING);
    // Beside a rib in the middle, or a cell there.
    let first = if cells.is_multiple_of(2) {
        (step - 1).max(1)
    } else {
        step.div_ceil(2)
    };
    let mut ribs: Vec<usize> = (first..tip).step_by(step).collect();
    // A tip that hangs on nothing for two cells folds.
    if ribs.last().is_none_or(|last| last + 1 < tip) {
        ribs.push(tip - 1);
    }
    let step = spacing(&BRAKE_SPACING);
    let braked: Vec<usize> = (step..tip).step_by(step).collect();
    let brakes = ("brake", 1.0, 0.0);
    for (name, position, diagonal) in ROWS.into_iter().chain([brakes]) {
        let is_brake = name == brakes.0;
        let of = |key: &str| format!("structure.wing.rows.{name}.{key}");
        let (ribs, heights) = if is_brake {
            (&braked, &BRAKE_HEIGHTS)
        } else {
            (&ribs, &HEIGHTS)
        };
        keys.set(of("position"), position, "three rows and brakes");
        let numbers: Vec<Value> = ribs.iter().map(|rib| Value::from(*rib as i64)).collect();
        keys.set(
            of("ribs"),
            numbers,
            "every one to fourth, so that they are not too far apart",
        );
        let levels = cascade(ribs.len(), heights);
        let why = "lines join in twos and threes, until three or fewer meet at the riser";
        keys.set(of("levels"), levels, why);
        let riser = if is_brake { 0.3 } else { 0.5 };
        keys.set(of("riser_length_m"), riser, "usual");
        keys.set(of("riser_material"), "webbing", "usual");
        if is_brake {
            keys.set(of("trim_m"), 0.1, "brakes hang loose");
        } else {
            keys.set(of("diagonals.foot"), 0.02, "usual");
            keys.set(of("diagonals.head"), diagonal, "usual");
        }
    }
}

/// By how much the bar shortens risers at full travel [m], row by row.
const SPEED_BAR: [(&str, f64); 3] = [("A", 0.07), ("B", 0.047), ("C", 0.023)];

fn speed_bar(keys: &mut Keys) {
    let shortening = SPEED_BAR.map(|(row, length)| (row.to_owned(), Value::from(length)));
    keys.set(
        "structure.wing.speed_bar.shortening_m",
        Value::Table(Table::from_iter(shortening)),
        "two thirds and one third of that of the A risers behind them; of 25 m² a wing of class D folds its nose in with a seventh more, one of class B with half as much again",
    );
}

/// Levels of lines from so many attachments down to the riser.
fn cascade(attached: usize, heights: &[&[f64]; 4]) -> Vec<Value> {
    let mut joins: Vec<Vec<usize>> = Vec::new();
    let mut above = attached;
    while above > MOST_MAIN_LINES && joins.len() + 1 < heights.len() {
        let pairs = above / 2;
        let mut level = vec![2; pairs];
        if !above.is_multiple_of(2) {
            level[pairs - 1] = 3;
        }
        joins.push(level);
        above = pairs;
    }
    let heights = heights[joins.len()];
    let material = |name: &str| ("material".to_owned(), Value::from(name));
    let level = |(joins, height): (&Vec<usize>, &f64)| {
        let joins: Vec<Value> = joins.iter().map(|n| Value::from(*n as i64)).collect();
        let joins = ("joins".to_owned(), Value::from(joins));
        let height = ("height".to_owned(), Value::from(*height));
        Value::Table(Table::from_iter([material("gallery"), joins, height]))
    };
    let mut levels: Vec<Value> = joins.iter().zip(heights).map(level).collect();
    levels.push(Value::Table(Table::from_iter([material("main")])));
    levels
}
