//! Potential flow about a section: linear vorticity on straight panels, stream function constant on the outline.
//!
//! Drela, XFOIL, in Low Reynolds Number Aerodynamics, Springer LNE 54 (1989). Unknowns are the speed γ along the surface at each node, in the
//! order of the nodes, and the stream function's value; the last equation is Kutta's condition γ_first + γ_last = 0. Across an open trailing
//! edge lies a panel with source strength u (b·n) and vorticity u (b·t), u the mean speed there and b the bisector. Where the edge is closed, both
//! its nodes coincide, and the last one's equation is that the jump of γ between the sides is extrapolated linearly to the edge.
//!
//! Displacement adds sources: with σ = dm/ds on each panel, m = u δ*, the speeds are γ = γ₀ + D m. Departure: σ is constant on a panel of the
//! surface, as in Fidkowski (2022).

use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};
use glam::DVec2;

use super::error::SectionError;
use super::influence::{Cut, source_stream, vortex_stream, vortex_velocity};
use super::panelling::Panels;

/// The section's equations, factorised, and what does not depend on the angle.
#[derive(Debug)]
pub struct Inviscid {
    /// The panels.
    pub panels: Panels,
    factors: PartialPivLu<f64>,
    /// Speeds in a stream along x and along y.
    basis: [Vec<f64>; 2],
    /// Change of speed at node i per mass m at node j, signed along the way of the nodes; row by row.
    pub displacement: Mat<f64>,
}

impl Inviscid {
    /// Sets up and factorises.
    pub fn new(panels: Panels) -> Result<Self, SectionError> {
        let n = panels.count();
        let mut matrix = Mat::<f64>::zeros(n + 1, n + 1);
        for (i, &point) in panels.nodes.iter().enumerate() {
            for j in 0..n - 1 {
                let [a, b] = vortex_stream([panels.nodes[j], panels.nodes[j + 1]], point);
                matrix[(i, j)] += a;
                matrix[(i, j + 1)] += b;
            }
            if !panels.is_sharp() {
                let edge = edge_stream(&panels, point);
                matrix[(i, 0)] -= 0.5 * edge;
                matrix[(i, n - 1)] += 0.5 * edge;
            }
            matrix[(i, n)] = -1.0;
        }
        matrix[(n, 0)] = 1.0;
        matrix[(n, n - 1)] = 1.0;
        if panels.is_sharp() {
            for j in 0..=n {
                matrix[(n - 1, j)] = 0.0;
            }
            for side in [[0, 1, 2], [n - 1, n - 2, n - 3]] {
                let sign = if side[0] == 0 { -1.0 } else { 1.0 };
                let step = |k: usize| panels.nodes[side[k]].distance(panels.nodes[side[k + 1]]);
                let ratio = step(0) / step(1);
                matrix[(n - 1, side[0])] += sign;
                matrix[(n - 1, side[1])] -= sign * (1.0 + ratio);
                matrix[(n - 1, side[2])] += sign * ratio;
            }
        }
        let factors = matrix.partial_piv_lu();
        let sides = Mat::from_fn(n + 1, 2, |i, k| {
            if i >= n || (i == n - 1 && panels.is_sharp()) {
                return 0.0;
            }
            // ψ = y of a stream along x, −x of one along y.
            let p = panels.nodes[i];
            if k == 0 { -p.y } else { p.x }
        });
        let solution = factors.solve(&sides);
        let basis = [0, 1].map(|k| (0..n).map(|i| solution[(i, k)]).collect::<Vec<f64>>());
        if basis.iter().flatten().any(|g| !g.is_finite()) {
            return Err(SectionError::Singular);
        }
        let mut inviscid = Self {
            panels,
            factors,
            basis,
            displacement: Mat::zeros(0, 0),
        };
        inviscid.displacement = inviscid.response_to_surface_sources();
        Ok(inviscid)
    }

