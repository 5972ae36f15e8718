//! Error against seconds over resolution, Mach number, operator, storage and engine.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::front::{fastest_within, pareto};
pub use super::measurement::Point;
use super::measurement::{ERROR_LIMITS, Flow, Setting};
use super::{Engine, Stop, Watch, drag, go_on, plots, taylor_green, write_rows};
use crate::bluff_body::BluffBody;
use crate::lattice::Operator;
use crate::plan::AirPlacement;
use crate::simulation::AirEngine;

/// Steps between looks at the interrupt flag.
const STEPS_AT_ONCE: usize = 256;

/// A flow that takes less is computed up to three times, and the shortest time counts [s].
const REPEATED_BELOW_S: f64 = 0.2;

/// Ratio of a finer grid's error to a coarser one's beyond which the coarser one was lucky.
const CANCELLING: f64 = 1.1;

/// What a problem computes.
enum Kind {
    /// A flow whose velocity is known everywhere; the error is the relative L2 norm of the difference.
    Field(fn(&Setting) -> Flow),
    /// A body whose drag is published; the error is the relative difference of the drag from the published one times a factor for the walls.
    Drag {
        body: fn(&Setting) -> BluffBody,
        walls: f64,
    },
}

/// A problem of this benchmark.
struct Problem {
    name: &'static str,
    /// What the error is.
    error: &'static str,
    kind: Kind,
    lattice_speeds: &'static [f64],
    /// Resolutions of the quick and of the full set.
    resolutions: [&'static [usize]; 2],
    /// Cell updates [millions] beyond which a setting is left out of the quick and of the full set.
    largest: [f64; 2],
}

const DRAG_SPEEDS: &[f64] = &[0.04, 0.08, 0.15];

const DRAG_RESOLUTIONS: [&[usize]; 2] = [&[6, 8, 10], &[6, 8, 10, 12, 16]];

const DRAG_LARGEST: [f64; 2] = [600.0, 4_400.0];

const PROBLEMS: [Problem; 3] = [
    Problem {
        name: "taylor-green",
        error: "relative L2 error of the velocity at t = L/U",
        kind: Kind::Field(taylor_green::flow),
        lattice_speeds: &[0.02, 0.04, 0.08, 0.15],
        // From grids so coarse that their error shows beside that of the Mach number.
        resolutions: [
            &[8, 12, 16, 24, 32, 48, 64],
            &[8, 12, 16, 24, 32, 48, 64, 96, 128],
        ],
        largest: [f64::INFINITY; 2],
    },
    Problem {
        name: "sphere",
        error: "relative error of the drag coefficient at Re 100",
        kind: Kind::Drag {
            body: drag::sphere,
            walls: drag::SPHERE_WALLS,
        },
        lattice_speeds: DRAG_SPEEDS,
        resolutions: DRAG_RESOLUTIONS,
        largest: DRAG_LARGEST,
    },
    Problem {
        name: "disk",
        error: "relative error of the drag coefficient at Re 100",
        kind: Kind::Drag {
            body: drag::disk,
            walls: drag::DISK_WALLS,
        },
        lattice_speeds: DRAG_SPEEDS,
        resolutions: DRAG_RESOLUTIONS,
        largest: DRAG_LARGEST,
    },
];

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
        mark_cancelling(&mut own);
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
    write_rows(&folder.join("work-precision.csv"), &points)?;
    Ok((points, text))
}

/// Marks the points at which errors of two signs cancel.
fn mark_cancelling(points: &mut [Point]) {
    for i in 0..points.len() {
        let one = &points[i];
        points[i].cancels = points.iter().any(|finer| {
            finer.is_result()
                && finer.resolution > one.resolution
                && finer.error > CANCELLING * one.error
                && finer.mach == one.mach
                && finer.operator == one.operator
                && finer.engine == one.engine
        });
    }
}

/// (seconds, error), for the front: an error beyond 100 % is no result, and one that cancels by chance says nothing of other flows.
fn coordinates(points: &[Point]) -> Vec<(f64, f64)> {
    points
        .iter()
        .map(|p| {
            let counts = p.is_result() && !p.cancels;
            (p.seconds, if counts { p.error } else { f64::NAN })
        })
        .collect()
}

/// Settings of a problem, each once.
fn settings(problem: &Problem, full: bool) -> Vec<Setting> {
    let set = usize::from(full);
    let mut settings = Vec::new();
    for operator in Operator::ALL {
        for &lattice_speed in problem.lattice_speeds {
            for &resolution in problem.resolutions[set] {
                let setting = Setting {
                    resolution,
                    lattice_speed,
                    operator,
                };
                if problem.kind.updates(&setting) <= problem.largest[set] {
                    settings.push(setting);
                }
            }
        }
    }
    settings
}

