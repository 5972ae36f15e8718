//! The structure of a case: `[structure]`. What kind it is, how canopies are cut, and what all kinds have in common.

use std::f64::consts::PI;

use glam::DVec3;

use super::body::{Body, BodyKind};
use super::fabric::{check_fabric, check_permeability};
use super::file::{self, File, Structure};
use super::mesh_examination::FromFiles;
use super::problem::Problem;
use super::rigging::{NEEDS_LINES, Written, lines_per_end, rig};
use super::values::{absent, positive, within};
use super::{contact, lep_sim, mesh, nodes, plate, specimens, usual, wing};
use crate::geometry::parachute::designs::{
    Design, DesignFault, RadialSlots, Shape, VIKING_DISK, VIKING_GAP,
};
use crate::geometry::parachute::gores::FlatCircular;
use crate::geometry::parachute::sewn::Cut;

/// Builds the structure of a case, if it has one; what is known of meshes of others is kept with the files.
pub(super) fn check(
    file: &File,
    files: &mut FromFiles,
    gravity: Option<DVec3>,
) -> Result<Option<Body>, Problem> {
    wing::check_loads(file)?;
    let Some(written) = &file.structure else {
        return Ok(None);
    };
    let mut body = build(file, written, files, gravity)?;
    nodes::check(file, &mut body, files)?;
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

/// Builds a structure of its kind.
fn build(
    file: &File,
    written: &Structure,
    files: &mut FromFiles,
    gravity: Option<DVec3>,
) -> Result<Body, Problem> {
    match written {
        Structure::FlatCircular(table) => flat_circular(file, table),
        Structure::Conical(table) => conical(file, table),
        Structure::Slotted(table) => slotted(file, table),
        Structure::ExtendedSkirt(table) => extended_skirt(file, table),
        Structure::Annular(table) => annular(file, table),
        Structure::DiskGapBand(table) => disk_gap_band(file, table),
        Structure::Ringslot(table) => ringslot(file, table),
        Structure::Cruciform(table) => cruciform(file, table),
        Structure::Sheet(table) => specimens::check_sheet(table, &check_fabric(file)?),
        Structure::Plate(table) => plate::check(table, &check_fabric(file)?),
        Structure::Cable(table) => specimens::check_cable(table, gravity),
        Structure::Mesh(table) => mesh::check(file, table, files),
        Structure::LepSim(table) => lep_sim::check(file, table, files),
        Structure::Airbag(table) => specimens::check_airbag(table, &check_fabric(file)?),
        Structure::Disc(table) => specimens::check_disc(table, &check_fabric(file)?),
        Structure::Coupon(table) => specimens::check_coupon(table, &check_fabric(file)?),
        Structure::Wing(table) => {
            let (wing, structure) = wing::check(file, table, files.folder)?;
            Ok(Body::at_rest(structure, BodyKind::Wing(Box::new(wing))))
        }
    }
}

/// How far the parts of a disk-gap-band canopy may miss the nominal area.
const AREA_TOLERANCE: f64 = 0.01;

fn gores(key: &str, gores: usize, what: &str) -> Result<usize, Problem> {
    if (3..=200).contains(&gores) {
        return Ok(gores);
    }
    Err(Problem::new(
        format!("{key}.gores"),
        format!("{key}.gores = {gores} is out of range"),
        format!("{what} has 3 to 200 gores"),
    ))
}

fn rings(key: &str, rings: usize) -> Result<usize, Problem> {
    if (2..=500).contains(&rings) {
        return Ok(rings);
    }
    Err(Problem::new(
        format!("{key}.rings"),
        format!("{key}.rings = {rings} is out of range"),
        "allowed are 2 to 500 rings of triangles; 12 is the least that folds well",
    ))
}

fn vent(key: &str, diameter_m: Option<f64>) -> Result<Option<f64>, Problem> {
    diameter_m
        .map(|d| positive(&format!("{key}.vent_diameter_m"), d))
        .transpose()
}

/// The pattern of a design, or which key is wrong with it.
fn cut(key: &str, design: Design) -> Result<Cut, Problem> {
    let pattern = design.pattern().map_err(|fault| {
        let (name, help) = match fault {
            DesignFault::Vent(_) if design.shape == Shape::Annular => {
                ("opening_diameter_m", "give a smaller opening")
            }
            DesignFault::Vent(_) => ("vent_diameter_m", "give a smaller vent"),
            DesignFault::Slots(..) => {
                ("slot_from_m", "choose slot_from_m and slot_to_m in between")
            }
            DesignFault::RingWidth(_) => (
                "slot_width_m",
                "give narrower or fewer slots, or a smaller vent",
            ),
            DesignFault::SlotWidth(_) => (
                "slot_width_m",
                "give narrower slots, or 0 for cuts along seams",
            ),
        };
        Problem::new(format!("{key}.{name}"), format!("[{key}]: {fault}"), help)
    })?;
    Ok(Cut::Gores(design, pattern))
}

fn flat_circular(file: &File, t: &file::FlatCircular) -> Result<Body, Problem> {
    let key = "structure.flat_circular";
    let nominal_area_m2 = positive(&format!("{key}.nominal_area_m2"), t.nominal_area_m2)?;
    let gores = gores(key, t.gores, "a flat circular canopy")?;
    let rings = rings(key, t.rings)?;
    let cut = match vent(key, t.vent_diameter_m)? {
        None => Cut::Circle(FlatCircular {
            nominal_area_m2,
            gores,
            rings,
        }),
        vent_diameter_m => cut(
            key,
            Design {
                nominal_area_m2,
                gores,
                rings,
                vent_diameter_m,
                shape: Shape::Conical {
                    cone_angle_rad: 0.0,
                    slots: None,
                },
            },
        )?,
    };
    let canopy = Written {
        key,
        cut,
        common: t.common(),
    };
    rig(file, &canopy)
}

fn cone_angle(key: &str, degrees: f64) -> Result<f64, Problem> {
    within(&format!("{key}.cone_angle_deg"), degrees, 0.0, 60.0).map(f64::to_radians)
}

fn conical(file: &File, t: &file::Conical) -> Result<Body, Problem> {
    let key = "structure.conical";
    let design = Design {
        nominal_area_m2: positive(&format!("{key}.nominal_area_m2"), t.nominal_area_m2)?,
        gores: gores(key, t.gores, "a conical canopy")?,
        rings: rings(key, t.rings)?,
        vent_diameter_m: vent(key, t.vent_diameter_m)?,
        shape: Shape::Conical {
            cone_angle_rad: cone_angle(key, t.cone_angle_deg)?,
            slots: None,
        },
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}

fn slotted(file: &File, t: &file::Slotted) -> Result<Body, Problem> {
    let key = "structure.slotted";
    let count = gores(key, t.gores, "a slotted canopy")?;
    if t.slots == 0 || !count.is_multiple_of(t.slots) {
        return Err(Problem::new(
            format!("{key}.slots"),
            format!("{key}.slots = {} does not divide {count} gores", t.slots),
            "slots lie along seams, evenly around the canopy: give a divisor of the number of gores",
        ));
    }
    let width = format!("{key}.slot_width_m");
    let design = Design {
        nominal_area_m2: positive(&format!("{key}.nominal_area_m2"), t.nominal_area_m2)?,
        gores: count,
        rings: rings(key, t.rings)?,
        vent_diameter_m: vent(key, t.vent_diameter_m)?,
        shape: Shape::Conical {
            cone_angle_rad: cone_angle(
                key,
                usual::or(format!("{key}.cone_angle_deg"), t.cone_angle_deg, 0.0),
            )?,
            slots: Some(RadialSlots {
                count: t.slots,
                width_m: within(&width, t.slot_width_m, 0.0, 1e3)?,
                from_m: positive(&format!("{key}.slot_from_m"), t.slot_from_m)?,
                to_m: positive(&format!("{key}.slot_to_m"), t.slot_to_m)?,
            }),
        },
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}

fn extended_skirt(file: &File, t: &file::ExtendedSkirt) -> Result<Body, Problem> {
    let key = "structure.extended_skirt";
    let of = |name: &str| format!("{key}.{name}");
    let design = Design {
        nominal_area_m2: positive(&of("nominal_area_m2"), t.nominal_area_m2)?,
        gores: gores(key, t.gores, "an extended-skirt canopy")?,
        rings: rings(key, t.rings)?,
        vent_diameter_m: vent(key, t.vent_diameter_m)?,
        shape: Shape::ExtendedSkirt {
            extension_ratio: within(&of("extension_ratio"), t.extension_ratio, 0.01, 0.5)?,
            skirt_width_ratio: within(
                &of("skirt_width_ratio"),
                usual::or(of("skirt_width_ratio"), t.skirt_width_ratio, 1.0),
                0.5,
                1.0,
            )?,
        },
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}

fn annular(file: &File, t: &file::Annular) -> Result<Body, Problem> {
    let key = "structure.annular";
    let of = |name: &str| format!("{key}.{name}");
    if t.apex_guide_n_m.is_some() {
        return Err(Problem::new(
            of("apex_guide_n_m"),
            "an annular canopy has no apex that could be guided",
            "remove apex_guide_n_m",
        ));
    }
    let design = Design {
        nominal_area_m2: positive(&of("nominal_area_m2"), t.nominal_area_m2)?,
        gores: gores(key, t.gores, "an annular canopy")?,
        rings: rings(key, t.rings)?,
        vent_diameter_m: Some(positive(&of("opening_diameter_m"), t.opening_diameter_m)?),
        shape: Shape::Annular,
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}

fn disk_gap_band(file: &File, t: &file::DiskGapBand) -> Result<Body, Problem> {
    let key = "structure.disk_gap_band";
    let of = |name: &str| format!("{key}.{name}");
    let nominal_area_m2 = match (t.nominal_area_m2, t.nominal_diameter_m) {
        (Some(area), None) => positive(&of("nominal_area_m2"), area)?,
        (None, Some(d)) => 0.25 * PI * positive(&of("nominal_diameter_m"), d)?.powi(2),
        _ => {
            return Err(Problem::new(
                of("nominal_area_m2"),
                format!("[{key}] needs exactly one of nominal_area_m2 and nominal_diameter_m"),
                "keep one of the two",
            ));
        }
    };
    let nominal_diameter_m = (4.0 * nominal_area_m2 / PI).sqrt();
    let count = gores(key, t.gores, "a disk-gap-band canopy")?;
    let disk_diameter_m = positive(
        &of("disk_diameter_m"),
        usual::or(
            of("disk_diameter_m"),
            t.disk_diameter_m,
            VIKING_DISK * nominal_diameter_m,
        ),
    )?;
    let gap_width_m = positive(
        &of("gap_width_m"),
        usual::or(
            of("gap_width_m"),
            t.gap_width_m,
            VIKING_GAP * nominal_diameter_m,
        ),
    )?;
    // Around a polygon of the disk's area.
    let half_gore = PI / count as f64;
    let around_m = disk_diameter_m * (PI * count as f64 * half_gore.tan()).sqrt();
    let disk_m2 = 0.25 * PI * disk_diameter_m * disk_diameter_m;
    let left_m = (nominal_area_m2 - disk_m2) / around_m - gap_width_m;
    let band_width_m = match t.band_width_m {
        None if left_m > 0.0 => usual::noted(of("band_width_m"), left_m),
        None => {
            return Err(Problem::new(
                of("disk_diameter_m"),
                format!(
                    "disk and gap take {:.4} m² of {nominal_area_m2:.4} m²: nothing is left for the band",
                    disk_m2 + around_m * gap_width_m
                ),
                "give a smaller disk or gap: the nominal area is that of disk, vent, gap and band",
            ));
        }
        Some(band) => {
            let band = positive(&of("band_width_m"), band)?;
            let area = disk_m2 + around_m * (gap_width_m + band);
            if (area / nominal_area_m2 - 1.0).abs() > AREA_TOLERANCE {
                return Err(Problem::new(
                    of("band_width_m"),
                    format!(
                        "disk, vent, gap and band have {area:.4} m², not the nominal {nominal_area_m2:.4} m²"
                    ),
                    format!(
                        "leave out band_width_m to take what is left ({left_m:.4} m), or correct the others"
                    ),
                ));
            }
            band
        }
    };
    let design = Design {
        nominal_area_m2,
        gores: count,
        rings: rings(key, t.rings)?,
        vent_diameter_m: vent(key, Some(t.vent_diameter_m))?,
        shape: Shape::DiskGapBand {
            disk_diameter_m,
            gap_width_m,
            band_width_m,
        },
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}

/// Most slots around a canopy.
const RINGSLOT_LIMIT: usize = 50;

/// Most tapes across a slot between two seams.
const TAPE_LIMIT: usize = 9;

fn tapes_per_gore(file: &File, key: &str, tapes: usize) -> Result<usize, Problem> {
    let key = format!("{key}.tapes_per_gore");
    if tapes > TAPE_LIMIT {
        return Err(Problem::new(
            key.as_str(),
            format!("{key} = {tapes} is out of range"),
            format!("across a slot lie 0 to {TAPE_LIMIT} tapes from seam to seam"),
        ));
    }
    if tapes > 0 && file.belts.is_none() {
        return Err(Problem::new(
            key.as_str(),
            format!("{key} = {tapes}, but the case has no [belts], of whose material tapes are"),
            format!("give [belts], or remove {key}"),
        ));
    }
    Ok(tapes)
}

fn ringslot(file: &File, t: &file::Ringslot) -> Result<Body, Problem> {
    let key = "structure.ringslot";
    let of = |name: &str| format!("{key}.{name}");
    if !(1..=RINGSLOT_LIMIT).contains(&t.slots) {
        return Err(Problem::new(
            of("slots"),
            format!("{key}.slots = {} is out of range", t.slots),
            format!("a ringslot canopy has 1 to {RINGSLOT_LIMIT} slots"),
        ));
    }
    let design = Design {
        nominal_area_m2: positive(&of("nominal_area_m2"), t.nominal_area_m2)?,
        gores: gores(key, t.gores, "a ringslot canopy")?,
        rings: rings(key, t.rings)?,
        vent_diameter_m: vent(key, Some(t.vent_diameter_m))?,
        shape: Shape::Ringslot {
            slots: t.slots,
            slot_width_m: positive(&of("slot_width_m"), t.slot_width_m)?,
            tapes_per_gore: {
                let tapes = usual::or(of("tapes_per_gore"), t.tapes_per_gore, 0);
                tapes_per_gore(file, key, tapes)?
            },
        },
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}

fn cruciform(file: &File, t: &file::Cruciform) -> Result<Body, Problem> {
    let key = "structure.cruciform";
    let of = |name: &str| format!("{key}.{name}");
    let length_m = positive(&of("length_m"), t.length_m)?;
    let width_m = positive(&of("width_m"), t.width_m)?;
    if length_m <= 1.05 * width_m {
        return Err(Problem::new(
            of("length_m"),
            format!("{key}: rectangles of {length_m} m by {width_m} m leave no arms"),
            "length_m is that of one whole rectangle, end to end: make it longer than width_m; 3 to 4 times is usual",
        ));
    }
    let lines_per_end = match &file.lines {
        Some(lines) => lines_per_end(lines)?,
        None => return Err(absent("lines", NEEDS_LINES)),
    };
    let design = Design {
        nominal_area_m2: width_m * (2.0 * length_m - width_m),
        gores: 4,
        rings: rings(key, t.rings)?,
        vent_diameter_m: None,
        shape: Shape::Cruciform {
            length_m,
            width_m,
            lines_per_end,
        },
    };
    let canopy = Written {
        key,
        cut: cut(key, design)?,
        common: t.common(),
    };
    rig(file, &canopy)
}
