//! Faces of more than three corners as triangles that cover them once, also where they are hollow (concave) or not plane.

use glam::{DVec2, DVec3};

/// Distance from the plane of a face, over its size, from which it is not plane.
const OUT_OF_PLANE: f64 = 1e-6;

/// Area of a triangle, over the square of the size of the face, below which it has none.
const NO_AREA: f64 = 1e-12;

/// By how much a diagonal must be shorter to be taken instead of the usual one.
const SHORTER: f64 = 1.0 - 1e-9;

/// Triangles that cover a face once, as numbers of its corners; `None` if the face crosses itself. A face without area becomes triangles
/// without area.
///
/// Quads that are not plane are cut along the shorter diagonal. Faces that bulge outwards everywhere become a fan about their first corner,
/// others are cut ear by ear (Meisters 1975), those with short diagonals first.
pub fn triangles(corners_m: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let count = corners_m.len();
    let fan = || {
        (1..count.saturating_sub(1))
            .map(|k| [0, k, k + 1])
            .collect()
    };
    let origin = corners_m.first().copied().unwrap_or_default();
    let from_origin = |corner: &DVec3| *corner - origin;
    let pairs = corners_m.iter().zip(corners_m.iter().cycle().skip(1));
    let normal: DVec3 = pairs
        .map(|(a, b)| from_origin(a).cross(from_origin(b)))
        .sum();
    let size_m = corners_m
        .iter()
        .map(|corner| from_origin(corner).length())
        .fold(0.0, f64::max);
    let least_m2 = NO_AREA * size_m * size_m;
    let Some(normal) = normal
        .try_normalize()
        .filter(|_| normal.length() > least_m2)
    else {
        // All of it lies in a line, or its sides cancel out.
        let mut areas = corners_m
            .windows(2)
            .map(|pair| from_origin(&pair[0]).cross(from_origin(&pair[1])));
        let is_line = areas.all(|area| area.length() <= least_m2);
        return is_line.then(fan);
    };
    let across = normal.any_orthonormal_vector();
    let up = normal.cross(across);
    let face = Face {
        corners_m,
        flat_m: corners_m
            .iter()
            .map(|corner| DVec2::new(from_origin(corner).dot(across), from_origin(corner).dot(up)))
            .collect(),
        least_m2,
    };
    if count == 4 {
        let heights = corners_m.iter().map(|c| from_origin(c).dot(normal).abs());
        let is_plane = heights.fold(0.0, f64::max) <= OUT_OF_PLANE * size_m;
        return face.quad(is_plane);
    }
    if face.bulges() {
        return Some(fan());
    }
    if face.crosses_itself() {
        return None;
    }
    face.ears()
}

struct Face<'a> {
    corners_m: &'a [DVec3],
    /// The corners in the plane of the face, which is seen running anticlockwise.
    flat_m: Vec<DVec2>,
    least_m2: f64,
}

