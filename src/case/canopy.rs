//! Checks of canopies: `[structure.flat_circular]` and its like, `[lines]`, `[belts]` and the bands.

use std::f64::consts::PI;

use super::Problem;
use super::file::{self, CanopyCommon, File};
use super::scene::{Body, BodyKind, Canopy, absent, positive, vector, within};
use super::structure::{check_fabric, check_material};
use crate::geometry::parachute::designs::{
    Design, DesignFault, RadialSlots, Shape, VIKING_DISK, VIKING_GAP,
};
use crate::geometry::parachute::gores::FlatCircular;
use crate::geometry::parachute::sewn::{Cut, Folding, LinePlaces};
use crate::geometry::parachute::{self, BuildFault, Rigging};
use crate::lines::Cable;
use crate::lines::drag::LineDrag;

/// Most segments of a line.
const SEGMENT_LIMIT: usize = 200;

/// How far the parts of a disk-gap-band canopy may miss the nominal area.
const AREA_TOLERANCE: f64 = 0.01;

/// A canopy as written: the key of its table, what it is, and what all canopies have.
struct Written {
    key: String,
    cut: Cut,
    common: CanopyCommon,
}

/// The canopy of a case, if it has one.
pub(super) fn check(file: &File) -> Result<Option<Body>, Problem> {
    let Some(table) = &file.structure else {
        return Ok(None);
    };
    let written = if let Some(t) = &table.flat_circular {
        flat_circular(t)
    } else if let Some(t) = &table.conical {
        conical(t)
    } else if let Some(t) = &table.slotted {
        slotted(t)
    } else if let Some(t) = &table.extended_skirt {
        extended_skirt(t)
    } else if let Some(t) = &table.annular {
        annular(t)
    } else if let Some(t) = &table.disk_gap_band {
        disk_gap_band(t)
    } else if let Some(t) = &table.cruciform {
        cruciform(t, file)
    } else {
        return Ok(None);
    };
    rig(file, &written?).map(Some)
}

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
            DesignFault::SlotWidth(_) => (
                "slot_width_m",
                "give narrower slots, or 0 for cuts along seams",
            ),
        };
        Problem::new(format!("{key}.{name}"), format!("[{key}]: {fault}"), help)
    })?;
    Ok(Cut::Gores(design, pattern))
}

fn flat_circular(t: &file::FlatCircular) -> Result<Written, Problem> {
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
    Ok(Written {
        key: key.to_owned(),
        cut,
        common: t.common(),
    })
}

fn cone_angle(key: &str, degrees: f64) -> Result<f64, Problem> {
    within(&format!("{key}.cone_angle_deg"), degrees, 0.0, 60.0).map(f64::to_radians)
}

fn conical(t: &file::Conical) -> Result<Written, Problem> {
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
    Ok(Written {
        key: key.to_owned(),
        cut: cut(key, design)?,
        common: t.common(),
    })
}

fn slotted(t: &file::Slotted) -> Result<Written, Problem> {
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
            cone_angle_rad: cone_angle(key, t.cone_angle_deg.unwrap_or(0.0))?,
            slots: Some(RadialSlots {
                count: t.slots,
                width_m: within(&width, t.slot_width_m, 0.0, 1e3)?,
                from_m: positive(&format!("{key}.slot_from_m"), t.slot_from_m)?,
                to_m: positive(&format!("{key}.slot_to_m"), t.slot_to_m)?,
            }),
        },
    };
    Ok(Written {
        key: key.to_owned(),
        cut: cut(key, design)?,
        common: t.common(),
    })
}

fn extended_skirt(t: &file::ExtendedSkirt) -> Result<Written, Problem> {
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
                t.skirt_width_ratio.unwrap_or(1.0),
                0.5,
                1.0,
            )?,
        },
    };
    Ok(Written {
        key: key.to_owned(),
        cut: cut(key, design)?,
        common: t.common(),
    })
}

fn annular(t: &file::Annular) -> Result<Written, Problem> {
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
    Ok(Written {
        key: key.to_owned(),
        cut: cut(key, design)?,
        common: t.common(),
    })
}

fn disk_gap_band(t: &file::DiskGapBand) -> Result<Written, Problem> {
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
        t.disk_diameter_m
            .unwrap_or(VIKING_DISK * nominal_diameter_m),
    )?;
    let gap_width_m = positive(
        &of("gap_width_m"),
        t.gap_width_m.unwrap_or(VIKING_GAP * nominal_diameter_m),
    )?;
    // Around a polygon of the disk's area.
    let half_gore = PI / count as f64;
    let around_m = disk_diameter_m * (PI * count as f64 * half_gore.tan()).sqrt();
    let disk_m2 = 0.25 * PI * disk_diameter_m * disk_diameter_m;
    let left_m = (nominal_area_m2 - disk_m2) / around_m - gap_width_m;
    let band_width_m = match t.band_width_m {
        None if left_m > 0.0 => left_m,
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
    Ok(Written {
        key: key.to_owned(),
        cut: cut(key, design)?,
        common: t.common(),
    })
}

