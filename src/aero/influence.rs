//! What a panel does at a point: of constant source, and of doublets that are constant or grow along the chord.
//!
//! With n the normal and r the distance, of a panel A at a point P
//!
//! ```text
//! source   S = 1/(4π) ∫_A 1/r dA              (potential −S of a unit source)
//! doublet  D = 1/(4π) ∫_A n·(P − Q)/r³ dA      (solid angle over 4π; +½ just above the panel, −½ just below)
//! slope    M = 1/(4π) ∫_A ξ n·(P − Q)/r³ dA    (doublet that grows along the chord, ξ = e·(Q − centre))
//! ```
//!
//! With ξ = e·(P − centre) − e·(P − Q), and (P − Q)/r³ the gradient of 1/r by Q, M of a plane triangle is its solid angle and integrals of 1/r along its edges, as S is.
//!
//! A panel is a quadrilateral with the mean of its corners as apex of four plane triangles, so that neighbours share their edges and a closed
//! body has no gaps, however twisted its panels are. Near by, D is the triangles' solid angle (van Oosterom & Strackee, IEEE Trans. Biomed.
//! Eng. 30, 1983) and S the sum over their edges (Hess & Smith, Prog. Aeronautical Sci. 8, 1967). Farther away both are integrated at four
//! Gauss points of the bilinear panel, and farther still at its centre (Katz & Plotkin 2001, section 10.4, have the exact and the point range).

use glam::DVec3;

/// Distances over the panel's diameter beyond which four points, and beyond which one, take the place of the exact integrals. Their relative
/// errors there are below 2e-4 and 2e-3.
const FOUR_POINTS: f64 = 3.0;
const ONE_POINT: f64 = 8.0;

const OVER_4_PI: f64 = 0.25 * std::f64::consts::FRAC_1_PI;

/// A quadrilateral panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Panel {
    /// Corners, counter-clockwise seen from outside [m]; two may coincide.
    pub corners_m: [DVec3; 4],
    /// Their mean [m].
    pub centre_m: DVec3,
    /// ∫ n dA [m²].
    pub area_m2: DVec3,
    /// Area itself [m²], more than the length of ∫ n dA where the panel is twisted.
    size_m2: f64,
    /// Unit normal, outwards.
    pub normal: DVec3,
    /// Longer diagonal or side [m].
    pub diameter_m: f64,
    /// Gauss points of the bilinear panel [m], and ∫ n dA of each share [m²].
    gauss: [(DVec3, DVec3); 4],
    /// Unit vector from the middle of the side between the last and the first corner to that of the side opposite: along the chord.
    pub along: DVec3,
    /// ∫ ξ n dA [m³].
    slope_area_m3: DVec3,
    /// ∫ ξ² dA over the area [m²].
    square_m2: f64,
}

/// What a panel does at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Influence {
    /// Doublet integral D.
    pub doublet: f64,
    /// Doublet integral M of a strength that grows along the chord [m].
    pub doublet_slope_m: f64,
    /// Source integral S [m].
    pub source_m: f64,
}

impl Panel {
    /// The panel between four corners; without a normal where they span no area.
    #[must_use]
    pub fn new(corners_m: [DVec3; 4]) -> Self {
        let [a, b, c, d] = corners_m;
        let area_m2 = 0.5 * (c - a).cross(d - b);
        let g = 0.5 / 3f64.sqrt();
        let gauss = [[-g, -g], [g, -g], [g, g], [-g, g]].map(|[u, v]| {
            let (u, v) = (0.5 + u, 0.5 + v);
            let point = (1.0 - u) * ((1.0 - v) * a + v * d) + u * ((1.0 - v) * b + v * c);
            let along_u = (1.0 - v) * (b - a) + v * (c - d);
            let along_v = (1.0 - u) * (d - a) + u * (c - b);
            (point, 0.25 * along_u.cross(along_v))
        });
        let diameter_m = [c - a, d - b, b - a, c - b, d - c, a - d]
            .map(DVec3::length)
            .into_iter()
            .fold(0.0, f64::max);
        let centre_m = 0.25 * (a + b + c + d);
        let along = (b + c - a - d).normalize_or_zero();
        let size_m2: f64 = gauss.iter().map(|(_, area)| area.length()).sum();
        let squares: f64 = gauss
            .iter()
            .map(|(at, area)| area.length() * along.dot(*at - centre_m).powi(2))
            .sum();
        Self {
            corners_m,
            centre_m,
            area_m2,
            size_m2,
            normal: area_m2.normalize_or_zero(),
            diameter_m,
            gauss,
            along,
            slope_area_m3: gauss
                .iter()
                .map(|(at, area)| *area * along.dot(*at - centre_m))
                .sum(),
            square_m2: squares / size_m2.max(f64::MIN_POSITIVE),
        }
    }

