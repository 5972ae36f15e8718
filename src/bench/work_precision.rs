//! Error against seconds over resolution, Mach number, operator, storage and engine.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde::Serialize;

use super::front::{fastest_within, pareto};
use super::{Engine, Stop, Watch, go_on, plots, taylor_green};
use crate::lattice::Operator;
use crate::lattice::grid::Setup;
use crate::output::write_atomically;
use crate::plan::AirPlacement;
use crate::simulation::AirEngine;

/// Steps between looks at the interrupt flag.
const STEPS_AT_ONCE: usize = 256;

/// A flow that takes less is computed up to three times, and the shortest time counts [s].
const REPEATED_BELOW_S: f64 = 0.2;

/// Errors for which the fastest setting is named.
const ERROR_LIMITS: [f64; 2] = [0.05, 0.01];

/// What is varied.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    /// Cells along the reference length.
    pub resolution: usize,
    /// Reference speed [cells per step].
    pub lattice_speed: f64,
    pub operator: Operator,
}

type Velocity = dyn Fn([usize; 3]) -> [f64; 3] + Sync;

type Initial = dyn Fn([usize; 3]) -> (f64, [f64; 3]) + Sync;

/// A flow with a known end.
pub(super) struct Flow {
    pub setup: Setup,
    pub initial: Box<Initial>,
    pub steps: usize,
    /// Velocity at the end [cells per step].
    pub exact: Box<Velocity>,
}

/// A problem of this benchmark.
struct Problem {
    name: &'static str,
    /// What the error is.
    error: &'static str,
    flow: fn(&Setting) -> Flow,
    /// Resolutions of the quick and of the full set.
    resolutions: [&'static [usize]; 2],
}

const PROBLEMS: [Problem; 1] = [Problem {
    name: "taylor-green",
    error: "relative L2 error of the velocity at t = L/U",
    flow: taylor_green::flow,
    resolutions: [&[16, 24, 32, 48, 64], &[16, 24, 32, 48, 64, 96, 128, 192]],
}];

const LATTICE_SPEEDS: [f64; 4] = [0.02, 0.04, 0.08, 0.15];

/// One measurement.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// Name of the problem.
    pub problem: &'static str,
    /// Engine and precision.
    pub engine: String,
    /// Collision operator.
    pub operator: Operator,
    /// Cells along the reference length.
    pub resolution: usize,
    /// Reference speed over the speed of sound.
    pub mach: f64,
    /// Cells in all.
    pub cells: usize,
    /// Steps.
    pub steps: usize,
    /// Time of the steps [s].
    pub seconds: f64,
    /// The problem's error.
    pub error: f64,
    /// Whether no other point of the problem is as fast and as accurate.
    pub pareto: bool,
}

/// Names of the problems.
pub fn names() -> impl Iterator<Item = &'static str> {
    PROBLEMS.into_iter().map(|problem| problem.name)
}

/// Measures the problems whose name contains `filter`; writes `work-precision.csv` and a plot per problem into `folder`, and returns the
/// points with a text that sums up.
pub fn measure(
    filter: Option<&str>,
    full: bool,
    engines: &[Engine],
    folder: &Path,
    watch: &mut Watch,
) -> Result<(Vec<Point>, String), Stop> {
    let mut points = Vec::new();
    let mut text = String::new();
    let chosen: Vec<_> = PROBLEMS
        .into_iter()
        .filter(|problem| filter.is_none_or(|f| problem.name.contains(f)))
        .collect();
    for problem in chosen {
        let mut own = measure_problem(&problem, full, engines, watch)?;
        let front = pareto(&coordinates(&own));
        for (point, on_front) in own.iter_mut().zip(front) {
            point.pareto = on_front;
        }
        text.push_str(&summary(&problem, &own));
        plots::work_precision(
            &folder.join(format!("work-precision-{}.png", problem.name)),
            problem.name,
            problem.error,
            &own,
        )?;
        points.append(&mut own);
    }
    write_csv(&folder.join("work-precision.csv"), &points)?;
    Ok((points, text))
}

fn coordinates(points: &[Point]) -> Vec<(f64, f64)> {
    points.iter().map(|p| (p.seconds, p.error)).collect()
}