fn measure_problem(
    problem: &Problem,
    full: bool,
    engines: &[Engine],
    watch: &mut Watch,
) -> Result<Vec<Point>, Stop> {
    let settings = settings(problem, full);
    let planned = (engines.len() * settings.len()) as u64;
    let mut points = Vec::new();
    for engine in engines {
        for setting in &settings {
            let mut best = problem.kind.compute(setting, engine, watch.interrupt)?;
            // Short times scatter; the flow is the same every time.
            let repeats = if best.seconds < REPEATED_BELOW_S {
                2
            } else {
                0
            };
            for _ in 0..repeats {
                let again = problem.kind.compute(setting, engine, watch.interrupt)?;
                best.seconds = best.seconds.min(again.seconds);
            }
            points.push(Point {
                problem: problem.name,
                engine: engine.name(),
                operator: setting.operator,
                resolution: setting.resolution,
                mach: setting.lattice_speed * 3f64.sqrt(),
                cells: best.cells,
                steps: best.steps,
                seconds: best.seconds,
                error: best.error,
                cancels: false,
                pareto: false,
            });
            watch
                .observer
                .progress(points.len() as u64, planned, problem.name);
        }
    }
    Ok(points)
}

/// What one flow cost, and how wrong it is.
struct Measurement {
    cells: usize,
    steps: u64,
    seconds: f64,
    error: f64,
}

impl Kind {
    /// Cell updates of a setting at most [millions].
    fn updates(&self, setting: &Setting) -> f64 {
        match self {
            Self::Field(flow) => {
                let flow = flow(setting);
                1e-6 * (flow.setup.cells.iter().product::<usize>() * flow.steps) as f64
            }
            Self::Drag { body, .. } => {
                let body = body(setting);
                1e-6 * body.cells().iter().product::<usize>() as f64 * body.steps()
            }
        }
    }

    fn compute(
        &self,
        setting: &Setting,
        engine: &Engine,
        interrupt: &AtomicBool,
    ) -> Result<Measurement, Stop> {
        match self {
            Self::Field(flow) => compute_field(&flow(setting), engine, interrupt),
            Self::Drag { body, walls } => compute_drag(&body(setting), *walls, engine, interrupt),
        }
    }
}

fn compute_drag(
    body: &BluffBody,
    walls: f64,
    engine: &Engine,
    interrupt: &AtomicBool,
) -> Result<Measurement, Stop> {
    let drag = body.drag(engine.placement, engine.device.as_ref(), &mut |_| {
        !interrupt.load(Ordering::Relaxed)
    })?;
    let error = body.published_drag().map_or(f64::NAN, |(published, _)| {
        drag.coefficient / (published * walls) - 1.0
    });
    Ok(Measurement {
        cells: body.cells().iter().product(),
        steps: drag.steps,
        seconds: drag.seconds,
        error: error.abs(),
    })
}

