//! Bending stiffness of membranes: the curvature of every triangle from the bends of its edges, quadratic in the positions.
//!
//! Curvature of a triangle (Grinspun et al. 2006, "Computing discrete shape operators on general meshes"): κ = Σ_e θ_e/(2 A l_e) t_e⊗t_e,
//! with θ_e the angle between its normal and that beyond edge e, t_e perpendicular to the edge in the plane and as long. For
//! small angles the vector l_e θ_e n is the linear combination of the four nodes of both triangles given by cotangents (Bergou et
//! al. 2006, "A quadratic bending model for inextensible surfaces"), so the energy ½ A κ:D:κ is a sum of three squares over six
//! nodes. *Departure from Bergou et al.*: their sum over single edges is three times too stiff for rectangles bent about an edge.
//!
//! The sheet is flat at rest, whatever its rest shape. A triangle at a free edge sees no bend there, and feels no moment across it: its
//! curvature across the edge follows from the others (a narrow strip is as stiff as a beam, E h³/12, not 1/(1 − ν²) times that).

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::elements::EDGES;
use super::{Bending, Structure};

/// Rigidity over that of the whole plate that subtractions may leave where there is none.
const ROUND_OFF: f64 = 1e-12;

/// What is left of a rigidity D \[N m\] where no moment acts along the unit vector `normal`: the curvature κ_nn follows the others, so that the
/// energy is least, D − (D a)(D a)ᵀ/(aᵀ D a) with a = (n_x², n_y², 2 n_x n_y).
fn without_moment_across(d: &mut [[f64; 3]; 3], normal: DVec2) {
    let a = [
        normal.x * normal.x,
        normal.y * normal.y,
        2.0 * normal.x * normal.y,
    ];
    let da = d.map(|row| row[0] * a[0] + row[1] * a[1] + row[2] * a[2]);
    let stiffness = a[0] * da[0] + a[1] * da[1] + a[2] * da[2];
    if stiffness <= ROUND_OFF * (d[0][0] + d[1][1] + d[2][2]) {
        return;
    }
    for (row, left) in d.iter_mut().zip(da) {
        for (entry, right) in row.iter_mut().zip(da) {
            *entry -= left * right / stiffness;
        }
    }
}

/// Cotangent of the angle at `corner` between two places.
fn cotangent(corner: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (a, b) = (a - corner, b - corner);
    a.dot(b) / a.cross(b).length()
}

impl Structure {
    /// Adds bending stiffness to all triangles: `rest_m` their rest places, `warp` along whose projection x lies, `rigidity_nm` the
    /// flexural rigidity \[N m\] with rows and columns xx, yy, engineering xy. Triangles without area are left out.
    pub fn add_curvatures(&mut self, rest_m: &[DVec3], warp: DVec3, rigidity_nm: [[f64; 3]; 3]) {
        self.add_clamped_curvatures(rest_m, warp, rigidity_nm, |_| false);
    }

