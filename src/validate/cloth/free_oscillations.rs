//! Motion without damping: what the integration in time takes of its energy, how it changes the period, and what it leaves of a wave.
//!
//! * A mass between two springs that push and pull: energy lost in ten periods, and the length of a period, over the steps of a period.
//! * A Gaussian wave of displacement, ten elements wide, in a row of springs: its peak after 100 elements at a Courant number of 1.
//! * A sheet that swings about its upper edge, of 6 by 6 cells: energy lost in half a second, over the step.

use std::f64::consts::TAU;

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, Sheet, built, crossings, isotropic};
use crate::cloth::{Spring, Structure, TimeIntegration};
use crate::cpu::cloth::integration::FIRST_PARTS;
use crate::cpu::cloth::{Cloth, InitialHessian, SolverSettings, StepInput};
use crate::geometry::sheet::{self, FabricModel, SheetShape};
use crate::measure::extremes::largest;

/// Both ways, by their names in cases.
const WAYS: [(TimeIntegration, &str); 2] = [
    (TimeIntegration::Bdf2, "bdf2"),
    (TimeIntegration::BackwardEuler, "backward_euler"),
];

const PERIODS: usize = 10;

/// Steps per period at which the gate stands.
const STEPS: usize = 100;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    mass_on_springs(session)?;
    wave(session)?;
    swinging_sheet(session)
}

fn settings() -> SolverSettings {
    SolverSettings {
        tolerance: 1e-9,
        initial_hessian: InitialHessian::BlockJacobi,
        refresh_every: None,
        ..SETTINGS
    }
}

/// Steps of a motion, the first in parts, of which `look` is told.
fn advance(
    session: &Session,
    sheet: &mut Sheet,
    (input, steps): (&StepInput, usize),
    mut look: impl FnMut(&Cloth),
) -> Result<(), Stop> {
    let dt = input.time_step_s.unwrap_or(0.0);
    for (number, share) in FIRST_PARTS.iter().chain(vec![&1.0; steps - 1]).enumerate() {
        let input = StepInput {
            time_step_s: Some(dt * share),
            ..*input
        };
        session.solve(sheet, &input, &settings())?;
        if number + 1 >= FIRST_PARTS.len() {
            look(&sheet.cloth);
        }
    }
    Ok(())
}

fn spring(a: u32, stiffness_n_m: f64, rest_length_m: f64) -> Spring {
    Spring {
        nodes: [a, a + 1],
        rest_length_m,
        stiffness_n_m,
        compressive_stiffness_n_m: stiffness_n_m,
    }
}

fn energy_j(cloth: &Cloth, gravity_m_s2: DVec3) -> f64 {
    cloth.kinetic_energy_j() + cloth.elastic_energy_j() + cloth.potential_energy_j(gravity_m_s2)
}

fn mass_on_springs(session: &mut Session) -> Result<(), Stop> {
    let (stiffness_n_m, mass_kg) = (500.0_f64, 0.3);
    let period_s = TAU * (mass_kg / (2.0 * stiffness_n_m)).sqrt();
    for (integration, name) in WAYS {
        let ladder: &[usize] = session.size(&[50, 100, 200], &[50, 100, 200, 400]);
        for &steps in ladder {
            let structure = Structure {
                positions_m: [0.0, 1.1, 2.0].map(|x| DVec3::X * x).to_vec(),
                masses_kg: vec![0.0, mass_kg, 0.0],
                held: vec![true, false, true],
                springs: vec![spring(0, stiffness_n_m, 1.0), spring(1, stiffness_n_m, 1.0)],
                ..Structure::default()
            };
            let mut sheet = session.sheet(Cloth::new(structure), false)?;
            let start_j = energy_j(&sheet.cloth, DVec3::ZERO);
            let input = StepInput {
                time_step_s: Some(period_s / steps as f64),
                integration,
                ..StepInput::default()
            };
            let mut ways = Vec::new();
            advance(session, &mut sheet, (&input, PERIODS * steps), |cloth| {
                ways.push(cloth.positions_m[1].x - 1.0);
            })?;
            let lost = 1.0 - energy_j(&sheet.cloth, DVec3::ZERO) / start_j;
            let phase = TAU / steps as f64;
            let theory = match integration {
                TimeIntegration::Bdf2 => -(-0.5 * TAU * phase.powi(3) * PERIODS as f64).exp_m1(),
                TimeIntegration::BackwardEuler => {
                    1.0 - (1.0 + phase * phase).powi(-((PERIODS * steps) as i32))
                }
            };
            let row = session
                .sheet_row(
                    &sheet,
                    format!("{name}: energy lost in 10 periods of {steps} steps"),
                    lost,
                )
                .reference(theory, "theory, leading term");
            if steps == STEPS && integration == TimeIntegration::Bdf2 {
                row.gate(Gate::AtMost(0.01));
            }
            let crossings = crossings(&ways);
            // One that does not swing has no period, and fails its gate.
            let longer = match &crossings[..] {
                [first, .., last] => {
                    let half_periods = (crossings.len() - 1) as f64;
                    2.0 * (last - first) / half_periods / steps as f64 - 1.0
                }
                _ => f64::NAN,
            };
            let row = session
                .sheet_row(
                    &sheet,
                    format!("{name}: period longer by, {steps} steps"),
                    longer,
                )
                .reference(phase * phase / 3.0, "theory, leading term");
            if steps == STEPS {
                row.gate(Gate::Within(0.1));
            }
        }
    }
    Ok(())
}

