//! Finite elements of fabric: their rest state and their kinematics.
//!
//! A membrane triangle is described by the squared elongations of its edges, s_i = l_i² − L_i² (Delingette 2008): the
//! Green strain is linear in them, E = B s, so forces act along the edges only and any St Venant–Kirchhoff law, also an
//! orthotropic one, is represented exactly.

use glam::{DVec2, DVec3};

use crate::frame::CableKind;
use crate::lines::drag::LineDrag;

/// Rest state of a membrane triangle.
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    /// Nodes.
    pub nodes: [u32; 3],
    /// What it is made of: 0 for the structure's first fabric, k for [`crate::cloth::Structure::further_fabrics`]`[k − 1]`.
    pub fabric: u32,
    /// Rest area [m²].
    pub rest_area_m2: f64,
    /// Squared rest lengths of the edges (1→2, 2→0, 0→1) [m²].
    pub rest_squares_m2: [f64; 3],
    /// B of E = B s: rows xx, yy, 2·xy in fabric axes (x along the warp) [1/m²].
    pub strain_from_squares: [[f64; 3]; 3],
}

/// Edge i runs from `EDGES[i][0]` to `EDGES[i][1]`, opposite node i.
pub const EDGES: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// Length of a direction's projection on a triangle, over its own, below which the direction counts as across it: beyond what places with six
/// digits turn a triangle by.
const ACROSS: f64 = 1e-3;

impl Triangle {
    /// Triangle with the given rest shape in fabric axes [m]; `None` if its area is zero or not finite.
    #[must_use]
    pub fn new(nodes: [u32; 3], rest_m: [DVec2; 3]) -> Option<Self> {
        let edges = EDGES.map(|[from, to]| rest_m[to] - rest_m[from]);
        let rest_area_m2 = 0.5 * edges[2].perp_dot(-edges[1]).abs();
        let longest = edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max);
        if !(rest_area_m2.is_finite() && rest_area_m2 > 1e-9 * longest && longest > 0.0) {
            return None;
        }
        // s_i = 2 (dx² Exx + dy² Eyy + dx dy · 2Exy); invert the 3×3 matrix.
        let d = edges.map(|e| DVec3::new(e.x * e.x, e.y * e.y, e.x * e.y) * 2.0);
        let matrix = glam::DMat3::from_cols(d[0], d[1], d[2]).transpose();
        let inverse = matrix.inverse();
        let strain_from_squares = [0, 1, 2].map(|row| inverse.row(row).to_array());
        if !strain_from_squares.iter().flatten().all(|b| b.is_finite()) {
            return None;
        }
        Some(Self {
            nodes,
            fabric: 0,
            rest_area_m2,
            rest_squares_m2: edges.map(|e| e.length_squared()),
            strain_from_squares,
        })
    }

    /// Triangle whose rest shape is flat in space, with the warp along the projection of `warp`.
    #[must_use]
    pub fn from_rest_positions(nodes: [u32; 3], rest_m: [DVec3; 3], warp: DVec3) -> Option<Self> {
        Self::laid_out(nodes, rest_m, warp, [0.0; 2])
    }

    /// Triangle that is stretched along warp and weft by `initial_strain` where it is laid out. The warp lies along the projection of `warp`
    /// on the triangle; along that of y where `warp` stands on it, and of z where that is y.
    #[must_use]
    pub fn laid_out(
        nodes: [u32; 3],
        rest_m: [DVec3; 3],
        warp: DVec3,
        initial_strain: [f64; 2],
    ) -> Option<Self> {
        let shrink = DVec2::ONE / (DVec2::ONE + DVec2::from_array(initial_strain));
        let normal = (rest_m[1] - rest_m[0])
            .cross(rest_m[2] - rest_m[0])
            .try_normalize()?;
        // What rounding leaves of a direction across the triangle is none within it.
        let x = [warp, DVec3::Y, DVec3::Z]
            .into_iter()
            .find_map(|direction| {
                let within = direction - normal * direction.dot(normal);
                (within.length() > ACROSS * direction.length()).then(|| within.normalize())
            })?;
        let y = normal.cross(x);
        Self::new(
            nodes,
            rest_m.map(|p| shrink * DVec2::new((p - rest_m[0]).dot(x), (p - rest_m[0]).dot(y))),
        )
    }

    /// Vectors along the edges at present.
    #[inline]
    #[must_use]
    pub fn edge_vectors(&self, positions: &[DVec3]) -> [DVec3; 3] {
        let corners = self.nodes.map(|n| positions[n as usize]);
        EDGES.map(|[from, to]| corners[to] - corners[from])
    }

    /// Green strain (xx, yy, 2·xy) for the given edge vectors.
    #[inline]
    #[must_use]
    pub fn strain(&self, edges: &[DVec3; 3]) -> [f64; 3] {
        let s: [f64; 3] =
            std::array::from_fn(|i| edges[i].length_squared() - self.rest_squares_m2[i]);
        self.strain_from_squares
            .map(|row| row[0] * s[0] + row[1] * s[1] + row[2] * s[2])
    }

    /// Twice the present area times the unit normal [m²].
    #[inline]
    #[must_use]
    pub fn doubled_area_vector(&self, positions: &[DVec3]) -> DVec3 {
        let [a, b, c] = self.nodes.map(|n| positions[n as usize]);
        (b - a).cross(c - a)
    }
}

