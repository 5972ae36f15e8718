//! Materials of cables: lines, belts, bands, tethers.

use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{at_once, positive};
use crate::lines::{Cable, CableLaw, ForceStrainTable};

/// Checks the material written in the table `key`.
pub(super) fn check_material(key: &str, material: &file::CableMaterial) -> Result<Cable, Problem> {
    let key = |name: &str| format!("{key}.{name}");
    let area_m2 = positive(&key("area_m2"), material.area_m2)?;
    let law = match (material.youngs_modulus_pa, &material.force_strain) {
        (Some(modulus), None) => CableLaw::Linear {
            axial_stiffness_n: area_m2 * positive(&key("youngs_modulus_pa"), modulus)?,
        },
        (None, Some(points)) => {
            let table = ForceStrainTable::new(points.clone()).map_err(|why| {
                Problem::new(
                    key("force_strain"),
                    format!("{} is no force–strain curve: {why}", key("force_strain")),
                    "give points [strain, force in N] that rise, such as [[0.01, 100.0], [0.03, 500.0]]",
                )
            })?;
            CableLaw::Table(table)
        }
        _ => {
            return Err(Problem::new(
                key("youngs_modulus_pa"),
                format!(
                    "needs exactly one of {} and {}",
                    key("youngs_modulus_pa"),
                    key("force_strain")
                ),
                "keep the modulus of a linear cable, or the table of a tensile test",
            ));
        }
    };
    let damping_n_s = usual::or(key("damping_n_s"), material.damping_n_s, 0.0);
    if damping_n_s != 0.0 {
        at_once(|| positive(&key("damping_n_s"), damping_n_s))?;
    }
    Ok(Cable {
        area_m2,
        density_kg_m3: positive(&key("density_kg_m3"), material.density_kg_m3)?,
        law,
        damping_n_s,
        breaking_load_n: None,
    })
}

/// Checks the material of belts or of a band.
pub(super) fn check_tape(key: &str, tape: &file::TapeMaterial) -> Result<Cable, Problem> {
    let material = file::CableMaterial {
        area_m2: tape.area_m2,
        density_kg_m3: tape.density_kg_m3,
        youngs_modulus_pa: tape.youngs_modulus_pa,
        force_strain: tape.force_strain.clone(),
        damping_n_s: tape.damping_n_s,
    };
    let breaking = tape.breaking_load_n;
    let breaking = breaking.map(|load| positive(&format!("{key}.breaking_load_n"), load));
    Ok(Cable {
        breaking_load_n: breaking.transpose()?,
        ..check_material(key, &material)?
    })
}
