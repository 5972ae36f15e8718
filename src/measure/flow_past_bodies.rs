//! What the flow past a rigid body depends on: direction and speed that its coefficients refer to, its settling, and published drags.

use glam::DVec3;

use super::steady::bodies::Settling;
use crate::case::Scene;
use crate::case::scene::{Air, Flow, RigidBody, Shape};
use crate::case::steady::never_steady;
use crate::rigid::Motion;

/// What goes before the names of a body's columns and results.
#[must_use]
pub fn prefix(scene: &Scene, body: &RigidBody) -> String {
    if scene.body.is_none() && scene.rigid_bodies.len() == 1 {
        String::new()
    } else {
        format!("{}_", body.name)
    }
}

/// Direction of the drag.
pub(super) fn drag_direction(air: &Air, body: &RigidBody) -> DVec3 {
    match (&body.motion.motion, &air.flow) {
        (_, Flow::WindTunnel { speed_m_s, .. }) if *speed_m_s > 0.0 => DVec3::X,
        (Motion::ConstantVelocity { velocity_m_s, .. }, _) => {
            (-*velocity_m_s).try_normalize().unwrap_or(DVec3::X)
        }
        _ => DVec3::X,
    }
}

/// Reynolds number of a body, with its reference length.
#[must_use]
pub fn reynolds_number(air: &Air, body: &RigidBody) -> f64 {
    body.reference_speed_m_s(air) * body.reference_length_m / air.kinematic_viscosity_m2_s
}

/// What the settling of the flow past a body depends on, or why that never becomes steady.
pub fn settling(scene: &Scene, air: &Air, body: &RigidBody) -> Result<Settling, &'static str> {
    if scene.body.is_some() {
        return Err("fabric beside the body moves");
    }
    if let Some(why) = never_steady(air, scene.descent.is_some(), body) {
        return Err(why);
    }
    let (risen_s, turn_s) = match &body.motion.motion {
        Motion::ConstantVelocity { rise_s, .. } => (*rise_s, None),
        Motion::ConstantRotation { rate_rad_s, rise_s } => {
            let turn_s = std::f64::consts::TAU / rate_rad_s.abs();
            (*rise_s, turn_s.is_finite().then_some(turn_s))
        }
        _ => (0.0, None),
    };
    Ok(Settling {
        unit_s: body.reference_length_m / body.reference_speed_m_s(air),
        risen_s,
        turn_s,
        unsteady: reynolds_number(air, body) > steady_reynolds_number(body.shape),
    })
}

/// Reynolds number up to which the wake of a shape is steady: sphere 210 and disk 116 (Natarajan & Acrivos 1993, J. Fluid Mech. 254), all
/// others that of a cylinder across the stream, 47 (Williamson 1996, Annu. Rev. Fluid Mech. 28).
fn steady_reynolds_number(shape: Shape) -> f64 {
    match shape {
        Shape::Sphere { .. } => 210.0,
        Shape::Disk { .. } => 116.0,
        Shape::Plate { .. } | Shape::Cylinder { .. } | Shape::Wing { .. } | Shape::Mesh => 47.0,
    }
}

/// Published drag coefficient of a body at rest in an unbounded even stream, on the reference area of the case, where its Reynolds number is covered.
pub(super) fn reference_drag(
    scene: &Scene,
    air: &Air,
    body: &RigidBody,
) -> Option<(f64, &'static str)> {
    let steady = match &body.motion.motion {
        Motion::Held => true,
        Motion::ConstantVelocity { .. } => {
            matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s == 0.0)
        }
        _ => false,
    };
    let speed = body.reference_speed_m_s(air);
    // What is published is of whole bodies that no air passes, held alone in an even stream.
    if scene.descent.is_some() || body.permeability.is_some() {
        return None;
    }
    let uneven = matches!(
        &air.flow,
        Flow::WindTunnel {
            inlet_profile: Some(_),
            ..
        }
    );
    let alone = scene.body.is_none() && scene.rigid_bodies.len() == 1;
    if !steady || !alone || !body.faces.is_empty() || uneven {
        return None;
    }
    let area_m2 = body.shape.area_m2()?;
    let (drag, source) = match body.shape {
        Shape::Sphere { diameter_m } => {
            sphere_drag(speed * diameter_m / air.kinematic_viscosity_m2_s)
                .map(|drag| (drag, "Schiller & Naumann 1933: 24/Re (1 + 0.15 Re^0.687)"))
        }
        Shape::Disk { diameter_m }
            if body.normal.dot(drag_direction(air, body)).abs() > 0.9999 =>
        {
            disk_drag(speed * diameter_m / air.kinematic_viscosity_m2_s).map(|drag| {
                (
                    drag,
                    "Clift, Grace & Weber 1978: 64/(pi Re) (1 + 0.138 Re^0.792), disk normal to the flow",
                )
            })
        }
        _ => None,
    }?;
    Some((drag * area_m2 / body.reference_area_m2, source))
}

/// Drag coefficient of a sphere, 0.5 < Re < 800 (Schiller & Naumann 1933, within 5 %).
#[must_use]
pub fn sphere_drag(reynolds: f64) -> Option<f64> {
    (0.5..=800.0)
        .contains(&reynolds)
        .then(|| 24.0 / reynolds * (1.0 + 0.15 * reynolds.powf(0.687)))
}

/// Drag coefficient of a disk normal to the flow, 1.5 < Re ≤ 133 (Clift, Grace & Weber 1978).
#[must_use]
pub fn disk_drag(reynolds: f64) -> Option<f64> {
    (1.5..=133.0)
        .contains(&reynolds)
        .then(|| 64.0 / (std::f64::consts::PI * reynolds) * (1.0 + 0.138 * reynolds.powf(0.792)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Re 100: 1.09 for the sphere (VALIDATION of this project, and the correlation); limits of the ranges.
    #[test]
    fn published_values() {
        assert!((sphere_drag(100.0).unwrap() - 1.0917).abs() < 1e-3);
        assert!(sphere_drag(1e4).is_none());
        assert!((disk_drag(100.0).unwrap() - 1.282).abs() < 1e-3);
    }
}
