//! The fastest flow that every operator survives, over viscosity: free turbulence at three angles, and bodies in a tunnel.
//!
//! Bodies: those of [`super::bluff_bodies`], with 8 cells per diameter, side or chord, for 60 D/U.
//!
//! Free turbulence: a three-dimensional Taylor–Green vortex of amplitude U/3, carried through its periodic box of 16³ cells by a uniform wind of
//! 2U/3 at an angle to the x axis, for twenty turnovers L/(U/3). Far below the cell size the grid resolves nothing of the cascade, which
//! is where operators break down. A flow counts as survived if every cell is finite, slower than 1.5 U, and the kinetic energy has not
//! grown.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::work_precision::advance;
use super::{Engine, Stop, Watch, bluff_bodies, go_on, plots, write_rows};
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosityModel;
use crate::lattice::grid::{Setup, Sides, StreamwiseEnds};
use crate::lattice::stability::{Body, Point, PointAtBody, VISCOUS_PARTS, measured};
use crate::plan::AirPlacement;
use crate::simulation::AirEngine;

const CELLS: usize = 16;

const TURNOVERS: f64 = 20.0;

/// Mach numbers of U that are tried, in order, until one breaks down.
pub const MACH_NUMBERS: [f64; 8] = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6];

/// Between wind and x axis [°].
const ANGLES_DEG: [f64; 3] = [0.0, 22.5, 45.0];

/// Without eddy viscosity, and with every model.
const MODELS: [Option<EddyViscosityModel>; 4] = [
    None,
    Some(EddyViscosityModel::Smagorinsky),
    Some(EddyViscosityModel::Wale),
    Some(EddyViscosityModel::Vreman),
];

/// Looks at the flow during a run.
const LOOKS: usize = 40;

/// Speeds of the wind past bodies [cells per step], tried until one is survived.
const BODY_SPEEDS: [f64; 4] = [0.15, 0.1, 0.05, 0.025];

/// Cells per diameter, side or chord of bodies.
const BODY_CELLS: usize = 8;

/// Time that bodies are followed [D/U].
const BODY_TIME: f64 = 60.0;

/// All operators, or one.
fn operators(only: Option<Operator>) -> impl Iterator<Item = Operator> {
    let all = Operator::ALL.into_iter();
    all.filter(move |operator| only.is_none_or(|only| only == *operator))
}

/// Computes the map of free turbulence on all `engines`, of all operators or one; writes `stability.csv` and `stability.png` into `folder`.
pub fn map(
    engines: &[Engine],
    only: Option<Operator>,
    folder: &Path,
    watch: &mut Watch,
) -> Result<Vec<Point>, Stop> {
    let mut points = Vec::new();
    let operators = || operators(only);
    let planned = (engines.len() * operators().count() * MODELS.len() * VISCOUS_PARTS.len()) as u64;
    for engine in engines {
        for operator in operators() {
            for eddy_viscosity in MODELS {
                for viscous_part in VISCOUS_PARTS {
                    let interrupt = watch.interrupt;
                    go_on(interrupt)?;
                    let one = |&angle_deg: &f64| -> Result<Point, Stop> {
                        let mut point = Point {
                            engine: engine.name(),
                            operator,
                            eddy_viscosity,
                            viscous_part,
                            angle_deg,
                            mach: 0.0,
                        };
                        for mach in MACH_NUMBERS {
                            if !survives(engine, &point, mach, interrupt)? {
                                break;
                            }
                            point.mach = mach;
                        }
                        Ok(point)
                    };
                    let found: Result<Vec<Point>, Stop> = match engine.placement {
                        AirPlacement::Cpu(_) => ANGLES_DEG.par_iter().map(one).collect(),
                        AirPlacement::Gpu(_) => ANGLES_DEG.iter().map(one).collect(),
                    };
                    points.extend(found?);
                    watch.observer.progress(
                        (points.len() / ANGLES_DEG.len()) as u64,
                        planned,
                        "stability",
                    );
                }
            }
        }
    }
    write_rows(&folder.join("stability.csv"), &points)?;
    plots::stability(&folder.join("stability.png"), &points)?;
    Ok(points)
}

/// Computes the map of flows past bodies on one engine; writes `stability_at_bodies.csv` into `folder`.
///
/// The fastest wind is tried first, since most settings stand it or break down soon.
pub fn map_at_bodies(
    engine: &Engine,
    only: Option<Operator>,
    folder: &Path,
    watch: &mut Watch,
) -> Result<Vec<PointAtBody>, Stop> {
    let mut points = Vec::new();
    let each = MODELS.len() * VISCOUS_PARTS.len() * Body::OF_MAP.len();
    let planned = (operators(only).count() * each) as u64;
    for operator in operators(only) {
        for eddy_viscosity in MODELS {
            for viscous_part in VISCOUS_PARTS {
                for body in Body::OF_MAP {
                    let mut mach = 0.0;
                    for lattice_speed in BODY_SPEEDS {
                        let flow = bluff_bodies::Flow {
                            body,
                            cells: BODY_CELLS,
                            reynolds: 3.0 * lattice_speed * BODY_CELLS as f64 / viscous_part,
                            lattice_speed,
                            operator,
                            eddy_viscosity: eddy_viscosity.map(measured),
                            end: BODY_TIME,
                        };
                        if flow.outcome(engine, folder, watch.interrupt)?.stands {
                            mach = lattice_speed * 3f64.sqrt();
                            break;
                        }
                    }
                    points.push(PointAtBody {
                        engine: engine.name(),
                        operator,
                        eddy_viscosity,
                        viscous_part,
                        body,
                        mach: (1e3 * mach).round() / 1e3,
                    });
                    watch
                        .observer
                        .progress(points.len() as u64, planned, "stability at bodies");
                }
            }
        }
    }
    write_rows(&folder.join("stability_at_bodies.csv"), &points)?;
    Ok(points)
}

