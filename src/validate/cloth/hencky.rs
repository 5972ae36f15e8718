//! Hencky's problem: a circular membrane clamped at its rim under a uniform dead load q.
//!
//! w₀ = c (q a/(E h))^⅓ a and N₀ = n (E h q² a²)^⅓ in the middle; ν = 0.3: c = 0.6534, n = 0.4311 (Hencky 1915; corrected by Fichter 1997,
//! NASA TP-3658). The load is the fabric's weight.

use glam::DVec3;

use super::super::flows::slope;
use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built};
use crate::cpu::cloth::read_outs::triangle_loads;
use crate::cpu::cloth::{Cloth, StepInput};
use crate::geometry::{fabric_surface, surfaces};

const RADIUS_M: f64 = 0.5;

/// q a/(E h); small, as in the theory.
const LOAD: f64 = 1e-5;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let (modulus_pa, thickness_m) = (4e8, 1e-4);
    let fabric = super::isotropic(modulus_pa, 0.3, thickness_m);
    let pressure_pa = LOAD * modulus_pa * thickness_m / RADIUS_M;
    let deflection = 0.6534 * LOAD.cbrt() * RADIUS_M;
    let tension = 0.4311 * (modulus_pa * thickness_m * (pressure_pa * RADIUS_M).powi(2)).cbrt();
    let rings: &[usize] = session.size(&[5, 10, 20, 40], &[5, 10, 20, 40, 80, 160]);
    let finest = rings[rings.len() - 1];
    let mut errors = Vec::new();
    let mut engine = None;
    for &rings in rings {
        let surface = surfaces::disk(RADIUS_M, RADIUS_M / rings as f64);
        let structure = fabric_surface::build(&surface, DVec3::Y, &fabric);
        let mut structure = built(structure.ok(), "the membrane")?;
        for (place, held) in structure.positions_m.iter_mut().zip(&mut structure.held) {
            let r = place.length() / RADIUS_M;
            *held = r > 1.0 - 1e-9;
            // A bulge to start from.
            place.x = 0.5 * deflection * (1.0 - r * r).max(0.0);
        }
        let mut sheet = session.sheet(Cloth::new(structure), false)?;
        let acceleration = pressure_pa / fabric.areal_density_kg_m2();
        let input = StepInput {
            gravity_m_s2: acceleration * DVec3::X,
            ..StepInput::default()
        };
        session.solve_to_rest(&mut sheet, &input, &SETTINGS)?;
        engine = Some(sheet.engine());
        let found = sheet.cloth.positions_m[0].x;
        let row = session
            .sheet_row(
                &sheet,
                format!("deflection over radius, {rings} rings"),
                found / RADIUS_M,
            )
            .reference(deflection / RADIUS_M, "Hencky 1915, Fichter 1997");
        if rings == finest {
            row.gate(Gate::Within(0.01));
        }
        errors.push([(rings as f64).ln(), (found / deflection - 1.0).abs().ln()]);
        // The mean of the triangles around the middle.
        let loads = triangle_loads(&sheet.cloth.structure, &sheet.cloth.positions_m);
        let around: Vec<f64> = sheet
            .cloth
            .structure
            .triangles
            .iter()
            .zip(&loads)
            .filter(|(triangle, _)| triangle.nodes.contains(&0))
            .map(|(_, load)| 0.5 * load.principal_tensions_n_m.iter().sum::<f64>())
            .collect();
        let found = around.iter().sum::<f64>() / around.len() as f64;
        let row = session
            .sheet_row(
                &sheet,
                format!("tension in the middle, N/m, {rings} rings"),
                found,
            )
            .reference(tension, "Hencky 1915, Fichter 1997");
        if rings == finest {
            row.gate(Gate::Within(0.03));
        }
    }
    let row = session.row(
        [0; 3],
        "deflection: order over rings, fitted",
        order(&errors),
    );
    row.engine = engine;
    row.is_judged = true;
    row.reference(2.0, "linear triangles")
        .gate(Gate::AtLeast(1.7));
    Ok(())
}

/// Order of logarithms of errors over those of rings, as far as the four digits of the constants show it; not a number of fewer than two, or where
/// one is none.
fn order(errors: &[[f64; 2]]) -> f64 {
    let is_hidden = |[_, error]: &[f64; 2]| *error <= (5e-4_f64).ln();
    let shown = errors.iter().position(is_hidden).unwrap_or(errors.len());
    -slope(&errors[..shown])
}

#[cfg(test)]
mod tests {
    use super::order;

    #[test]
    fn an_order_that_cannot_be_told_is_no_number() {
        let errors = |errors: [f64; 3]| [5.0f64, 10.0, 20.0].map(f64::ln).into_iter().zip(errors);
        let of = |all| {
            let all: Vec<[f64; 2]> = errors(all).map(|(n, error)| [n, error.ln()]).collect();
            order(&all)
        };
        assert!((of([0.08, 0.02, 0.005]) - 2.0).abs() < 1e-9);
        assert!((of([0.08, 0.02, 4e-4]) - 2.0).abs() < 1e-9);
        for few in [
            [0.08, 4e-4, 1e-4],
            [1e-4, 1e-4, 1e-4],
            [f64::NAN, 0.02, 0.005],
            [0.08, f64::NAN, 0.005],
        ] {
            assert!(of(few).is_nan(), "{few:?}");
        }
    }
}
