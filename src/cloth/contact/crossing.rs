//! Where fabric passes through itself: edges that pierce triangles.

use glam::DVec3;

use super::grid::{Extent, Grid};
use super::pairs::Surface;

/// Six times the signed volume of a tetrahedron [m³].
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    (b - a).cross(c - a).dot(d - a)
}

/// True if the segment passes through the inside of the triangle: its ends lie on either side, and it leaves all three edges on the same
/// hand. What only touches, or lies in the plane, does not count.
#[must_use]
pub fn pierces(segment: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let [p, q] = segment;
    let (above, below) = (volume(a, b, c, p), volume(a, b, c, q));
    if above * below >= 0.0 {
        return false;
    }
    let hands = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    hands.iter().all(|h| *h > 0.0) || hands.iter().all(|h| *h < 0.0)
}

/// Every edge that passes through a triangle with which it shares no node, as (edge, triangle), in a fixed order.
#[must_use]
pub fn crossings(surface: &Surface, positions: &[DVec3]) -> Vec<([u32; 2], [u32; 3])> {
    let place = |node: u32| positions[node as usize];
    let extents: Vec<Extent> = surface
        .triangles
        .iter()
        .map(|nodes| Extent::around(&nodes.map(place)))
        .collect();
    let edges: Vec<Extent> = surface
        .edges
        .iter()
        .map(|(nodes, _)| Extent::around(&nodes.map(place)))
        .collect();
    let longest = edges.iter().map(Extent::longest_side).fold(0.0, f64::max);
    // Some reach, so that a surface without extent has cells all the same.
    let reach = 1e-9 * longest.max(f64::MIN_POSITIVE);
    let grid = Grid::new(&extents, reach, longest);
    let mut found = Vec::new();
    for (number, (nodes, _)) in surface.edges.iter().enumerate() {
        grid.near(&edges[number], |t| {
            let triangle = surface.triangles[t];
            if nodes.iter().any(|node| triangle.contains(node)) {
                return;
            }
            if pierces(nodes.map(place), triangle.map(place)) {
                found.push((*nodes, triangle));
            }
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_passes_through_the_inside_counts() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let through = |x: f64, y: f64, low: f64, high: f64| {
            let ends = [DVec3::new(x, y, low), DVec3::new(x + 0.1, y, high)];
            pierces(ends, triangle)
        };
        assert!(through(0.2, 0.3, -1.0, 1.0));
        assert!(through(0.2, 0.3, 1.0, -1.0));
        assert!(!through(0.2, 0.3, 0.1, 1.0), "ends before");
        assert!(!through(0.7, 0.7, -1.0, 1.0), "passes beside");
        assert!(!through(0.2, 0.3, 0.0, 1.0), "touches");
        assert!(
            !pierces([DVec3::X * -1.0, DVec3::X * 2.0], triangle),
            "lies in the plane"
        );
    }
}