fn compute_field(
    flow: &Flow,
    engine: &Engine,
    interrupt: &AtomicBool,
) -> Result<Measurement, Stop> {
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
    let [nx, ny, nz] = flow.setup.cells;
    let (mut off, mut whole) = (0.0, 0.0);
    for (i, (_, u)) in air.macroscopic()?.into_iter().enumerate() {
        let exact = (flow.exact)([i % nx, i / nx % ny, i / nx / ny]);
        for a in 0..3 {
            off += (f64::from(u[a]) - exact[a]).powi(2);
            whole += exact[a] * exact[a];
        }
    }
    Ok(Measurement {
        cells: nx * ny * nz,
        steps: flow.steps as u64,
        seconds,
        error: (off / whole).sqrt(),
    })
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

/// Three digits, in per cent.
fn percent(error: f64) -> String {
    let digits = 2.0 - (100.0 * error).log10().floor();
    format!("{:.*} %", digits.clamp(0.0, 6.0) as usize, 100.0 * error)
}

fn describe(point: &Point) -> String {
    format!(
        "{:.3} s, error {}: {}, {}, {} cells, Mach {:.3}",
        point.seconds,
        percent(point.error),
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
    let failed = points.iter().filter(|p| !p.is_result()).count();
    let cancelling = points.iter().filter(|p| p.cancels).count();
    if cancelling > 0 {
        lines.push(format!(
            "  {cancelling} of {} settings left out: finer grids at their Mach number are worse, so that errors cancel in them by chance",
            points.len()
        ));
    }
    if failed > 0 {
        lines.push(format!(
            "  {failed} of {} settings broke down or are wrong by more than 100 %",
            points.len()
        ));
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Precision;

    /// No setting is measured twice, and none is larger than its set allows.
    #[test]
    fn every_setting_comes_once() {
        for problem in &PROBLEMS {
            for full in [false, true] {
                let settings = settings(problem, full);
                assert!(settings.len() >= 8, "{}", problem.name);
                for (i, setting) in settings.iter().enumerate() {
                    assert!(!settings[..i].contains(setting), "{setting:?}");
                    let updates = problem.kind.updates(setting);
                    assert!(updates <= problem.largest[usize::from(full)]);
                }
            }
        }
    }

    fn point(seconds: f64, error: f64) -> Point {
        Point {
            problem: "sphere",
            engine: "cpu f32".to_owned(),
            operator: Operator::RecursiveRegularised,
            resolution: 8,
            mach: 0.1,
            cells: 1,
            steps: 1,
            seconds,
            error,
            cancels: false,
            pareto: false,
        }
    }

    /// The error of a grid that a finer one exceeds is luck, but not if the finer one broke down, or differs in more than the grid.
    #[test]
    fn luck_is_marked() {
        let on = |resolution, mach, error| Point {
            resolution,
            mach,
            ..point(1.0, error)
        };
        let mut points = [
            on(8, 0.1, 0.05),
            on(12, 0.1, 0.002),
            on(16, 0.1, 0.01),
            on(24, 0.1, 0.0105),
            on(32, 0.1, f64::NAN),
            on(12, 0.2, 0.001),
        ];
        mark_cancelling(&mut points);
        let marked = points.each_ref().map(|p| p.cancels);
        assert_eq!(marked, [false, true, false, false, false, false]);
        assert_eq!(fastest_within(&coordinates(&points[..4]), 0.005), None);
    }

    /// Points that are no results are neither on the front nor in the plot, whose axes they would stretch.
    #[test]
    fn broken_flows_are_counted_and_left_out() {
        let mut points = [
            point(0.1, f64::NAN),
            point(0.2, 1e30),
            point(0.3, 0.02),
            point(0.4, f64::INFINITY),
        ];
        points[2].pareto = true;
        assert_eq!(pareto(&coordinates(&points)), [false, false, true, false]);
        let text = summary(&PROBLEMS[1], &points);
        assert!(text.contains("to 5 %: 0.300 s, error 2.00 %"), "{text}");
        assert!(text.contains("to 1 %: no setting reaches it"), "{text}");
        assert!(text.contains("3 of 4 settings broke down"), "{text}");
        let folder = tempfile::tempdir().unwrap();
        let plot = folder.path().join("plot.png");
        plots::work_precision(&plot, "sphere", "error", &points).unwrap();
        assert!(plot.exists());
        let none = folder.path().join("none.png");
        plots::work_precision(&none, "sphere", "error", &points[..2]).unwrap();
        assert!(!none.exists());
    }

    /// Both kinds measure a coarse flow: second order of the vortices, and a drag within 40 %.
    #[test]
    fn coarse_flows_are_measured() {
        let engine = Engine::cpu(Precision::F32);
        let interrupt = AtomicBool::new(false);
        let error = |problem: &Problem, resolution, lattice_speed| {
            let setting = Setting {
                resolution,
                lattice_speed,
                operator: Operator::RecursiveRegularised,
            };
            let found = problem.kind.compute(&setting, &engine, &interrupt).unwrap();
            assert!(found.seconds > 0.0 && found.steps > 10 && found.cells > 100);
            assert!(
                1e-6 * (found.steps * found.cells as u64) as f64
                    <= 1.05 * problem.kind.updates(&setting)
            );
            found.error
        };
        // A Mach number in proportion to the cell size.
        let (coarse, fine) = (error(&PROBLEMS[0], 16, 0.16), error(&PROBLEMS[0], 32, 0.08));
        assert!((3.0..6.0).contains(&(coarse / fine)), "{coarse} {fine}");
        let drag = error(&PROBLEMS[1], 6, 0.15);
        assert!((0.01..0.4).contains(&drag), "{drag}");
        interrupt.store(true, Ordering::Relaxed);
        let setting = Setting {
            resolution: 6,
            lattice_speed: 0.15,
            operator: Operator::RecursiveRegularised,
        };
        for problem in &PROBLEMS {
            let stopped = problem.kind.compute(&setting, &engine, &interrupt);
            assert!(
                matches!(stopped, Err(Stop::Interrupted)),
                "{}",
                problem.name
            );
        }
    }
}
