//! A wing of LEparagliding as a case of ours: `leparagliding.txt` with its airfoil files becomes a plan and its trim (docs/leparagliding.md).
//!
//! The format is that of the program's manual (Casellas, Laboratori d'Envol, 2010 to 2026).

mod published;
mod read;
mod rods;
mod rows;
mod sections;
mod skin_tension;
mod speed;
mod vh_ribs;

use std::collections::BTreeMap;

use toml::{Table, Value};

pub use published::{Published, lines_m, rows_of_lines_m};
pub use sections::ReadFault;

use self::read::{CENTIMETRE_M, Drawing};
use self::vh_ribs::Piece;
use super::design::{Keys, commented, wing};
use super::file::Quality;
use crate::geometry::profile::Profile;

/// Why a wing cannot be brought in.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ImportFault {
    /// The file is not as it should be.
    #[error("{0}")]
    Read(#[from] ReadFault),
    /// The pilot does not suit the wing.
    #[error("the mass of the pilot (--pilot) does not suit the area of the wing: {0}")]
    Pilot(String),
    /// It is no wing of two skins.
    #[error("the wing is of type \"{0}\"; only \"ds\", of two skins, can be brought in")]
    Kind(String),
}

/// A wing that was brought in.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Its name in the file.
    pub name: String,
    /// The case.
    pub text: String,
    /// Airfoil files that it names.
    pub profiles: Vec<String>,
    /// What the file says and the plan does not.
    pub left_out: Vec<String>,
}

/// Thickness over the chord below which a profile stands for an edge that is sewn flat, and the profile that stands in its place.
const FLAT: f64 = 0.03;
const IN_PLACE_OF_FLAT: &str = "0006";

/// Reads the text of a `leparagliding.txt` and writes it as a case; `pilot_kg` hangs on the risers, 3.9 kg per m² if it is not given. `profile`
/// reads an airfoil file; `None` where it cannot be read.
///
/// # Errors
///
/// Where the text lacks a section, or the wing has one skin.
pub fn import(
    text: &str,
    pilot_kg: Option<f64>,
    profile: impl Fn(&str) -> Option<Profile>,
) -> Result<Imported, ImportFault> {
    let kind = read::kind(text)?;
    if kind != "ds" {
        return Err(ImportFault::Kind(kind));
    }
    let drawing = Drawing::read(text)?;
    let mut left_out = Vec::new();
    let vh_ribs = vh_ribs::read(text);
    let airfoils: Airfoils = (drawing.ribs.iter())
        .map(|rib| (rib.profile.as_str(), profile(&rib.profile)))
        .collect();
    let keys = keys((&drawing, &vh_ribs), pilot_kg, &airfoils, &mut left_out)?;
    let mut case = Table::from_iter([("version".to_owned(), Value::from(1))]);
    let derived = keys.put_into(&mut case);
    let mut profiles: Vec<String> = drawing.ribs.iter().map(|rib| rib.profile.clone()).collect();
    profiles.sort();
    profiles.dedup();
    profiles.retain(|file| !is_flat(&airfoils, file));
    Ok(Imported {
        text: commented(&case, &derived),
        name: drawing.name,
        profiles,
        left_out,
    })
}

/// The airfoil of a file's text; `None` where it cannot be read.
#[must_use]
pub fn airfoil(text: &str) -> Option<Profile> {
    Profile::parse(text).ok()
}

/// Airfoils by their files; `None`: it cannot be read.
type Airfoils<'a> = BTreeMap<&'a str, Option<Profile>>;

fn is_flat(airfoils: &Airfoils, file: &str) -> bool {
    let profile = airfoils.get(file).and_then(Option::as_ref);
    profile.is_some_and(|profile| profile.thickness() < FLAT)
}

