//! An elliptic wing: span efficiency in the Trefftz plane, induced drag by pressure, and lift slope.

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{aligned_flow, flat_wing, lattice_slope, slope, stream, symmetric_profile};

const SPAN: f64 = 10.0;

/// Chord at the root.
const CHORD: f64 = 1.6;

const ANGLE: f64 = 0.1;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let wing = |strips: usize, percent: usize| -> Result<_, Stop> {
        let sections: Vec<[f64; 2]> = (0..=strips)
            .map(|k| {
                let angle = 0.5 * std::f64::consts::PI * k as f64 / strips as f64;
                let chord = if k == strips {
                    0.0
                } else {
                    CHORD * angle.cos()
                };
                [0.5 * SPAN * angle.sin(), chord]
            })
            .collect();
        // Straight at the quarter chord: elliptic loading is then elliptic in lifting-line theory.
        Ok(flat_wing(&sections, 0.25, &symmetric_profile(percent)?))
    };
    let (per_side, strips) = session.size((24, 16), (40, 40));
    session.check_interrupt()?;
    let surface = wing(strips, 12)?.panels(per_side)?;
    let panels = surface.panels.len();
    let flow = aligned_flow(&surface, stream(ANGLE))?;
    let far = flow.trefftz_forces(&surface, 1.0);
    // e = L²/(π q b² D), q = 1/2.
    let least = far.lift_n.powi(2) / (0.5 * std::f64::consts::PI * SPAN * SPAN);
    session
        .aero_row(
            panels,
            "span efficiency e, Trefftz plane",
            least / far.induced_drag_n,
        )
        .reference(1.0, "elliptic loading (Prandtl)")
        .gate(Gate::Within(0.02));
    let near = flow.pressure_forces(&surface, 1.0, DVec3::ZERO);
    let (lift, drag) = near.lift_and_drag_n(stream(ANGLE));
    session
        .aero_row(panels, "lift by pressure", lift)
        .reference(far.lift_n, "Trefftz plane")
        .gate(Gate::Within(0.03));
    session
        .aero_row(panels, "induced drag by pressure", drag)
        .reference(far.induced_drag_n, "Trefftz plane");
    let mut lattice = Vec::new();
    for refine in [1, 2] {
        session.check_interrupt()?;
        lattice.push(lattice_slope(&wing(10 * refine, 2)?, 8 * refine)?);
    }
    let mut of_thickness = Vec::new();
    for percent in [8, 4] {
        session.check_interrupt()?;
        of_thickness.push(slope(&wing(strips, percent)?, per_side)?);
    }
    session
        .aero_row(
            panels,
            "lift slope without thickness",
            2.0 * of_thickness[1] - of_thickness[0],
        )
        .reference(
            2.0 * lattice[1] - lattice[0],
            "vortex lattice, extrapolated",
        )
        .gate(Gate::Within(0.03));
    Ok(())
}