    /// Speeds along the way of the nodes at an angle of attack.
    pub fn speeds(&self, angle_rad: f64) -> Vec<f64> {
        let (sin, cos) = angle_rad.sin_cos();
        self.basis[0]
            .iter()
            .zip(&self.basis[1])
            .map(|(x, y)| cos * x + sin * y)
            .collect()
    }

    fn response_to_surface_sources(&self) -> Mat<f64> {
        let n = self.panels.count();
        let nodes = &self.panels.nodes;
        let mut sides = Mat::zeros(n, n);
        for (i, &point) in nodes.iter().enumerate() {
            for j in 0..n - 1 {
                let panel = [nodes[j], nodes[j + 1]];
                let [a, b] = source_stream(panel, point, Cut::Left);
                let per_mass = (a + b) / panel[0].distance(panel[1]);
                sides[(i, j)] -= per_mass;
                sides[(i, j + 1)] += per_mass;
            }
        }
        self.respond(&sides)
    }

    /// Speeds that keep the stream function constant, one column per column of stream functions at the nodes.
    pub fn respond(&self, stream: &Mat<f64>) -> Mat<f64> {
        let n = self.panels.count();
        let is_sharp = self.panels.is_sharp();
        let sides = Mat::from_fn(n + 1, stream.ncols(), |i, k| {
            if i >= n || (i == n - 1 && is_sharp) {
                0.0
            } else {
                -stream[(i, k)]
            }
        });
        self.factors.solve(&sides)
    }

    /// Velocity at a point outside per speed at each node; the stream's own is not in it.
    pub fn velocity_per_speed(&self, point: DVec2) -> Vec<DVec2> {
        let nodes = &self.panels.nodes;
        let n = nodes.len();
        let mut velocity = vec![DVec2::ZERO; n];
        for j in 0..n - 1 {
            let [a, b] = vortex_velocity([nodes[j], nodes[j + 1]], point);
            velocity[j] += a;
            velocity[j + 1] += b;
        }
        if !self.panels.is_sharp() {
            let edge = edge_velocity(&self.panels, point);
            velocity[0] -= 0.5 * edge;
            velocity[n - 1] += 0.5 * edge;
        }
        velocity
    }
}

/// The trailing edge's panel with the components of the bisector along it and across.
fn edge_panel(panels: &Panels) -> ([DVec2; 2], f64, f64) {
    let panel = [panels.nodes[panels.count() - 1], panels.nodes[0]];
    let along = (panel[1] - panel[0]).normalize_or_zero();
    (
        panel,
        panels.bisector.dot(along),
        panels.bisector.dot(along.perp()),
    )
}

/// ψ of the trailing edge's panel per mean speed there.
fn edge_stream(panels: &Panels, point: DVec2) -> f64 {
    let (panel, along, across) = edge_panel(panels);
    let vortex: f64 = vortex_stream(panel, point).iter().sum();
    let source: f64 = source_stream(panel, point, Cut::Left).iter().sum();
    along * vortex + across * source
}

/// Velocity of the trailing edge's panel per mean speed there.
fn edge_velocity(panels: &Panels, point: DVec2) -> DVec2 {
    let (panel, along, across) = edge_panel(panels);
    let [a, b] = vortex_velocity(panel, point);
    let [c, d] = super::influence::source_velocity(panel, point);
    along * (a + b) + across * (c + d)
}

/// Lift and moment about the quarter chord of the pressures at the nodes, nose up positive.
pub fn pressure_forces(panels: &Panels, pressures: &[f64], angle_rad: f64) -> [f64; 2] {
    let n = panels.count();
    let wind = DVec2::from_angle(angle_rad).perp();
    let (mut lift, mut moment) = (0.0, 0.0);
    for i in 0..n {
        let j = (i + 1) % n;
        let [a, b] = [panels.nodes[i], panels.nodes[j]];
        let step = b - a;
        // Pressure pushes to the right of the way, into the outline.
        let inwards = -step.perp();
        let (mean, difference) = (
            0.5 * (pressures[i] + pressures[j]),
            pressures[j] - pressures[i],
        );
        lift += mean * inwards.dot(wind);
        let arm = 0.5 * (a + b) - DVec2::new(0.25, 0.0);
        // Pressure varies linearly: its centre lies off the middle.
        moment -= arm.perp_dot(inwards) * mean + difference / 12.0 * step.perp_dot(inwards);
    }
    [lift, moment]
}