/// A spring of a network.
#[derive(Debug, Clone, Copy)]
pub struct Spring {
    /// Ends.
    pub nodes: [u32; 2],
    /// Rest length [m].
    pub rest_length_m: f64,
    /// Stiffness when stretched [N/m].
    pub stiffness_n_m: f64,
    /// Stiffness when shortened [N/m].
    pub compressive_stiffness_n_m: f64,
}

/// Quadratic bending ½ k |Σ c_i x_i|² over some nodes, flat at rest.
///
/// Coefficients sum to zero, and so do their first moments over the rest shape: rigid and in-plane motion cost nothing.
#[derive(Debug, Clone, Copy)]
pub struct Bending<const NODES: usize> {
    /// Nodes; the last ones repeat where fewer are needed.
    pub nodes: [u32; NODES],
    /// c_i
    pub coefficients: [f64; NODES],
    /// Stiffness [N/m].
    pub stiffness_n_m: f64,
}

impl Bending<3> {
    /// ½ k |x₋ − 2x + x₊|² along a row of nodes.
    #[must_use]
    pub const fn second_difference(nodes: [u32; 3], stiffness_n_m: f64) -> Self {
        Self {
            nodes,
            coefficients: [1.0, -2.0, 1.0],
            stiffness_n_m,
        }
    }

    /// ½ E I κ² s of a rod that is straight at rest, at a node between edges of the given lengths [m]: s is half of both,
    /// κ = |(x₊ − x)/b − (x − x₋)/a|/s. `flexural_rigidity_nm2` is E I.
    #[must_use]
    pub fn of_rod(nodes: [u32; 3], [before, behind]: [f64; 2], flexural_rigidity_nm2: f64) -> Self {
        let share = 0.5 * (before + behind);
        let [before, behind] = [share / before, share / behind];
        Self {
            nodes,
            coefficients: [before, -(before + behind), behind],
            stiffness_n_m: flexural_rigidity_nm2 / share.powi(3),
        }
    }
}

/// A straight piece of a cable.
#[derive(Debug, Clone, Copy)]
pub struct CableSegment {
    /// Ends.
    pub nodes: [u32; 2],
    /// Rest length [m].
    pub rest_length_m: f64,
    /// What it carries at which strain; a number of [`crate::cloth::Structure::cable_laws`].
    pub law: u32,
    /// Axial damping c of F = f(ε) + c dε/dt while taut [N s].
    pub damping_n_s: f64,
    /// Load at which it breaks \[N\], if it is told.
    pub breaking_load_n: Option<f64>,
    /// What the wind meets; `None`: it feels no air.
    pub drag: Option<LineDrag>,
    /// What it is for.
    pub kind: CableKind,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn homogeneous_deformations_give_the_exact_green_strain() {
        let rest = [
            DVec2::new(0.1, 0.2),
            DVec2::new(0.9, 0.05),
            DVec2::new(0.3, 0.8),
        ];
        let triangle = Triangle::new([0, 1, 2], rest).unwrap();
        // x = F X with a 3×2 deformation gradient; E = ½ (FᵀF − I).
        let f = [DVec3::new(1.1, 0.2, 0.3), DVec3::new(-0.1, 0.8, 0.5)];
        let positions: Vec<DVec3> = rest.iter().map(|p| f[0] * p.x + f[1] * p.y).collect();
        let strain = triangle.strain(&triangle.edge_vectors(&positions));
        let expected = [
            0.5 * (f[0].length_squared() - 1.0),
            0.5 * (f[1].length_squared() - 1.0),
            f[0].dot(f[1]),
        ];
        for k in 0..3 {
            assert!((strain[k] - expected[k]).abs() < 1e-13);
        }
    }