    /// Doublet, slope and source integrals at a point.
    #[must_use]
    pub fn influence(&self, point_m: DVec3) -> Influence {
        let off = point_m - self.centre_m;
        let square = off.length_squared();
        let size = self.diameter_m * self.diameter_m;
        if square > ONE_POINT * ONE_POINT * size {
            let inverse = 1.0 / square.sqrt();
            let doublet = OVER_4_PI * self.area_m2.dot(off) * inverse * inverse * inverse;
            Influence {
                doublet,
                // How the normal turns along the chord, and ∂/∂ξ of n·(P − Q)/r³, over which ξ² is the weight.
                doublet_slope_m: OVER_4_PI * self.slope_area_m3.dot(off) * inverse.powi(3)
                    + 3.0 * self.along.dot(off) / square * self.square_m2 * doublet,
                source_m: OVER_4_PI * self.size_m2 * inverse,
            }
        } else if square > FOUR_POINTS * FOUR_POINTS * size {
            let (mut doublet, mut slope, mut source) = (0.0, 0.0, 0.0);
            for (at, area) in &self.gauss {
                let off = point_m - *at;
                let inverse = 1.0 / off.length();
                let share = area.dot(off) * inverse * inverse * inverse;
                doublet += share;
                slope += share * self.along.dot(*at - self.centre_m);
                source += area.length() * inverse;
            }
            Influence {
                doublet: OVER_4_PI * doublet,
                doublet_slope_m: OVER_4_PI * slope,
                source_m: OVER_4_PI * source,
            }
        } else {
            self.exact(point_m)
        }
    }

    /// The exact integrals over the four triangles.
    #[must_use]
    pub fn exact(&self, point_m: DVec3) -> Influence {
        let apex = self.centre_m - point_m;
        let apex_length = apex.length();
        let corners = self.corners_m.map(|corner| corner - point_m);
        let lengths = corners.map(DVec3::length);
        // ∫ 1/r along the spokes and along the rim.
        let spokes: [f64; 4] =
            std::array::from_fn(|k| line_integral(apex, corners[k], apex_length, lengths[k]));
        let (mut angle, mut slope, mut source) = (0.0, 0.0, 0.0);
        for k in 0..4 {
            let next = (k + 1) % 4;
            let (a, b) = (corners[k], corners[next]);
            let rim = line_integral(a, b, lengths[k], lengths[next]);
            let doubled = (a - apex).cross(b - apex);
            let length = doubled.length();
            // A triangle without area, where corners coincide.
            if length <= 1e-13 * self.diameter_m * self.diameter_m {
                continue;
            }
            let normal = doubled / length;
            let seen = solid_angle([apex, a, b], [apex_length, lengths[k], lengths[next]]);
            let height = -normal.dot(apex);
            let sides = [(apex, a, spokes[k]), (a, b, rim), (b, apex, spokes[next])];
            // ∮ 1/r along the rim of the triangle, times its normal in the plane.
            let mut rims = DVec3::ZERO;
            for (from, to, integral) in sides {
                let outwards = (to - from).cross(normal) * integral;
                // In-plane distance of the edge from the point, times the integral of 1/r along it.
                source += outwards.dot(from);
                rims += outwards;
            }
            source -= height * seen;
            angle += seen;
            let place = -self.along.dot(apex) - height * self.along.dot(normal);
            slope += place * seen - height * self.along.dot(rims);
        }
        Influence {
            doublet: OVER_4_PI * angle,
            doublet_slope_m: OVER_4_PI * slope,
            source_m: OVER_4_PI * source,
        }
    }
}

/// ln((r₁ + r₂ + L)/(r₁ + r₂ − L))/L of an edge from `a` to `b` seen from the origin; zero for an edge without length.
///
/// Next to a long edge r₁ + r₂ − L cancels; with (r₁ + r₂)² − L² = 2 (r₁ r₂ + a·b) = 2 |a × b|²/(r₁ r₂ − a·b) nothing does.
fn line_integral(a: DVec3, b: DVec3, a_length: f64, b_length: f64) -> f64 {
    let length = (b - a).length();
    if length <= 0.0 {
        return 0.0;
    }
    let (product, dot) = (a_length * b_length, a.dot(b));
    let rest = if dot < 0.0 {
        a.cross(b).length_squared() / (product - dot)
    } else {
        product + dot
    };
    let sum = a_length + b_length + length;
    (sum * sum / (2.0 * rest.max(1e-30 * sum * sum))).ln() / length
}

/// Solid angle of a triangle seen from the origin, positive from the side that its normal points to.
fn solid_angle([a, b, c]: [DVec3; 3], [la, lb, lc]: [f64; 3]) -> f64 {
    let volume = a.dot(b.cross(c));
    let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    -2.0 * volume.atan2(under)
}

