//! Velocity along a surface from the potential of its panels.
//!
//! The tangential velocity is the onset flow's, the surface gradient of φ added. The gradient comes from the neighbours' centres.
//! Five of them give the chord-wise derivative, over the length of the strip's polygon. A parabola through three gives the span-wise one, over their distance;
//! at trailing edges and tips both are one-sided. The gradient is the vector in the panel's plane that has both derivatives (Katz & Plotkin 2001, section 12.3, with
//! differences over lengths in place of panel numbers). Panels of caps take the chord-wise derivative alone: around the
//! edges of a tip potential flow would be infinitely fast, where air separates.

use glam::DVec3;

use super::chordwise;
use super::surface::{Cap, PanelSurface, mirrored};

/// Centres from which the derivative along the chord is taken.
const CHORDWISE_POINTS: usize = 5;

/// A value with its place.
type Sample = (DVec3, f64);

/// Velocity at the panels' centres [m/s].
pub(super) fn on_surface(surface: &PanelSurface, potential: &[f64], onset: &[DVec3]) -> Vec<DVec3> {
    let tangential = |panel: usize, gradient: DVec3| {
        let normal = surface.panels[panel].normal;
        let velocity = onset[surface.strip_of(panel)] + gradient;
        velocity - normal * normal.dot(velocity)
    };
    let mut velocities: Vec<DVec3> = (0..surface.spanwise)
        .flat_map(|strip| {
            let weights = chordwise::derivatives(surface, strip, CHORDWISE_POINTS);
            let first = strip * surface.chordwise;
            let panels = weights.into_iter().enumerate();
            panels.map(move |(i, weights)| {
                let panel = first + i;
                tangential(panel, in_strip(surface, potential, panel, &weights))
            })
        })
        .collect();
    for cap in &surface.caps {
        for k in 0..surface.chordwise / 2 {
            let panel = cap.first + k;
            velocities.push(tangential(panel, in_cap(surface, potential, *cap, k)));
        }
    }
    velocities
}

fn sample(surface: &PanelSurface, potential: &[f64], panel: usize) -> Sample {
    (surface.panels[panel].centre_m, potential[panel])
}

/// Surface gradient at a panel of a strip, with the weights of its derivative along the chord.
fn in_strip(
    surface: &PanelSurface,
    potential: &[f64],
    panel: usize,
    weights: &chordwise::Weights,
) -> DVec3 {
    let count = surface.chordwise;
    let (strip, i) = (panel / count, panel % count);
    let at = |i: usize, strip: usize| sample(surface, potential, strip * count + i);
    let here = at(i, strip);
    let along = surface.panels[panel].along;
    let along_slope = weights.iter().map(|(k, w)| w * at(*k, strip).1).sum();
    let last = surface.spanwise - 1;
    let before = if strip > 0 {
        Some(at(i, strip - 1))
    } else if surface.is_symmetric {
        Some((mirrored(here.0), here.1))
    } else {
        None
    };
    let after = (strip < last).then(|| at(i, strip + 1));
    let (across, across_slope) = match (before, after) {
        (Some(before), Some(after)) => central(before, here, after),
        (None, Some(next)) if last >= 2 => one_sided(here, next, at(i, strip + 2)),
        (Some(next), None) if last >= 2 => {
            let second = if strip >= 2 { at(i, strip - 2) } else { next };
            backwards(one_sided(here, next, second))
        }
        (None, Some(next)) => two_points(here, next),
        (Some(next), None) if last >= 1 => backwards(two_points(here, next)),
        // One strip: the flow of a section.
        _ => (surface.span_m(strip).normalize_or_zero(), 0.0),
    };
    let normal = surface.panels[panel].normal;
    from_slopes(normal, [(along, along_slope), (across, across_slope)])
}

/// Surface gradient along the chord at the panel `k` of a cap.
fn in_cap(surface: &PanelSurface, potential: &[f64], cap: Cap, k: usize) -> DVec3 {
    let last = surface.chordwise / 2 - 1;
    let at = |k: usize| sample(surface, potential, cap.first + k);
    let (along, slope) = if k == 0 {
        two_points(at(0), at(1))
    } else if k == last {
        two_points(at(last - 1), at(last))
    } else {
        central(at(k - 1), at(k), at(k + 1))
    };
    let normal = surface.panels[cap.first + k].normal;
    let flat = along - normal * normal.dot(along);
    flat * (slope / flat.length_squared().max(f64::MIN_POSITIVE))
}

/// The vector in the plane across `normal` with the given products with two other vectors.
fn from_slopes(normal: DVec3, [(a, a_slope), (b, b_slope)]: [(DVec3, f64); 2]) -> DVec3 {
    let flat = |v: DVec3| v - normal * normal.dot(v);
    let (a, b) = (flat(a), flat(b));
    let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
    let determinant = aa * bb - ab * ab;
    if determinant <= 1e-12 * aa * bb {
        return DVec3::ZERO;
    }
    a * ((bb * a_slope - ab * b_slope) / determinant)
        + b * ((aa * b_slope - ab * a_slope) / determinant)
}

/// Derivatives of place and value over the distance, by a parabola through three samples, at the middle one.
fn central(before: Sample, here: Sample, after: Sample) -> (DVec3, f64) {
    let (b, a) = (here.0.distance(before.0), after.0.distance(here.0));
    let [w_before, w_after] = [a / b / (a + b), b / a / (a + b)];
    (
        w_before * (here.0 - before.0) + w_after * (after.0 - here.0),
        w_before * (here.1 - before.1) + w_after * (after.1 - here.1),
    )
}

/// The same at the first of three.
fn one_sided(here: Sample, next: Sample, second: Sample) -> (DVec3, f64) {
    let (a, b) = (next.0.distance(here.0), second.0.distance(next.0));
    if b <= 0.0 {
        return two_points(here, next);
    }
    let [w_next, w_second] = [(2.0 * a + b) / (a * (a + b)), -a / (b * (a + b))];
    (
        w_next * (next.0 - here.0) + w_second * (second.0 - next.0),
        w_next * (next.1 - here.1) + w_second * (second.1 - next.1),
    )
}

fn two_points(here: Sample, next: Sample) -> (DVec3, f64) {
    let distance = next.0.distance(here.0);
    ((next.0 - here.0) / distance, (next.1 - here.1) / distance)
}

fn backwards((place, value): (DVec3, f64)) -> (DVec3, f64) {
    (-place, -value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parabolas over uneven steps are met exactly, at the middle and at the end.
    #[test]
    fn differences_are_exact_for_parabolas() {
        let at = |s: f64| (DVec3::X * s, 3.0 * s * s - 2.0 * s + 1.0);
        let (_, middle) = central(at(0.7), at(1.0), at(1.9));
        assert!((middle - 4.0).abs() < 1e-12, "{middle}");
        let (_, end) = one_sided(at(1.0), at(1.3), at(2.1));
        assert!((end - 4.0).abs() < 1e-12, "{end}");
        let (_, end) = backwards(one_sided(at(1.0), at(0.8), at(0.1)));
        assert!((end - 4.0).abs() < 1e-12, "{end}");
    }
}
