//! Folding: the flat pattern as a pleated cone that keeps every rest length.
//!
//! Seams fold outward to the polar angle α_o from the canopy's axis, centre lines of gores inward to α_i. A half gore stays
//! plane, because the angle between neighbouring fold lines remains that of the flat pattern:
//! cos δ = cos α_o cos α_i + sin α_o sin α_i cos δ, δ = π/gores. So the map is an isometry of every triangle. One
//! parameter remains, which sets the projected area gores · sin α_o sin α_i sin δ · R².

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::gores::{FlatCircular, GoreMesh};

/// Outer fold angle for an inner one [rad].
fn outer_angle(inner: f64, delta: f64) -> f64 {
    let (a, b) = (inner.cos(), inner.sin() * delta.cos());
    b.atan2(a) + (delta.cos() / a.hypot(b)).clamp(-1.0, 1.0).acos()
}

/// Node positions of the canopy pleated to the given projected-diameter ratio √(4 S_p/π)/D₀, apex at the origin, skirt towards
/// −x [m]; `None` for ratios that no such folding reaches (0 < ratio < 1 is needed).
#[must_use]
pub fn pleated_cone(
    pattern: &FlatCircular,
    mesh: &GoreMesh,
    diameter_ratio: f64,
) -> Option<Vec<DVec3>> {
    if !(diameter_ratio > 0.0 && diameter_ratio < 1.0) {
        return None;
    }
    let delta = pattern.half_gore_rad();
    let radius = pattern.skirt_radius_m();
    let target = diameter_ratio * diameter_ratio * pattern.nominal_area_m2;
    let area = |inner: f64| {
        pattern.gores as f64
            * outer_angle(inner, delta).sin()
            * inner.sin()
            * delta.sin()
            * radius
            * radius
    };
    let (mut low, mut high) = (0.0, 0.5 * PI);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if area(middle) < target {
            low = middle
        } else {
            high = middle
        }
    }
    let inner = 0.5 * (low + high);
    let outer = outer_angle(inner, delta);
    let fold_line = |line: usize| {
        let polar = if line.is_multiple_of(2) { outer } else { inner };
        let azimuth = delta * line as f64;
        DVec3::new(
            -polar.cos(),
            polar.sin() * azimuth.cos(),
            polar.sin() * azimuth.sin(),
        )
    };
    Some(positions_along(mesh, delta, fold_line))
}

/// Inner fold angle for an outer one between fold lines that are `half_azimuth` apart about the axis, for half gores of the angle `delta`
/// [rad]; `None` where half gores are too wide for their azimuth, or too narrow.
#[must_use]
pub(super) fn inner_angle(outer: f64, half_azimuth: f64, delta: f64) -> Option<f64> {
    let (a, b) = (outer.cos(), outer.sin() * half_azimuth.cos());
    let cosine = delta.cos() / a.hypot(b);
    if cosine > 1.0 + 1e-12 {
        return None;
    }
    let inner = b.atan2(a) - cosine.min(1.0).acos();
    (inner > 0.0).then_some(inner)
}

/// Half the azimuth that each gore takes where pleats are uneven [rad]: π/N (1 + a cos(2π (g + ½)/N)).
#[must_use]
pub(super) fn half_azimuths(gores: usize, asymmetry: f64) -> Vec<f64> {
    let place = |gore: usize| TAU * (gore as f64 + 0.5) / gores as f64;
    (0..gores)
        .map(|gore| PI / gores as f64 * (1.0 + asymmetry * place(gore).cos()))
        .collect()
}

/// As [`pleated_cone`], with uneven pleats: all seams lean as much, centre lines follow; an isometry, too.
#[must_use]
pub fn uneven_cone(
    pattern: &FlatCircular,
    mesh: &GoreMesh,
    diameter_ratio: f64,
    asymmetry: f64,
) -> Option<Vec<DVec3>> {
    let delta = pattern.half_gore_rad();
    let radius = pattern.skirt_radius_m();
    let target = diameter_ratio * diameter_ratio * pattern.nominal_area_m2;
    let halves = half_azimuths(pattern.gores, asymmetry);
    let inner = |outer: f64| -> Option<Vec<f64>> {
        halves
            .iter()
            .map(|half| inner_angle(outer, *half, delta))
            .collect()
    };
    let area = |outer: f64, inner: &[f64]| -> f64 {
        let gores = halves.iter().zip(inner);
        let sum: f64 = gores.map(|(half, inner)| inner.sin() * half.sin()).sum();
        sum * outer.sin() * radius * radius
    };
    let (mut low, mut high) = (delta, 0.5 * PI);
    let mut best = None;
    for _ in 0..80 {
        let outer = 0.5 * (low + high);
        match inner(outer) {
            Some(inner) if area(outer, &inner) < target => {
                low = outer;
                best = Some((outer, inner));
            }
            _ => high = outer,
        }
    }
    let (outer, inner) = best?;
    if (area(outer, &inner) / target - 1.0).abs() > 1e-3 {
        return None;
    }
    let mut fold_lines = Vec::with_capacity(2 * pattern.gores + 1);
    let direction = |polar: f64, azimuth: f64| {
        DVec3::new(
            -polar.cos(),
            polar.sin() * azimuth.cos(),
            polar.sin() * azimuth.sin(),
        )
    };
    let mut azimuth = 0.0;
    for (half, inner) in halves.iter().zip(&inner) {
        fold_lines.push(direction(outer, azimuth));
        fold_lines.push(direction(*inner, azimuth + half));
        azimuth += 2.0 * half;
    }
    fold_lines.push(fold_lines[0]);
    Some(positions_along(mesh, delta, |line| fold_lines[line]))
}

/// Node positions for given directions of the fold lines.
fn positions_along(mesh: &GoreMesh, delta: f64, fold_line: impl Fn(usize) -> DVec3) -> Vec<DVec3> {
    mesh.flat_positions_m
        .iter()
        .zip(&mesh.half_gores)
        .map(|(flat, &half)| {
            // Coordinates of the node along the two fold lines that bound its half gore.
            let start = delta * half as f64;
            let (along, beside) = (
                flat.y * start.cos() + flat.z * start.sin(),
                flat.z * start.cos() - flat.y * start.sin(),
            );
            let second = beside / delta.sin();
            let first = along - second * delta.cos();
            fold_line(half) * first + fold_line(half + 1) * second
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::gores;
    use super::*;

    #[test]
    fn folding_keeps_every_edge_and_reaches_the_ratio() {
        let pattern = FlatCircular {
            nominal_area_m2: 0.78,
            gores: 8,
            rings: 12,
        };
        let mesh = gores::mesh(&pattern);
        for ratio in [0.1, 0.2, 0.5, 0.9] {
            let folded = pleated_cone(&pattern, &mesh, ratio).unwrap();
            for t in &mesh.triangles {
                for k in 0..3 {
                    let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
                    let flat = mesh.flat_positions_m[a].distance(mesh.flat_positions_m[b]);
                    assert!(
                        (folded[a].distance(folded[b]) - flat).abs() < 1e-12,
                        "{ratio}"
                    );
                }
            }
            let skirt: Vec<DVec3> = folded[folded.len() - 96..].to_vec();
            let area: f64 = (0..96)
                .map(|k| {
                    let (a, b) = (skirt[k], skirt[(k + 1) % 96]);
                    0.5 * (a.y * b.z - a.z * b.y)
                })
                .sum();
            let reached = (4.0 * area / PI).sqrt() / pattern.nominal_diameter_m();
            assert!((reached - ratio).abs() < 0.02, "{ratio} {reached}");
        }
    }
}
