//! What the walls of a tunnel add to the drag of a bluff rigid body, where a correction is known.
//!
//! A wake that separates at edges: q_corrected/q = 1 + K C_D S/C (Maskell 1963, ARC R&M 3400). In three dimensions K is that of canopies,
//! 1.85 (Macha & Buffington 1990): it leaves a disk at Re 1000 within 2 % of its drag without walls, Maskell's 5/2 within 4 %. Of a sphere
//! it is Maskell's, which leaves 2 % at Re 1000; of a plate across the whole tunnel his 0.96. A circular cylinder across the tunnel: Allen & Vincenti 1944 (NACA Report 782) as in
//! Roshko 1961 (J. Fluid Mech. 10), C_D/C_D' = 1 − ½ C_D' d/h − 2.5 (d/h)². Other bodies have none: of a sphere at Re 100 Maskell's law takes
//! off twice of what the walls add. Ladders: `docs/results/2026-11-23-bodies-settling-and-walls.md`.

use glam::DVec3;

use super::flow_past_bodies::{drag_direction, prefix, reynolds_number, settling};
use super::shared::{CORRECTED_DRAG, PRESSURE_RATIO};
use super::statistics::Mean;
use crate::case::Scene;
use crate::case::scene::{Air, Flow, RigidBody, Shape};
use crate::output::{Quantity, Results};
use crate::rigid::{BoxFace, Motion};

/// Factor K of bodies about as wide as high, by Macha & Buffington.
pub(super) const THREE_DIMENSIONS: f64 = 1.85;

/// Maskell's of a sphere.
const SPHERE: f64 = 2.5;

/// Maskell's of a plate across the whole tunnel.
const TWO_DIMENSIONS: f64 = 0.96;

/// Sides of a plate over one another up to which its wake counts as three-dimensional.
const SLENDER: f64 = 10.0;

/// Part of the tunnel's width or height from which on a body stands across it.
const ACROSS: f64 = 0.9;

/// Cosine of the angle between a plate's normal and the wind, from which on it counts as normal to it: 15°.
const NORMAL: f64 = 0.966;

/// Reynolds number from which on the wake of an edge is what the theory holds for.
const SEPARATED: f64 = 1e3;

/// Reynolds numbers of spheres and cylinders whose boundary layer separates before it is turbulent.
const SUBCRITICAL: std::ops::RangeInclusive<f64> = 1e3..=2e5;

/// How the drag is corrected.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Law {
    /// Of the form of Maskell's, with a factor.
    Maskell(f64),
    /// Allen & Vincenti's of a cylinder, whose diameter is this part of the tunnel.
    Cylinder(f64),
}

impl Law {
    /// The drag coefficient without walls over the measured one, from that and its area over the section.
    fn share(self, drag: f64, blockage: f64) -> f64 {
        match self {
            Self::Maskell(factor) => 1.0 / (1.0 + factor * drag * blockage),
            Self::Cylinder(part) => 1.0 - 0.5 * drag * blockage - 2.5 * part * part,
        }
    }

    /// Its derivative times the drag coefficient, added to it: what an interval shrinks by.
    fn share_of_interval(self, drag: f64, blockage: f64) -> f64 {
        let share = self.share(drag, blockage);
        match self {
            Self::Maskell(_) => share * share,
            Self::Cylinder(_) => share - 0.5 * drag * blockage,
        }
    }

    fn note(self) -> String {
        match self {
            Self::Maskell(factor) => format!(
                "{}, factor {factor} on C_D S / section; holds for separated wakes, up to a tenth of the section",
                if factor == THREE_DIMENSIONS {
                    "Macha & Buffington 1990"
                } else {
                    "Maskell 1963"
                }
            ),
            Self::Cylinder(_) => {
                "Allen & Vincenti 1944: 1 - C_D d/(2 h) - 2.5 (d/h)^2; holds for cylinders across the tunnel, Re 1e3 to 2e5".to_owned()
            }
        }
    }
}

/// Drag coefficient without the walls of the tunnel, and why there is none.
pub(super) fn results(
    results: &mut Results,
    (scene, air, body): (&Scene, &Air, &RigidBody),
    drag: Mean,
    unsettled: Option<&str>,
) {
    let prefix = prefix(scene, body);
    let corrected = CORRECTED_DRAG.of(&prefix);
    let law = match law(scene, air, body) {
        Ok(law) => law,
        Err(why) => {
            results.insert(
                &corrected,
                Quantity::missing(&format!("no correction for walls is known: {why}")),
            );
            return;
        }
    };
    let blockage = body.reference_area_m2 / air.section_m2();
    let share = law.share(drag.value, blockage);
    let mut quantity = Quantity::new(drag.value * share).with_note(&law.note());
    if let Some(confidence) = drag.confidence {
        let shrunk = law.share_of_interval(drag.value, blockage);
        quantity = quantity.with_confidence(confidence * shrunk.abs());
    }
    if let Some(why) = unsettled {
        quantity.mark_unresolved(why);
    }
    results.insert(&corrected, quantity);
    results.tell(&PRESSURE_RATIO.of(&prefix), 1.0 / share);
}

