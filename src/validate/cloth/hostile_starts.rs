//! Starts that no designer would choose: random places, one point, inside out, slivers, over stiffnesses and time steps. Each run takes some
//! steps of free fabric held at a corner; every state must be finite, and the sum of kinetic and elastic energy of fabric that does not push
//! must never rise. (Implicit Euler cannot gain energy where the elastic one is convex over the step; fabric that pushes is not, when it is
//! collapsed, and its gain is only stated.)

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built};
use crate::cpu::cloth::gather::Gather;
use crate::cpu::cloth::nodal_forces::{Pulls, elastic_gradient};
use crate::cpu::cloth::{Cloth, InitialHessian, SolverSettings, StepInput};
use crate::fabric::Fabric;
use crate::geometry::sheet::{self, FabricModel, SheetShape};
use crate::measure::extremes::larger;
use crate::solve::lbfgs::Stop as Ended;

/// Membrane stiffnesses E h [N/m].
const STIFFNESSES_N_M: [f64; 4] = [1e1, 1e3, 1e5, 1e8];

/// Time steps [s].
const TIME_STEPS_S: [f64; 3] = [1e-5, 1e-3, 1e-1];

const STEPS: usize = 3;

/// Rise of energy that counts as round-off, over the energy at the start: the objective resolves 1e-10 of itself.
const RISE: f64 = 1e-6;

/// The same of a solve that stops before it has converged: what it leaves is only as good as its residual.
const UNFINISHED_RISE: f64 = 1e-4;

/// Share of compressive stiffness of fabric that pushes, so that collapsed shapes are under load.
const PUSHING: f64 = 0.1;

const EVALUATION_LIMIT: usize = 1000;

/// A start, made from the flat place of a node and noise.
type Start = fn(DVec3, DVec3) -> DVec3;

const STARTS: [(&str, Start); 5] = [
    ("random places", |_, noise| noise),
    ("all in one point", |_, _| DVec3::ZERO),
    ("inside out", |flat, noise| -flat + 1e-3 * noise),
    ("slivers", |flat, _| {
        DVec3::new(1e-9 * flat.x, 1.5 * flat.y, 0.0)
    }),
    ("stretched tenfold", |flat, noise| 10.0 * flat + 0.1 * noise),
];

fn noise(node: usize) -> DVec3 {
    let number = |axis: usize| {
        let hash = ((3 * node + axis) as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (hash >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    DVec3::new(number(0), number(1), number(2))
}

fn energy_j(cloth: &Cloth) -> f64 {
    let structure = &cloth.structure;
    let mut unused = vec![DVec3::ZERO; structure.node_count()];
    let gather = Gather::new(structure);
    cloth.kinetic_energy_j()
        + elastic_gradient(
            structure,
            &gather,
            &cloth.positions_m,
            &mut Pulls::default(),
            &mut unused,
        )
}

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let cells = session.size(6, 16);
    let shape = SheetShape {
        size_m: [1.0, 1.0],
        divisions: [cells, cells],
        corner_m: DVec3::new(-0.5, -0.5, 0.0),
        across: DVec3::X,
        down: DVec3::Y,
    };
    for (model, residual_stiffness) in [
        (FabricModel::Membrane, 0.0),
        (FabricModel::Network, 0.0),
        (FabricModel::Membrane, PUSHING),
    ] {
        for (name, start) in STARTS {
            let (mut runs, mut broken, mut evaluations) = (0, 0, 0);
            let (mut rise, mut unfinished, mut unfinished_rise) = (0.0_f64, 0, 0.0_f64);
            let mut last = None;
            for stiffness in STIFFNESSES_N_M {
                for time_step_s in TIME_STEPS_S {
                    for initial_hessian in [InitialHessian::Multigrid, InitialHessian::BlockJacobi]
                    {
                        let fabric = Fabric {
                            residual_stiffness,
                            ..super::isotropic(stiffness / 1e-4, 0.3, 1e-4)
                        };
                        let structure = sheet::build(&shape, &fabric, model);
                        let mut structure = built(structure, "the sheet")?;
                        for (node, place) in structure.positions_m.iter_mut().enumerate() {
                            *place = start(*place, noise(node));
                        }
                        structure.held[0] = true;
                        let mut sheet = session.sheet(Cloth::new(structure), true)?;
                        let input = StepInput {
                            time_step_s: Some(time_step_s),
                            ..StepInput::default()
                        };
                        let settings = SolverSettings {
                            tolerance: 1e-3,
                            displacement_floor_m: 1e-9,
                            evaluation_limit: EVALUATION_LIMIT,
                            initial_hessian,
                            ..SETTINGS
                        };
                        runs += 1;
                        let first = energy_j(&sheet.cloth);
                        let mut before = first;
                        for _ in 0..STEPS {
                            let outcome = session.solve(&mut sheet, &input, &settings)?;
                            evaluations += outcome.evaluations;
                            let after = energy_j(&sheet.cloth);
                            let mut places = sheet.cloth.positions_m.iter();
                            let energies = [first, after].iter().all(|e| e.is_finite());
                            if !(energies && places.all(|x| x.is_finite())) {
                                broken += 1;
                                break;
                            }
                            let change = (after - before) / first.max(f64::MIN_POSITIVE);
                            if outcome.stop == Ended::Converged {
                                rise = larger(rise, change);
                            } else {
                                unfinished += 1;
                                unfinished_rise = larger(unfinished_rise, change);
                            }
                            before = after;
                        }
                        last = Some(sheet);
                    }
                }
            }
            let sheet = built(last, "the sheet")?;
            let pushes = residual_stiffness > 0.0;
            let model = match model {
                FabricModel::Membrane if pushes => "pushing membrane",
                FabricModel::Membrane => "membrane",
                FabricModel::Network => "network",
            };
            session
                .sheet_row(
                    &sheet,
                    format!("{model}, {name}: of {runs} runs not finite"),
                    f64::from(broken),
                )
                .gate(Gate::AtMost(0.0));
            let row = session.sheet_row(
                &sheet,
                format!("{model}, {name}: largest rise of energy over the first"),
                rise,
            );
            if !pushes {
                row.gate(Gate::AtMost(RISE));
            }
            session.sheet_row(
                &sheet,
                format!("{model}, {name}: of {} steps not converged", runs * STEPS),
                f64::from(unfinished),
            );
            let row = session.sheet_row(
                &sheet,
                format!("{model}, {name}: largest rise of energy in these"),
                unfinished_rise,
            );
            if !pushes {
                row.gate(Gate::AtMost(UNFINISHED_RISE));
            }
            session.sheet_row(
                &sheet,
                format!("{model}, {name}: evaluations per step"),
                evaluations as f64 / (runs * STEPS) as f64,
            );
        }
    }
    Ok(())
}
