//! Rays and points against the triangles of a surface. Bundles of triangles that follow each other in its list are passed over
//! together where the sphere around them is not met.
//!
//! A ray meets a triangle as in Möller & Trumbore 1997 (J. Graphics Tools 2).

use glam::DVec3;

use super::Surface;

/// Triangles of a bundle.
const BUNDLE: usize = 64;

/// Share by which the sphere around a bundle is larger than it need be.
const SPARE: f64 = 1e-6;

/// How far beyond its edges a triangle is met, over their length: no ray slips through between neighbours.
const BEYOND_EDGES: f64 = 1e-9;

/// Steps of a sequence that fills a square evenly (Roberts 2018, R2).
const EVEN: [f64; 2] = [0.754_877_67, 0.569_840_29];

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// Number of the triangle.
    pub(super) triangle: usize,
    /// Distance from where the ray begins [m]; negative behind it.
    pub(super) distance_m: f64,
    /// 1 where the ray runs against the normal, −1 where it runs along it.
    pub(super) turn: i32,
}

/// The triangles of a surface in bundles.
pub(super) struct Bundles<'a> {
    surface: &'a Surface,
    /// Middle and radius of the sphere around every bundle [m].
    spheres: Vec<(DVec3, f64)>,
}

impl<'a> Bundles<'a> {
    /// Those of a surface.
    pub(super) fn of(surface: &'a Surface) -> Self {
        let sphere = |triangles: &[[u32; 3]]| {
            let corners = || {
                triangles
                    .iter()
                    .flat_map(move |&nodes| surface.corners(nodes))
            };
            let low = corners().fold(DVec3::INFINITY, DVec3::min);
            let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
            let middle_m = 0.5 * (low + high);
            let radius_m = corners()
                .map(|place| place.distance(middle_m))
                .fold(0.0, f64::max);
            (middle_m, (1.0 + SPARE) * radius_m)
        };
        Self {
            surface,
            spheres: surface.triangles.chunks(BUNDLE).map(sphere).collect(),
        }
    }

    /// Numbers and corners of the triangles of bundles whose sphere, by its middle and radius, is `wanted`.
    fn triangles(
        &self,
        wanted: impl Fn(DVec3, f64) -> bool,
    ) -> impl Iterator<Item = (usize, [DVec3; 3])> {
        let surface = self.surface;
        let bundles = self.spheres.iter().enumerate();
        bundles
            .filter(move |(_, sphere)| wanted(sphere.0, sphere.1))
            .flat_map(move |(bundle, _)| {
                let first = bundle * BUNDLE;
                let end = (first + BUNDLE).min(surface.triangles.len());
                (first..end).map(move |number| (number, surface.corners(surface.triangles[number])))
            })
    }

    /// Where a ray, whose direction has unit length, meets triangles; some of those behind it are among them.
    pub(super) fn meetings(
        &self,
        origin_m: DVec3,
        direction: DVec3,
    ) -> impl Iterator<Item = Meeting> {
        let wanted = move |middle_m: DVec3, radius_m: f64| {
            let to_m = middle_m - origin_m;
            let along_m = to_m.dot(direction);
            along_m >= -radius_m && (to_m - direction * along_m).length() <= radius_m
        };
        self.triangles(wanted)
            .filter_map(move |(triangle, corners)| {
                let (distance_m, turn) = meeting(origin_m, direction, corners)?;
                Some(Meeting {
                    triangle,
                    distance_m,
                    turn,
                })
            })
    }

    /// True if a point is within `near_m` of a triangle.
    pub(super) fn is_near(&self, point_m: DVec3, near_m: f64) -> bool {
        let wanted =
            move |middle_m: DVec3, radius_m: f64| middle_m.distance(point_m) <= radius_m + near_m;
        self.triangles(wanted)
            .any(|(_, corners)| distance_m(point_m, corners) <= near_m)
    }

    /// True if a closed surface encloses a point, whichever way its normals point: a ray does not leave it as often as it enters it.
    pub(super) fn encloses(&self, point_m: DVec3, direction: DVec3) -> bool {
        let ahead = self
            .meetings(point_m, direction)
            .filter(|meeting| meeting.distance_m > 0.0);
        ahead.map(|meeting| meeting.turn).sum::<i32>() != 0
    }
}