/// The law that holds for a body, or why none does.
fn law(scene: &Scene, air: &Air, body: &RigidBody) -> Result<Law, &'static str> {
    let Flow::WindTunnel { .. } = air.flow else {
        return Err("there is no tunnel");
    };
    if scene.body.is_some() || scene.rigid_bodies.len() > 1 {
        return Err("there are several bodies");
    }
    let across =
        spans(&body.faces) && matches!(body.shape, Shape::Cylinder { .. } | Shape::Plate { .. });
    if !body.faces.is_empty() && !across {
        return Err("the body passes through a face: of half models and mounts no law is known");
    }
    settling(scene, air, body)?;
    let along = drag_direction(air, body);
    if along.x.abs() < 0.9999 || matches!(body.motion.motion, Motion::ConstantRotation { .. }) {
        return Err("the body moves otherwise than along the tunnel");
    }
    if body.permeability.is_some() {
        return Err("the body is permeable");
    }
    let reynolds = reynolds_number(air, body);
    let [width, height] = parts(air, body);
    match body.shape {
        Shape::Disk { .. } | Shape::Plate { .. } if body.normal.dot(along).abs() < NORMAL => {
            Err("the body is not normal to the stream")
        }
        Shape::Disk { .. } | Shape::Plate { .. } if reynolds < SEPARATED => {
            Err("Re is below 1000, where walls act otherwise than on a separated wake")
        }
        Shape::Disk { .. } => Ok(Law::Maskell(THREE_DIMENSIONS)),
        Shape::Plate { .. } if width.max(height) >= ACROSS => {
            if width.min(height) >= ACROSS {
                Err("the plate closes the tunnel")
            } else {
                Ok(Law::Maskell(TWO_DIMENSIONS))
            }
        }
        Shape::Plate { size_m: [a, b] } if a.max(b) <= SLENDER * a.min(b) => {
            Ok(Law::Maskell(THREE_DIMENSIONS))
        }
        Shape::Plate { .. } => Err("the plate is slender and does not reach across the tunnel"),
        Shape::Cylinder { .. } if width.max(height) < ACROSS => {
            Err("the cylinder does not reach across the tunnel")
        }
        Shape::Cylinder { .. } if !SUBCRITICAL.contains(&reynolds) => {
            Err("it holds for a cylinder across the tunnel at Re 1e3 to 2e5 only")
        }
        Shape::Cylinder { .. } => Ok(Law::Cylinder(width.min(height))),
        Shape::Sphere { .. } if SUBCRITICAL.contains(&reynolds) => Ok(Law::Maskell(SPHERE)),
        Shape::Sphere { .. } => Err("it holds for a sphere at Re 1e3 to 2e5 only"),
        Shape::Wing { .. } => Err("the body is a wing"),
        Shape::Mesh => Err("the body is a mesh"),
    }
}

/// True if a body passes through both sides of one axis and no other face: it stands across the tunnel.
fn spans(faces: &[BoxFace]) -> bool {
    matches!(faces, [lower, upper] if lower.axis == upper.axis)
}

/// Extents of a body along y and z over those of the tunnel.
fn parts(air: &Air, body: &RigidBody) -> [f64; 2] {
    let places = &body.surface.positions_m;
    let least = places
        .iter()
        .copied()
        .fold(DVec3::INFINITY, |a, b| a.min(b));
    let most = places
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, |a, b| a.max(b));
    let extent = most - least;
    let size = |axis: usize| air.cells[axis] as f64 * air.units.cell_size_m;
    [extent.y / size(1), extent.z / size(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Disk of C_D 1.3 on a twentieth of the section, and a cylinder of C_D' 1.2 across a tunnel ten diameters high.
    #[test]
    fn the_laws_by_hand() {
        let disk = Law::Maskell(THREE_DIMENSIONS);
        assert!((1.3 * disk.share(1.3, 0.05) - 1.3 / 1.120_25).abs() < 1e-12);
        let cylinder = Law::Cylinder(0.1);
        assert!((cylinder.share(1.2, 0.1) - (1.0 - 0.06 - 0.025)).abs() < 1e-12);
        // An interval goes with the derivative of the corrected coefficient.
        for law in [disk, cylinder] {
            let at = |drag: f64| drag * law.share(drag, 0.07);
            let slope = (at(1.2 + 1e-6) - at(1.2 - 1e-6)) / 2e-6;
            assert!(
                (law.share_of_interval(1.2, 0.07) - slope).abs() < 1e-9,
                "{law:?}"
            );
        }
    }
}
