//! Validation: problems with known answers, computed through the public interface of the crate, one file per problem.
//!
//! Each problem computes a few flows and adds rows to a [`Report`]: a quantity, its reference, its error, and the gate that it must pass.
//! The quick set takes about a minute on two CPU cores; coarse grids have gates of their own there, which the row says. `--full` takes
//! the sizes for which the reference gates are meant.

mod acoustic_pulse;
mod aero;
mod beltrami;
mod cavity;
mod cloth;
mod couette;
mod coupling;
mod disk;
mod drag;
mod falling_disk;
mod openings;
mod permeable_screen;
mod poiseuille;
mod report;
mod shear_layer;
mod soak;
mod sphere;
mod taylor_green;
mod taylor_green_vortex;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

pub use report::{Gate, Machine, Report, Row};

use crate::gpu::{Device, DeviceError};
use crate::lattice::Operator;
use crate::lattice::grid::{Initial, Setup, Sides, StreamwiseEnds};
use crate::plan::{AirPlacement, Storage};
use crate::run::Observer;
use crate::simulation::{AirEngine, MarkerEngine};

/// Steps between looks at the interrupt flag and reports of progress.
const STEPS_AT_ONCE: usize = 64;

/// Relative errors of the velocity below which round-off in f32 shows: velocities of 1e-2 next to populations of 1e-2 to 1e-1, over up to
/// ten thousand steps (the same flows in f32 and f64 differ by 1e-6 to 7e-5).
const SINGLE_PRECISION_ERROR: f64 = 5e-5;

/// Least order of convergence.
const ORDER: f64 = 1.9;

/// The same on a device, whose round-off adds 1e-5 to errors of 1e-4 on the finest grid: 1.86 was measured where the CPU has 1.93.
const DEVICE_ORDER: f64 = 1.8;

/// A validation problem.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// Name on the command line.
    pub name: &'static str,
    /// Cell updates of the quick and of the full set [millions], for progress; of fabric, what takes as long.
    updates: [f64; 2],
    compute: fn(&mut Session) -> Result<(), Stop>,
}