fn measure_problem(
    problem: &Problem,
    full: bool,
    engines: &[Engine],
    watch: &mut Watch,
) -> Result<Vec<Point>, Stop> {
    let mut settings = Vec::new();
    for engine in engines {
        for operator in Operator::ALL {
            for lattice_speed in LATTICE_SPEEDS {
                for &resolution in problem.resolutions[usize::from(full)] {
                    let setting = Setting {
                        resolution,
                        lattice_speed,
                        operator,
                    };
                    settings.push((engine, setting));
                }
            }
        }
    }
    let mut points = Vec::with_capacity(settings.len());
    let planned = settings.len() as u64;
    for (engine, setting) in settings {
        let flow = (problem.flow)(&setting);
        let cells: usize = flow.setup.cells.iter().product();
        let mut best = f64::INFINITY;
        let mut error = f64::NAN;
        for _ in 0..3 {
            let (seconds, this_error) = compute(&flow, engine, watch.interrupt)?;
            best = best.min(seconds);
            error = this_error;
            if seconds > REPEATED_BELOW_S {
                break;
            }
        }
        points.push(Point {
            problem: problem.name,
            engine: engine.name(),
            operator: setting.operator,
            resolution: setting.resolution,
            mach: setting.lattice_speed * 3f64.sqrt(),
            cells,
            steps: flow.steps,
            seconds: best,
            error,
            pareto: false,
        });
        watch
            .observer
            .progress(points.len() as u64, planned, problem.name);
    }
    Ok(points)
}

/// (seconds of the steps, error).
fn compute(flow: &Flow, engine: &Engine, interrupt: &AtomicBool) -> Result<(f64, f64), Stop> {
    let mut air = AirEngine::build(
        flow.setup.clone(),
        Some(&*flow.initial),
        engine.placement,
        engine.device.as_ref(),
    )?;
    let start = Instant::now();
    let mut left = flow.steps;
    while left > 0 {
        go_on(interrupt)?;
        let count = left.min(STEPS_AT_ONCE);
        advance(&mut air, count)?;
        left -= count;
    }
    if let (AirPlacement::Gpu(_), Some(device)) = (engine.placement, &engine.device) {
        device.wait()?;
    }
    let seconds = start.elapsed().as_secs_f64();
    let [nx, ny, _] = flow.setup.cells;
    let (mut off, mut whole) = (0.0, 0.0);
    for (i, (_, u)) in air.macroscopic()?.into_iter().enumerate() {
        let exact = (flow.exact)([i % nx, i / nx % ny, i / nx / ny]);
        for a in 0..3 {
            off += (f64::from(u[a]) - exact[a]).powi(2);
            whole += exact[a] * exact[a];
        }
    }
    Ok((seconds, (off / whole).sqrt()))
}

/// Some steps of air without any force.
pub(super) fn advance(air: &mut AirEngine, steps: usize) -> Result<(), Stop> {
    if let AirEngine::Gpu(fluid) = air {
        return Ok(fluid.collide_stream_steps(steps)?);
    }
    for _ in 0..steps {
        air.collide_stream(None, None)?;
    }
    Ok(())
}

fn describe(point: &Point) -> String {
    format!(
        "{:.4} s, error {:.2e}: {}, {}, {} cells, Mach {:.3}",
        point.seconds,
        point.error,
        point.engine,
        point.operator.name(),
        point.resolution,
        point.mach
    )
}

fn summary(problem: &Problem, points: &[Point]) -> String {
    let mut lines = vec![format!("{}: {}", problem.name, problem.error)];
    for limit in ERROR_LIMITS {
        lines.push(match fastest_within(&coordinates(points), limit) {
            Some(i) => format!("  to {:.0} %: {}", 100.0 * limit, describe(&points[i])),
            None => format!("  to {:.0} %: no setting reaches it", 100.0 * limit),
        });
    }
    lines.push("  settings that none other beats, fastest first:".to_owned());
    let mut front: Vec<&Point> = points.iter().filter(|p| p.pareto).collect();
    front.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    lines.extend(front.into_iter().map(|p| format!("    {}", describe(p))));
    lines.join("\n") + "\n"
}

fn write_csv(path: &Path, points: &[Point]) -> Result<(), Stop> {
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(out);
        for point in points {
            table.serialize(point).map_err(std::io::Error::other)?;
        }
        table.flush()
    })?;
    Ok(())
}
