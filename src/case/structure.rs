//! Checks of `[structure]` and `[fabric]`, and the building of the structure; canopies in [`super::canopy`].

use glam::DVec3;

use super::file::{self, File};
use super::mesh_examination::FromFiles;
use super::scene::{Body, BodyKind, absent, positive, vector, within};
use super::wing::{self, Wing};
use super::{Problem, usual};
use super::{canopy, contact, descent, lep_sim, mesh, permeability, plate, specimens};
use crate::fabric::Fabric;
use crate::fabric::permeability::Permeability;
use crate::geometry::mesh::quality;
use crate::geometry::{cable, sheet};
use crate::lines::{Cable, CableLaw, ForceStrainTable};

/// Most cells of a sheet: some 5 GB.
const SHEET_CELL_LIMIT: usize = 4_000_000;

/// Builds the structure of a case, if it has one; what else is known of meshes and wings of other programs is kept with the files.
pub(super) fn check(
    file: &File,
    files: &mut FromFiles,
    gravity: Option<DVec3>,
    wing: Option<&mut Wing>,
) -> Result<Option<Body>, Problem> {
    let Some(table) = &file.structure else {
        return Ok(None);
    };
    let shapes = [
        table.flat_circular.is_some(),
        table.conical.is_some(),
        table.slotted.is_some(),
        table.extended_skirt.is_some(),
        table.annular.is_some(),
        table.disk_gap_band.is_some(),
        table.cruciform.is_some(),
        table.sheet.is_some(),
        table.plate.is_some(),
        table.cable.is_some(),
        table.mesh.is_some(),
        table.lep_sim.is_some(),
        table.airbag.is_some(),
        table.disc.is_some(),
        table.coupon.is_some(),
        table.wing.is_some(),
    ];
    let body = if shapes.into_iter().filter(|is_there| *is_there).count() != 1 {
        None
    } else if table.is_drawn_canopy() {
        canopy::check(file)?
    } else if let Some(sheet) = &table.sheet {
        Some(check_sheet(file, sheet)?)
    } else if let Some(written) = &table.plate {
        Some(plate::check(written, &check_fabric(file)?)?)
    } else if let Some(cable) = &table.cable {
        Some(check_cable(cable, gravity)?)
    } else if let Some(written) = &table.mesh {
        Some(mesh::check(file, written, files)?)
    } else if let Some(written) = &table.lep_sim {
        Some(lep_sim::check(file, written, files)?)
    } else if let Some(airbag) = &table.airbag {
        Some(specimens::check_airbag(airbag, &check_fabric(file)?)?)
    } else if let Some(disc) = &table.disc {
        Some(specimens::check_disc(disc, &check_fabric(file)?)?)
    } else if let Some(coupon) = &table.coupon {
        Some(specimens::check_coupon(coupon, &check_fabric(file)?)?)
    } else {
        wing.map(wing::body)
    };
    let mut body = body.ok_or_else(|| {
        Problem::new(
            "structure",
            "[structure] needs exactly one shape",
            "keep or add just one canopy ([structure.flat_circular], docs/canopies.md) or one of [structure.sheet], [structure.plate], [structure.cable], [structure.mesh], [structure.lep_sim], \
             [structure.airbag], [structure.disc], [structure.coupon], [structure.wing]",
        )
    })?;
    body.structure.permeability = check_permeability(file)?;
    let moves = file.time.is_some() || file.air.is_some();
    body.structure.check(moves).map_err(|fault| {
        Problem::new(
            "structure",
            format!("the structure cannot be solved: {fault} (numbers count from 0)"),
            "mend the mesh or the lengths, or hold the node",
        )
    })?;
    contact::check(file, &mut body)?;
    Ok(Some(body))
}

fn check_permeability(file: &File) -> Result<Option<Permeability>, Problem> {
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
    let density_kg_m3 = descent::density_kg_m3(air)?;
    let thickness_m = Some(fabric.thickness_m);
    permeability::check("fabric.permeability", table, thickness_m, density_kg_m3).map(Some)
}

/// Share of compressive stiffness that fabric keeps if the case says nothing: with a thousandth, stiff inflated membranes lost 8 % of their
/// thickness to what slack fabric pushed with.
pub(super) const USUAL_RESIDUAL: f64 = 1e-5;