fn cruciform(t: &file::Cruciform, file: &File) -> Result<Written, Problem> {
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
    let lines = file.lines.as_ref().map_or(0, |lines| lines.count);
    let design = Design {
        nominal_area_m2: width_m * (2.0 * length_m - width_m),
        gores: 4,
        rings: rings(key, t.rings)?,
        vent_diameter_m: None,
        shape: Shape::Cruciform {
            length_m,
            width_m,
            lines_per_end: lines / 4,
        },
    };
    Ok(Written {
        key: key.to_owned(),
        cut: cut(key, design)?,
        common: t.common(),
    })
}

/// Where the lines of a case are.
fn line_places(lines: &file::Lines, cut: &Cut) -> Result<LinePlaces, Problem> {
    let (gores, ends) = match cut {
        Cut::Circle(circle) => (circle.gores, false),
        Cut::Gores(design, _) => (
            design.gores,
            matches!(design.shape, Shape::Cruciform { .. }),
        ),
    };
    if ends {
        if lines.count >= 8 && lines.count.is_multiple_of(4) && lines.count <= 400 {
            return Ok(LinePlaces::Ends(lines.count / 4));
        }
        return Err(Problem::new(
            "lines.count",
            format!(
                "lines.count = {} cannot be shared out over four ends",
                lines.count
            ),
            "give a multiple of 4, from 8 to 400: as many lines along each end, from corner to corner",
        ));
    }
    if lines.count == gores {
        return Ok(LinePlaces::Seams);
    }
    if lines.count == 2 * gores {
        return Ok(LinePlaces::SeamsAndCentres);
    }
    let message = if lines.count == 0 {
        "lines.count = 0: nothing would hold the canopy".to_owned()
    } else {
        format!("lines.count = {} does not match {gores} gores", lines.count)
    };
    Err(Problem::new(
        "lines.count",
        message,
        format!(
            "give one line per seam: lines.count = {gores}, or one more on every centre line: {}",
            2 * gores
        ),
    ))
}

/// Bands and vent lines.
fn check_bands(file: &File, cut: &Cut) -> Result<[Option<Cable>; 3], Problem> {
    let has_vent = matches!(cut, Cut::Gores(design, _) if design.vent_diameter_m.is_some());
    let annular = matches!(cut, Cut::Gores(design, _) if design.shape == Shape::Annular);
    let tables = [
        ("skirt_band", &file.skirt_band, true),
        ("vent_band", &file.vent_band, has_vent),
        ("vent_lines", &file.vent_lines, has_vent && !annular),
    ];
    let mut found = [None, None, None];
    for ((key, table, is_used), found) in tables.into_iter().zip(&mut found) {
        let Some(table) = table else { continue };
        if !is_used {
            return Err(Problem::new(
                key,
                format!(
                    "[{key}] has no effect: the canopy has no vent{}",
                    if annular { " with lines" } else { "" }
                ),
                format!("remove [{key}], or give the canopy a vent (vent_diameter_m)"),
            ));
        }
        *found = Some(check_material(key, table)?);
    }
    Ok(found)
}

