//! A validation under way: what it computes, and the rows that it adds.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::flows::slope;
use super::report::{Gate, Report, Row};
use crate::gpu::{Device, DeviceError};
use crate::lattice::grid::{Initial, Setup};
use crate::measure::extremes::largest;
use crate::plan::AirPlacement;
use crate::run::Observer;
use crate::simulation::{AirEngine, MarkerEngine};

/// Steps between looks at the interrupt flag and reports of progress.
const STEPS_AT_ONCE: usize = 64;

/// Relative errors of the velocity below which round-off in f32 shows: velocities of 1e-2 next to populations of 1e-2 to 1e-1, over up to
/// ten thousand steps (the same flows in f32 and f64 differ by 1e-6 to 7e-5).
const SINGLE_PRECISION_ERROR: f64 = 5e-5;

/// The most of that, with a margin: what an error that is hidden may come to.
const HIDDEN_ERROR: f64 = 1e-4;

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
    pub(super) updates: [f64; 2],
    pub(super) compute: fn(&mut Session) -> Result<(), Stop>,
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

/// A validation under way.
pub(super) struct Session<'a> {
    pub(super) order: &'a Order,
    pub(super) interrupt: &'a AtomicBool,
    pub(super) observer: &'a mut dyn Observer,
    pub(super) report: Report,
    pub(super) problem: &'static str,
    /// Cell updates planned and done [millions].
    pub(super) planned: f64,
    pub(super) done: f64,
    /// Updates done once the present problem is.
    pub(super) problem_end: f64,
    /// When the next row's flow began.
    pub(super) began: Instant,
}

