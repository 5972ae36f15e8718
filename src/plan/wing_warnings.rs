//! What a wing has that no paraglider, kite or ram-air parachute has: mostly a number in another unit.
//!
//! The ranges are wide on purpose. They leave out what would be meant, and catch a factor of a thousand, degrees for radians, and what is upside down. Usual values are orders of
//! magnitude as makers of wings, cloth and lines give them; nothing is computed with them.

use std::f64::consts::FRAC_PI_4;
use std::ops::RangeInclusive;

use crate::case::Scene;
use crate::case::wing::Wing;
use crate::fabric::Fabric;
use crate::geometry::wing::plan::{Level, Row};
use crate::trim::Settings;

/// Mass of pilot, wing and lines over the flat area [kg/m²]. Paragliders have 2.5 to 6, miniwings up to 10, ram-air parachutes up to 15.
const WING_LOADINGS_KG_M2: RangeInclusive<f64> = 0.5..=30.0;

/// Of the air, from high in the atmosphere to pressurised tunnels [kg/m³].
const AIR_DENSITIES_KG_M3: RangeInclusive<f64> = 0.01..=20.0;

/// From the Moon to Jupiter [m/s²].
const GRAVITIES_M_S2: RangeInclusive<f64> = 1.0..=30.0;

/// Drag area of a pilot over the flat area, at most.
const LARGEST_DRAG_AREA: f64 = 0.15;

/// Of cloth [kg/m²]; paragliders have 0.025 to 0.05.
const CLOTH_KG_M2: RangeInclusive<f64> = 0.005..=1.0;

/// Of cloth, by its threads: modulus times thickness [N/m].
const CLOTH_STIFFNESSES_N_M: RangeInclusive<f64> = 100.0..=1e8;

/// Mass of a line over the volume of its diameter [kg/m³]. Aramid and polyethylene have 970 to 1440 without the air between their fibres.
const LINE_DENSITIES_KG_M3: RangeInclusive<f64> = 100.0..=5000.0;

/// Breaking load of a line over its mass per length [N m/kg]. Fibres of aramid and polyethylene have some 2e6 to 4e6, covers and splices take some.
const LINE_STRENGTHS_NM_KG: RangeInclusive<f64> = 2e4..=6e6;

/// Largest roll of a station that reads like radians [degrees].
const ROLL_IN_RADIANS_DEG: f64 = 1.6;

/// Warnings of a wing, each with what to check.
pub(super) fn warnings(scene: &Scene) -> Vec<String> {
    let Some(wing) = scene.wing() else {
        return Vec::new();
    };
    let mut found = Vec::new();
    if let Some(trim) = &wing.trim {
        of_trim(scene, (wing, trim), &mut found);
    }
    found.extend(stands_above(wing));
    found.extend(roll(wing));
    let fabrics = &wing.plan.fabrics;
    for (name, fabric) in [
        ("upper", &fabrics.upper),
        ("lower", &fabrics.lower),
        ("ribs", &fabrics.ribs),
        ("diagonals", &fabrics.diagonals),
    ] {
        found.extend(of_cloth(name, fabric));
    }
    found.extend(rows(&wing.plan.rows));
    let mut known: Vec<&str> = Vec::new();
    for level in wing.plan.rows.iter().flat_map(|row| &row.levels) {
        if !known.contains(&level.material.as_str()) {
            known.push(&level.material);
            found.extend(of_lines(level));
        }
    }
    found
}

fn of_trim(scene: &Scene, (wing, trim): (&Wing, &Settings), found: &mut Vec<String>) {
    let area_m2 = wing.built.measures.flat_area_m2;
    let loading_kg_m2 = flying_mass_kg(scene, trim) / area_m2;
    if !WING_LOADINGS_KG_M2.contains(&loading_kg_m2) {
        found.push(format!(
            "the wing carries {loading_kg_m2:.3} kg per m2 of its flat area; paragliders have 2.5 to 6: check the sizes of the wing, and \
             equilibrium.trim.pilot_mass_kg"
        ));
    }
    let density = trim.density_kg_m3;
    if !AIR_DENSITIES_KG_M3.contains(&density) {
        found.push(format!(
            "the air of the trim has {density} kg/m3; at sea level it has 1.225: check equilibrium.trim.air_density_kg_m3"
        ));
    }
    if trim.pilot_drag_area_m2 > LARGEST_DRAG_AREA * area_m2 {
        found.push(format!(
            "the drag area of the pilot is {} m2, of a wing of {area_m2:.3} m2; pilots have 0.3 to 0.6: check equilibrium.trim.pilot_drag_area_m2",
            trim.pilot_drag_area_m2
        ));
    }
    if let Some(gravity) = scene.gravity_m_s2.map(glam::DVec3::length)
        && !GRAVITIES_M_S2.contains(&gravity)
    {
        found.push(format!(
            "gravity is {gravity} m/s2; on Earth it is 9.81: check gravity.acceleration_m_s2"
        ));
    }
}