fn rig(file: &File, written: &Written) -> Result<Body, Problem> {
    let Written {
        key: table,
        cut,
        common,
    } = written;
    let key = |name: &str| format!("{table}.{name}");
    let fabric = check_fabric(file)?;
    let lines = file
        .lines
        .as_ref()
        .ok_or_else(|| absent("lines", "a canopy hangs on suspension lines"))?;
    let line_places = line_places(lines, cut)?;
    let line_material = file::CableMaterial {
        area_m2: lines.area_m2,
        density_kg_m3: lines.density_kg_m3,
        youngs_modulus_pa: lines.youngs_modulus_pa,
        force_strain: lines.force_strain.clone(),
        damping_n_s: lines.damping_n_s,
    };
    let folding = &common.folding;
    let folded_diameter_ratio = within(
        &key("folding.folded_diameter_ratio"),
        folding.folded_diameter_ratio,
        0.02,
        0.95,
    )?;
    let opened_diameter_ratio = within(
        &key("folding.opened_diameter_ratio"),
        folding.opened_diameter_ratio,
        folded_diameter_ratio,
        0.95,
    )?;
    let tilt_deg = within(
        &key("folding.tilt_deg"),
        folding.tilt_deg.unwrap_or(0.0),
        -45.0,
        45.0,
    )?;
    let asymmetry = within(
        &key("folding.asymmetry"),
        folding.asymmetry.unwrap_or(0.0),
        0.0,
        0.8,
    )?;
    if tilt_deg != 0.0 && common.apex_guide_n_m.is_some() {
        return Err(Problem::new(
            key("folding.tilt_deg"),
            "apex_guide_n_m would pull a tilted canopy back onto the axis",
            "remove folding.tilt_deg or apex_guide_n_m",
        ));
    }
    let line_segments = lines.segments.unwrap_or(1);
    if !(1..=SEGMENT_LIMIT).contains(&line_segments) {
        return Err(Problem::new(
            "lines.segments",
            format!("lines.segments = {line_segments} is out of range"),
            format!("allowed are 1 to {SEGMENT_LIMIT} segments per line"),
        ));
    }
    let [skirt_band, vent_band, vent_lines] = check_bands(file, cut)?;
    let rigging = Rigging {
        cut: cut.clone(),
        fabric,
        belts: file
            .belts
            .as_ref()
            .map(|belts| check_material("belts", belts))
            .transpose()?,
        skirt_band,
        vent_band,
        vent_lines,
        lines: check_material("lines", &line_material)?,
        line_places,
        line_length_m: positive("lines.length_m", lines.length_m)?,
        line_slack_m: check_line_slack(lines)?,
        line_segments,
        riser_length_m: lines
            .riser_length_m
            .map(|length| positive("lines.riser_length_m", length))
            .transpose()?,
        confluence_m: vector(&key("confluence_m"), common.confluence_m)?,
        folding: Folding {
            diameter_ratio: folded_diameter_ratio,
            asymmetry,
        },
        tilt_rad: tilt_deg.to_radians(),
        apex_guide_n_m: common
            .apex_guide_n_m
            .map(|k| positive(&key("apex_guide_n_m"), k))
            .transpose()?,
    };
    let built = parachute::build(&rigging).map_err(|fault| match fault {
        BuildFault::ShortLines => Problem::new(
            "lines.length_m",
            format!(
                "lines of {} m are too short for the folded skirt",
                lines.length_m
            ),
            "lengthen the lines, or fold tighter (folding.folded_diameter_ratio)",
        ),
        BuildFault::Folding => Problem::new(
            key("folding.folded_diameter_ratio"),
            format!(
                "{} = {folded_diameter_ratio}: {fault}",
                key("folding.folded_diameter_ratio")
            ),
            "fold tighter or wider, or with less asymmetry",
        ),
        BuildFault::Degenerate(_) => Problem::new(
            key("rings"),
            format!("{table}: {fault}"),
            "use another number of rings",
        ),
    })?;
    let mut structure = built.structure;
    structure.line_drag = check_line_drag(file, lines)?;
    Ok(Body {
        quality: built.quality,
        kind: BodyKind::Canopy(Canopy {
            nominal_area_m2: cut.nominal_area_m2(),
            nominal_diameter_m: cut.nominal_diameter_m(),
            canopy_node_count: built.canopy_node_count,
            lower_end: built.lower_end,
            apex_count: built.apex_count,
            opened_diameter_ratio,
            loading_pressure_pa: positive(
                &key("folding.loading_pressure_pa"),
                folding.loading_pressure_pa,
            )?,
        }),
        structure,
    })
}

/// Length that lines have beyond the one drawn \[m\]; negative for lines that are tight.
fn check_line_slack(lines: &file::Lines) -> Result<f64, Problem> {
    let slack_m = lines.slack_m.unwrap_or(0.0);
    within(
        "lines.slack_m",
        slack_m,
        -0.1 * lines.length_m,
        lines.length_m,
    )
}

fn check_line_drag(file: &File, lines: &file::Lines) -> Result<Option<LineDrag>, Problem> {
    let (coefficient, diameter_m) = match (lines.drag_coefficient, lines.diameter_m) {
        (None, None) => return Ok(None),
        (Some(coefficient), Some(diameter_m)) => (coefficient, diameter_m),
        (Some(_), None) => {
            return Err(absent(
                "lines.diameter_m",
                "lines.drag_coefficient refers to it",
            ));
        }
        (None, Some(_)) => {
            return Err(Problem::new(
                "lines.diameter_m",
                "lines.diameter_m has no effect: it needs lines.drag_coefficient",
                "add lines.drag_coefficient (about 1.1 for a round line), or remove the diameter",
            ));
        }
    };
    if file.air.is_none() {
        return Err(Problem::new(
            "lines.drag_coefficient",
            "lines.drag_coefficient has no effect: it needs [air]",
            "remove it and lines.diameter_m, or add [air]",
        ));
    }
    Ok(Some(LineDrag {
        coefficient: within("lines.drag_coefficient", coefficient, 0.01, 5.0)?,
        diameter_m: positive("lines.diameter_m", diameter_m)?,
    }))
}
