//! Triangles inside a plane outline with holes: ribs and mini-ribs.

use glam::DVec2;
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation,
};

/// Smallest angle that refinement strives for away from the outline's own corners [°].
const SMALLEST_ANGLE_DEG: f64 = 25.0;

/// Largest area of a triangle over the square of the outline's mean edge.
const LARGEST_AREA: f64 = 4.0;

/// A filled outline.
#[derive(Debug, Clone)]
pub struct Filled {
    /// Points: the outline's, those of the holes, those given inside, then new ones.
    pub points: Vec<DVec2>,
    /// Triangles, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

/// Fills a polygon but for its holes with a refined constrained Delaunay triangulation (Ruppert's algorithm, of the `spade` crate) that
/// leaves the given edges whole, so that neighbours fit; `inside` are nodes of it. `None` if edges cross or points coincide.
#[must_use]
pub fn fill(outline: &[DVec2], holes: &[Vec<DVec2>], inside: &[DVec2]) -> Option<Filled> {
    let mut points = Vec::new();
    let mut edges = Vec::new();
    for ring in std::iter::once(outline).chain(holes.iter().map(Vec::as_slice)) {
        let first = points.len();
        points.extend(ring.iter().map(|p| Point2::new(p.x, p.y)));
        edges.extend((0..ring.len()).map(|i| [first + i, first + (i + 1) % ring.len()]));
    }
    points.extend(inside.iter().map(|p| Point2::new(p.x, p.y)));
    let given = points.len();
    let mut crossing = false;
    let mut mesh =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, edges, |_| {
            crossing = true
        })
        .ok()?;
    if crossing || mesh.num_vertices() != given {
        return None;
    }
    let mean_edge = (0..outline.len())
        .map(|i| outline[i].distance(outline[(i + 1) % outline.len()]))
        .sum::<f64>()
        / outline.len() as f64;
    let refined = mesh.refine(
        RefinementParameters::<f64>::new()
            .exclude_outer_faces(true)
            .keep_constraint_edges()
            .with_angle_limit(AngleLimit::from_deg(SMALLEST_ANGLE_DEG))
            .with_max_allowed_area(LARGEST_AREA * mean_edge * mean_edge),
    );
    let outside: std::collections::HashSet<_> = refined.excluded_faces.into_iter().collect();
    let points = mesh
        .vertices()
        .map(|v| DVec2::new(v.position().x, v.position().y))
        .collect();
    let triangles = mesh
        .inner_faces()
        .filter(|face| !outside.contains(&face.fix()))
        .map(|face| face.vertices().map(|v| v.fix().index() as u32))
        .collect();
    Some(Filled { points, triangles })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(radius: f64, count: usize) -> Vec<DVec2> {
        (0..count)
            .map(|i| DVec2::from_angle(std::f64::consts::TAU * i as f64 / count as f64) * radius)
            .collect()
    }

    fn area(points: &[DVec2]) -> f64 {
        (0..points.len())
            .map(|i| 0.5 * points[i].perp_dot(points[(i + 1) % points.len()]))
            .sum()
    }

    #[test]
    fn a_ring_keeps_its_edges_and_its_area() {
        let (outer, inner) = (ring(1.0, 40), ring(0.4, 16));
        let filled = fill(&outer, std::slice::from_ref(&inner), &[]).unwrap();
        let found: f64 = filled
            .triangles
            .iter()
            .map(|t| area(&t.map(|n| filled.points[n as usize])))
            .sum();
        assert!((found - (area(&outer) - area(&inner))).abs() < 1e-12);
        assert_eq!(filled.points[..40], outer);
        assert_eq!(filled.points[40..56], inner);
        // Every given edge belongs to exactly one triangle, every other one to two.
        let mut uses = std::collections::HashMap::new();
        for t in &filled.triangles {
            for i in 0..3 {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                *uses.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
        let rims = uses.values().filter(|n| **n == 1).count();
        assert_eq!(rims, 56);
        assert!(uses.values().all(|n| *n <= 2));
    }

    #[test]
    fn points_inside_are_nodes() {
        let (outer, inner) = (ring(1.0, 40), ring(0.3, 16));
        let given = [-0.5, 0.0, 0.5].map(|x| DVec2::new(x, 0.6));
        let filled = fill(&outer, std::slice::from_ref(&inner), &given).unwrap();
        assert_eq!(filled.points[56..59], given);
        let found: f64 = (filled.triangles.iter())
            .map(|t| area(&t.map(|n| filled.points[n as usize])))
            .sum();
        assert!((found - (area(&outer) - area(&inner))).abs() < 1e-12);
        for node in 56..59 {
            assert!(filled.triangles.iter().any(|t| t.contains(&node)));
        }
    }

    #[test]
    fn crossing_outlines_are_refused() {
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(DVec2::from_array);
        assert!(fill(&bow, &[], &[]).is_none());
        let twice = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(DVec2::from_array);
        assert!(fill(&twice, &[], &[]).is_none());
    }
}
