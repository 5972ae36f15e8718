//! How a canopy is cut: its table below `[structure]`.

use std::f64::consts::PI;

use super::super::file::{CanopyDesign, CanopyType};
use super::super::problem::Problem;
use super::super::values::within;
use super::derived::Keys;
use super::scales::Scales;

/// Width of a gore at the skirt that is aimed at [m].
const GORE_WIDTH_M: f64 = 1.1;

/// Least share that a vent, slots or an extension may have [%]: smaller ones are fractions that were meant as such.
const LEAST_PERCENT: f64 = 0.5;

/// Name of the table below `[structure]`.
pub(super) const fn table(kind: CanopyType) -> &'static str {
    match kind {
        CanopyType::FlatCircular => "flat_circular",
        CanopyType::Conical => "conical",
        CanopyType::ExtendedSkirt => "extended_skirt",
        CanopyType::DiskGapBand => "disk_gap_band",
        CanopyType::Ringslot => "ringslot",
        CanopyType::Cruciform => "cruciform",
    }
}

/// Gores of a canopy, or `None` of a cruciform one.
pub(super) fn gores(design: &CanopyDesign, scales: &Scales) -> Option<usize> {
    let usual = 2 * (0.5 * PI * scales.diameter_m / GORE_WIDTH_M).round() as usize;
    (design.kind != CanopyType::Cruciform).then(|| design.gores.unwrap_or(usual.clamp(8, 64)))
}

/// Suspension lines.
pub(super) fn line_count(design: &CanopyDesign, gores: Option<usize>) -> usize {
    design.line_count.or(gores).unwrap_or(16)
}

/// Refuses keys that the type has no use for.
fn refuse_unused(design: &CanopyDesign) -> Result<(), Problem> {
    let is = |kind: CanopyType| design.kind == kind;
    for (key, written, used, what) in [
        (
            "cone_angle_deg",
            design.cone_angle_deg.is_some(),
            is(CanopyType::Conical),
            "a conical canopy",
        ),
        (
            "extension_percent",
            design.extension_percent.is_some(),
            is(CanopyType::ExtendedSkirt),
            "an extended skirt",
        ),
        (
            "arm_width_ratio",
            design.arm_width_ratio.is_some(),
            is(CanopyType::Cruciform),
            "a cruciform canopy",
        ),
        (
            "slots",
            design.slots.is_some(),
            is(CanopyType::Ringslot),
            "a ringslot canopy",
        ),
        (
            "slot_percent",
            design.slot_percent.is_some(),
            is(CanopyType::Ringslot),
            "a ringslot canopy",
        ),
        (
            "gores",
            design.gores.is_some(),
            !is(CanopyType::Cruciform),
            "a canopy of gores",
        ),
        (
            "vent_percent",
            design.vent_percent.is_some(),
            !is(CanopyType::Cruciform),
            "a canopy of gores",
        ),
    ] {
        if written && !used {
            return Err(Problem::new(
                format!("canopy.{key}"),
                format!("canopy.{key} has no effect: only {what} has it"),
                format!("remove {key}"),
            ));
        }
    }
    Ok(())
}

/// Area, gores, vent and what else the cut needs.
pub(super) fn derive(
    design: &CanopyDesign,
    scales: &Scales,
    rings: usize,
    keys: &mut Keys,
) -> Result<(), Problem> {
    refuse_unused(design)?;
    let table = table(design.kind);
    let of = |name: &str| format!("structure.{table}.{name}");
    let percent = |key: &str, written: Option<f64>, usual: f64, most: f64| {
        let key = format!("canopy.{key}");
        let value = within(&key, written.unwrap_or(usual), 0.0, most)?;
        if value > 0.0 && value < LEAST_PERCENT {
            return Err(Problem::new(
                key.as_str(),
                format!("{key} = {value} is less than {LEAST_PERCENT} per cent"),
                format!(
                    "write per cent, not a fraction: {} for that share",
                    100.0 * value
                ),
            ));
        }
        Ok(value)
    };
    if design.kind == CanopyType::Cruciform {
        let ratio = design.arm_width_ratio.unwrap_or(0.27);
        let ratio = within("canopy.arm_width_ratio", ratio, 0.1, 0.9)?;
        let length_m = (scales.area_m2 / (ratio * (2.0 - ratio))).sqrt();
        let why = "S_0 = width · (2 length − width), arm_width_ratio";
        keys.set(of("length_m"), length_m, why);
        keys.set(of("width_m"), ratio * length_m, why);
        keys.set(of("rings"), rings as i64, "quality");
        return Ok(());
    }
    keys.set(of("nominal_area_m2"), scales.area_m2, "π/4 D_0²");
    let gores = gores(design, scales).unwrap_or_default();
    let why = match design.gores {
        Some(_) => "gores",
        None => "gores of about 1.1 m at the skirt, 8 to 64",
    };
    keys.set(of("gores"), gores as i64, why);
    let usual_vent = match design.kind {
        CanopyType::Ringslot => 10.0,
        CanopyType::DiskGapBand => 7.0,
        _ => 0.0,
    };
    let vent = percent("vent_percent", design.vent_percent, usual_vent, 50.0)?;
    let vent_m = 0.01 * vent * scales.diameter_m;
    if vent > 0.0 || usual_vent > 0.0 {
        keys.set(of("vent_diameter_m"), vent_m, "vent_percent of D_0");
    }
    let (mut rings, mut why_rings) = (rings, "quality");
    match design.kind {
        CanopyType::Conical => {
            let angle = design.cone_angle_deg.unwrap_or(25.0);
            keys.set(of("cone_angle_deg"), angle, "cone_angle_deg");
        }
        CanopyType::ExtendedSkirt => {
            let percent = percent("extension_percent", design.extension_percent, 10.0, 50.0)?;
            keys.set(of("extension_ratio"), 0.01 * percent, "extension_percent");
        }
        CanopyType::Ringslot => {
            let slots = design.slots.unwrap_or(6);
            let share = 0.01 * percent("slot_percent", design.slot_percent, 15.0, 50.0)?;
            keys.set(of("slots"), slots as i64, "slots");
            let width_m = slot_width_m(scales, gores, slots, vent_m, share);
            keys.set(of("slot_width_m"), width_m, "slot_percent of S_0");
            keys.set(of("tapes_per_gore"), TAPES_PER_GORE, "usual");
            let least = 2 * (slots + 1);
            if least > rings {
                (rings, why_rings) = (
                    least,
                    "two across the fabric between slots, which is more than quality asks for",
                );
            }
        }
        CanopyType::FlatCircular | CanopyType::DiskGapBand | CanopyType::Cruciform => {}
    }
    keys.set(of("rings"), rings as i64, why_rings);
    Ok(())
}

/// Tapes across a slot from seam to seam. *Our choice*: slots of 15 % of the area then open to 1.2 times their width, without any to twice (docs/results/2026-11-29-narrow-openings.md).
const TAPES_PER_GORE: i64 = 3;

/// Width of slots that together have a share of the nominal area. The middles of evenly spaced slots lie, in the mean, halfway between vent and
/// skirt.
fn slot_width_m(scales: &Scales, gores: usize, slots: usize, vent_m: f64, share: f64) -> f64 {
    let gores_slope = gores as f64 * (PI / gores as f64).tan();
    let reach = |area_m2: f64| (area_m2 / gores_slope).sqrt();
    let [start, end] = [0.25 * PI * vent_m * vent_m, scales.area_m2].map(reach);
    share * scales.area_m2 / (gores_slope * slots as f64 * (start + end))
}