impl Face<'_> {
    /// Twice the area of a triangle, negative where it runs clockwise [m²].
    fn area2_m2(&self, [a, b, c]: [usize; 3]) -> f64 {
        (self.flat_m[b] - self.flat_m[a]).perp_dot(self.flat_m[c] - self.flat_m[a])
    }

    fn has_area(&self, triangle: &[usize; 3]) -> bool {
        self.area2_m2(*triangle) > self.least_m2
    }

    fn quad(&self, is_plane: bool) -> Option<Vec<[usize; 3]>> {
        let ways = [[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]];
        let diagonal_m = |a: usize, b: usize| self.corners_m[a].distance(self.corners_m[b]);
        let way = match ways.map(|way| way.iter().all(|t| self.has_area(t))) {
            [true, true] if is_plane => 0,
            [true, true] => usize::from(diagonal_m(1, 3) < SHORTER * diagonal_m(0, 2)),
            [true, false] => 0,
            [false, true] => 1,
            [false, false] => return None,
        };
        Some(ways[way].to_vec())
    }

    /// True if a fan about the first corner covers the face: it turns left everywhere, once around.
    fn bulges(&self) -> bool {
        let count = self.flat_m.len();
        let mut turned = 0.0;
        for k in 0..count {
            let [a, b, c] = [k, (k + 1) % count, (k + 2) % count].map(|k| self.flat_m[k]);
            let turn = (b - a).angle_to(c - b);
            if turn < -1e-9 {
                return false;
            }
            turned += turn;
        }
        turned < 1.5 * std::f64::consts::TAU
            && (1..count - 1).all(|k| self.has_area(&[0, k, k + 1]))
    }

    fn crosses_itself(&self) -> bool {
        let count = self.flat_m.len();
        let next = |k: usize| (k + 1) % count;
        let cuts = |a: usize, b: usize| {
            let sides = [a, next(a)].map(|end| self.area2_m2([b, next(b), end]));
            sides[0] * sides[1] < 0.0
        };
        (0..count).any(|a| (0..a).any(|b| cuts(a, b) && cuts(b, a)))
    }

    fn ears(&self) -> Option<Vec<[usize; 3]>> {
        let mut triangles = Vec::with_capacity(self.flat_m.len() - 2);
        let mut left: Vec<usize> = (0..self.flat_m.len()).collect();
        while left.len() > 3 {
            let count = left.len();
            let ear_at = |k: usize| {
                [
                    left[(k + count - 1) % count],
                    left[k],
                    left[(k + 1) % count],
                ]
            };
            let mut candidates: Vec<(f64, usize)> = (0..count)
                .filter(|k| self.has_area(&ear_at(*k)))
                .map(|k| {
                    let [a, _, c] = ear_at(k);
                    (self.corners_m[a].distance(self.corners_m[c]), k)
                })
                .collect();
            candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
            // What only touches the cut is left alone as long as there is another one.
            let found = [-self.least_m2, self.least_m2].iter().find_map(|margin| {
                let is_free = |(_, k): &&(f64, usize)| {
                    let ear = ear_at(*k);
                    left.iter().all(|corner| !self.holds(ear, *corner, *margin))
                };
                candidates.iter().find(is_free)
            });
            let &(_, k) = found?;
            triangles.push(ear_at(k));
            left.remove(k);
        }
        triangles.push([left[0], left[1], left[2]]);
        Some(triangles)
    }

    /// True if a corner lies in a triangle, by more than `margin_m2` of twice the area to each side, and is none of its own.
    fn holds(&self, [a, b, c]: [usize; 3], corner: usize, margin_m2: f64) -> bool {
        let is_own = |own: usize| own == corner || self.flat_m[own] == self.flat_m[corner];
        ![a, b, c].into_iter().any(is_own)
            && [[a, b, corner], [b, c, corner], [c, a, corner]]
                .iter()
                .all(|side| self.area2_m2(*side) > margin_m2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_m2(corners_m: &[DVec3], triangles: &[[usize; 3]]) -> [f64; 2] {
        let vectors = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|k| corners_m[k]);
            0.5 * (b - a).cross(c - a)
        });
        let sum: DVec3 = vectors.clone().sum();
        [sum.length(), vectors.map(DVec3::length).sum()]
    }

    /// An L, a star, a comb and a triangle with further corners on its sides, tilted: covered once whichever corner comes first.
    #[test]
    fn hollow_faces_are_covered_once() {
        let l = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]];
        let star = [
            [0, -9],
            [2, -2],
            [9, 0],
            [2, 2],
            [0, 9],
            [-2, 2],
            [-9, 0],
            [-2, -2],
        ];
        let comb = [
            [0, 0],
            [7, 0],
            [7, 5],
            [6, 5],
            [5, 1],
            [4, 5],
            [3, 5],
            [2, 1],
            [1, 5],
            [0, 5],
        ];
        let sides = [[0, 0], [1, 0], [2, 0], [6, 0], [3, 3], [0, 6], [0, 2]];
        let dart = [[0, 0], [4, 0], [1, 1], [0, 4]];
        for (flat, expected) in [
            (&l[..], 4.0),
            (&star[..], 72.0),
            (&comb[..], 27.0),
            (&sides[..], 18.0),
            (&dart[..], 4.0),
        ] {
            for first in 0..flat.len() {
                let corners_m: Vec<DVec3> = (0..flat.len())
                    .map(|k| flat[(k + first) % flat.len()])
                    .map(|[x, y]| DVec3::new(f64::from(x), 0.6 * f64::from(y), 0.8 * f64::from(y)))
                    .collect();
                let triangles = triangles(&corners_m).unwrap();
                assert_eq!(triangles.len(), flat.len() - 2);
                for area in area_m2(&corners_m, &triangles) {
                    assert!((area - expected).abs() < 1e-9, "{flat:?} {first} {area}");
                }
            }
        }
    }

    #[test]
    fn quads_out_of_plane_are_cut_along_the_shorter_diagonal() {
        let quad = |heights: [f64; 4], stretch: f64| {
            let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let corners_m: Vec<DVec3> = (0..4)
                .map(|k| {
                    let [x, y] = places[k];
                    DVec3::new(x + stretch * y, y, heights[k])
                })
                .collect();
            triangles(&corners_m).unwrap()[0]
        };
        assert_eq!(quad([0.0; 4], 0.5), [0, 1, 2], "a plane one is a fan");
        assert_eq!(quad([0.1, 0.0, 0.1, 0.0], 0.5), [1, 2, 3]);
        assert_eq!(quad([0.1, 0.0, 0.1, 0.0], -0.5), [0, 1, 2]);
    }

    #[test]
    fn what_crosses_itself_is_none() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let tie = [at(0.0, 0.0), at(1.0, 1.0), at(1.0, 0.0), at(0.0, 1.3)];
        assert_eq!(triangles(&tie), None);
        let symmetric = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)];
        assert_eq!(triangles(&symmetric), None);
        let star = (0..5).map(|k| {
            let (sin, cos) = (f64::from(k) * 0.8 * std::f64::consts::PI).sin_cos();
            at(cos, sin)
        });
        assert_eq!(triangles(&star.collect::<Vec<_>>()), None);
        // Without area: told of each triangle later on.
        assert_eq!(
            triangles(&[at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0), at(3.0, 0.0)])
                .unwrap()
                .len(),
            2
        );
    }
}
