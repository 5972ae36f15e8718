//! Distances of a node from a triangle and of two edges, with the weights of the nearest points.
//!
//! With nearest points Σ w_i x_i on either side (weights positive on the one, negative on the other) the distance is d = |Σ w_i x_i|, and
//! its gradient is w_i n with n = Σ w_i x_i/d: the nearest points move along their own side, where d does not change (Ericson 2005,
//! sections 5.1.5 and 5.1.9, for the nearest points).

use glam::DVec3;

/// Where two sides of a pair are nearest.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// Weights of the four nodes; they sum to zero.
    pub weights: [f64; 4],
    /// From the second side to the first [m].
    pub offset_m: DVec3,
}

impl Nearest {
    /// The distance [m].
    #[must_use]
    pub fn gap_m(&self) -> f64 {
        self.offset_m.length()
    }

    fn new(weights: [f64; 4], places: &[DVec3; 4]) -> Self {
        let mut offset_m = DVec3::ZERO;
        for (weight, place) in weights.into_iter().zip(places) {
            offset_m += *place * weight;
        }
        Self { weights, offset_m }
    }

    fn nearer(self, other: Self) -> Self {
        if other.offset_m.length_squared() < self.offset_m.length_squared() {
            other
        } else {
            self
        }
    }
}

/// Below this square of the sine of their angle, edges are taken to be parallel as far as round-off can tell.
const PARALLEL: f64 = 1e-14;

/// Share of a segment at which it is nearest to a point; the start of a segment without length.
fn share_along(point: DVec3, start: DVec3, end: DVec3) -> f64 {
    let along = end - start;
    let square = along.length_squared();
    if square > 0.0 {
        ((point - start).dot(along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// A node (first) and a triangle.
#[must_use]
pub fn node_triangle(places: &[DVec3; 4]) -> Nearest {
    let [p, a, b, c] = *places;
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let square = normal.length_squared();
    // A triangle that has collapsed to a line is its edges.
    if square > 1e-24 * ab.length_squared() * ac.length_squared() {
        let ap = p - a;
        let second = ap.cross(ac).dot(normal) / square;
        let third = ab.cross(ap).dot(normal) / square;
        let first = 1.0 - second - third;
        if first >= 0.0 && second >= 0.0 && third >= 0.0 {
            return Nearest::new([1.0, -first, -second, -third], places);
        }
    }
    let on_edge = |from: usize, to: usize| {
        let share = share_along(p, places[from], places[to]);
        let mut weights = [1.0, 0.0, 0.0, 0.0];
        weights[from] = share - 1.0;
        weights[to] = -share;
        Nearest::new(weights, places)
    };
    on_edge(1, 2).nearer(on_edge(2, 3)).nearer(on_edge(3, 1))
}

/// Two edges, nodes 0–1 and 2–3.
#[must_use]
pub fn edge_edge(places: &[DVec3; 4]) -> Nearest {
    let [a, b, c, d] = *places;
    let (first, second, between) = (b - a, d - c, a - c);
    let (aa, cc, ac) = (
        first.length_squared(),
        second.length_squared(),
        first.dot(second),
    );
    let at = |s: f64, t: f64| Nearest::new([1.0 - s, s, t - 1.0, -t], places);
    let determinant = aa * cc - ac * ac;
    if determinant > PARALLEL * aa * cc {
        let along_first = first.dot(between);
        let along_second = second.dot(between);
        let s = ((ac * along_second - along_first * cc) / determinant).clamp(0.0, 1.0);
        let t = (ac * s + along_second) / cc;
        if (0.0..=1.0).contains(&t) {
            return at(s, t);
        }
        let t = t.clamp(0.0, 1.0);
        return at(share_along(c + second * t, a, b), t);
    }
    // Parallel edges, or one without length: nearest at one of the ends.
    at(0.0, share_along(a, c, d))
        .nearer(at(1.0, share_along(b, c, d)))
        .nearer(at(share_along(c, a, b), 0.0))
        .nearer(at(share_along(d, a, b), 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Against the smallest of many samples, in random positions of which many have their nearest points on edges or corners.
    #[test]
    fn distances_are_those_of_the_nearest_samples() {
        const SAMPLES: usize = 60;
        let mut seed = 5;
        for _ in 0..200 {
            let places: [DVec3; 4] = std::array::from_fn(|_| {
                DVec3::new(random(&mut seed), random(&mut seed), random(&mut seed))
            });
            let [p, a, b, c] = places;
            let share = |i: usize| i as f64 / SAMPLES as f64;
            let (mut triangle, mut edges) = (f64::INFINITY, f64::INFINITY);
            for i in 0..=SAMPLES {
                for j in 0..=SAMPLES {
                    if i + j <= SAMPLES {
                        triangle =
                            triangle.min(p.distance(a + (b - a) * share(i) + (c - a) * share(j)));
                    }
                    edges = edges.min((p + (a - p) * share(i)).distance(b + (c - b) * share(j)));
                }
            }
            for (found, sampled) in [
                (node_triangle(&places).gap_m(), triangle),
                (edge_edge(&places).gap_m(), edges),
            ] {
                assert!(found <= sampled + 1e-12, "{found} {sampled}");
                assert!(sampled - found < 0.08, "{found} {sampled}");
            }
        }
    }

    #[test]
    fn degenerate_pairs_have_distances_too() {
        let x = DVec3::X;
        let line = [DVec3::Y, DVec3::ZERO, x, x * 2.0];
        assert!((node_triangle(&line).gap_m() - 1.0).abs() < 1e-15);
        let point = [DVec3::Y; 4];
        assert!(node_triangle(&point).gap_m() == 0.0);
        assert!(edge_edge(&point).gap_m() == 0.0);
        let parallel = [DVec3::ZERO, x, x * 3.0 + DVec3::Y, x * 0.5 + DVec3::Y];
        assert!((edge_edge(&parallel).gap_m() - 1.0).abs() < 1e-15);
        let collinear = [DVec3::ZERO, x, x * 3.0, x * 2.0];
        assert!((edge_edge(&collinear).gap_m() - 1.0).abs() < 1e-15);
    }
}