/// Pilot, wing and lines.
pub(super) fn flying_mass_kg(scene: &Scene, trim: &Settings) -> f64 {
    let own = scene.body.iter().flat_map(|body| &body.structure.masses_kg);
    own.sum::<f64>() + trim.pilot_mass_kg
}

/// Lines that hang upwards.
fn stands_above(wing: &Wing) -> Option<String> {
    let frames = &wing.built.frames;
    let lowest_m = (frames.iter())
        .map(|frame| frame.quarter_m.z)
        .fold(f64::INFINITY, f64::min);
    let height_m = wing.plan.hang_point_m.z;
    (height_m > lowest_m).then(|| {
        format!(
            "structure.wing.hang_point_m stands {:.3} m above the lowest rib: z points upwards, and lines hang down",
            height_m - lowest_m
        )
    })
}

/// Stations turned by a degree, as if by radians.
fn roll(wing: &Wing) -> Option<String> {
    let rolls = wing.plan.stations.iter().map(|station| station.roll_rad);
    let largest_deg = rolls.map(f64::abs).fold(0.0, f64::max).to_degrees();
    (0.0 < largest_deg && largest_deg <= ROLL_IN_RADIANS_DEG).then(|| {
        format!(
            "stations roll by {largest_deg:.3} degrees at most, so that the wing is all but flat: roll_deg is in degrees, not in radians"
        )
    })
}

fn of_cloth(name: &str, fabric: &Fabric) -> Vec<String> {
    let key = format!("structure.wing.fabrics.{name}");
    let mut found = Vec::new();
    let mass = fabric.areal_density_kg_m2();
    if !CLOTH_KG_M2.contains(&mass) {
        found.push(format!(
            "{key} weighs {mass:.3e} kg/m2; cloth of paragliders weighs 0.025 to 0.05: check its thickness_m and density_kg_m3"
        ));
    }
    let stiffness = fabric.warp_modulus_pa.max(fabric.weft_modulus_pa) * fabric.thickness_m;
    if !CLOTH_STIFFNESSES_N_M.contains(&stiffness) {
        found.push(format!(
            "{key} has a stiffness of {stiffness:.3e} N/m along its threads; cloth has some 1e4 to 1e5: check its moduli and thickness_m"
        ));
    }
    found
}

/// Rows are told from the nose to the brakes, which have a place by themselves.
fn rows(rows: &[Row]) -> Option<String> {
    let behind = rows.windows(2).find(|pair| {
        let [front, rear] = [&pair[0], &pair[1]];
        let letters = front.name.len() == 1 && rear.name.len() == 1;
        letters && front.name < rear.name && front.position > rear.position
    })?;
    let [front, rear] = [&behind[0], &behind[1]];
    Some(format!(
        "row {} is sewn on at {} of the chord, before row {} at {}: rows go from the nose to the brakes in the order of their names",
        rear.name, rear.position, front.name, front.position
    ))
}

fn of_lines(level: &Level) -> Vec<String> {
    let key = format!("structure.wing.line_materials.{}", level.material);
    let cable = &level.cable;
    let mut found = Vec::new();
    let density = cable.density_kg_m3;
    let mass = density * cable.area_m2;
    if !LINE_DENSITIES_KG_M3.contains(&density) {
        found.push(format!(
            "{key} has {mass:.3e} kg/m and a diameter of {:.3e} m, which is {density:.3e} kg/m3; aramid and polyethylene have some 1000: check its \
             mass_per_length_kg_m and diameter_m",
            (cable.area_m2 / FRAC_PI_4).sqrt()
        ));
    }
    if let Some(load) = cable.breaking_load_n
        && !LINE_STRENGTHS_NM_KG.contains(&(load / mass))
    {
        found.push(format!(
            "{key} breaks at {load} N with {mass:.3e} kg/m; good fibres bear 2e6 to 4e6 N per kg/m: check its breaking_load_n and mass_per_length_kg_m"
        ));
    }
    found
}