#[cfg(test)]
mod tests {
    use super::*;

    type Complex = DVec2;

    fn times(a: Complex, b: Complex) -> Complex {
        DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
    }

    fn over(a: Complex, b: Complex) -> Complex {
        times(a, DVec2::new(b.x, -b.y)) / b.length_squared()
    }

    fn power(a: Complex, n: f64) -> Complex {
        a.length().powf(n) * DVec2::from_angle(a.to_angle() * n)
    }

    /// Karman-Trefftz section from a circle about `centre` through 1: nodes clockwise from the trailing edge, over the chord; exact speeds
    /// along the way and lift coefficient.
    fn karman_trefftz(count: usize, angle: f64, edge: f64) -> (Vec<DVec2>, Vec<f64>, f64) {
        let n = 2.0 - edge / std::f64::consts::PI;
        let centre = DVec2::new(-0.1, 0.08);
        let from = DVec2::X - centre;
        let (radius, beta) = (from.length(), -from.to_angle());
        let map = |z: Complex| {
            let (plus, minus) = (power(z + DVec2::X, n), power(z - DVec2::X, n));
            n * over(plus + minus, plus - minus)
        };
        let slope = |z: Complex| {
            let (plus, minus) = (power(z + DVec2::X, n), power(z - DVec2::X, n));
            let bottom = times(plus - minus, plus - minus);
            let top = times(power(z + DVec2::X, n - 1.0), power(z - DVec2::X, n - 1.0));
            4.0 * n * n * over(top, bottom)
        };
        let circulation = 4.0 * std::f64::consts::PI * radius * (angle + beta).sin();
        let mut points = Vec::new();
        let mut speeds = Vec::new();
        for k in 0..=count {
            let theta = -beta - std::f64::consts::TAU * k as f64 / count as f64;
            let around = DVec2::from_angle(theta);
            points.push(map(centre + radius * around));
            // Speed along the circle, clockwise.
            let on_circle =
                2.0 * (theta - angle).sin() + circulation / (std::f64::consts::TAU * radius);
            speeds.push(on_circle / slope(centre + radius * around).length());
        }
        let right = points[0].x;
        let left = points.iter().fold(0.0, |m: f64, p| m.min(p.x));
        let chord = right - left;
        let mut nodes: Vec<DVec2> = points
            .iter()
            .map(|p| DVec2::new((p.x - left) / chord, p.y / chord))
            .collect();
        nodes[count] = nodes[0];
        (nodes, speeds, 2.0 * circulation / chord)
    }

    /// Lift converges with the square of the panels' length at least, pressures to less than a hundredth.
    #[test]
    fn karman_trefftz_sections_have_their_exact_flow() {
        for angle in [-0.05, 0.1] {
            let mut errors = Vec::new();
            for count in [80, 160, 320] {
                let (nodes, exact, lift) = karman_trefftz(count, angle, 0.2);
                let inviscid = Inviscid::new(Panels::from_nodes(nodes)).unwrap();
                let speeds = inviscid.speeds(angle);
                let pressures: Vec<f64> = speeds.iter().map(|u| 1.0 - u * u).collect();
                let [computed, _] = pressure_forces(&inviscid.panels, &pressures, angle);
                let inner = 3..count - 2;
                let worst = inner
                    .map(|k| (speeds[k] * speeds[k] - exact[k] * exact[k]).abs())
                    .fold(0.0, f64::max);
                errors.push([(computed - lift).abs(), worst]);
            }
            for pair in errors.windows(2) {
                for k in 0..2 {
                    assert!(pair[1][k] < 0.35 * pair[0][k], "{errors:?}");
                }
            }
            assert!(errors[1][0] < 0.002 && errors[1][1] < 0.02, "{errors:?}");
        }
    }
}
