//! Lift slopes of thin rectangular wings against the vortex lattice, and of the lattice against the exact circular wing.
//!
//! The panel method's wings are 8 % and 4 % thick (thinner ones converge more slowly); a straight line through both slopes gives that of no thickness. The lattice's slopes come
//! from two lattices, one twice as fine, extrapolated as its error halves with the size. The circular wing's 1.7900 is Jordan's (Z. Flugwiss.
//! 21, 1973).

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{flat_wing, lattice_slope, slope, symmetric_profile};

/// Gate on thin-limit slopes.
const BAND: f64 = 0.03;

/// Lift slope of the circular wing [1/rad].
const CIRCULAR_WING: f64 = 1.790_023;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let thin = symmetric_profile(2)?;
    let (per_side, strips) = session.size((32, 16), (40, 24));
    // Chords √(1 − y²) · 2, straight at half chord.
    let of_circle = |strips: usize| {
        let sections: Vec<[f64; 2]> = (0..=strips)
            .map(|k| {
                let angle = 0.5 * std::f64::consts::PI * k as f64 / strips as f64;
                // cos π/2 is not quite zero.
                let chord = if k == strips { 0.0 } else { 2.0 * angle.cos() };
                [angle.sin(), chord]
            })
            .collect();
        flat_wing(&sections, 0.5, &thin)
    };
    let mut slopes = Vec::new();
    for refine in [1, 2] {
        session.check_interrupt()?;
        let wing = of_circle(10 * refine);
        let flat = std::f64::consts::PI / wing.flat_area_m2();
        // On the circle's own area.
        slopes.push(lattice_slope(&wing, 8 * refine)? / flat);
    }
    let panels = 16 * 20;
    session
        .aero_row(
            panels,
            "circular wing: lift slope, vortex lattice",
            2.0 * slopes[1] - slopes[0],
        )
        .reference(CIRCULAR_WING, "Jordan 1973")
        .gate(Gate::Within(0.01));
    for aspect_ratio in [2.0, 6.0, 10.0] {
        let sections = [[0.0, 1.0], [0.5 * aspect_ratio, 1.0]];
        let mut slopes = Vec::new();
        for refine in [1, 2] {
            session.check_interrupt()?;
            let wing = flat_wing(&sections, 0.25, &thin).divided(10 * refine, 0.8)?;
            slopes.push(lattice_slope(&wing, 8 * refine)?);
        }
        let lattice = 2.0 * slopes[1] - slopes[0];
        let mut of_thickness = Vec::new();
        for percent in [8, 4] {
            session.check_interrupt()?;
            let wing =
                flat_wing(&sections, 0.25, &symmetric_profile(percent)?).divided(strips, 0.8)?;
            of_thickness.push(slope(&wing, per_side)?);
        }
        session
            .aero_row(
                2 * per_side * strips,
                format!(
                    "rectangular wing, aspect ratio {aspect_ratio}: lift slope without thickness"
                ),
                2.0 * of_thickness[1] - of_thickness[0],
            )
            .reference(lattice, "vortex lattice, extrapolated")
            .gate(Gate::Within(BAND));
    }
    Ok(())
}