/// All problems, cheap ones first.
pub const PROBLEMS: [Problem; 36] = [
    Problem {
        name: "poiseuille",
        updates: [92.0, 800.0],
        compute: poiseuille::compute,
    },
    Problem {
        name: "couette",
        updates: [7.0, 60.0],
        compute: couette::compute,
    },
    Problem {
        name: "taylor-green",
        updates: [27.0, 435.0],
        compute: taylor_green::compute,
    },
    Problem {
        name: "beltrami",
        updates: [280.0, 8_900.0],
        compute: beltrami::compute,
    },
    Problem {
        name: "acoustic-pulse",
        updates: [110.0, 110.0],
        compute: acoustic_pulse::compute,
    },
    Problem {
        name: "soak",
        updates: [41.0, 410.0],
        compute: soak::compute,
    },
    Problem {
        name: "permeable-screen",
        updates: [60.0, 60.0],
        compute: permeable_screen::compute,
    },
    Problem {
        name: "openings",
        updates: [200.0, 9_000.0],
        compute: openings::compute,
    },
    Problem {
        name: "sphere",
        updates: [500.0, 35_000.0],
        compute: sphere::compute,
    },
    Problem {
        name: "disk",
        updates: [680.0, 21_000.0],
        compute: disk::compute,
    },
    Problem {
        name: "falling-disk",
        updates: [360.0, 5_800.0],
        compute: falling_disk::compute,
    },
    Problem {
        name: "shear-layer",
        updates: [130.0, 73_000.0],
        compute: shear_layer::compute,
    },
    Problem {
        name: "taylor-green-vortex",
        updates: [2_140.0, 34_200.0],
        compute: taylor_green_vortex::compute,
    },
    Problem {
        name: "cavity",
        updates: [800.0, 80_000.0],
        compute: cavity::compute,
    },
    Problem {
        name: "immersed-boundary",
        updates: [5.0, 5.0],
        compute: coupling::immersed_boundary::compute,
    },
    Problem {
        name: "spherical-couette",
        updates: [80.0, 2_000.0],
        compute: coupling::spherical_couette::compute,
    },
    Problem {
        name: "marker-spacing",
        updates: [1_160.0, 190_000.0],
        compute: coupling::marker_spacing::compute,
    },
    Problem {
        name: "force-routes",
        updates: [200.0, 25_000.0],
        compute: coupling::force_routes::compute,
    },
    Problem {
        name: "flexible-plate",
        updates: [98.0, 370_000.0],
        compute: coupling::flexible_plate::compute,
    },
    Problem {
        name: "flag",
        updates: [187.0, 444_000.0],
        compute: coupling::flag::compute,
    },
    Problem {
        name: "light-canopies",
        updates: [138.0, 32_600.0],
        compute: coupling::light_canopies::compute,
    },
    Problem {
        name: "potential-bodies",
        updates: [30.0, 600.0],
        compute: aero::potential_bodies::compute,
    },
    Problem {
        name: "plane-section",
        updates: [10.0, 60.0],
        compute: aero::plane_section::compute,
    },
    Problem {
        name: "rectangular-wings",
        updates: [120.0, 500.0],
        compute: aero::rectangular_wings::compute,
    },
    Problem {
        name: "elliptic-wing",
        updates: [60.0, 800.0],
        compute: aero::elliptic_wing::compute,
    },
    Problem {
        name: "belloc-wing",
        updates: [60.0, 400.0],
        compute: aero::belloc_wing::compute,
    },
    Problem {
        name: "trim",
        updates: [60.0, 300.0],
        compute: aero::trim::compute,
    },
    Problem {
        name: "membrane-patch",
        updates: [5.0, 30.0],
        compute: cloth::patch::compute,
    },
    Problem {
        name: "catenary",
        updates: [5.0, 5.0],
        compute: cloth::catenary::compute,
    },
    Problem {
        name: "hencky",
        updates: [60.0, 1000.0],
        compute: cloth::hencky::compute,
    },
    Problem {
        name: "airbag",
        updates: [200.0, 1500.0],
        compute: cloth::airbag::compute,
    },
    Problem {
        name: "pressure-vessels",
        updates: [60.0, 1000.0],
        compute: cloth::pressure_vessels::compute,
    },
    Problem {
        name: "shear-panel",
        updates: [40.0, 300.0],
        compute: cloth::shear_panel::compute,
    },
    Problem {
        name: "heavy-cantilever",
        updates: [60.0, 300.0],
        compute: cloth::heavy_cantilever::compute,
    },
    Problem {
        name: "drum",
        updates: [60.0, 500.0],
        compute: cloth::drum::compute,
    },
    Problem {
        name: "hostile-starts",
        updates: [60.0, 500.0],
        compute: cloth::hostile_starts::compute,
    },
];

/// The problem of the name `filter`, or else all whose name contains it; all without one.
#[must_use]
pub fn chosen(filter: Option<&str>) -> Vec<Problem> {
    let named = |name: &str| filter == Some(name);
    let exact = PROBLEMS.iter().any(|problem| named(problem.name));
    PROBLEMS
        .into_iter()
        .filter(|problem| match filter {
            _ if exact => named(problem.name),
            Some(text) => problem.name.contains(text),
            None => true,
        })
        .collect()
}

/// What ends a validation early.
#[derive(Debug, thiserror::Error)]
pub enum Stop {
    /// The user interrupted it; the rows so far are in the report.
    #[error("interrupted")]
    Interrupted,
    /// The device failed.
    #[error("{0}")]
    Device(#[from] DeviceError),
    /// A flow cannot be set up.
    #[error("{0}")]
    Refused(String),
}

/// What to compute, and where.
#[derive(Debug)]
pub struct Order {
    /// The problems.
    pub problems: Vec<Problem>,
    /// Real sizes.
    pub full: bool,
    /// Who computes the air.
    pub placement: AirPlacement,
    /// The device, if one does.
    pub device: Option<Arc<Device>>,
}

/// Computes the problems of an order; also returns what ended it early.
pub fn validate(
    order: &Order,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> (Report, Result<(), Stop>) {
    let size = usize::from(order.full);
    let mut session = Session {
        order,
        interrupt,
        observer,
        report: Report::new(order),
        problem: "",
        planned: order.problems.iter().map(|p| p.updates[size]).sum(),
        done: 0.0,
        problem_end: 0.0,
        began: Instant::now(),
    };
    let mut end = Ok(());
    for problem in &order.problems {
        let start = session.problem_end;
        session.problem = problem.name;
        session.done = start;
        session.problem_end = start + problem.updates[size];
        session.began = Instant::now();
        end = (problem.compute)(&mut session);
        if end.is_err() {
            break;
        }
    }
    let mut report = session.report;
    report.interrupted = matches!(end, Err(Stop::Interrupted));
    (report, end)
}

/// A validation under way.
struct Session<'a> {
    order: &'a Order,
    interrupt: &'a AtomicBool,
    observer: &'a mut dyn Observer,
    report: Report,
    problem: &'static str,
    /// Cell updates planned and done [millions].
    planned: f64,
    done: f64,
    /// Updates done once the present problem is.
    problem_end: f64,
    /// When the next row's flow began.
    began: Instant,
}

impl Session<'_> {
    /// One of two sizes.
    fn size<T>(&self, quick: T, full: T) -> T {
        if self.order.full { full } else { quick }
    }

