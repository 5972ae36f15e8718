//! A heavy strip clamped level at one end: bending stiffness and large rotations (elastica; K = w L³/D, drop of the free end 0.1235 L for
//! K = 1 and 0.6406 L for K = 8, by integrating θ″ = −K (1 − s) cos θ, θ(0) = 0, θ′(1) = 0).

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built};
use crate::cpu::cloth::{Cloth, StepInput};
use crate::fabric::Fabric;
use crate::geometry::sheet::{self, FabricModel, SheetShape};

const LENGTH_M: f64 = 0.2;

/// Thick against its length, so that stretching is not much stiffer than bending; it stretches by 1e-5 all the same.
const THICKNESS_M: f64 = 2e-3;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let fabric = Fabric {
        residual_stiffness: 1.0,
        ..super::isotropic(1e7, 0.0, THICKNESS_M)
    };
    let rigidity_nm = 1e7 * THICKNESS_M.powi(3) / 12.0;
    let cells: &[usize] = session.size(&[10, 20, 40], &[10, 20, 40, 80]);
    let finest = cells[cells.len() - 1];
    for (load, drop) in [(1.0, 0.1235), (8.0, 0.6406)] {
        for &cells in cells {
            // A held cell keeps the strip level: its middle is the clamp, since the bend between it and the next cell belongs
            // to both halves.
            let cell = LENGTH_M / (cells as f64 + 0.5);
            let shape = SheetShape {
                size_m: [LENGTH_M + 0.5 * cell, 2.0 * cell],
                divisions: [cells + 1, 2],
                corner_m: DVec3::new(-0.5 * cell, 0.0, 0.0),
                across: DVec3::X,
                down: DVec3::Y,
            };
            let structure = sheet::build(&shape, &fabric, FabricModel::Membrane);
            let mut structure = built(structure, "the strip")?;
            let rest = structure.positions_m.clone();
            structure.add_curvatures(&rest, DVec3::X, fabric.rigidity_nm());
            for (place, held) in structure.positions_m.iter().zip(&mut structure.held) {
                *held = place.x < 0.75 * cell;
            }
            let mut sheet = session.sheet(Cloth::new(structure), false)?;
            // Weight per length and width w = ρ h g.
            let weight = load * rigidity_nm / LENGTH_M.powi(3);
            let input = StepInput {
                gravity_m_s2: -weight / fabric.areal_density_kg_m2() * DVec3::Z,
                ..StepInput::default()
            };
            session.solve_to_rest(&mut sheet, &input, &SETTINGS)?;
            let free: Vec<f64> = sheet
                .cloth
                .positions_m
                .iter()
                .zip(&rest)
                .filter(|(_, rest)| rest.x > LENGTH_M - 1e-9)
                .map(|(x, _)| -x.z)
                .collect();
            let found = free.iter().sum::<f64>() / free.len() as f64 / LENGTH_M;
            let row = session
                .sheet_row(
                    &sheet,
                    format!("drop over length, K = {load}, {cells} cells"),
                    found,
                )
                .reference(drop, "elastica");
            if cells == finest {
                row.gate(Gate::Within(0.02));
            }
        }
    }
    Ok(())
}
