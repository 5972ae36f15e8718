//! A hanging cable (catenary).

use glam::DVec3;

use crate::cloth::Structure;
use crate::frame::CableKind;
use crate::lines::Cable;

/// Builds a cable of `segments` between two held ends, started as a parabola of roughly the right length.
#[must_use]
pub fn build(ends_m: [DVec3; 2], length_m: f64, segments: usize, cable: &Cable) -> Structure {
    let span = ends_m[0].distance(ends_m[1]);
    // Parabola of sag f has length ≈ span + 8 f²/(3 span).
    let sag = (0.375 * span * (length_m - span)).max(0.0).sqrt();
    let mut structure = Structure::default();
    for i in 0..=segments {
        let s = i as f64 / segments as f64;
        let place = ends_m[0].lerp(ends_m[1], s) - DVec3::Z * (4.0 * sag * s * (1.0 - s));
        structure.positions_m.push(place);
    }
    structure.masses_kg = vec![0.0; segments + 1];
    structure.held = (0..=segments).map(|i| i == 0 || i == segments).collect();
    let nodes: Vec<u32> = (0..=segments as u32).collect();
    let rest = vec![length_m / segments as f64; segments];
    structure.add_cable(&nodes, &rest, cable, CableKind::Cable);
    structure
}
