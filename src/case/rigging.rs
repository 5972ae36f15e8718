//! Checks of what a canopy hangs on and is folded like: `[lines]`, `[belts]`, the bands and `folding`.

use super::body::{Body, BodyKind, Canopy, LoadingPressure};
use super::cable_material::{check_material, check_tape};
use super::fabric::check_fabric;
use super::file::{self, CanopyCommon, File};
use super::problem::Problem;
use super::usual;
use super::usual_box;
use super::values::{LINE_DIAMETERS_M, absent, positive, vector, within};
use crate::geometry::parachute::designs::Shape;
use crate::geometry::parachute::sewn::{Cut, Folding, LinePlaces};
use crate::geometry::parachute::{self, BuildFault, Rigging, Risers};
use crate::lines::Cable;
use crate::lines::drag::LineDrag;

/// Most segments of a line.
const SEGMENT_LIMIT: usize = 200;

/// A canopy as written: the key of its table, what it is, and what all canopies have.
pub(super) struct Written<'a> {
    pub(super) key: &'a str,
    pub(super) cut: Cut,
    pub(super) common: CanopyCommon,
}

pub(super) const NEEDS_LINES: &str = "a canopy hangs on suspension lines";

/// Lines along each end of a cruciform canopy.
pub(super) fn lines_per_end(lines: &file::Lines) -> Result<usize, Problem> {
    if lines.count >= 8 && lines.count.is_multiple_of(4) && lines.count <= 400 {
        return Ok(lines.count / 4);
    }
    Err(Problem::new(
        "lines.count",
        format!(
            "lines.count = {} cannot be shared out over four ends",
            lines.count
        ),
        "give a multiple of 4, from 8 to 400: as many lines along each end, from corner to corner",
    ))
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
        return lines_per_end(lines).map(LinePlaces::Ends);
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
    for (key, is_written, is_used) in [
        ("vent_band", file.vent_band.is_some(), has_vent),
        (
            "vent_lines",
            file.vent_lines.is_some(),
            has_vent && !annular,
        ),
    ] {
        if is_written && !is_used {
            return Err(Problem::new(
                key,
                format!(
                    "[{key}] has no effect: the canopy has no vent{}",
                    if annular { " with lines" } else { "" }
                ),
                format!("remove [{key}], or give the canopy a vent (vent_diameter_m)"),
            ));
        }
    }
    let lines = file.vent_lines.as_ref();
    let lines = lines.map(|table| check_material("vent_lines", table));
    Ok([
        tape("skirt_band", file.skirt_band.as_ref())?,
        tape("vent_band", file.vent_band.as_ref())?,
        lines.transpose()?,
    ])
}

/// Belts or a band, where the case has them.
fn tape(key: &str, written: Option<&file::TapeMaterial>) -> Result<Option<Cable>, Problem> {
    written.map(|tape| check_tape(key, tape)).transpose()
}

/// The canopy as built and folded.
pub(super) fn rig(file: &File, written: &Written) -> Result<Body, Problem> {
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
        .ok_or_else(|| absent("lines", NEEDS_LINES))?;
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
        usual::or(key("folding.tilt_deg"), folding.tilt_deg, 0.0),
        -45.0,
        45.0,
    )?;
    let asymmetry = within(
        &key("folding.asymmetry"),
        usual::or(key("folding.asymmetry"), folding.asymmetry, 0.0),
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
    let line_segments = usual::or("lines.segments", lines.segments, 1);
    if !(1..=SEGMENT_LIMIT).contains(&line_segments) {
        return Err(Problem::new(
            "lines.segments",
            format!("lines.segments = {line_segments} is out of range"),
            format!("allowed are 1 to {SEGMENT_LIMIT} segments per line"),
        ));
    }
    let [skirt_band, vent_band, vent_lines] = check_bands(file, cut)?;
    let breaking = lines.breaking_load_n;
    let breaking = breaking.map(|load| positive("lines.breaking_load_n", load));
    let rigging = Rigging {
        cut: cut.clone(),
        fabric,
        belts: tape("belts", file.belts.as_ref())?,
        skirt_band,
        vent_band,
        vent_lines,
        lines: Cable {
            breaking_load_n: breaking.transpose()?,
            ..check_material("lines", &line_material)?
        },
        line_places,
        line_length_m: positive("lines.length_m", lines.length_m)?,
        line_slack_m: check_line_slack(lines)?,
        line_segments,
        risers: check_risers(lines)?,
        confluence_m: vector(
            &key("confluence_m"),
            common
                .confluence_m
                .ok_or_else(|| usual_box::unknown_place(&key("confluence_m")))?,
        )?,
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
    if let Some(drag) = check_line_drag(file, lines)? {
        structure.give_lines_drag(|_| drag);
    }
    Ok(Body {
        quality: built.quality,
        kind: BodyKind::Canopy(Canopy {
            nominal_area_m2: cut.nominal_area_m2(),
            nominal_diameter_m: cut.nominal_diameter_m(),
            canopy_node_count: built.canopy_node_count,
            apex: 0,
            lower_end: Some(built.lower_end),
            loading: Some(LoadingPressure {
                pressure_pa: positive(
                    &key("folding.loading_pressure_pa"),
                    folding.loading_pressure_pa,
                )?,
                opened_diameter_ratio,
            }),
        }),
        structure,
    })
}

fn check_risers(lines: &file::Lines) -> Result<Option<Risers>, Problem> {
    let count = usual::or("lines.riser_count", lines.riser_count, 1);
    if count == 0 || !lines.count.is_multiple_of(count) || count == lines.count {
        return Err(Problem::new(
            "lines.riser_count",
            format!(
                "lines.riser_count = {count} cannot share out {} lines",
                lines.count
            ),
            "give a divisor of lines.count, less than it: as many neighbouring lines join into each riser",
        ));
    }
    match lines.riser_length_m {
        Some(length) => Ok(Some(Risers {
            count,
            length_m: positive("lines.riser_length_m", length)?,
        })),
        None if count > 1 => Err(absent(
            "lines.riser_length_m",
            "lines.riser_count refers to it",
        )),
        None => Ok(None),
    }
}

/// Length that lines have beyond the one drawn \[m\]; negative for lines that are tight.
fn check_line_slack(lines: &file::Lines) -> Result<f64, Problem> {
    let slack_m = usual::or("lines.slack_m", lines.slack_m, 0.0);
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
        diameter_m: within(
            "lines.diameter_m",
            diameter_m,
            LINE_DIAMETERS_M[0],
            LINE_DIAMETERS_M[1],
        )?,
    }))
}
