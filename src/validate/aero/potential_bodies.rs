//! Surface pressure on a sphere and on a 2:1 prolate ellipsoid in an oblique stream.
//!
//! On an ellipsoid the velocity is the part along the surface of (k_x V_x, k_y V_y, k_z V_z), k = 2/(2 − α), with Lamb's integrals α (Lamb,
//! Hydrodynamics, 6th edition, sections 111 and 114; a sphere: k = 3/2).

use glam::DVec3;

use super::super::flows::slope;
use super::super::report::Gate;
use super::super::session::{Session, Stop};
use crate::aero::potential_flow::{MEMORY_LIMIT, PotentialFlow};
use crate::aero::surface::ellipsoid;
use crate::measure::extremes::larger;

/// Largest error of the pressure coefficient on the finest surface; the coefficient spans 2.25 and 3.1.
const LARGEST: f64 = 0.05;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let stream = DVec3::new(0.8, 0.36, 0.48);
    for (name, axes) in [
        ("sphere", DVec3::ONE),
        ("2:1 ellipsoid", DVec3::new(2.0, 1.0, 1.0)),
    ] {
        let factors = factors(axes);
        let mut points = Vec::new();
        let sizes: &[usize] = session.size(&[12, 18, 26], &[16, 26, 40, 60]);
        for &n in sizes {
            session.check_interrupt()?;
            let body = ellipsoid(axes, n, n)?;
            let flow = PotentialFlow::new(&body, DVec3::X, MEMORY_LIMIT)?
                .solve(&[stream])?
                .remove(0);
            let pressures = flow.pressure_coefficients(&body);
            let (mut most, mut squares, mut area) = (0.0, 0.0, 0.0);
            for (panel, pressure) in body.panels.iter().zip(pressures) {
                let inside = panel.centre_m / axes;
                let normal = (inside / axes).normalize();
                let velocity = factors * stream;
                let along = velocity - normal * normal.dot(velocity);
                let error = pressure - (1.0 - along.length_squared());
                most = larger(most, error.abs());
                squares += error * error * panel.area_m2.length();
                area += panel.area_m2.length();
            }
            let rms = (squares / area).sqrt();
            points.push([(n as f64).ln(), rms.ln()]);
            let panels = body.panels.len();
            session.aero_row(
                panels,
                format!("{name}: error of Cp, root mean square, {n} x {n}"),
                rms,
            );
            let row = session.aero_row(
                panels,
                format!("{name}: error of Cp, largest, {n} x {n}"),
                most,
            );
            if n == sizes[sizes.len() - 1] {
                row.gate(Gate::AtMost(LARGEST));
                let force = flow
                    .pressure_forces(&body, 2.0, DVec3::ZERO)
                    .force_n
                    .length();
                session
                    .aero_row(panels, format!("{name}: force over q l^2"), force)
                    .gate(Gate::AtMost(1e-2));
            }
        }
        let panels = sizes[sizes.len() - 1].pow(2);
        session
            .aero_row(
                panels,
                format!("{name}: order over panels along a side, root mean square"),
                -slope(&points),
            )
            .gate(Gate::AtLeast(1.5));
    }
    Ok(())
}

/// k along the axes of a prolate ellipsoid or a sphere.
fn factors(axes: DVec3) -> DVec3 {
    let square = 1.0 - (axes.y / axes.x).powi(2);
    if square < 1e-9 {
        return DVec3::splat(1.5);
    }
    let e = square.sqrt();
    let log = ((1.0 + e) / (1.0 - e)).ln();
    let along = 2.0 * (1.0 - square) / e.powi(3) * (0.5 * log - e);
    let across = 1.0 / square - (1.0 - square) / (2.0 * e.powi(3)) * log;
    2.0 / (2.0 - DVec3::new(along, across, across))
}
