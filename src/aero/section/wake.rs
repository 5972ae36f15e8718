//! The wake, and how displacement changes the speed at every station of surface and wake.
//!
//! The wake follows the inviscid streamline from the trailing edge for a chord, in panels that grow geometrically (Drela 1989). Its sources have
//! the strength dm/ds at the panels' middles, half-way means at the nodes, and vary linearly between, so that speeds at the nodes are finite
//! (Fidkowski 2022). The first node has the trailing edge's speed.

use faer::Mat;
use glam::DVec2;

use super::influence::{Cut, source_stream, source_velocity};
use super::inviscid::Inviscid;

/// Length of the wake [chords].
const LENGTH: f64 = 1.0;

/// Length of the dead air behind an open trailing edge over its gap.
const DEAD_AIR: f64 = 2.5;

/// A flow at one angle of attack, with its response to displacement. Stations are the surface's nodes, then the wake's.
#[derive(Debug)]
pub struct Flow {
    /// Speeds without displacement, along the way of the nodes and down the wake.
    pub speeds: Vec<f64>,
    /// Change of those speeds per mass u δ*, which counts negative on the lower side.
    pub response: Mat<f64>,
    /// Distance of each wake node behind the trailing edge along the wake [chords].
    pub behind: Vec<f64>,
    /// Thickness of the dead air at each wake node [chords].
    pub dead_air: Vec<f64>,
}

impl Flow {
    /// Lays the wake at an angle of attack and finds the response.
    pub fn new(inviscid: &Inviscid, angle_rad: f64) -> Self {
        let n = inviscid.panels.count();
        let mut speeds = inviscid.speeds(angle_rad);
        let stream = DVec2::from_angle(angle_rad);
        let wake = trace(inviscid, &speeds, stream);
        let count = wake.len();
        let mut sides = Mat::zeros(n, count);
        for (i, &point) in inviscid.panels.nodes.iter().enumerate() {
            let weights = per_wake_mass(&wake, |half| source_stream(half, point, Cut::Ahead));
            for (k, weight) in weights.into_iter().enumerate() {
                sides[(i, k)] = weight;
            }
        }
        let by_wake = inviscid.respond(&sides);
        let mut response = Mat::zeros(n + count, n + count);
        for i in 0..n {
            for j in 0..n {
                response[(i, j)] = inviscid.displacement[(i, j)];
            }
            for k in 0..count {
                response[(i, n + k)] = by_wake[(i, k)];
            }
        }
        speeds.push(speeds[n - 1]);
        for j in 0..n + count {
            response[(n, j)] = response[(n - 1, j)];
        }
        for (k, &point) in wake.iter().enumerate().skip(1) {
            let per_speed = inviscid.velocity_per_speed(point);
            let velocity = stream + weighted(&per_speed, &speeds[..n]);
            let along = velocity.normalize_or_zero();
            speeds.push(velocity.length());
            let shares: Vec<f64> = per_speed.iter().map(|v| v.dot(along)).collect();
            // Column by column, as they lie in memory.
            for j in 0..n + count {
                let terms = shares.iter().enumerate();
                let sum: f64 = terms.map(|(i, share)| share * response[(i, j)]).sum();
                response[(n + k, j)] += sum;
            }
            let nodes = &inviscid.panels.nodes;
            for j in 0..n - 1 {
                let panel = [nodes[j], nodes[j + 1]];
                let [a, b] = source_velocity(panel, point);
                let per_mass = (a + b).dot(along) / panel[0].distance(panel[1]);
                response[(n + k, j)] -= per_mass;
                response[(n + k, j + 1)] += per_mass;
            }
            let weights = per_wake_mass(&wake, |half| {
                source_velocity(half, point).map(|v| v.dot(along))
            });
            for (j, weight) in weights.into_iter().enumerate() {
                response[(n + k, n + j)] += weight;
            }
        }
        let mut behind = vec![0.0; count];
        for k in 1..count {
            behind[k] = behind[k - 1] + wake[k].distance(wake[k - 1]);
        }
        let dead_air = behind
            .iter()
            .map(|&at| dead_air(inviscid.panels.gap, inviscid.panels.closing, at))
            .collect();
        Self {
            speeds,
            response,
            behind,
            dead_air,
        }
    }
}

fn weighted(vectors: &[DVec2], weights: &[f64]) -> DVec2 {
    vectors.iter().zip(weights).map(|(&v, &w)| w * v).sum()
}

/// Nodes of the wake from the trailing edge.
fn trace(inviscid: &Inviscid, speeds: &[f64], stream: DVec2) -> Vec<DVec2> {
    let panels = &inviscid.panels;
    let n = panels.count();
    let count = n / 8 + 2;
    let first = 0.5 * (panels.along[1] + panels.along[n - 1] - panels.along[n - 2]);
    let ratio = growth(LENGTH / first, count - 1);
    let mut step = first;
    let mut direction = panels.bisector;
    let mut wake = vec![panels.trailing_edge()];
    for k in 1..count {
        let next = wake[k - 1] + step * direction;
        direction =
            (stream + weighted(&inviscid.velocity_per_speed(next), speeds)).normalize_or_zero();
        wake.push(next);
        step *= ratio;
    }
    wake
}

/// Ratio of a geometric series of `terms` terms that begins with 1 and has this sum.
fn growth(sum: f64, terms: usize) -> f64 {
    let (mut low, mut high) = (0.5, 4.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let total: f64 = (0..terms).map(|k| f64::powi(middle, k as i32)).sum();
        if total < sum {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Effect of the mass at each wake node, from what strengths at the ends of a half panel do.
fn per_wake_mass(wake: &[DVec2], effect: impl Fn([DVec2; 2]) -> [f64; 2]) -> Vec<f64> {
    let panels = wake.len() - 1;
    let mut per_strength = vec![0.0; panels];
    for k in 0..panels {
        let middle = 0.5 * (wake[k] + wake[k + 1]);
        let [at_first, at_middle] = effect([wake[k], middle]);
        let [also_middle, at_last] = effect([middle, wake[k + 1]]);
        per_strength[k] += at_middle + also_middle;
        for (node, value) in [(k, at_first), (k + 1, at_last)] {
            per_strength[node.saturating_sub(1)] += 0.5 * value;
            per_strength[node.min(panels - 1)] += 0.5 * value;
        }
    }
    let mut per_mass = vec![0.0; wake.len()];
    for (k, strength) in per_strength.iter().enumerate() {
        let weight = strength / wake[k].distance(wake[k + 1]);
        per_mass[k] -= weight;
        per_mass[k + 1] += weight;
    }
    per_mass
}

/// Cubic from the gap, with the sides' closing as slope, to nothing.
fn dead_air(gap: f64, closing: f64, behind: f64) -> f64 {
    let left = 1.0 - behind / (DEAD_AIR * gap).max(1e-12);
    if left <= 0.0 {
        return 0.0;
    }
    let slope = DEAD_AIR * closing.clamp(-1.2, 1.2);
    gap * (3.0 - slope - (2.0 - slope) * left) * left * left
}