/// Distance along a ray to a triangle, and 1 where it runs against the normal or −1.
fn meeting(origin_m: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(f64, i32)> {
    let [to_b, to_c] = [b - a, c - a];
    let across = direction.cross(to_c);
    let determinant = to_b.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from_a = origin_m - a;
    let turned = from_a.cross(to_b);
    let share_b = from_a.dot(across) / determinant;
    let share_c = direction.dot(turned) / determinant;
    let is_met = share_b >= -BEYOND_EDGES
        && share_c >= -BEYOND_EDGES
        && share_b + share_c <= 1.0 + BEYOND_EDGES;
    let turn = if determinant > 0.0 { 1 } else { -1 };
    is_met.then(|| (to_c.dot(turned) / determinant, turn))
}

/// Distance of a point from a triangle [m].
fn distance_m(point_m: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let sides = [[a, b], [b, c], [c, a]];
    let is_above = sides
        .iter()
        .all(|&[from, to]| normal.cross(to - from).dot(point_m - from) >= 0.0);
    if is_above && normal != DVec3::ZERO {
        return normal.dot(point_m - a).abs();
    }
    let to_sides = sides.map(|[from, to]| {
        let side = to - from;
        let share = (point_m - from).dot(side) / side.length_squared();
        point_m.distance(from + side * share.clamp(0.0, 1.0))
    });
    to_sides.into_iter().fold(f64::INFINITY, f64::min)
}

/// Points of a surface, spread evenly over its area, and the numbers of their triangles; none on a surface without area.
pub(super) fn points(surface: &Surface, count: usize) -> Vec<(usize, DVec3)> {
    let mut area_m2 = 0.0;
    let ends_m2: Vec<f64> = (surface.area_vectors_m2())
        .map(|area| {
            area_m2 += area.length();
            area_m2
        })
        .collect();
    if area_m2.is_nan() || area_m2 <= 0.0 {
        return Vec::new();
    }
    let place = |number: usize| {
        let at_m2 = area_m2 * (number as f64 + 0.5) / count as f64;
        let triangle = ends_m2
            .partition_point(|end| *end < at_m2)
            .min(surface.triangles.len() - 1);
        let [a, b, c] = surface.corners(surface.triangles[triangle]);
        let [mut s, mut t] = EVEN.map(|step| (number as f64 * step).fract());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        (triangle, a + (b - a) * s + (c - a) * t)
    };
    (0..count).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_a_triangle() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (point, distance) in [
            (DVec3::new(0.2, 0.2, -0.5), 0.5),
            (DVec3::new(0.5, -2.0, 0.0), 2.0),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5f64.sqrt()),
        ] {
            assert!((distance_m(point, corners) - distance).abs() < 1e-12);
        }
        // One without area is a line.
        let line = [DVec3::ZERO, DVec3::X, DVec3::ZERO];
        assert!((distance_m(DVec3::new(0.5, 0.0, 2.0), line) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn rays_meet_triangles_from_both_sides() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let from = DVec3::new(0.25, 0.25, 2.0);
        let (distance, turn) = meeting(from, DVec3::NEG_Z, corners).unwrap();
        assert!((distance - 2.0).abs() < 1e-12 && turn == 1);
        let (distance, turn) = meeting(from, DVec3::Z, corners).unwrap();
        assert!((distance + 2.0).abs() < 1e-12 && turn == -1);
        assert!(meeting(DVec3::new(0.6, 0.6, 2.0), DVec3::NEG_Z, corners).is_none());
        assert!(meeting(from, DVec3::X, corners).is_none());
    }

    /// Nine tenths of the area are two triangles, the rest are many small ones.
    #[test]
    fn points_are_spread_over_the_area() {
        let mut surface = crate::geometry::surfaces::plate([0.1, 1.0], 0.02);
        let many = surface.triangles.len();
        let first = surface.positions_m.len() as u32;
        surface.positions_m.extend([
            DVec3::ZERO,
            DVec3::new(0.9, 0.0, 0.0),
            DVec3::new(0.9, 1.0, 0.0),
            DVec3::new(0.0, 1.0, 0.0),
        ]);
        let corners = [[0, 1, 2], [0, 2, 3]];
        (surface.triangles).extend(corners.map(|corners| corners.map(|node| first + node)));
        let points = points(&surface, 1000);
        let large = points.iter().filter(|(triangle, _)| *triangle >= many);
        assert!((895..=905).contains(&large.clone().count()));
        // A quarter of a rectangle's points lie in a quarter of it.
        let corner = large.filter(|(_, place)| place.x < 0.45 && place.y < 0.5);
        assert!((200..250).contains(&corner.count()));
        assert!(super::points(&Surface::default(), 8).is_empty());
    }
}