pub(super) fn check_fabric(file: &File) -> Result<Fabric, Problem> {
    let written = file
        .fabric
        .as_ref()
        .ok_or_else(|| absent("fabric", "the structure is made of fabric"))?;
    // What resists bending is compressed on one side.
    let is_plate = file.structure.as_ref().is_some_and(|s| s.plate.is_some());
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
        within(key, value, least, most)?;
    }
    Ok(strain)
}

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
        positive(&key("damping_n_s"), damping_n_s)?;
    }
    Ok(Cable {
        area_m2,
        density_kg_m3: positive(&key("density_kg_m3"), material.density_kg_m3)?,
        law,
        damping_n_s,
    })
}

fn check_sheet(file: &File, written: &file::Sheet) -> Result<Body, Problem> {
    const KEY: &str = "structure.sheet";
    let key = |name: &str| format!("{KEY}.{name}");
    let fabric = check_fabric(file)?;
    for size in written.size_m {
        positive(&key("size_m"), size)?;
    }
    let [across, down] = written.divisions;
    let in_range = |n: usize| (1..=5_000).contains(&n);
    if !in_range(across) || !in_range(down) || across * down > SHEET_CELL_LIMIT {
        return Err(Problem::new(
            key("divisions"),
            format!(
                "{} = {:?} is out of range",
                key("divisions"),
                written.divisions
            ),
            format!("allowed are 1 to 5000 cells along each side, and {SHEET_CELL_LIMIT} in all"),
        ));
    }
    let hung_width_m = within(
        &key("hung_width_m"),
        written.hung_width_m,
        0.05 * written.size_m[0],
        written.size_m[0],
    )?;
    let shape = sheet::SheetShape {
        size_m: written.size_m,
        divisions: written.divisions,
        corner_m: vector(&key("corner_m"), written.corner_m)?,
        across: DVec3::X,
        down: -DVec3::Z,
    };
    let mut structure = sheet::build(&shape, &fabric, written.model).ok_or_else(|| {
        Problem::new(
            key("divisions"),
            "the cells of the spring network are too elongated for this shear modulus: a spring would push on its own",
            "make the cells squarer, or use model = \"membrane\"",
        )
    })?;
    let positions = structure.positions_m.clone();
    let [width, height] = written.size_m;
    // Gather the width in a smooth bulge, so that the start is neither flat nor torn.
    let ratio = hung_width_m / width;
    let bulge = width * (0.5 * (1.0 - ratio * ratio)).max(0.0).sqrt() / std::f64::consts::PI;
    for (place, rest) in structure.positions_m.iter_mut().zip(&positions) {
        let s = (rest.x - shape.corner_m.x) / width;
        let t = (shape.corner_m.z - rest.z) / height;
        *place = DVec3::new(
            shape.corner_m.x + s * hung_width_m,
            rest.y + bulge * (std::f64::consts::PI * s).sin() * (1.0 + 0.2 * t),
            rest.z,
        );
    }
    for corner in [shape.node(0, 0), shape.node(written.divisions[0], 0)] {
        structure.held[corner as usize] = true;
    }
    let triangles: Vec<[u32; 3]> = structure.triangles.iter().map(|t| t.nodes).collect();
    Ok(Body {
        quality: quality::measure(&positions, &triangles),
        kind: BodyKind::Sheet,
        structure,
    })
}

fn check_cable(written: &file::HangingCable, gravity: Option<DVec3>) -> Result<Body, Problem> {
    const KEY: &str = "structure.cable";
    let material = check_material(&format!("{KEY}.material"), &written.material)?;
    let ends = [
        vector(&format!("{KEY}.ends_m"), written.ends_m[0])?,
        vector(&format!("{KEY}.ends_m"), written.ends_m[1])?,
    ];
    let span_m = ends[0].distance(ends[1]);
    let length_m = positive(&format!("{KEY}.length_m"), written.length_m)?;
    if length_m <= span_m {
        return Err(Problem::new(
            format!("{KEY}.length_m"),
            format!("a cable of {length_m} m does not reach over {span_m} m"),
            "make the cable longer than the distance of its ends",
        ));
    }
    if !(2..=100_000).contains(&written.segments) {
        return Err(Problem::new(
            format!("{KEY}.segments"),
            format!("{KEY}.segments = {} is out of range", written.segments),
            "allowed are 2 to 100000 segments",
        ));
    }
    let weight_n_m = material.mass_per_length_kg_m() * gravity.map_or(0.0, DVec3::length);
    Ok(Body {
        structure: cable::build(ends, length_m, written.segments, &material),
        quality: None,
        kind: BodyKind::Cable {
            span_m,
            length_m,
            weight_n_m,
        },
    })
}