/// Largest Mach number survived at every angle: one line per setting, one column per τ − ½.
#[must_use]
pub fn table(points: &[Point]) -> String {
    let settings = points.iter().map(|point| {
        let name = name_of(&point.engine, point.operator, point.eddy_viscosity);
        (name, point.viscous_part, point.mach)
    });
    lines("largest Mach number survived; tau - 1/2 =", settings)
}

/// The same past every body.
#[must_use]
pub fn table_at_bodies(points: &[PointAtBody]) -> String {
    let settings = points.iter().map(|point| {
        let name = name_of(&point.engine, point.operator, point.eddy_viscosity);
        (name, point.viscous_part, point.mach)
    });
    lines("the same of winds past bodies; tau - 1/2 =", settings)
}

/// One line for each name, of (name, τ − ½, Mach number): the least Mach number of those alike.
fn lines(title: &str, settings: impl Iterator<Item = (String, f64, f64)>) -> String {
    let mut text = format!("{title:<58}");
    for part in VISCOUS_PARTS {
        text.push_str(&format!("{part:>7.0e}"));
    }
    let mut lines: Vec<(String, [f64; VISCOUS_PARTS.len()])> = Vec::new();
    for (name, viscous_part, survived) in settings {
        if lines.last().is_none_or(|(last, _)| *last != name) {
            lines.push((name, [f64::INFINITY; VISCOUS_PARTS.len()]));
        }
        if let (Some((_, mach)), Some(i)) = (
            lines.last_mut(),
            VISCOUS_PARTS.iter().position(|p| *p == viscous_part),
        ) {
            mach[i] = mach[i].min(survived);
        }
    }
    for (name, mach) in lines {
        text.push_str(&format!("\n{name:<58}"));
        for value in mach {
            text.push_str(&format!("{value:>7}"));
        }
    }
    text + "\n"
}

/// Engine, operator and eddy viscosity in words.
fn name_of(engine: &str, operator: Operator, model: Option<EddyViscosityModel>) -> String {
    let operator = operator.name();
    match model {
        Some(model) => format!("{engine}, {operator} + {}", model.name()),
        None => format!("{engine}, {operator}"),
    }
}

fn survives(
    engine: &Engine,
    point: &Point,
    mach: f64,
    interrupt: &AtomicBool,
) -> Result<bool, Stop> {
    let speed = mach / 3f64.sqrt();
    let (wind, vortex) = (2.0 / 3.0 * speed, speed / 3.0);
    let angle = point.angle_deg.to_radians();
    let k = TAU / CELLS as f64;
    let initial = move |cell: [usize; 3]| {
        let [x, y, z] = cell.map(|c| k * (c as f64 + 0.5));
        // p = (ρ V²/16)(cos 2x + cos 2y)(cos 2z + 2); δρ = 3 p.
        let excess = 3.0 / 16.0
            * vortex
            * vortex
            * ((2.0 * x).cos() + (2.0 * y).cos())
            * ((2.0 * z).cos() + 2.0);
        let u = [
            wind * angle.cos() + vortex * x.sin() * y.cos() * z.cos(),
            wind * angle.sin() - vortex * x.cos() * y.sin() * z.cos(),
            0.0,
        ];
        (excess, u)
    };
    let setup = Setup {
        cells: [CELLS; 3],
        ends: StreamwiseEnds::Periodic,
        sides: Sides::Periodic,
        relaxation_time: 0.5 + point.viscous_part,
        inlet_profile: None,
        sponge_cells: None,
        idle: None,
        operator: point.operator,
        eddy_viscosity: point.eddy_viscosity.map(measured),
    };
    let mut air = AirEngine::build(
        setup,
        Some(&initial),
        engine.placement,
        engine.device.as_ref(),
    )?;
    let (_, before) = air.mass_and_energy()?;
    let steps = (TURNOVERS * CELLS as f64 / vortex).ceil() as usize;
    for _ in 0..LOOKS {
        go_on(interrupt)?;
        advance(&mut air, steps.div_ceil(LOOKS))?;
        let (_, energy) = air.mass_and_energy()?;
        // Sound from the start moves energy to and fro between motion and pressure.
        let grown = !energy.is_finite() || energy > 1.02 * before;
        if grown || air.breakdown(1.5 * speed)?.is_some() {
            return Ok(false);
        }
    }
    Ok(true)
}
