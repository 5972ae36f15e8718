//! What a scene needs of the engines, against what they can: judged before the first step.
//! Whoever uses the engines without a plan is refused there (`gpu::cloth`).
//!
//! CPU threads compute every scene. A device computes the air of every scene within its limits of memory; of fabric it lacks what stands here.

use std::collections::HashMap;

use super::Placement;
use crate::case::Scene;
use crate::cloth::Structure;

/// Something that a scene needs of the engine of its fabric, and that a device lacks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the fabric cannot be solved on a device: {what}, which only the host computes; {remedy}")]
pub struct Lacking {
    what: String,
    remedy: &'static str,
}

const LEAVE_OUT: &str = "leave --cloth device out";

/// A need: what it is, whether a scene has it, what to do.
type Need = (&'static str, fn(&Scene) -> bool, &'static str);

const NEEDS: [Need; 5] = [
    (
        "the case has [contact]",
        |scene| structure(scene).is_some_and(|s| s.contact.is_some()),
        "leave --cloth device out, or remove [contact]",
    ),
    (
        "the structure is sewn of several fabrics",
        |scene| structure(scene).is_some_and(|s| !s.further_fabrics.is_empty()),
        LEAVE_OUT,
    ),
    (
        "the case has a wing in the wind, or pulls risers",
        |scene| {
            let wing = scene.wing();
            wing.is_some_and(|wing| wing.tunnel.is_some() || !wing.pulls.is_empty())
        },
        LEAVE_OUT,
    ),
    (
        "the case has [equilibrium.trim]",
        |scene| scene.wing().is_some_and(|wing| wing.trim.is_some()),
        LEAVE_OUT,
    ),
    (
        "the case has [equilibrium.wing_pressure], which is renewed on the shape that it makes",
        |scene| scene.wing().is_some_and(|w| w.load_pa.is_some()),
        LEAVE_OUT,
    ),
];

fn structure(scene: &Scene) -> Option<&Structure> {
    scene.body.as_ref().map(|body| &body.structure)
}

/// What the fabric of `scene` needs and a device lacks; `None` where a device can solve it.
#[must_use]
pub fn lacking_on_device(scene: &Scene) -> Option<Lacking> {
    let needed = NEEDS.iter().find(|(_, needs, _)| needs(scene));
    if let Some(&(what, _, remedy)) = needed {
        return Some(Lacking {
            what: what.to_owned(),
            remedy,
        });
    }
    let node = node_at_open_edge(structure(scene)?, prescribed_pressure_pa(scene)?)?;
    Some(Lacking {
        what: format!(
            "pressure that follows the fabric ends at an edge that moves, as at node {node}"
        ),
        remedy: "hold the edge, or leave --cloth device out",
    })
}

/// Whether all engines of a placement can compute the scene.
pub fn check(scene: &Scene, placement: &Placement) -> Result<(), Lacking> {
    let lacking = placement
        .cloth_on_device()
        .then(|| lacking_on_device(scene));
    lacking.flatten().map_or(Ok(()), Err)
}

/// Pressure of the static equilibrium on every triangle [Pa]; `None` where none is prescribed.
fn prescribed_pressure_pa(scene: &Scene) -> Option<Vec<f64>> {
    if let Some(wing) = scene.imported_wing() {
        return Some(wing.inside_pa.clone());
    }
    let pressure_pa = scene.equilibrium?.pressure_pa?;
    Some(vec![pressure_pa; structure(scene)?.triangles.len()])
}

/// The first node that moves at an edge of a patch of equal pressure. There the pull of following pressure is no gradient of a potential.
fn node_at_open_edge(structure: &Structure, pressures_pa: Vec<f64>) -> Option<u32> {
    let mut jumps_pa: HashMap<[u32; 2], f64> = HashMap::new();
    for (triangle, pressure_pa) in structure.triangles.iter().zip(&pressures_pa) {
        for side in 0..3 {
            let [from, to] = [0, 1].map(|end| triangle.nodes[(side + end) % 3]);
            // Neighbours that are turned alike run along their common edge in opposite directions.
            let (edge, sign) = if from < to {
                ([from, to], 1.0)
            } else {
                ([to, from], -1.0)
            };
            *jumps_pa.entry(edge).or_default() += sign * pressure_pa;
        }
    }
    let largest = pressures_pa.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let open = jumps_pa
        .iter()
        .filter(|(_, jump_pa)| jump_pa.abs() > ROUND_OFF * largest);
    let moving = open.flat_map(|(edge, _)| edge.iter().copied());
    moving.filter(|&node| !structure.held[node as usize]).min()
}

/// Difference of pressures over the largest that counts as none.
const ROUND_OFF: f64 = 1e-9;