    /// Whether the air is computed in double precision.
    fn is_double(&self) -> bool {
        self.order.placement == AirPlacement::Cpu(crate::plan::Precision::F64)
    }

    /// Air at its start.
    fn air(&self, setup: Setup, initial: &Initial) -> Result<AirEngine, Stop> {
        Ok(AirEngine::build(
            setup,
            Some(initial),
            self.order.placement,
            self.order.device.as_ref(),
        )?)
    }

    /// Some steps of the air under a uniform acceleration, if there is one.
    fn advance(
        &mut self,
        air: &mut AirEngine,
        steps: usize,
        acceleration: Option<[f64; 3]>,
    ) -> Result<(), Stop> {
        let cells = air.grid().cell_count() as f64;
        let mut left = steps;
        while left > 0 {
            if self.interrupt.load(Ordering::Relaxed) {
                return Err(Stop::Interrupted);
            }
            let count = left.min(STEPS_AT_ONCE);
            match (&mut *air, acceleration) {
                (AirEngine::Gpu(fluid), None) => fluid.collide_stream_steps(count)?,
                _ => {
                    for _ in 0..count {
                        air.collide_stream(acceleration, None)?;
                    }
                }
            }
            if let Some(device) = &self.order.device {
                device.wait()?;
            }
            left -= count;
            self.progress_to(self.done + 1e-6 * cells * count as f64);
        }
        Ok(())
    }

    /// One step of the air under the force of markers.
    fn advance_with(&mut self, air: &mut AirEngine, markers: &MarkerEngine) -> Result<(), Stop> {
        self.check_interrupt()?;
        air.collide_stream(None, Some(markers))?;
        self.progress_to(self.done + 1e-6 * air.grid().cell_count() as f64);
        Ok(())
    }

