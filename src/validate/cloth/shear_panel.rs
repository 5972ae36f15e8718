//! Shear: Wagner's panel, and the bias test of a woven fabric.
//!
//! A thin panel sheared by γ between stiff edges buckles into diagonal wrinkles: σ₁ = E γ/2 at 45°, so that τ = σ₁/2 (Wagner 1929).
//! A strip cut at 45° from warp and weft has the modulus 1/E45 = ¼ (1/E₁ + 1/E₂ − 2ν/E₁ + 1/G) (paper P1, eq. 1).

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built};
use crate::cpu::cloth::read_outs::triangle_loads;
use crate::cpu::cloth::{Cloth, SolverSettings, StepInput};
use crate::fabric::Fabric;
use crate::geometry::coupon;
use crate::geometry::sheet::{self, FabricModel, SheetShape};

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    wagner(session)?;
    bias(session)
}

/// Engineering shear strain of the panel; small, so that Green's strain is the engineer's.
const SHEAR: f64 = 1e-4;

fn wagner(session: &mut Session) -> Result<(), Stop> {
    let modulus_pa = 4.31e8;
    let fabric = Fabric {
        residual_stiffness: 1e-4,
        ..super::isotropic(modulus_pa, 0.14, 1e-4)
    };
    let cells = session.size(10, 40);
    let shape = SheetShape {
        size_m: [1.0, 1.0],
        divisions: [cells, cells],
        corner_m: DVec3::ZERO,
        across: DVec3::X,
        down: DVec3::Y,
    };
    let structure = sheet::build(&shape, &fabric, FabricModel::Membrane);
    let mut structure = built(structure, "the panel")?;
    for (place, held) in structure.positions_m.iter_mut().zip(&mut structure.held) {
        let inside = |x: f64| x > 1e-9 && x < 1.0 - 1e-9;
        *held = !(inside(place.x) && inside(place.y));
        if *held {
            place.x += SHEAR * place.y;
        }
    }
    let mut sheet = session.sheet(Cloth::new(structure), false)?;
    let settings = SolverSettings {
        displacement_floor_m: 1e-11,
        evaluation_limit: 2000,
        ..SETTINGS
    };
    session.solve_to_rest(&mut sheet, &StepInput::default(), &settings)?;
    let loads = triangle_loads(&sheet.cloth.structure, &sheet.cloth.positions_m);
    let count = loads.len() as f64;
    let larger = loads
        .iter()
        .map(|l| l.principal_tensions_n_m[0])
        .sum::<f64>()
        / count;
    let shear = loads.iter().map(|l| l.shear_tension_n_m).sum::<f64>() / count;
    let exact = modulus_pa * 1e-4 * 0.5 * SHEAR;
    session
        .sheet_row(
            &sheet,
            "Wagner: diagonal tension over E h gamma/2",
            larger / exact,
        )
        .reference(1.0, "Wagner 1929")
        .gate(Gate::Within(1e-3));
    session
        .sheet_row(
            &sheet,
            "Wagner: shear over diagonal tension",
            shear / larger,
        )
        .reference(0.5, "Wagner 1929")
        .gate(Gate::Within(1e-3));
    // Green's strain of simple shear is (0, γ²/2, γ) in Voigt form.
    let (mean, radius) = (
        0.25 * SHEAR * SHEAR,
        0.5 * SHEAR * (0.25 * SHEAR * SHEAR + 1.0).sqrt(),
    );
    for (k, (name, exact)) in [("larger", mean + radius), ("smaller", mean - radius)]
        .into_iter()
        .enumerate()
    {
        let strain = loads.iter().map(|l| l.principal_strains[k]).sum::<f64>() / count;
        session
            .sheet_row(&sheet, format!("Wagner: {name} principal strain"), strain)
            .reference(exact, "simple shear")
            .gate(Gate::Within(1e-3));
    }
    Ok(())
}

fn bias(session: &mut Session) -> Result<(), Stop> {
    let (modulus_pa, poisson, shear_pa) = (4.31e8, 0.14, 1e7);
    let fabric = Fabric {
        shear_modulus_pa: shear_pa,
        residual_stiffness: 1e-4,
        ..super::isotropic(modulus_pa, poisson, 1e-4)
    };
    let exact = 4.0 / (2.0 / modulus_pa - 2.0 * poisson / modulus_pa + 1.0 / shear_pa);
    let across = session.size(8, 24);
    let shape = coupon::Coupon {
        length_m: 0.4,
        width_m: 0.05,
        cells_across: across,
        warp_angle_deg: 45.0,
        elongation: 2e-3,
    };
    let strip = built(coupon::build(&shape, &fabric), "the strip")?;
    let mut sheet = session.sheet(Cloth::new(strip.structure.clone()), false)?;
    let input = StepInput {
        moved_supports: &strip.moved,
        ..StepInput::default()
    };
    let settings = SolverSettings {
        displacement_floor_m: 1e-10,
        evaluation_limit: 5000,
        ..SETTINGS
    };
    session.solve_to_rest(&mut sheet, &input, &settings)?;
    let force: f64 = sheet
        .cloth
        .reactions_n(&input)
        .iter()
        .filter(|(node, _)| strip.moved.iter().any(|(moved, _)| moved == node))
        .map(|(_, force)| force.x)
        .sum();
    let strain = strip.gauge_strain(&sheet.cloth.positions_m);
    session
        .sheet_row(
            &sheet,
            "bias test: modulus of the middle third, Pa",
            force / (shape.width_m * fabric.thickness_m) / strain,
        )
        .reference(exact, "paper P1, eq. 1")
        .gate(Gate::Within(0.01));
    Ok(())
}
