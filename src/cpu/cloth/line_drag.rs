//! Drag of suspension lines ([`crate::lines::drag`]) as drag of their nodes, half of a segment's at each end.
//!
//! The coefficient and the direction of a line are those at the start of a step, the force follows the velocity at its end: c P (u − v₀) −
//! c (v − v₀) with P = I − t tᵀ. What this adds along the line is of the order of the step and vanishes in steady motion.

use glam::DVec3;

use super::loads::NodalDrag;
use crate::cloth::Structure;

/// Appends the drag of all lines that feel the wind; `wind_m_s` tells it at a place.
pub fn add_line_drags(
    structure: &Structure,
    positions_m: &[DVec3],
    velocities_m_s: &[DVec3],
    (density_kg_m3, wind_m_s): (f64, impl Fn(DVec3) -> DVec3),
    drags: &mut Vec<NodalDrag>,
) {
    for line in &structure.cables {
        let Some(drag) = line.drag else { continue };
        let [a, b] = line.nodes.map(|n| positions_m[n as usize]);
        let along = (b - a).normalize_or_zero();
        let length = a.distance(b);
        let wind = wind_m_s(a.midpoint(b));
        for node in line.nodes {
            let own = velocities_m_s[node as usize];
            let slip = wind - own;
            let across = slip - along * along.dot(slip);
            drags.push(NodalDrag {
                node,
                coefficient_kg_s: drag.coefficient_kg_s(
                    density_kg_m3,
                    0.5 * length,
                    across.length(),
                ),
                air_velocity_m_s: own + across,
            });
        }
    }
}
