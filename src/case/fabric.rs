//! Fabric: `[fabric]` and its permeability.

use super::density::density_kg_m3;
use super::file::{self, File, Structure};
use super::permeability;
use super::problem::Problem;
use super::usual;
use super::values::{absent, at_once, positive, within};
use crate::fabric::Fabric;
use crate::fabric::permeability::Permeability;

/// Checks `[fabric.permeability]`.
pub(super) fn check_permeability(file: &File) -> Result<Option<Permeability>, Problem> {
    let Some((fabric, table)) = file
        .fabric
        .as_ref()
        .and_then(|fabric| Some((fabric, fabric.permeability.as_ref()?)))
    else {
        return Ok(None);
    };
    let Some(air) = &file.air else {
        return Err(Problem::new(
            "fabric.permeability",
            "[fabric.permeability] has no effect: it needs [air]",
            "remove [fabric.permeability], or add [air]",
        ));
    };
    let density_kg_m3 = density_kg_m3(air)?;
    let thickness_m = Some(fabric.thickness_m);
    permeability::check("fabric.permeability", table, thickness_m, density_kg_m3).map(Some)
}

/// Share of compressive stiffness that fabric keeps if the case says nothing: with a thousandth, stiff inflated membranes lost 8 % of their
/// thickness to what slack fabric pushed with.
pub(super) const USUAL_RESIDUAL: f64 = 1e-5;

/// Checks `[fabric]`.
pub(super) fn check_fabric(file: &File) -> Result<Fabric, Problem> {
    let written = file
        .fabric
        .as_ref()
        .ok_or_else(|| absent("fabric", "the structure is made of fabric"))?;
    // What resists bending is compressed on one side.
    let is_plate = matches!(file.structure, Some(Structure::Plate(_)));
    check_fabric_at(
        "fabric",
        written,
        if is_plate { 1.0 } else { USUAL_RESIDUAL },
    )
}

/// Checks the fabric written in the table `key`; `usual_residual` is the share of compressive stiffness that it keeps if the case says nothing.
pub(super) fn check_fabric_at(
    key: &str,
    written: &file::Fabric,
    usual_residual: f64,
) -> Result<Fabric, Problem> {
    let key = |name: &str| format!("{key}.{name}");
    let warp_modulus_pa = positive(&key("youngs_modulus_pa"), written.youngs_modulus_pa)?;
    let weft_modulus_pa = positive(
        &key("weft_youngs_modulus_pa"),
        usual::or(
            key("weft_youngs_modulus_pa"),
            written.weft_youngs_modulus_pa,
            warp_modulus_pa,
        ),
    )?;
    let poisson_ratio = within(&key("poisson_ratio"), written.poisson_ratio, 0.0, 0.49)?;
    if poisson_ratio * poisson_ratio * weft_modulus_pa >= warp_modulus_pa {
        return Err(Problem::new(
            key("poisson_ratio"),
            "ν² E_weft ≥ E_warp: such a material would create energy",
            format!("lower {}", key("poisson_ratio")),
        ));
    }
    let isotropic = Fabric::isotropic_shear_modulus_pa(warp_modulus_pa, poisson_ratio);
    Ok(Fabric {
        thickness_m: positive(&key("thickness_m"), written.thickness_m)?,
        density_kg_m3: positive(&key("density_kg_m3"), written.density_kg_m3)?,
        warp_modulus_pa,
        weft_modulus_pa,
        poisson_ratio,
        shear_modulus_pa: positive(
            &key("shear_modulus_pa"),
            usual::or(key("shear_modulus_pa"), written.shear_modulus_pa, isotropic),
        )?,
        cubic_shear_compliance_1_pa3: written
            .cubic_shear_compliance_1_pa3
            .map(|cubic| {
                // With τ of some megapascals, α τ³ of some percent.
                within(&key("cubic_shear_compliance_1_pa3"), cubic, 1e-40, 1e-6)
            })
            .transpose()?,
        residual_stiffness: within(
            &key("residual_stiffness"),
            usual::or(
                key("residual_stiffness"),
                written.residual_stiffness,
                usual_residual,
            ),
            0.0,
            1.0,
        )?,
        initial_strain: check_initial_strain(&key("initial_strain"), written.initial_strain)?,
        yield_stress_pa: written
            .yield_stress_pa
            .map(|stress| positive(&key("yield_stress_pa"), stress))
            .transpose()?,
    })
}

/// Strains at which the initial state of fabric may lie: far beyond what any fabric bears.
const INITIAL_STRAIN: [f64; 2] = [-0.5, 0.5];

fn check_initial_strain(key: &str, written: Option<[f64; 2]>) -> Result<[f64; 2], Problem> {
    let strain = usual::or(key, written, [0.0; 2]);
    let [least, most] = INITIAL_STRAIN;
    for value in strain {
        at_once(|| within(key, value, least, most))?;
    }
    Ok(strain)
}
