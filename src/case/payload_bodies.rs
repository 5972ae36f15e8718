//! Checks of `[payload.bodies]`: further masses on tethers below a payload.

use std::collections::BTreeMap;

use glam::DVec3;

use super::cable_material::check_material;
use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{check_name, positive};
use crate::cloth::Structure;
use crate::frame::CableKind;

/// A point mass that hangs on a tether from the payload or from another one.
#[derive(Debug, Clone, PartialEq)]
pub struct PayloadBody {
    /// Its name.
    pub name: String,
    /// Its node.
    pub node: u32,
    /// Number of its tether among the cables; the upper end is the first of its nodes.
    pub tether: usize,
    /// Its mass [kg].
    pub mass_kg: f64,
    /// Its drag area [m²]; 0 without drag.
    pub drag_area_m2: f64,
}

/// Hangs all bodies below `payload`, the node of the payload, straight down (−x) on tethers without tension.
pub(super) fn hang(
    tables: &BTreeMap<String, file::PayloadBody>,
    payload: usize,
    structure: &mut Structure,
) -> Result<Vec<PayloadBody>, Problem> {
    let mut bodies: Vec<PayloadBody> = Vec::new();
    // Whatever hangs from something known, until nothing is left.
    while bodies.len() < tables.len() {
        let before = bodies.len();
        for (name, table) in tables {
            let key = |of: &str| format!("payload.bodies.{name}.{of}");
            if bodies.iter().any(|body| body.name == *name) {
                continue;
            }
            let above = match &table.hangs_from {
                None => payload as u32,
                Some(other) if !tables.contains_key(other) => {
                    return Err(Problem::new(
                        key("hangs_from"),
                        format!(
                            "{} names \"{other}\", which is none of [payload.bodies]",
                            key("hangs_from")
                        ),
                        "name another body, or leave it away: then it hangs from the payload",
                    ));
                }
                Some(other) => match bodies.iter().find(|body| body.name == *other) {
                    Some(body) => body.node,
                    None => continue,
                },
            };
            check_name("payload.bodies", name, "a body")?;
            let mass_kg = positive(&key("mass_kg"), table.mass_kg)?;
            let length_m = positive(&key("tether_length_m"), table.tether_length_m)?;
            let drag_area_m2 = match table.drag_area_m2 {
                None => usual::noted(key("drag_area_m2"), 0.0),
                Some(area) => positive(&key("drag_area_m2"), area)?,
            };
            let cable = check_material(&key("tether"), &table.tether)?;
            let place_m = structure.positions_m[above as usize] - DVec3::X * length_m;
            let node = structure.add_node(place_m);
            structure.masses_kg[node as usize] = mass_kg;
            bodies.push(PayloadBody {
                name: name.clone(),
                node,
                tether: structure.cables.len(),
                mass_kg,
                drag_area_m2,
            });
            structure.add_cable(&[above, node], &[length_m], &cable, CableKind::Cable);
        }
        if bodies.len() == before {
            let lost = tables
                .keys()
                .find(|name| bodies.iter().all(|b| b.name != **name));
            let key = format!(
                "payload.bodies.{}.hangs_from",
                lost.map_or("", String::as_str)
            );
            return Err(Problem::new(
                key.as_str(),
                format!("{key}: these bodies hang from each other in a circle"),
                "let one of them hang from the payload (without hangs_from)",
            ));
        }
    }
    Ok(bodies)
}