    /// An error if the user has interrupted the validation.
    fn check_interrupt(&self) -> Result<(), Stop> {
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(Stop::Interrupted);
        }
        Ok(())
    }

    /// Reports so many updates done [millions].
    fn progress_to(&mut self, updates: f64) {
        self.done = updates.min(self.problem_end);
        self.observer.progress(
            self.done.ceil().max(1.0) as u64,
            self.planned.ceil().max(1.0) as u64,
            self.problem,
        );
    }

    /// Adds a row; its time is that since the row before.
    fn row(&mut self, cells: [usize; 3], quantity: impl Into<String>, value: f64) -> &mut Row {
        let now = Instant::now();
        let seconds = now.duration_since(self.began).as_secs_f64();
        self.began = now;
        let mut row = Row::new(self.problem, quantity.into(), value, cells, seconds);
        row.is_judged = self.order.placement != AirPlacement::Gpu(Storage::F16);
        self.report.add(row)
    }

    /// Adds rows of errors on ever finer grids, that at 32 cells gated, and rows of the order: between neighbours, and fitted over all
    /// grids whose error single precision does not hide, which is gated.
    fn orders(&mut self, what: &str, errors: &[([usize; 3], usize, f64)]) {
        for &(cells, n, error) in errors {
            let row = self.row(cells, format!("{what}: L2 error, N = {n}"), error);
            if n == 32 {
                row.gate(Gate::AtMost(5e-3));
            }
        }
        let hidden = if self.is_double() {
            0.0
        } else {
            SINGLE_PRECISION_ERROR
        };
        for pair in errors.windows(2) {
            let [(_, coarse, e0), (cells, fine, e1)] = [pair[0], pair[1]];
            let order = (e0 / e1).ln() / (fine as f64 / coarse as f64).ln();
            self.row(
                cells,
                format!("{what}: order, N = {coarse} to {fine}"),
                order,
            );
        }
        // Single pairs scatter: the sound of the start is at another phase on every grid.
        let shown: Vec<_> = errors
            .iter()
            .take_while(|(_, _, error)| *error > hidden || error.is_nan())
            .collect();
        let (Some(&&(_, first, _)), Some(&&(cells, last, _))) = (shown.first(), shown.last())
        else {
            return;
        };
        let gate = match self.order.placement {
            AirPlacement::Cpu(_) => ORDER,
            AirPlacement::Gpu(_) => DEVICE_ORDER,
        };
        if last > first {
            let points: Vec<[f64; 2]> = shown
                .iter()
                .map(|(_, n, error)| [(*n as f64).ln(), error.ln()])
                .collect();
            self.row(
                cells,
                format!("{what}: order, N = {first} to {last}, fitted"),
                -slope(&points),
            )
            .reference(2.0, "second order, exact solution")
            .gate(Gate::AtLeast(gate));
        }
    }
}

/// Slope of the straight line through points by least squares.
fn slope(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let rise: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let run: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
    rise / run
}

/// Air in a periodic box.
fn periodic(cells: [usize; 3], relaxation_time: f64, operator: Operator) -> Setup {
    Setup {
        cells,
        ends: StreamwiseEnds::Periodic,
        sides: Sides::Periodic,
        relaxation_time,
        sponge_cells: None,
        operator,
        eddy_viscosity: None,
    }
}

/// ν = (τ − ½)/3.
fn viscosity(relaxation_time: f64) -> f64 {
    (relaxation_time - 0.5) / 3.0
}

/// τ = ½ + 3 ν.
fn relaxation_time(viscosity: f64) -> f64 {
    0.5 + 3.0 * viscosity
}

const OPERATORS: [(Operator, &str); 2] = [
    (Operator::TwoRelaxationTimes, "TRT"),
    (Operator::RecursiveRegularised, "regularised"),
];

/// Density excess and bare velocity of all cells, x fastest, in the engine's precision.
fn states(air: &AirEngine) -> Result<Vec<(f64, [f64; 3])>, Stop> {
    let [nx, ny, nz] = air.grid().cells;
    let cells = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]);
    Ok(match air {
        AirEngine::CpuF64(fluid) => cells.map(|cell| fluid.bare_state(cell)).collect(),
        AirEngine::CpuF32(_) | AirEngine::Gpu(_) => air
            .macroscopic()?
            .into_iter()
            .map(|(excess, u)| (f64::from(excess), u.map(f64::from)))
            .collect(),
    })
}

/// Relative L2 error of the velocity against `exact(cell)`; `shift` is added to the computed velocity first.
fn velocity_error(
    air: &AirEngine,
    shift: [f64; 3],
    exact: impl Fn([usize; 3]) -> [f64; 3],
) -> Result<f64, Stop> {
    let [nx, ny, _] = air.grid().cells;
    let (mut off, mut whole) = (0.0, 0.0);
    for (i, (_, u)) in states(air)?.into_iter().enumerate() {
        let e = exact([i % nx, i / nx % ny, i / nx / ny]);
        for a in 0..3 {
            off += (u[a] + shift[a] - e[a]).powi(2);
            whole += e[a] * e[a];
        }
    }
    Ok((off / whole).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_means_one_problem_and_a_part_of_it_all() {
        let names =
            |filter| -> Vec<&str> { chosen(filter).iter().map(|problem| problem.name).collect() };
        assert_eq!(names(Some("taylor-green")), ["taylor-green"]);
        assert_eq!(
            names(Some("taylor")),
            ["taylor-green", "taylor-green-vortex"]
        );
        assert_eq!(names(None).len(), PROBLEMS.len());
        assert!(names(Some("warp-drive")).is_empty());
    }
}