impl Session<'_> {
    /// One of two sizes.
    pub(super) fn size<T>(&self, quick: T, full: T) -> T {
        if self.order.full { full } else { quick }
    }

    /// Whether the air is computed in double precision.
    pub(super) fn is_double(&self) -> bool {
        self.order.placement == AirPlacement::Cpu(crate::plan::Precision::F64)
    }

    /// Air at its start.
    pub(super) fn air(&self, setup: Setup, initial: &Initial) -> Result<AirEngine, Stop> {
        Ok(AirEngine::build(
            setup,
            Some(initial),
            self.order.placement,
            self.order.device.as_ref(),
        )?)
    }

    /// Some steps of the air under a uniform acceleration, if there is one.
    pub(super) fn advance(
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
    pub(super) fn advance_with(
        &mut self,
        air: &mut AirEngine,
        markers: &MarkerEngine,
    ) -> Result<(), Stop> {
        self.check_interrupt()?;
        air.collide_stream(None, Some(markers))?;
        self.progress_to(self.done + 1e-6 * air.grid().cell_count() as f64);
        Ok(())
    }

    /// An error if the user has interrupted the validation.
    pub(super) fn check_interrupt(&self) -> Result<(), Stop> {
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(Stop::Interrupted);
        }
        Ok(())
    }

    /// Reports so many updates done [millions].
    pub(super) fn progress_to(&mut self, updates: f64) {
        self.done = updates.min(self.problem_end);
        self.observer.progress(
            self.done.ceil().max(1.0) as u64,
            self.planned.ceil().max(1.0) as u64,
            self.problem,
        );
    }

    /// Adds a row; its time is that since the row before.
    pub(super) fn row(
        &mut self,
        cells: [usize; 3],
        quantity: impl Into<String>,
        value: f64,
    ) -> &mut Row {
        let now = Instant::now();
        let seconds = now.duration_since(self.began).as_secs_f64();
        self.began = now;
        let mut row = Row::new(self.problem, quantity.into(), value, cells, seconds);
        row.is_judged = !self.order.placement.is_in_sixteen_bits();
        self.report.add(row)
    }

    /// Adds rows of errors on ever finer grids, that at 32 cells gated, and rows of the order: between neighbours, and fitted over all
    /// grids whose error single precision does not hide, which is gated. Where it hides all but one, what it hides is gated.
    pub(super) fn orders(&mut self, what: &str, errors: &[([usize; 3], usize, f64)]) {
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
        let is_hidden = |(_, _, error): &([usize; 3], usize, f64)| *error <= hidden;
        let shown = errors.iter().position(is_hidden).unwrap_or(errors.len());
        let [(_, first, _), .., (cells, last, _)] = errors[..shown] else {
            let cells = errors.last().map_or([0; 3], |(cells, _, _)| *cells);
            let counted = errors.iter().enumerate();
            let counted = counted.filter(|(k, (_, _, error))| *k >= shown || error.is_nan());
            self.row(
                cells,
                format!("{what}: no order, round-off hides it: largest error of these grids"),
                largest(counted.map(|(_, (_, _, error))| *error)),
            )
            .gate(Gate::AtMost(HIDDEN_ERROR));
            return;
        };
        let gate = match self.order.placement {
            AirPlacement::Cpu(_) => ORDER,
            AirPlacement::Gpu(_) => DEVICE_ORDER,
        };
        let points: Vec<[f64; 2]> = errors[..shown]
            .iter()
            .map(|(_, n, error)| [(*n as f64).ln(), error.ln()])
            .collect();
        // Grids behind one whose error is hidden count, too.
        let kept = errors[shown..]
            .iter()
            .all(|(_, _, error)| *error <= HIDDEN_ERROR);
        let order = if kept { -slope(&points) } else { f64::NAN };
        self.row(
            cells,
            format!("{what}: order, N = {first} to {last}, fitted"),
            order,
        )
        .reference(2.0, "second order, exact solution")
        .gate(Gate::AtLeast(gate));
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::plan::Precision;

    /// Watches nothing.
    pub(in crate::validate) struct Nobody;

    impl Observer for Nobody {
        fn progress(&mut self, _: u64, _: u64, _: &str) {}
        fn note(&mut self, _: &str) {}
    }

    /// The rows of errors on 16, 32, ... cells in single precision.
    fn rows_of(errors: &[f64]) -> Report {
        let order = Order {
            problems: Vec::new(),
            full: false,
            placement: AirPlacement::Cpu(Precision::F32),
            device: None,
        };
        let mut session = Session {
            order: &order,
            interrupt: &AtomicBool::new(false),
            observer: &mut Nobody,
            report: Report::new(false, order.placement, None),
            problem: "",
            planned: 1.0,
            done: 0.0,
            problem_end: 1.0,
            began: Instant::now(),
        };
        let sized = errors.iter().enumerate();
        let sized: Vec<_> = sized.map(|(k, error)| ([1; 3], 16 << k, *error)).collect();
        session.orders("flow", &sized);
        session.report
    }

    /// With or without an order that can be told, two gates: that on 32 cells, and one on the series.
    #[test]
    fn an_order_that_cannot_be_told_leaves_a_gate() {
        let series: [(&[f64], bool); 11] = [
            (&[4e-3, 1e-3, 2.5e-4], true),
            (&[4e-3, 2e-3, 1e-3], false),
            (&[4e-3, 1e-3, f64::NAN], false),
            (&[4e-3, 1e-3, 1e-5, 2e-5], true),
            (&[4e-3, 1e-3, 1e-5, f64::NAN], false),
            (&[4e-3, 1e-3, 1e-5, 0.5], false),
            (&[5.2e-5, 1.3e-5, 5.6e-6], true),
            (&[1.3e-5, 1.3e-5, 5.6e-6], true),
            (&[5.2e-5, 1.3e-5, 2e-4], false),
            (&[5.2e-5, 1.3e-5, f64::NAN], false),
            (&[f64::NAN, 1.3e-5, 5.6e-6], false),
        ];
        for (errors, holds) in series {
            let report = rows_of(errors);
            let gated = report.rows.iter().filter(|row| row.holds.is_some());
            assert_eq!(gated.count(), 2, "{errors:?}");
            assert_eq!(report.holds(), holds, "{errors:?}: {}", report.table());
        }
    }
}