/// Doublet integral D of a plane quadrilateral, however long.
#[must_use]
pub fn doublet_of_strip([a, b, c, d]: [DVec3; 4], point_m: DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|corner| corner - point_m);
    let [la, lb, lc, ld] = [a, b, c, d].map(DVec3::length);
    OVER_4_PI * (solid_angle([a, b, c], [la, lb, lc]) + solid_angle([a, c, d], [la, lc, ld]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twisted() -> Panel {
        Panel::new([
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(1.1, 0.1, 0.03),
            DVec3::new(1.0, 0.9, -0.02),
            DVec3::new(-0.1, 0.8, 0.04),
        ])
    }

    /// Integrals over many small pieces of the four triangles.
    fn by_pieces(panel: &Panel, point: DVec3) -> [f64; 3] {
        const PIECES: usize = 200;
        let (mut doublet, mut slope, mut source) = (0.0, 0.0, 0.0);
        for k in 0..4 {
            let a = panel.centre_m;
            let (e, f) = (panel.corners_m[k] - a, panel.corners_m[(k + 1) % 4] - a);
            let area = e.cross(f);
            for i in 0..PIECES {
                let u = (i as f64 + 0.5) / PIECES as f64;
                for j in 0..PIECES {
                    let v = (j as f64 + 0.5) / PIECES as f64;
                    // The square on the triangle (Duffy).
                    let q = a + u * ((1.0 - v) * e + v * f);
                    let weight = u / (PIECES * PIECES) as f64;
                    let r = point - q;
                    let share = weight * area.dot(r) / r.length().powi(3);
                    doublet += share;
                    slope += share * panel.along.dot(q - panel.centre_m);
                    source += weight * area.length() / r.length();
                }
            }
        }
        [doublet, slope, source].map(|sum| OVER_4_PI * sum)
    }

    fn numbers(influence: Influence) -> [f64; 3] {
        [
            influence.doublet,
            influence.doublet_slope_m,
            influence.source_m,
        ]
    }

    #[test]
    fn closed_forms_are_the_integrals() {
        let panel = twisted();
        for point in [
            DVec3::new(0.3, 0.4, 0.6),
            DVec3::new(0.3, 0.4, -0.6),
            DVec3::new(1.8, -0.4, 0.3),
            DVec3::new(-2.0, 1.0, 0.1),
        ] {
            let (exact, pieces) = (numbers(panel.exact(point)), by_pieces(&panel, point));
            for (exact, piece) in exact.iter().zip(pieces) {
                assert!((exact - piece).abs() < 1e-5, "{exact:?} {pieces:?}");
            }
        }
    }

    /// The quadratures keep the errors that their ranges promise.
    #[test]
    fn far_fields_join() {
        let panel = twisted();
        // The triangles of a twisted panel are a little larger than its bilinear surface.
        for (range, limit) in [(FOUR_POINTS, 1e-3), (ONE_POINT, 3e-3)] {
            for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.6, -0.48, 0.64)] {
                let point = panel.centre_m + 1.001 * range * panel.diameter_m * direction;
                let [near, far] = [panel.exact(point), panel.influence(point)].map(numbers);
                assert!(near != far);
                let dipole =
                    OVER_4_PI * panel.area_m2.length() / (range * panel.diameter_m).powi(2);
                for (near, far) in near.iter().zip(far).take(2) {
                    assert!((near - far).abs() < limit * dipole, "{near:?} {far:?}");
                }
                assert!((near[2] / far[2] - 1.0).abs() < limit, "{near:?} {far:?}");
            }
        }
    }

    /// The potential of doublets jumps by their strength; a closed surface is seen as 4π from inside and as nothing from outside.
    #[test]
    fn doublets_close() {
        let corner = |k: usize| {
            DVec3::new(
                f64::from(u8::from(k & 1 != 0)),
                f64::from(u8::from(k & 2 != 0)) * 1.3,
                // Not plane.
                f64::from(u8::from(k & 4 != 0)) + if k == 7 { 0.3 } else { 0.0 },
            )
        };
        let box_panels: Vec<Panel> = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ]
        .into_iter()
        .map(|face: [usize; 4]| Panel::new(face.map(corner)))
        .collect();
        let seen = |point| -> f64 { box_panels.iter().map(|p| p.exact(point).doublet).sum() };
        assert!((seen(DVec3::new(0.4, 0.5, 0.6)) + 1.0).abs() < 1e-12);
        assert!(seen(DVec3::new(0.4, 0.5, 1.6)).abs() < 1e-12);
        let top = &box_panels[5];
        for side in [-1.0, 1.0] {
            let doublet = top.exact(top.centre_m + side * 1e-7 * DVec3::Z).doublet;
            assert!((doublet - 0.5 * side).abs() < 0.15, "{doublet}");
        }
        let plane = Panel::new([DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y]);
        assert!((plane.exact(plane.centre_m - 1e-9 * DVec3::Z).doublet + 0.5).abs() < 1e-6);
        let strip = doublet_of_strip(plane.corners_m, DVec3::new(0.2, 0.3, 0.4));
        assert!((strip - plane.exact(DVec3::new(0.2, 0.3, 0.4)).doublet).abs() < 1e-14);
    }

    /// A corner without an edge changes nothing: a triangle given as a quadrilateral.
    #[test]
    fn triangles_are_panels() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let point = DVec3::new(0.1, 0.2, 0.5);
        let whole = Panel::new([a, b, c, c]).exact(point);
        let halves = [[a, b, 0.5 * (b + c), a], [a, 0.5 * (b + c), c, c]]
            .map(|corners| Panel::new(corners).exact(point));
        let [first, second] = halves;
        assert!((whole.doublet - first.doublet - second.doublet).abs() < 1e-12);
        assert!((whole.source_m - first.source_m - second.source_m).abs() < 1e-12);
    }
}
