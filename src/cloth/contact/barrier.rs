//! Energy of a pair that has come closer than its thickness: the clamped logarithmic barrier of incremental potential contact
//! (Li et al. 2020, eq. 6) in the distance itself, with the factor for near-parallel edges of the same paper (eq. 24).
//!
//! With the relative gap s = d/h, h the thickness and κ a stiffness [N/m]:
//!
//! E = κ h² ψ(s) [J], ψ(s) = −(s − 1)² ln s for 0 < s < 1, zero beyond.
//!
//! ψ, ψ′ and ψ″ vanish at s = 1, and E is infinite at s = 0: what touches never passes.

use glam::DVec3;

use super::distance::{edge_edge, node_triangle};
use super::pairs::{Kind, Pair};

/// What a pair does at present.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// Nodes, as in the pair.
    pub nodes: [u32; 4],
    /// Distance [m].
    pub gap_m: f64,
    /// Energy [J].
    pub energy_j: f64,
    /// Its gradient at the nodes [N].
    pub gradient_n: [DVec3; 4],
    /// Weights w of the nodes in the direction n in which the distance grows.
    pub weights: [f64; 4],
    /// n.
    pub normal: DVec3,
    /// Second derivative of the energy along the distance [N/m]: the projected Hessian of the pair is that times w_i w_j n nᵀ.
    pub curvature_n_m: f64,
}

/// ψ, ψ′ and ψ″ at a relative gap s between 0 and 1.
#[must_use]
pub fn barrier(s: f64) -> [f64; 3] {
    let (short, log) = (s - 1.0, s.ln());
    [
        -short * short * log,
        -short * (2.0 * log + short / s),
        -2.0 * log - 4.0 * short / s + short * short / (s * s),
    ]
}

/// The pair's push at these positions, for a stiffness κ [N/m]; `None` beyond its thickness. At distance zero the energy is infinite.
#[must_use]
pub fn push(pair: &Pair, positions: &[DVec3], stiffness_n_m: f64) -> Option<Push> {
    let places = pair.places(positions);
    let nearest = match pair.kind {
        Kind::NodeTriangle => node_triangle(&places),
        Kind::EdgeEdge => edge_edge(&places),
    };
    let gap_m = nearest.gap_m();
    // Not a number goes on, to where energies are looked at.
    if gap_m >= pair.thickness_m {
        return None;
    }
    let h = pair.thickness_m;
    let [value, slope, curvature] = barrier(gap_m / h);
    let mut energy_j = stiffness_n_m * h * h * value;
    let mut slope_n = stiffness_n_m * h * slope;
    let mut curvature_n_m = stiffness_n_m * curvature;
    let normal = nearest.offset_m / gap_m;
    let mut turning = None;
    if let (Kind::EdgeEdge, Some(factor)) = (pair.kind, Parallel::new(pair, &places)) {
        turning = Some((factor, energy_j));
        energy_j *= factor.value;
        slope_n *= factor.value;
        curvature_n_m *= factor.value;
    }
    let mut gradient_n = nearest.weights.map(|weight| normal * (slope_n * weight));
    if let Some((factor, unfactored)) = turning {
        let [first, second] = factor.gradient.map(|g| g * unfactored);
        gradient_n[0] -= first;
        gradient_n[1] += first;
        gradient_n[2] -= second;
        gradient_n[3] += second;
    }
    Some(Push {
        nodes: pair.nodes,
        gap_m,
        energy_j,
        gradient_n,
        weights: nearest.weights,
        normal,
        curvature_n_m,
    })
}

/// The factor that takes nearly parallel edges out, whose nearest points jump from one end to the other: pairs of nodes and triangles
/// keep such edges apart.
#[derive(Debug, Clone, Copy)]
struct Parallel {
    /// (2 − c/ε) c/ε with c = |e₁ × e₂|².
    value: f64,
    /// Its gradient with respect to e₁ and e₂ [1/m].
    gradient: [DVec3; 2],
}

impl Parallel {
    /// `None` for edges that are far enough from parallel.
    fn new(pair: &Pair, places: &[DVec3; 4]) -> Option<Self> {
        let (first, second) = (places[1] - places[0], places[3] - places[2]);
        let c = first.cross(second).length_squared();
        let ratio = c / pair.parallel_m4;
        if ratio >= 1.0 {
            return None;
        }
        let product = first.dot(second);
        let slope = 2.0 * (1.0 - ratio) / pair.parallel_m4;
        Some(Self {
            value: (2.0 - ratio) * ratio,
            gradient: [
                (first * second.length_squared() - second * product) * (2.0 * slope),
                (second * first.length_squared() - first * product) * (2.0 * slope),
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_barrier() {
        for s in [0.01, 0.2, 0.5, 0.9, 0.999] {
            let step = 1e-6 * s;
            let [up, down] = [s + step, s - step].map(barrier);
            let [_, slope, curvature] = barrier(s);
            assert!(((up[0] - down[0]) / (2.0 * step) - slope).abs() < 1e-7 * (1.0 + slope.abs()));
            let found = (up[1] - down[1]) / (2.0 * step);
            assert!((found - curvature).abs() < 1e-6 * (1.0 + curvature));
            assert!(slope < 0.0 && curvature > 0.0);
        }
        assert!(barrier(1.0).iter().all(|v| *v == 0.0));
    }
}