fn keys(
    (drawing, vh_ribs): (&Drawing, &Result<Vec<Piece>, ReadFault>),
    pilot_kg: Option<f64>,
    airfoils: &Airfoils,
    left_out: &mut Vec<String>,
) -> Result<Keys, ImportFault> {
    let scale_m = CENTIMETRE_M * drawing.scale;
    let of = |name: &str| format!("structure.wing.{name}");
    let ribs = &drawing.ribs;
    let half = ribs.len();
    let cells = if drawing.has_middle_rib() {
        2 * (half - 1)
    } else {
        2 * half - 1
    };
    if drawing.cells != cells {
        left_out.push(format!(
            "the number of cells, {} in section 1: its ribs make {cells}",
            drawing.cells
        ));
    }
    let chord = |number: usize| ribs[number].edges[1] - ribs[number].edges[0];
    let mut keys = Keys::default();
    let title = format!("{}, a wing of LEparagliding, in trim", drawing.name);
    keys.set("title", title, "wing name");
    keys.set(of("cells"), cells as i64, "ribs");
    let places: Vec<Value> = ribs
        .iter()
        .map(|rib| Value::from(scale_m * rib.span))
        .collect();
    keys.set(of("rib_places_m"), places, "x-rib, section 1");
    let hang = [
        0.01 * drawing.calage * chord(0) * scale_m,
        0.5 * drawing.karabiners * CENTIMETRE_M,
        -(drawing.lines * scale_m + drawing.riser * CENTIMETRE_M),
    ];
    let why = "calage, karabiners, lengths of lines and risers, section 8";
    keys.set(of("hang_point_m"), hang.map(Value::from).to_vec(), why);
    stations(drawing, scale_m, &mut keys);
    let names: BTreeMap<&str, String> = profile_names(drawing);
    for (file, name) in &names {
        if is_flat(airfoils, file) {
            let key = of(&format!("profiles.{name}.naca"));
            keys.set(key, IN_PLACE_OF_FLAT, "in place of a flat one");
            left_out.push(format!(
                "{file} is flat, as of an edge that is sewn together: a symmetric profile of 6 % stands in its place"
            ));
        } else {
            let key = of(&format!("profiles.{name}.file"));
            keys.set(key, *file, "section 2");
        }
    }
    openings(drawing, &mut keys);
    wing::sewn_of(drawing.intake().map_or(0.03, |[_, to]| to), &mut keys);
    let middle = airfoils.get(&ribs[0].profile[..]).and_then(Option::as_ref);
    let tension = &drawing.skin_tension;
    skin_tension::derive(tension, middle, drawing.intake(), &mut keys, left_out);
    let as_drawn = vh_ribs::derive(vh_ribs, (drawing, scale_m), &mut keys, left_out);
    let risers = rows::derive(drawing, (scale_m, !as_drawn), &mut keys, left_out);
    let stand = (half, drawing.has_middle_rib());
    rods::derive(&drawing.rods, stand, &mut keys, left_out);
    let study = drawing.speed_study.as_ref();
    speed::derive(study, &risers, chord(0) * scale_m, &mut keys, left_out);
    let area_m2: f64 = (1..half)
        .map(|k| (chord(k - 1) + chord(k)) * (ribs[k].span - ribs[k - 1].span))
        .sum::<f64>()
        * scale_m
        * scale_m
        + 2.0 * chord(0) * ribs[0].span * scale_m * scale_m;
    wing::trim_of((area_m2, [pilot_kg, None]), 0.0, Quality::Normal, &mut keys)
        .map_err(|problem| ImportFault::Pilot(problem.help))?;
    left_out
        .push("holes of ribs, trimmers, and materials: usual ones stand in their place".to_owned());
    Ok(keys)
}

/// Names of the profiles, by their files.
fn profile_names(drawing: &Drawing) -> BTreeMap<&str, String> {
    let mut names = BTreeMap::new();
    for rib in &drawing.ribs {
        let next = names.len() + 1;
        names
            .entry(&rib.profile[..])
            .or_insert_with(|| format!("profile_{next}"));
    }
    names
}

/// A station at every rib.
fn stations(drawing: &Drawing, scale_m: f64, keys: &mut Keys) {
    let names = profile_names(drawing);
    let ribs = &drawing.ribs;
    let chord = |number: usize| ribs[number].edges[1] - ribs[number].edges[0];
    let [tip_deg, middle_deg] = drawing.washin_deg;
    let twist_deg = |number: usize| match drawing.washin_rule {
        0 => ribs[number].washin_deg,
        // As `lep-out.txt` lists it: by the chord, and at the tip what is asked for.
        _ if number + 1 == ribs.len() => tip_deg,
        rule => {
            let middle_deg = if rule == 2 { middle_deg } else { 0.0 };
            middle_deg + (tip_deg - middle_deg) * (1.0 - chord(number) / chord(0))
        }
    };
    let station = |number: usize, span: f64, lean_deg: f64| {
        let rib = &ribs[number];
        let numbers = [
            ("span_m", scale_m * span),
            ("chord_m", scale_m * chord(number)),
            ("sweep_m", scale_m * (rib.edges[0] - ribs[0].edges[0])),
            ("roll_deg", lean_deg),
            ("twist_deg", twist_deg(number)),
        ];
        let numbers = numbers.map(|(name, number)| (name.to_owned(), Value::from(number)));
        let mut station: Table = numbers.into_iter().collect();
        let profile = names[&rib.profile[..]].as_str();
        station.insert("profile".to_owned(), Value::from(profile));
        Value::Table(station)
    };
    // A cell in the middle has no rib there.
    let middle = (!drawing.has_middle_rib()).then(|| station(0, 0.0, 0.0));
    let others = (ribs.iter().enumerate()).map(|(number, rib)| {
        let lean_deg = if rib.span == 0.0 { 0.0 } else { rib.lean_deg };
        station(number, rib.span, lean_deg)
    });
    let all: Vec<Value> = middle.into_iter().chain(others).collect();
    let why = "sections 1 and 2; twist is the washin";
    keys.set("structure.wing.stations", all, why);
}

/// Intakes and mini-ribs.
fn openings(drawing: &Drawing, keys: &mut Keys) {
    let of = |name: &str| format!("structure.wing.{name}");
    let ribs = &drawing.ribs;
    let why = "section 2";
    if let Some([from, to]) = drawing.intake() {
        keys.set(of("intakes.from"), from, why);
        keys.set(of("intakes.to"), to, why);
        let closed = ribs.iter().rev().take_while(|rib| !rib.is_open).count();
        keys.set(of("intakes.closed_tip_cells"), closed as i64, why);
    }
    let mut lengths: Vec<f64> = ribs.iter().map(|rib| rib.mini_rib).collect();
    lengths.retain(|length| (5.0..=50.0).contains(length));
    lengths.sort_by(f64::total_cmp);
    if let Some(middle) = lengths.get(lengths.len() / 2) {
        keys.set(of("mini_ribs_from"), 1.0 - 0.01 * middle, why);
    }
}
