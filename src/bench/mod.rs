//! Benchmarks with two numbers each: what a flow costs, and how wrong it is.
//!
//! [`work_precision`] computes flows with known answers over resolution, Mach number, operator, storage and engine, and says which
//! settings no other beats in both time and error. [`stability`] looks for the fastest flow that every operator survives at vanishing
//! viscosity, of free turbulence and past bodies; [`crate::lattice::stability`] holds what it found, for `ripstop check`. [`bluff_bodies`] follows
//! bodies over resolution, Reynolds number and speed on the lattice. [`coupling`] compares schemes of
//! coupling air and fabric, and follows the default one down to sheets much lighter than the air around them. [`aerodynamics`] measures
//! panels, and draws a measured wing's polar beside the computed one. [`fabric`] solves equilibria with known answers over mesh size, model and
//! arithmetic. [`levels`] measures what boxes of finer cells cost beside their steps. [`device`] measures a device: latencies, bandwidth, air, canopies and fabric.
//! [`pace`] tells which of CPU threads and a device updates bare air the faster, for `--engine auto`.
//!
//! Times are of the steps alone. They compare settings of one run on one machine; nothing here is a test.

pub mod aerodynamics;
pub mod bluff_bodies;
pub mod coupling;
pub mod device;
mod drag;
pub mod fabric;
mod front;
pub mod levels;
mod measurement;
pub mod pace;
mod plots;
pub mod stability;
mod taylor_green;
pub mod work_precision;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::bluff_body;
use crate::gpu::{Device, DeviceError};
use crate::output::{OutputError, write_atomically};
use crate::plan::{AirPlacement, Placement, Precision};
use crate::run::Observer;
use crate::simulation::Failure;

/// Who computes the air.
#[derive(Debug, Clone)]
pub struct Engine {
    /// Where, and in which precision.
    pub placement: AirPlacement,
    /// The device, if one computes.
    pub device: Option<Arc<Device>>,
}

impl Engine {
    /// CPU threads in that precision.
    #[must_use]
    pub const fn cpu(precision: Precision) -> Self {
        Self {
            placement: AirPlacement::Cpu(precision),
            device: None,
        }
    }

    /// Engine and precision in words.
    #[must_use]
    pub fn name(&self) -> String {
        let placement = Placement {
            air: self.placement,
            ..Placement::from(Precision::F32)
        };
        format!("{} {}", placement.engine(), placement.precision_name())
    }
}

/// What ends a benchmark early.
#[derive(Debug, thiserror::Error)]
pub enum Stop {
    /// The user interrupted it.
    #[error("interrupted")]
    Interrupted,
    /// The device failed.
    #[error("{0}")]
    Device(#[from] DeviceError),
    /// A file could not be written.
    #[error("{0}")]
    Output(#[from] OutputError),
    /// A flow cannot be set up.
    #[error("{0}")]
    Refused(String),
    /// A plot could not be drawn.
    #[error("cannot draw a plot: {0}")]
    Plot(String),
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Device(error) => Self::Device(error),
            other => Self::Refused(other.to_string()),
        }
    }
}

impl From<bluff_body::Stop> for Stop {
    fn from(stop: bluff_body::Stop) -> Self {
        match stop {
            bluff_body::Stop::Interrupted => Self::Interrupted,
            bluff_body::Stop::Device(error) => Self::Device(error),
            bluff_body::Stop::Refused(why) => Self::Refused(why),
        }
    }
}

/// Who watches, and may end it.
pub struct Watch<'a> {
    /// Turns true to end the benchmark.
    pub interrupt: &'a AtomicBool,
    /// Told of the progress.
    pub observer: &'a mut dyn Observer,
}

/// Writes rows as a table with a heading.
fn write_rows<T: serde::Serialize>(path: &Path, rows: &[T]) -> Result<(), Stop> {
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(out);
        for row in rows {
            table.serialize(row).map_err(std::io::Error::other)?;
        }
        table.flush()
    })?;
    Ok(())
}

fn go_on(interrupt: &AtomicBool) -> Result<(), Stop> {
    if interrupt.load(Ordering::Relaxed) {
        Err(Stop::Interrupted)
    } else {
        Ok(())
    }
}
