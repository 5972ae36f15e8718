//! Cloth, lines and tapes of a design, by their names.

use toml::{Table, Value};

use super::super::near::did_you_mean;
use super::super::problem::Problem;
use super::derived::Keys;
use crate::fabric::named::{CLOTHS, Cloth};
use crate::lines::named::{CORDS, Cord, TAPES};

/// Least strength of lines over their share of the opening load.
const SAFETY: f64 = 3.0;

/// Number in [`CORDS`] of the usual line of canopies up to so many metres.
const USUAL_CORDS: [(f64, usize); 2] = [(1.5, 0), (4.0, 1)];

/// The cloth of a design.
pub(super) fn cloth(table: &str, written: Option<&str>) -> Result<Cloth, Problem> {
    let found = named((table, "fabric"), written, &CLOTHS, |cloth| cloth.name)?;
    Ok(*found.unwrap_or(&CLOTHS[0]))
}

/// The tape of a design.
pub(super) fn tape(table: &str, written: Option<&str>) -> Result<Cord, Problem> {
    let found = named((table, "tapes"), written, &TAPES, |tape| tape.name)?;
    Ok(*found.unwrap_or(&TAPES[1]))
}

/// The cord of its lines, which together bear the opening load of a canopy of some diameter [m, 1, N]; and why.
pub(super) fn line(
    table: &str,
    written: Option<&str>,
    (diameter_m, count, load_n): (f64, usize, f64),
) -> Result<(Cord, String), Problem> {
    let count = count.max(1) as f64;
    let by_size = USUAL_CORDS.iter().find(|(most, _)| diameter_m <= *most);
    let weakest = by_size.map_or(2, |(_, cord)| *cord);
    let usual = (CORDS[weakest..].iter())
        .find(|cord| cord.strength_n() >= SAFETY * load_n / count)
        .unwrap_or(&CORDS[CORDS.len() - 1]);
    let cord = named((table, "lines"), written, &CORDS, |cord| cord.name)?;
    let cord = *cord.unwrap_or(usual);
    let times = cord.strength_n() * count / load_n;
    let why = format!(
        "{}, {:.0} N: {} times its share of an opening load of {load_n:.0} N{}",
        cord.name,
        cord.strength_n(),
        two_digits(times),
        if times < 1.0 { ", which tears it" } else { "" }
    );
    Ok((cord, why))
}

/// One decimal, or two digits where that is less than one.
fn two_digits(value: f64) -> String {
    let decimals = if value >= 0.95 {
        1.0
    } else {
        1.0 - value.log10().floor()
    };
    format!("{value:.*}", decimals.clamp(1.0, 9.0) as usize)
}

/// Weight, stiffness and permeability of the cloth.
pub(super) fn set_cloth(cloth: &Cloth, keys: &mut Keys) {
    let areal = cloth.areal_density_kg_m2();
    let of_cloth = cloth.source();
    let stiffness = "E times thickness as of the fabric of \"Effect of Shear Modulus on the Inflation Deformation of Parachutes\", by weight";
    let thickness_m = cloth.thickness_m();
    let density = areal / thickness_m;
    let law = Table::from_iter([("material".to_owned(), Value::from(cloth.specification))]);
    let constants = [
        ("thickness_m", thickness_m.into(), "2 mm per kg/m²"),
        ("density_kg_m3", density.into(), of_cloth),
        (
            "youngs_modulus_pa",
            cloth.youngs_modulus_pa().into(),
            stiffness,
        ),
        (
            "poisson_ratio",
            Cloth::POISSON_RATIO.into(),
            "the same fabric",
        ),
        ("permeability", law.into(), of_cloth),
    ];
    keys.set_material(cloth.name, "fabric", constants);
}

/// Section, density and stiffness of a cord or tape, in a table, and more that the table has; its size for the reason given.
pub(super) fn set_cord(
    table: &str,
    (cord, why): (&Cord, &str),
    more: &[(&'static str, f64, &'static str)],
    keys: &mut Keys,
) {
    let modulus = cord.youngs_modulus_pa();
    let constants = [
        ("area_m2", cord.area_m2(), why),
        ("density_kg_m3", Cord::DENSITY_KG_M3, "nylon"),
        ("youngs_modulus_pa", modulus, cord.source),
    ];
    let constants = constants.into_iter().chain(more.iter().copied());
    let constants = constants.map(|(name, number, why)| (name, number.into(), why));
    keys.set_material(cord.name, table, constants);
}

/// What has the name that is written; `None` where none is.
fn named<'a, T>(
    (table, key): (&str, &str),
    written: Option<&str>,
    all: &'a [T],
    name: impl Fn(&T) -> &'static str,
) -> Result<Option<&'a T>, Problem> {
    let Some(written) = written else {
        return Ok(None);
    };
    let found = all.iter().find(|one| name(one) == written);
    found.map(Some).ok_or_else(|| {
        let known: Vec<String> = all.iter().map(|one| format!("\"{}\"", name(one))).collect();
        Problem::new(
            format!("{table}.{key}"),
            format!("{table}.{key} = \"{written}\" is not known"),
            format!(
                "{}known are {}; a [{}] table gives constants of another one",
                did_you_mean(written, all.iter().map(&name)),
                known.join(", "),
                if key == "tapes" { "belts" } else { key }
            ),
        )
    })
}
