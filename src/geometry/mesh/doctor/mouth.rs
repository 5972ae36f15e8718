//! Where the opening of a canopy faces.

use glam::DVec3;

use super::examination::Border;

/// Least depth of fabric behind its opening, over the root of its area; below it is flat.
const DEPTH: f64 = 0.02;

/// Least area within a border, over the square of its length, at which it has a direction.
const OPEN: f64 = 1e-6;

/// Where the longest closed border faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mouth {
    /// Normal of the opening, away from the fabric.
    pub direction: DVec3,
    /// True where the fabric lies in the plane of the opening, so that the direction may as well be the opposite one.
    pub is_flat: bool,
}

/// The opening of a surface; `None` where no border is closed, or has a direction.
#[must_use]
pub fn mouth(places_m: &[DVec3], triangles: &[[u32; 3]], borders: &[Border]) -> Option<Mouth> {
    let is_closed =
        |border: &&Border| border.nodes.len() > 3 && border.nodes.first() == border.nodes.last();
    let longest = borders.iter().filter(is_closed);
    let longest = longest.max_by(|a, b| a.length_m.total_cmp(&b.length_m))?;
    let at = |node: u32| places_m[node as usize];
    let edges = || {
        longest
            .nodes
            .windows(2)
            .map(|pair| [at(pair[0]), at(pair[1])])
    };
    let length_m: f64 = edges().map(|[a, b]| a.distance(b)).sum();
    let middle_m = edges()
        .map(|[a, b]| 0.5 * (a + b) * a.distance(b))
        .sum::<DVec3>()
        / length_m;
    let vector_m2: DVec3 = edges()
        .map(|[a, b]| 0.5 * (a - middle_m).cross(b - middle_m))
        .sum();
    if !(length_m > 0.0 && vector_m2.length() > OPEN * length_m * length_m) {
        return None;
    }
    let normal = vector_m2.normalize();
    let mut area_m2 = 0.0;
    let mut moment = DVec3::ZERO;
    for nodes in triangles {
        let [a, b, c] = nodes.map(at);
        let area = 0.5 * (b - a).cross(c - a).length();
        area_m2 += area;
        moment += area * ((a + b + c) / 3.0 - middle_m);
    }
    let depth_m = -moment.dot(normal) / area_m2;
    Some(Mouth {
        direction: normal * if depth_m < 0.0 { -1.0 } else { 1.0 },
        is_flat: depth_m.abs() < DEPTH * area_m2.sqrt(),
    })
}
