//! Openings of a canopy that is read from a file: closed borders beside that of its mouth.

use std::collections::HashSet;
use std::f64::consts::PI;

use glam::DVec3;

use super::doctor::Border;
use crate::cloth::openings::{Opening, OpeningKind};
use crate::rigid::Surface;
use crate::sets::Sets;

/// 4π times area over length squared from which a border counts as round: 1 of a circle, 0.79 of a square, 0.55 of a rectangle of 4 : 1.
const ROUND: f64 = 0.7;

/// Openings of a surface whose borders come longest first: of each of its pieces the first closed one is its own edge, a canopy's mouth. A round one is as wide as the circle of its area, a
/// longer one as the strip of its area and length.
#[must_use]
pub fn openings(surface: &Surface, borders: &[Border]) -> Vec<Opening> {
    let closed = borders
        .iter()
        .filter(|border| border.nodes.len() > 3 && border.nodes.first() == border.nodes.last());
    let mut pieces = Sets::new(surface.positions_m.len());
    for [a, b, c] in &surface.triangles {
        pieces.join(*a, *b);
        pieces.join(*a, *c);
    }
    let mut edged = HashSet::new();
    closed
        .filter(|border| !edged.insert(pieces.first(border.nodes[0])))
        .map(|border| {
            let rim: Vec<[u32; 2]> = border.nodes.windows(2).map(|p| [p[0], p[1]]).collect();
            let at = |node: u32| surface.positions_m[node as usize];
            let origin = at(border.nodes[0]);
            let vector_m2: DVec3 = (rim.iter())
                .map(|[a, b]| 0.5 * (at(*a) - origin).cross(at(*b) - origin))
                .sum();
            let (area_m2, length_m) = (vector_m2.length(), border.length_m);
            let is_round = 4.0 * PI * area_m2 > ROUND * length_m * length_m;
            let (kind, width_m) = if is_round {
                (OpeningKind::Vent, (4.0 * area_m2 / PI).sqrt())
            } else {
                (OpeningKind::Slot, 2.0 * area_m2 / length_m)
            };
            Opening { kind, width_m, rim }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn border(nodes: &[u32], places: &[DVec3]) -> Border {
        let at = |node: u32| places[node as usize];
        Border {
            nodes: nodes.to_vec(),
            length_m: nodes.windows(2).map(|p| at(p[0]).distance(at(p[1]))).sum(),
        }
    }

    #[test]
    fn a_vent_and_a_slot_have_their_widths() {
        let circle = |radius: f64, height: f64| {
            (0..48).map(move |k| {
                let angle = 2.0 * PI * f64::from(k) / 48.0;
                DVec3::new(height, radius * angle.cos(), radius * angle.sin())
            })
        };
        let slot = [[0.0, 0.0], [0.6, 0.0], [0.6, 0.05], [0.0, 0.05]];
        let slot = slot.map(|[y, z]| DVec3::new(0.3, y, z));
        let places: Vec<DVec3> = (circle(1.0, 0.0).chain(circle(0.1, 0.5)).chain(slot)).collect();
        let ring = |first: u32, count: u32| -> Vec<u32> {
            (0..=count).map(|k| first + k % count).collect()
        };
        let borders = [ring(0, 48), ring(96, 4), ring(48, 48)].map(|nodes| border(&nodes, &places));
        let in_pieces = Surface {
            positions_m: places.clone(),
            triangles: vec![[48, 49, 96]],
        };
        // The larger circle, and the slot as the edge of a piece of its own with the smaller one in it.
        assert_eq!(openings(&in_pieces, &borders).len(), 1);
        let surface = Surface {
            positions_m: places,
            triangles: vec![[0, 48, 96]],
        };
        let found = openings(&surface, &borders);
        let kinds: Vec<OpeningKind> = found.iter().map(|opening| opening.kind).collect();
        assert_eq!(kinds, [OpeningKind::Slot, OpeningKind::Vent]);
        assert!((found[0].width_m / 0.05 - 1.0).abs() < 0.1, "{found:?}");
        assert!((found[1].width_m / 0.2 - 1.0).abs() < 0.01, "{found:?}");
        assert_eq!(found[1].rim.len(), 48);
    }
}
