//! Hencky's problem: a circular membrane clamped at its rim under a uniform dead load q.
//!
//! w₀ = c (q a/(E h))^⅓ a and N₀ = n (E h q² a²)^⅓ in the middle; ν = 0.3: c = 0.6534, n = 0.4311 (Hencky 1915; corrected by Fichter 1997,
//! NASA TP-3658). The load is the fabric's weight.

use glam::DVec3;

use super::super::flows::slope;
use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::SETTINGS;
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
        let Ok(mut structure) = fabric_surface::build(&surface, DVec3::Y, &fabric) else {
            continue;
        };
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
        session.solve(&mut sheet, &input, &SETTINGS)?;
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
    // The constants have four digits, which the finest meshes reach.
    let seen: Vec<[f64; 2]> = errors
        .into_iter()
        .take_while(|[_, error]| *error > (5e-4_f64).ln())
        .collect();
    if seen.len() > 1 {
        let order = -slope(&seen);
        let row = session.row([0; 3], "deflection: order over rings, fitted", order);
        row.engine = engine;
        row.is_judged = true;
        row.reference(2.0, "linear triangles")
            .gate(Gate::AtLeast(1.7));
    }
    Ok(())
}
