//! Checks of `[structure.wing.rods]`.

use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{positive, wing_key, within};
use crate::geometry::wing::plan::Rod;

/// Nylon (polyamide 6.6, dry): modulus of elasticity [Pa] and density [kg/m³].
const NYLON_MODULUS_PA: f64 = 2.8e9;
const NYLON_DENSITY_KG_M3: f64 = 1140.0;

/// Thickest rod [m].
const THICKEST_M: f64 = 0.05;

pub(super) fn check(table: &file::Wing) -> Result<Vec<Rod>, Problem> {
    let rods = table.rods.iter();
    rods.map(|(name, written)| check_one(table, name, written))
        .collect()
}

fn check_one(table: &file::Wing, name: &str, written: &file::Rod) -> Result<Rod, Problem> {
    let key = |what: &str| wing_key(&format!("rods.{name}.{what}"));
    let sides = [("upper", written.upper), ("lower", written.lower)];
    let [upper, lower] = sides.map(|(side, places)| {
        places
            .map(|places| check_places(&key(side), places))
            .transpose()
    });
    let sides = [upper?, lower?];
    let refuse = |at: String, message: &str| {
        let help = "give upper = [0.0, 0.1] and lower = [0.0, 0.06] for a rod around the nose, or one of them for a rod on one side";
        Err(Problem::new(&at, format!("{at}: {message}"), help))
    };
    let around = "a rod on both sides goes around the nose, and begins at 0 on each";
    match sides {
        [None, None] => return refuse(wing_key(&format!("rods.{name}")), "the rod has no place"),
        [Some([above, _]), Some(_)] if above > 0.0 => return refuse(key("upper"), around),
        [Some(_), Some([below, _])] if below > 0.0 => return refuse(key("lower"), around),
        _ => {}
    }
    let diameter_m = positive(&key("diameter_m"), written.diameter_m)?;
    let diameter_m = within(&key("diameter_m"), diameter_m, 0.0, THICKEST_M)?;
    let usual = |what: &str, written: Option<f64>, value: f64| {
        positive(&key(what), usual::or(key(what), written, value))
    };
    let modulus_pa = usual(
        "youngs_modulus_pa",
        written.youngs_modulus_pa,
        NYLON_MODULUS_PA,
    )?;
    let density_kg_m3 = usual("density_kg_m3", written.density_kg_m3, NYLON_DENSITY_KG_M3)?;
    let all = ribs(table.cells).collect();
    let ribs = usual::or(key("ribs"), written.ribs.clone(), all);
    check_ribs(&key("ribs"), table.cells, &ribs)?;
    let area_m2 = std::f64::consts::FRAC_PI_4 * diameter_m.powi(2);
    Ok(Rod {
        name: name.to_owned(),
        sides,
        // I = π d⁴/64
        flexural_rigidity_nm2: modulus_pa * area_m2 * diameter_m.powi(2) / 16.0,
        mass_per_length_kg_m: density_kg_m3 * area_m2,
        ribs,
    })
}

fn check_places(key: &str, [from, to]: [f64; 2]) -> Result<[f64; 2], Problem> {
    let places = [within(key, from, 0.0, 1.0)?, within(key, to, 0.0, 1.0)?];
    if to <= from {
        let message = format!("{key} = [{from}, {to}] does not grow");
        let help = "give places on that side, per chord, the one nearer to the nose first";
        return Err(Problem::new(key, message, help));
    }
    Ok(places)
}

/// Numbers of the ribs of a half, counted from the middle; without a rib there from 1.
fn ribs(cells: usize) -> std::ops::RangeInclusive<usize> {
    cells % 2..=cells.div_ceil(2)
}

fn check_ribs(key: &str, cells: usize, written: &[usize]) -> Result<(), Problem> {
    let all = ribs(cells);
    let help = format!(
        "name some of {} to {}, counted from the middle, each once",
        all.start(),
        all.end()
    );
    let refuse = |message: String| Err(Problem::new(key, message, help.as_str()));
    if written.is_empty() {
        return refuse(format!("{key} is empty"));
    }
    for (number, rib) in written.iter().enumerate() {
        if !all.contains(rib) {
            return refuse(format!("{key}: there is no rib {rib}"));
        }
        if written[..number].contains(rib) {
            return refuse(format!("{key}: rib {rib} is there twice"));
        }
    }
    Ok(())
}
