//! Where markers stand: a little inside the surface, because the kernel of a marker reaches beyond it and makes a body act larger
//! than it is drawn.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};

use super::Surface;
use crate::sets::Sets;

/// Distance from a rim within which nodes follow its inset, in insets: neighbours never change places.
const RIM_REACH: f64 = 6.0;

/// Share of a closed part's volume that must remain.
const SMALLEST_SHARE: f64 = 0.05;

/// The surface with every closed part moved inwards by `closed_m` along its normals, and every rim inwards by `rim_m` along the
/// surface [m]. `None` if a part is too small to hold it.
#[must_use]
pub fn inset(surface: &Surface, closed_m: f64, rim_m: f64) -> Option<Surface> {
    let mut result = surface.clone();
    if closed_m == 0.0 && rim_m == 0.0 {
        return Some(result);
    }
    let parts = parts(surface);
    for part in &parts {
        let part_surface = Surface {
            positions_m: surface.positions_m.clone(),
            triangles: part.clone(),
        };
        let rim = part_surface.rim();
        if rim.is_empty() {
            let (volume, _) = part_surface.volume_m3();
            move_inwards(&part_surface, closed_m * volume.signum(), &mut result);
            let moved = Surface {
                positions_m: result.positions_m.clone(),
                triangles: part.clone(),
            };
            if moved.volume_m3().0 / volume < SMALLEST_SHARE {
                return None;
            }
        } else {
            draw_rim_in(&part_surface, &rim, rim_m, &mut result);
        }
    }
    // Nothing may have turned over.
    let turned = surface
        .area_vectors_m2()
        .zip(result.area_vectors_m2())
        .any(|(before, after)| before.dot(after) <= 0.0 && before != DVec3::ZERO);
    (!turned).then_some(result)
}

/// Triangles of every connected part.
fn parts(surface: &Surface) -> Vec<Vec<[u32; 3]>> {
    let mut joined = Sets::new(surface.positions_m.len());
    for &[a, b, c] in &surface.triangles {
        joined.join(a, b);
        joined.join(a, c);
    }
    let mut numbers = HashMap::new();
    let mut parts: Vec<Vec<[u32; 3]>> = Vec::new();
    for &nodes in &surface.triangles {
        let first = joined.first(nodes[0]);
        let number = *numbers.entry(first).or_insert_with(|| {
            parts.push(Vec::new());
            parts.len() - 1
        });
        parts[number].push(nodes);
    }
    parts
}

/// Every node moves so that the planes of its triangles move by `distance_m` in the least-squares sense.
fn move_inwards(part: &Surface, distance_m: f64, result: &mut Surface) {
    /// Keeps flat surroundings, where two directions are not determined, from moving along themselves.
    const REGULARISATION: f64 = 1e-6;
    let mut sums: HashMap<u32, (DMat3, DVec3, f64)> = HashMap::new();
    for (&nodes, area) in part.triangles.iter().zip(part.area_vectors_m2()) {
        let normal = area.normalize_or_zero();
        let corners = part.corners(nodes);
        for k in 0..3 {
            let (to, back) = (
                corners[(k + 1) % 3] - corners[k],
                corners[(k + 2) % 3] - corners[k],
            );
            let weight = to.angle_between(back);
            if !weight.is_finite() {
                continue;
            }
            let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
            let sum = sums
                .entry(nodes[k])
                .or_insert((DMat3::ZERO, DVec3::ZERO, 0.0));
            sum.0 += outer * weight;
            sum.1 += normal * weight;
            sum.2 += weight;
        }
    }
    for (node, (matrix, vector, weight)) in sums {
        let regular = matrix + DMat3::from_diagonal(DVec3::splat(REGULARISATION * weight));
        let shift = regular.inverse() * vector * (1.0 + REGULARISATION);
        if shift.is_finite() {
            result.positions_m[node as usize] -= shift * distance_m;
        }
    }
}

/// Rim nodes move inwards along the surface, those behind them less and less.
fn draw_rim_in(part: &Surface, rim: &[[u32; 2]], distance_m: f64, result: &mut Surface) {
    // Sum of the inward normals of the two rim edges of every rim node.
    let mut inward: HashMap<u32, DVec3> = HashMap::new();
    let rim: HashSet<[u32; 2]> = rim.iter().copied().collect();
    for (&nodes, area) in part.triangles.iter().zip(part.area_vectors_m2()) {
        let normal = area.normalize_or_zero();
        for k in 0..3 {
            let edge = [nodes[k], nodes[(k + 1) % 3]];
            if rim.contains(&edge) {
                let [from, to] = edge.map(|n| part.positions_m[n as usize]);
                let conormal = normal.cross(to - from).normalize_or_zero();
                for node in edge {
                    *inward.entry(node).or_default() += conormal;
                }
            }
        }
    }
    let mut rim_nodes: Vec<(u32, DVec3)> = inward
        .into_iter()
        // Both edges move by the distance: their sum has length 2 cos of half the angle.
        .map(|(node, sum)| (node, 2.0 * sum / sum.length_squared().max(0.5)))
        .collect();
    rim_nodes.sort_by_key(|(node, _)| *node);
    let mut nodes: Vec<u32> = part.triangles.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let reach = RIM_REACH * distance_m.abs();
    for node in nodes {
        let place = part.positions_m[node as usize];
        let nearest = rim_nodes
            .iter()
            .map(|(rim_node, direction)| {
                (
                    part.positions_m[*rim_node as usize].distance(place),
                    *direction,
                )
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, direction)) = nearest
            && distance < reach
        {
            result.positions_m[node as usize] += direction * distance_m * (1.0 - distance / reach);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces of a cube move by the inset, edges and corners included, whichever way the normals point.
    #[test]
    fn a_cube_shrinks_on_all_sides() {
        let mut cube = Surface::block(DVec3::ZERO, DVec3::ONE);
        assert!(cube.is_closed());
        for sign in [1.0, -1.0] {
            assert!((cube.volume_m3().0 - sign).abs() < 1e-12);
            let smaller = inset(&cube, 0.1, 0.0).unwrap();
            assert!((smaller.volume_m3().0.abs() - 0.8f64.powi(3)).abs() < 1e-5);
            let (low, high) = smaller.bounds_m();
            assert!((low - DVec3::splat(0.1)).length() < 1e-5);
            assert!((high - DVec3::splat(0.9)).length() < 1e-5);
            assert!(inset(&cube, 0.6, 0.0).is_none());
            for triangle in &mut cube.triangles {
                triangle.swap(1, 2);
            }
        }
    }

    /// The rim of a square sheet comes in by the inset, corners included; its middle stays.
    #[test]
    fn a_sheet_loses_its_rim() {
        let n = 10u32;
        let node = |i: u32, j: u32| i + (n + 1) * j;
        let mut sheet = Surface::default();
        for j in 0..=n {
            for i in 0..=n {
                let place = DVec3::new(0.0, f64::from(i), f64::from(j)) / f64::from(n);
                sheet.positions_m.push(place);
            }
        }
        for j in 0..n {
            for i in 0..n {
                let (a, b) = (node(i, j), node(i + 1, j));
                let (c, d) = (node(i + 1, j + 1), node(i, j + 1));
                sheet.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        assert!(!sheet.is_closed());
        let smaller = inset(&sheet, 0.3, 0.03).unwrap();
        assert!((smaller.area_m2() - 0.94f64.powi(2)).abs() < 1e-12);
        let middle = node(5, 5) as usize;
        assert_eq!(smaller.positions_m[middle], sheet.positions_m[middle]);
    }
}