    /// The same for a sheet that is clamped where triangles meet nodes that are `beyond` the clamp: those triangles get no bending
    /// stiffness, and the bend at a clamp belongs to the triangle on the free side alone, over half of whose width it lies.
    pub fn add_clamped_curvatures(
        &mut self,
        rest_m: &[DVec3],
        warp: DVec3,
        rigidity_nm: [[f64; 3]; 3],
        is_beyond: impl Fn(u32) -> bool,
    ) {
        // Node opposite to every edge, by triangle.
        let mut sides: HashMap<[u32; 2], Vec<(usize, u32)>> = HashMap::new();
        let key = |a: u32, b: u32| [a.min(b), a.max(b)];
        for (t, triangle) in self.triangles.iter().enumerate() {
            for (i, [from, to]) in EDGES.into_iter().enumerate() {
                let edge = key(triangle.nodes[from], triangle.nodes[to]);
                sides.entry(edge).or_default().push((t, triangle.nodes[i]));
            }
        }
        let place = |node: u32| rest_m[node as usize];
        for (t, triangle) in self.triangles.iter().enumerate() {
            if triangle.nodes.into_iter().any(&is_beyond) {
                continue;
            }
            let [a, b, c] = triangle.nodes.map(place);
            let doubled = (b - a).cross(c - a);
            let Some(normal) = doubled.try_normalize() else {
                continue;
            };
            let flat = warp - normal * warp.dot(normal);
            let Some(x) = flat.try_normalize().or_else(|| (b - a).try_normalize()) else {
                continue;
            };
            let y = normal.cross(x);
            // Coefficients of κ_xx, κ_yy, 2κ_xy over the nodes of the triangle and those beyond its edges.
            let mut nodes = [triangle.nodes[0]; 6];
            nodes[..3].copy_from_slice(&triangle.nodes);
            let mut forms = [[0.0; 6]; 3];
            let mut d = rigidity_nm;
            for (i, [from, to]) in EDGES.into_iter().enumerate() {
                let [start, end] = [triangle.nodes[from], triangle.nodes[to]];
                let others = &sides[&key(start, end)];
                // Of an edge that more than two triangles share, the first other one.
                let edge = place(end) - place(start);
                let edge = DVec2::new(edge.dot(x), edge.dot(y));
                let Some(&(_, beyond)) = others.iter().find(|(other, _)| *other != t) else {
                    without_moment_across(&mut d, edge.perp().normalize_or_zero());
                    continue;
                };
                nodes[3 + i] = beyond;
                let [x0, x1, x2, x3] = [start, end, triangle.nodes[i], beyond].map(place);
                let [c01, c02] = [cotangent(x0, x1, x2), cotangent(x0, x1, x3)];
                let [c03, c04] = [cotangent(x1, x0, x2), cotangent(x1, x0, x3)];
                let t = edge.perp() / edge.length();
                let widths = if is_beyond(beyond) { 2.0 } else { 1.0 };
                let factor = widths / doubled.length();
                let share = [t.x * t.x, t.y * t.y, 2.0 * t.x * t.y].map(|d| factor * d);
                for (form, share) in forms.iter_mut().zip(share) {
                    form[from] += share * (c03 + c04);
                    form[to] += share * (c01 + c02);
                    form[i] -= share * (c01 + c03);
                    form[3 + i] -= share * (c02 + c04);
                }
            }
            if forms.iter().flatten().any(|c| !c.is_finite()) {
                continue;
            }
            // D = L diag(p) Lᵀ, so that κ:D:κ is a sum of squares; at free edges D is singular.
            let area = 0.5 * doubled.length();
            for k in 0..3 {
                let pivot = d[k][k];
                if pivot <= ROUND_OFF * rigidity_nm[k][k] {
                    continue;
                }
                let shares = d[k].map(|share| share / pivot);
                let coefficients = std::array::from_fn(|node| {
                    (0..3).map(|row| shares[row] * forms[row][node]).sum()
                });
                self.curvatures.push(Bending {
                    nodes,
                    coefficients,
                    stiffness_n_m: area * pivot,
                });
                for (row, share) in d.iter_mut().zip(shares) {
                    for (entry, other) in row.iter_mut().zip(shares) {
                        *entry -= pivot * share * other;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Triangle;

    /// A plate bent to a cylinder about any axis stores ½ D κ² per area, on rectangles and on sheared cells.
    #[test]
    fn cylinders_store_the_energy_of_plates() {
        let (n, radius, rigidity, poisson) = (24, 4.0, 2.0, 0.3);
        let d = [
            [rigidity, poisson * rigidity, 0.0],
            [poisson * rigidity, rigidity, 0.0],
            [0.0, 0.0, 0.5 * (1.0 - poisson) * rigidity],
        ];
        for shear in [0.0, 0.4] {
            for angle in [0.0, 0.5, 1.2] {
                let h = 1.0 / f64::from(n);
                let mut structure = Structure::default();
                let mut rest = Vec::new();
                for j in 0..=n {
                    for i in 0..=n {
                        let (i, j) = (f64::from(i), f64::from(j));
                        rest.push(DVec3::new((i + shear * j) * h, j * h, 0.0));
                    }
                }
                let id = |i: i32, j: i32| (j * (n + 1) + i) as u32;
                let mut inner_area = 0.0;
                for j in 0..n {
                    for i in 0..n {
                        for nodes in [
                            [id(i, j), id(i + 1, j), id(i + 1, j + 1)],
                            [id(i, j), id(i + 1, j + 1), id(i, j + 1)],
                        ] {
                            let corners = nodes.map(|k| rest[k as usize]);
                            let triangle = Triangle::from_rest_positions(nodes, corners, DVec3::X);
                            structure.triangles.push(triangle.unwrap());
                        }
                        if i > 0 && j > 0 && i + 1 < n && j + 1 < n {
                            inner_area += h * h;
                        }
                    }
                }
                structure.add_curvatures(&rest, DVec3::X, d);
                let (sine, cosine) = f64::sin_cos(angle);
                let bent: Vec<DVec3> = rest
                    .iter()
                    .map(|p| {
                        let along = p.x * cosine + p.y * sine;
                        let across = p.y * cosine - p.x * sine;
                        let a = along / radius;
                        let (x, z) = (radius * a.sin(), radius * (1.0 - a.cos()));
                        DVec3::new(x * cosine - across * sine, x * sine + across * cosine, z)
                    })
                    .collect();
                // Without the outer cells, whose edges do not bend.
                let is_inner = |bending: &&Bending<6>| {
                    bending.nodes[..3].iter().all(|&node| {
                        let (i, j) = (node as i32 % (n + 1), node as i32 / (n + 1));
                        i > 0 && j > 0 && i < n && j < n
                    })
                };
                let energy: f64 = structure
                    .curvatures
                    .iter()
                    .filter(is_inner)
                    .map(|bending| {
                        let terms = bending.nodes.iter().zip(bending.coefficients);
                        let sum: DVec3 = terms.map(|(k, c)| bent[*k as usize] * c).sum();
                        0.5 * bending.stiffness_n_m * sum.length_squared()
                    })
                    .sum();
                let exact = 0.5 * rigidity * inner_area / (radius * radius);
                assert!(
                    (energy / exact - 1.0).abs() < 0.01,
                    "shear {shear}, angle {angle}: {energy} {exact}"
                );
            }
        }
    }
}
