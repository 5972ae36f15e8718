//! What a careful engineer would say about a scene before it runs.

use super::{Plan, wing_warnings};
use crate::case::Scene;
use crate::case::scene::{BodyKind, Flow};

/// Shape quality below which triangles slow the solver down.
const POOR_SHAPE: f64 = 0.1;

/// Tolerance of the static equilibrium below which a device's arithmetic may not reach: the shipped chain was measured to stall at
/// 6e-6.
const DEVICE_TOLERANCE: f64 = 1e-5;

/// Share of the section that a body may block before its drag wants more than a small correction. A canopy is counted with its nominal
/// area S_0, about twice of what it projects when inflated.
const BLOCKAGE_LIMIT: f64 = 0.1;

/// Area of a canopy's fabric over S_0 as designs have it: vents, gaps and slots take some, fullness adds some.
const FABRIC_SHARES: std::ops::RangeInclusive<f64> = 0.6..=1.1;

/// Mass of a canopy over the area of its fabric that is not remarked upon [kg/m²].
const AREAL_DENSITIES_KG_M2: std::ops::RangeInclusive<f64> = 0.005..=3.0;

impl Plan {
    /// Warnings, each with its remedy.
    #[must_use]
    pub fn warnings(&self, scene: &Scene) -> Vec<String> {
        let mut warnings = Vec::new();
        warnings.extend(blockage(scene));
        warnings.extend(nominal_area(scene));
        warnings.extend(mass_of_fabric(scene));
        warnings.extend(wing_warnings::warnings(scene));
        warnings.extend(self.device_tolerance(scene));
        warnings.extend(late_pictures(scene));
        warnings.extend(
            self.evaluations
                .and_then(|known| known.warning(self.evaluation_limit)),
        );
        let quality = scene.body.as_ref().and_then(|body| body.quality);
        if scene.fabric_is_solved() && quality.is_some_and(|q| q.smallest_shape < POOR_SHAPE) {
            let remedy = if scene.wing().is_some() {
                "use more edges across a cell, or fewer along the chord (structure.wing.mesh)"
            } else {
                "use fewer gores or more rings, or mend the mesh"
            };
            warnings.push(format!(
                "poor triangles: the fabric will be solved slowly; {remedy}"
            ));
        }
        warnings
    }

    fn device_tolerance(&self, scene: &Scene) -> Option<String> {
        let tolerance = scene.equilibrium?.tolerance;
        (scene.body.is_some() && self.placement.cloth_on_device() && tolerance < DEVICE_TOLERANCE)
            .then(|| {
                format!(
                    "the forces of a device, in f32, may not reach equilibrium.tolerance below {DEVICE_TOLERANCE:e}: use --cloth host"
                )
            })
    }
}

/// Pictures that are all asked for after the end. (Of some, as in a shortened variant, nothing is said.)
fn late_pictures(scene: &Scene) -> Option<String> {
    let end_s = scene.time?.end_s;
    let first_s = scene
        .output
        .picture_times_s
        .iter()
        .copied()
        .reduce(f64::min)?;
    (first_s > end_s).then(|| {
        format!(
            "no picture but the last is made: the first is asked for at {first_s} s, and the run ends at {end_s} s (output.picture_times_s, time.end_s)"
        )
    })
}

/// A nominal area that hardly is that of the fabric: coefficients would be wrong by the square of D_0.
fn nominal_area(scene: &Scene) -> Option<String> {
    let body = scene.body.as_ref()?;
    let BodyKind::Canopy(canopy) = &body.kind else {
        return None;
    };
    let fabric_m2 = body.structure.rest_area_m2();
    let share = fabric_m2 / canopy.nominal_area_m2;
    (!FABRIC_SHARES.contains(&share)).then(|| {
        format!(
            "the canopy has {fabric_m2:.3} m2 of fabric, {share:.2} of the nominal area of {:.3} m2 to which D_0 and all coefficients refer; \
             correct nominal_area_m2 (or the unit of the mesh, structure.mesh.scale) unless that is meant",
            canopy.nominal_area_m2
        )
    })
}

/// Fabric, with what is sewn to it, of a mass that no canopy has: a constant in another unit.
fn mass_of_fabric(scene: &Scene) -> Option<String> {
    let body = scene.body.as_ref()?;
    let BodyKind::Canopy(canopy) = &body.kind else {
        return None;
    };
    let mass_kg: f64 = (body.structure.masses_kg)
        .get(..canopy.canopy_node_count)?
        .iter()
        .sum();
    let areal_density_kg_m2 = mass_kg / body.structure.rest_area_m2();
    (!AREAL_DENSITIES_KG_M2.contains(&areal_density_kg_m2)).then(|| {
        format!(
            "the canopy weighs {areal_density_kg_m2:.3e} kg per m2 of fabric, with what hangs on its nodes; parachutes weigh 0.02 to 0.5: check the units of fabric.thickness_m, \
             fabric.density_kg_m3, lines.area_m2 and lines.density_kg_m3 unless that is meant"
        )
    })
}

fn blockage(scene: &Scene) -> Option<String> {
    let air = scene.air.as_ref()?;
    let Flow::WindTunnel { .. } = air.flow else {
        return None;
    };
    let section = air.section_m2();
    let canopy = scene.body.as_ref().and_then(|body| match &body.kind {
        BodyKind::Canopy(canopy) => Some(canopy.nominal_area_m2),
        _ => None,
    });
    let rigid: f64 = scene.rigid_bodies.iter().map(|b| b.blocking_area_m2).sum();
    let share = (canopy.unwrap_or(0.0) + rigid) / section;
    (share > BLOCKAGE_LIMIT).then(|| {
        format!(
            "the body blocks {:.0} % of the section, so the walls speed the air up beside it: widen air.wind_tunnel.size_m by {:.1} for {:.0} %, \
             or compare only corrected coefficients{}",
            100.0 * share,
            (share / BLOCKAGE_LIMIT).sqrt(),
            100.0 * BLOCKAGE_LIMIT,
            if canopy.is_some() { "" } else { ", where a law is known for the body (docs/rigid-bodies.md)" }
        )
    })
}