fn wave(session: &mut Session) -> Result<(), Stop> {
    const ELEMENTS: usize = 400;
    const WIDTH: f64 = 10.0;
    const AMPLITUDE_M: f64 = 1e-4;
    let (length_m, stiffness_n_m, mass_kg) = (0.01_f64, 1e4_f64, 1e-3_f64);
    let across_s = (mass_kg / stiffness_n_m).sqrt();
    let middle = ELEMENTS as f64 / 2.0;
    for (integration, name) in WAYS {
        for courant in [2.0, 1.0, 0.5] {
            let structure = Structure {
                positions_m: (0..=ELEMENTS)
                    .map(|i| DVec3::X * (length_m * i as f64))
                    .collect(),
                masses_kg: vec![mass_kg; ELEMENTS + 1],
                held: (0..=ELEMENTS).map(|i| i == 0 || i == ELEMENTS).collect(),
                springs: (0..ELEMENTS as u32)
                    .map(|i| spring(i, stiffness_n_m, length_m))
                    .collect(),
                ..Structure::default()
            };
            let rest = structure.positions_m.clone();
            let mut sheet = session.sheet(Cloth::new(structure), true)?;
            for (i, x) in sheet.cloth.positions_m.iter_mut().enumerate() {
                let off = (i as f64 - middle) / WIDTH;
                x.x += AMPLITUDE_M * (-0.5 * off * off).exp();
            }
            let input = StepInput {
                time_step_s: Some(courant * across_s),
                integration,
                ..StepInput::default()
            };
            advance(
                session,
                &mut sheet,
                (&input, (100.0 / courant) as usize),
                |_| (),
            )?;
            let ways = sheet.cloth.positions_m.iter().zip(&rest);
            let highest = largest(ways.map(|(x, rest)| x.x - rest.x));
            let row = session.sheet_row(
                &sheet,
                format!(
                    "{name}: peak that a wave keeps over 100 elements, Courant number {courant}"
                ),
                highest / (0.5 * AMPLITUDE_M),
            );
            if courant == 1.0 && integration == TimeIntegration::Bdf2 {
                row.gate(Gate::AtLeast(0.9));
            }
        }
    }
    Ok(())
}

fn swinging_sheet(session: &mut Session) -> Result<(), Stop> {
    const CELLS: usize = 6;
    let gravity_m_s2 = DVec3::new(0.0, 0.0, -9.81);
    for (integration, name) in WAYS {
        let ladder: &[f64] = session.size(&[8e-3, 4e-3, 2e-3], &[8e-3, 4e-3, 2e-3, 1e-3]);
        for &time_step_s in ladder {
            let fabric = isotropic(4e7, 0.3, 1e-4);
            let shape = SheetShape {
                size_m: [1.0, 1.0],
                divisions: [CELLS, CELLS],
                corner_m: DVec3::ZERO,
                across: DVec3::X,
                down: DVec3::new(0.0, 0.5, -0.75_f64.sqrt()),
            };
            let structure = sheet::build(&shape, &fabric, FabricModel::Membrane);
            let mut structure = built(structure, "the sheet")?;
            structure.held[..=CELLS].fill(true);
            let weight_n = 9.81 * structure.masses_kg.iter().sum::<f64>();
            let mut sheet = session.sheet(Cloth::new(structure), true)?;
            let input = StepInput {
                time_step_s: Some(time_step_s),
                integration,
                gravity_m_s2,
                ..StepInput::default()
            };
            advance(
                session,
                &mut sheet,
                (&input, (0.5 / time_step_s) as usize),
                |_| (),
            )?;
            // It starts without energy, and could fall from 0.43 to 0.5 m below its edge.
            let lost =
                -energy_j(&sheet.cloth, gravity_m_s2) / (weight_n * (0.5 - 0.5 * 0.75_f64.sqrt()));
            let row = session.sheet_row(
                &sheet,
                format!(
                    "{name}: energy that a swinging sheet loses in 0.5 s, steps of {} ms",
                    time_step_s * 1e3
                ),
                lost,
            );
            // Twice of what was measured, a fortieth of backward Euler's.
            if time_step_s == 4e-3 && integration == TimeIntegration::Bdf2 {
                row.gate(Gate::AtMost(2e-3));
            }
        }
    }
    Ok(())
}
