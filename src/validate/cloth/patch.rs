//! Patch tests: an orthotropic sheet whose border is displaced affinely settles on the affine field, with rectangles and with jittered
//! triangles; and a rigid motion costs no energy.

use glam::{DVec2, DVec3};

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built};
use crate::cloth::{Structure, Triangle};
use crate::cpu::cloth::{Cloth, SolverSettings, StepInput};
use crate::fabric::Fabric;
use crate::measure::extremes::largest;

/// An orthotropic fabric whose shear modulus is independent of the others.
fn fabric() -> Fabric {
    Fabric {
        weft_modulus_pa: 2e7,
        shear_modulus_pa: 3e6,
        ..super::isotropic(4e7, 0.2, 1e-4)
    }
}

fn affine(p: DVec2) -> DVec3 {
    DVec3::new(
        1.04 * p.x + 0.01 * p.y,
        0.02 * p.x + 1.03 * p.y,
        0.3 * p.x - 0.1 * p.y,
    )
}

/// Deterministic numbers in −1 … 1.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A unit square of n × n cells, inner nodes moved by up to `jitter` cells; and its flat places.
fn square(n: usize, jitter: f64) -> Option<(Structure, Vec<DVec2>)> {
    let mut random = noise();
    let h = 1.0 / n as f64;
    let border = |k: usize| {
        let (i, j) = (k % (n + 1), k / (n + 1));
        [0, n].contains(&i) || [0, n].contains(&j)
    };
    let flat: Vec<DVec2> = (0..(n + 1) * (n + 1))
        .map(|k| {
            let place = DVec2::new((k % (n + 1)) as f64, (k / (n + 1)) as f64) * h;
            let offset = DVec2::new(random(), random()) * (jitter * h);
            if border(k) { place } else { place + offset }
        })
        .collect();
    let mut structure = Structure {
        masses_kg: vec![1.0; flat.len()],
        membrane: Some(fabric().membrane()),
        thickness_m: fabric().thickness_m,
        ..Structure::default()
    };
    for (k, p) in flat.iter().enumerate() {
        structure.held.push(border(k));
        let off = DVec3::new(random(), random(), random()) * (0.1 * h);
        let start = affine(*p);
        structure
            .positions_m
            .push(if border(k) { start } else { start + off });
    }
    for j in 0..n {
        for i in 0..n {
            let id = |i: usize, j: usize| (j * (n + 1) + i) as u32;
            for nodes in [
                [id(i, j), id(i + 1, j), id(i + 1, j + 1)],
                [id(i, j), id(i + 1, j + 1), id(i, j + 1)],
            ] {
                let corners = nodes.map(|k| flat[k as usize]);
                structure.triangles.push(Triangle::new(nodes, corners)?);
            }
        }
    }
    Some((structure, flat))
}

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    // Without loads the displacement decides.
    let settings = SolverSettings {
        displacement_floor_m: 1e-12,
        evaluation_limit: 2000,
        ..SETTINGS
    };
    for (name, jitter) in [("rectangles", 0.0), ("jittered", 0.3)] {
        let n = session.size(10, 40);
        let (structure, flat) = built(square(n, jitter), "the patch")?;
        let mut sheet = session.sheet(Cloth::new(structure), false)?;
        session.solve_to_rest(&mut sheet, &StepInput::default(), &settings)?;
        let places = flat.iter().zip(&sheet.cloth.positions_m);
        let error = largest(places.map(|(p, x)| x.distance(affine(*p))));
        session
            .sheet_row(&sheet, format!("{name}: largest error, sides"), error)
            .gate(Gate::AtMost(1e-6));
    }
    let (structure, flat) = built(square(10, 0.3), "the patch")?;
    let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
    let mut cloth = Cloth::new(structure);
    for (x, p) in cloth.positions_m.iter_mut().zip(&flat) {
        *x = turn * p.extend(0.0) + DVec3::new(3.0, -2.0, 5.0);
    }
    let reactions = cloth.reactions_n(&StepInput::default());
    let force = largest(reactions.iter().map(|(_, force)| force.length()));
    let stiffness = fabric().stiffness_n_m()[0][0];
    let sheet = session.sheet(cloth, true)?;
    session
        .sheet_row(
            &sheet,
            "rigid motion: largest force over stiffness, sides",
            force / stiffness,
        )
        .gate(Gate::AtMost(1e-12));
    Ok(())
}