    #[test]
    fn initial_strain_shrinks_the_rest_shape() {
        let places = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let triangle = Triangle::laid_out([0, 1, 2], places, DVec3::X, [0.02, 0.01]).unwrap();
        let strain = triangle.strain(&triangle.edge_vectors(&places));
        let green = |stretch: f64| 0.5 * (stretch * stretch - 1.0);
        for (found, expected) in strain.iter().zip([green(1.02), green(1.01), 0.0]) {
            assert!((found - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn degenerate_triangles_are_refused() {
        let line = [
            DVec2::new(0.0, 0.0),
            DVec2::new(1.0, 1.0),
            DVec2::new(2.0, 2.0),
        ];
        assert!(Triangle::new([0, 1, 2], line).is_none());
        assert!(Triangle::new([0, 1, 2], [DVec2::ZERO; 3]).is_none());
        let bad = [
            DVec2::new(f64::NAN, 0.0),
            DVec2::new(1.0, 1.0),
            DVec2::new(2.0, 0.0),
        ];
        assert!(Triangle::new([0, 1, 2], bad).is_none());
    }

    /// A rod bent to a circle stores ½ E I/R² per length, wherever its nodes stand.
    #[test]
    fn a_bent_rod_stores_the_energy_of_a_beam() {
        let (radius, rigidity) = (0.3, 0.004);
        let place = |angle: f64| radius * DVec3::new(angle.cos(), 0.0, angle.sin());
        // Edges of 0.5 to 1.5 degrees.
        let angles: Vec<f64> = (0..60)
            .map(|i| f64::from(i) + 0.25 * (2.3 * f64::from(i)).sin())
            .map(f64::to_radians)
            .collect();
        let places: Vec<DVec3> = angles.iter().map(|angle| place(*angle)).collect();
        let lengths: Vec<f64> = places.windows(2).map(|p| p[0].distance(p[1])).collect();
        let (mut energy, mut length) = (0.0, 0.0);
        for (three, pair) in places.windows(3).zip(lengths.windows(2)) {
            let bending = Bending::of_rod([0, 1, 2], [pair[0], pair[1]], rigidity);
            let terms = three.iter().zip(bending.coefficients);
            let sum: DVec3 = terms.map(|(place, c)| place * c).sum();
            energy += 0.5 * bending.stiffness_n_m * sum.length_squared();
            length += 0.5 * (pair[0] + pair[1]);
        }
        let exact = 0.5 * rigidity * length / (radius * radius);
        assert!((energy / exact - 1.0).abs() < 1e-3, "{energy} {exact}");
    }

    /// A flat sheet across the warp takes y, with places as exact as six digits make them.
    #[test]
    fn fabric_that_stands_across_the_warp_takes_the_next_direction() {
        for noise in [0.0, 5e-7, -5e-7] {
            let rest = [[noise, 0.0, 0.0], [0.0, 0.04, 0.03], [0.0, -0.02, 0.05]];
            let rest = rest.map(DVec3::from_array);
            let triangle = Triangle::from_rest_positions([0, 1, 2], rest, DVec3::X).unwrap();
            let stretched = rest.map(|p| p * DVec3::new(1.0, 1.2, 1.0));
            let strain = triangle.strain(&triangle.edge_vectors(&stretched));
            assert!(
                (strain[0] - 0.5 * (1.2 * 1.2 - 1.0)).abs() < 1e-6,
                "{strain:?}"
            );
            assert!(strain[1].abs().max(strain[2].abs()) < 1e-6, "{strain:?}");
        }
    }
}
