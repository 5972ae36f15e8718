//! A drum: the lowest mode of a stretched circular membrane, f = 2.4048 √(T/m)/(2πa), and backward Euler's own damping, which takes the
//! factor 1/√(1 + ω²dt²) of the amplitude per step.

use std::f64::consts::{PI, TAU};

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built, crossings};
use crate::cpu::cloth::{Cloth, SolverSettings, StepInput};
use crate::fabric::Fabric;
use crate::geometry::{fabric_surface, surfaces};
use crate::measure::extremes::largest;

const RADIUS_M: f64 = 0.5;

/// First zero of the Bessel function J₀.
const ZERO: f64 = 2.404_825_557_695_773;

/// Strain that stretches the drum.
const STRAIN: f64 = 0.01;

/// Amplitude over radius: small beside √strain, so that the tension stays.
const AMPLITUDE: f64 = 1e-4;

/// ω dt.
const PHASE_PER_STEP: f64 = 0.04;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let (modulus_pa, poisson, thickness_m) = (4e8, 0.3, 1e-4);
    let fabric = Fabric {
        initial_strain: [STRAIN; 2],
        ..super::isotropic(modulus_pa, poisson, thickness_m)
    };
    // Second Piola–Kirchhoff to present width: T = S for equal stretches.
    let green = 0.5 * ((1.0 + STRAIN).powi(2) - 1.0);
    let tension = modulus_pa * thickness_m / (1.0 - poisson) * green;
    // Mass per present area.
    let areal = fabric.areal_density_kg_m2() / (1.0 + STRAIN).powi(2);
    let exact = ZERO / (TAU * RADIUS_M) * (tension / areal).sqrt();
    let omega = TAU * exact;
    let time_step_s = PHASE_PER_STEP / omega;
    let rings: &[usize] = session.size(&[6, 12], &[6, 12, 24]);
    let finest = rings[rings.len() - 1];
    for &rings in rings {
        let surface = surfaces::disk(RADIUS_M, RADIUS_M / rings as f64);
        let structure = fabric_surface::build(&surface, glam::DVec3::Y, &fabric);
        let mut structure = built(structure.ok(), "the drum")?;
        for (x, held) in structure.positions_m.iter_mut().zip(&mut structure.held) {
            let r = x.length() / RADIUS_M;
            *held = r > 1.0 - 1e-9;
            if !*held {
                x.x = AMPLITUDE * RADIUS_M * bessel_0(ZERO * r);
            }
        }
        let shape: Vec<f64> = structure.positions_m.iter().map(|x| x.x).collect();
        let masses = structure.masses_kg.clone();
        let mut sheet = session.sheet(Cloth::new(structure), true)?;
        let input = StepInput {
            time_step_s: Some(time_step_s),
            ..StepInput::default()
        };
        let settings = SolverSettings {
            displacement_floor_m: 1e-9 * AMPLITUDE * RADIUS_M,
            ..SETTINGS
        };
        // Two periods of the amplitude of the mode.
        let steps = (2.0 * TAU / PHASE_PER_STEP).round() as usize;
        let mut amplitudes = vec![1.0];
        let norm: f64 = shape.iter().zip(&masses).map(|(s, m)| m * s * s).sum();
        for _ in 0..steps {
            session.solve(&mut sheet, &input, &settings)?;
            let share = sheet.cloth.positions_m.iter().zip(&shape).zip(&masses);
            amplitudes.push(share.map(|((x, s), m)| m * s * x.x).sum::<f64>() / norm);
        }
        let crossings = crossings(&amplitudes);
        // Backward Euler turns by atan(ω dt) per step. One that does not swing has no number, and fails its gates.
        let phase = match &crossings[..] {
            [first, .., last] => PI * (crossings.len() - 1) as f64 / (last - first),
            _ => f64::NAN,
        };
        let frequency = phase.tan() / (TAU * time_step_s);
        let row = session
            .sheet_row(&sheet, format!("frequency, Hz, {rings} rings"), frequency)
            .reference(exact, "exact");
        if rings == finest {
            row.gate(Gate::Within(0.01));
        }
        // Largest amplitudes of the first and the third half period.
        let peak = |from: f64, to: f64| {
            let between = &amplitudes[from as usize..to as usize];
            largest(between.iter().map(|a| a.abs()))
        };
        let lost_per_step = match &crossings[..] {
            [a, b, c, d, ..] => (peak(*a, *b) / peak(*c, *d)).ln() / (c - a),
            _ => f64::NAN,
        };
        let expected = 0.5 * phase.tan().powi(2).ln_1p();
        let row = session
            .sheet_row(
                &sheet,
                format!("loss of amplitude per step, {rings} rings"),
                lost_per_step,
            )
            .reference(expected, "backward Euler, exact");
        if rings == finest {
            row.gate(Gate::Within(0.01));
        }
    }
    Ok(())
}

/// J₀ by its power series; for arguments up to its first zero.
fn bessel_0(x: f64) -> f64 {
    let quarter = -0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..20 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}
