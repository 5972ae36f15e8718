//! What it costs that a box of finer cells lies in a lattice: the exchange between both, beside their steps ([`crate::simulation::Levels`]).

use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::{Engine, Stop, Watch, go_on, write_rows};
use crate::lattice::Operator;
use crate::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};
use crate::lattice::nest::{CLEARANCE, IdleCells, Nest, Refinement};
use crate::plan::AirPlacement;
use crate::simulation::{AirEngine, Levels};

/// Fine cells along each side of the box.
const SIDES: [usize; 2] = [48, 96];

/// The same of the full set.
const FULL: [usize; 4] = [32, 48, 96, 192];

/// Cell updates of the box that are timed, and steps at least.
const TIMED_UPDATES: f64 = 2e7;
const LEAST_STEPS: usize = 16;

/// Steps before the clock starts.
const WARM: usize = 8;

/// Stream that the lattices hold [cells per step].
const STREAM: [f64; 3] = [0.06, 0.02, -0.01];

/// Times per step of the box.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// Engine and precision.
    pub engine: String,
    /// Cells of the box along each side.
    pub cells: usize,
    /// Step of the box [ms].
    pub fine_ms: f64,
    /// Half a step of the lattice around it, by itself [ms].
    pub coarse_ms: f64,
    /// Half an exchange [ms].
    pub exchange_ms: f64,
    /// Exchange over the step of the box.
    pub exchange_share: f64,
}

/// Measures every engine, writes `levels.csv`, and tells of it.
pub fn measure(
    full: bool,
    engines: &[Engine],
    folder: &Path,
    watch: &mut Watch,
) -> Result<(Vec<Point>, String), Stop> {
    let sides: &[usize] = if full { &FULL } else { &SIDES };
    let mut points = Vec::new();
    let mut text = "engine, box: ms per fine step of the box, half a coarse step, half an exchange; exchange over the box's step\n".to_owned();
    for engine in engines {
        for &side in sides {
            go_on(watch.interrupt)?;
            let point = point(engine, side)?;
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{}, {side}^3: {:.3}, {:.3}, {:.3}; {:.0} %",
                point.engine,
                point.fine_ms,
                point.coarse_ms,
                point.exchange_ms,
                100.0 * point.exchange_share
            );
            points.push(point);
        }
    }
    write_rows(&folder.join("levels.csv"), &points)?;
    Ok((points, text))
}

/// A lattice around a box, or the box itself.
fn setup(cells: [usize; 3], of_box: bool, idle: Option<IdleCells>) -> Setup {
    let periodic = Setup {
        cells,
        ends: StreamwiseEnds::Periodic,
        inlet_profile: None,
        sides: Sides::Periodic,
        relaxation_time: 0.5 + 1e-3,
        sponge_cells: None,
        idle,
        operator: Operator::StabilisedRegularised,
        eddy_viscosity: None,
    };
    if !of_box {
        return periodic;
    }
    Setup {
        ends: StreamwiseEnds::Walls([Wall::OfBox; 2]),
        sides: Sides::Each([Faces::Walls([Wall::OfBox; 2]); 2]),
        relaxation_time: 0.5 + 2e-3,
        ..periodic
    }
}

fn build(engine: &Engine, setup: Setup) -> Result<AirEngine, Stop> {
    let stream = |_: [usize; 3]| (0.0, STREAM);
    Ok(AirEngine::build(
        setup,
        Some(&stream),
        engine.placement,
        engine.device.as_ref(),
    )?)
}

/// All that was asked of a device is done.
fn finished(engine: &Engine) -> Result<(), Stop> {
    if let (AirPlacement::Gpu(_), Some(device)) = (engine.placement, &engine.device) {
        device.wait()?;
    }
    Ok(())
}

fn point(engine: &Engine, side: usize) -> Result<Point, Stop> {
    let nest = Nest {
        first: [CLEARANCE + 1; 3],
        cells: [side / 2; 3],
        spans: [false; 3],
    };
    let outer = [side / 2 + 2 * (CLEARANCE + 1); 3];
    let refinement = Refinement {
        nest,
        inner: Vec::new(),
    };
    let idle = IdleCells::below(std::slice::from_ref(&refinement), None);
    let fine = build(engine, setup(nest.fine_cells(), true, None))?;
    let around = || build(engine, setup(outer, false, idle));
    let mut levels = Levels::new(around()?).with(nest, Levels::new(fine))?;
    let mut alone = around()?;
    let cells = side.pow(3) as f64;
    let steps = ((TIMED_UPDATES / cells) as usize).max(LEAST_STEPS);
    let (mut of_box, mut of_others, mut of_coarse) =
        (Duration::ZERO, Duration::ZERO, Duration::ZERO);
    for step in 0..WARM + steps {
        let began = Instant::now();
        levels.collide_stream(None, None)?;
        finished(engine)?;
        let stepped = Instant::now();
        let together = levels.coarser_levels(None)?;
        finished(engine)?;
        let exchanged = Instant::now();
        if together {
            alone.collide_stream(None, None)?;
            finished(engine)?;
        }
        if step >= WARM {
            of_box += stepped - began;
            of_others += exchanged - stepped;
            of_coarse += exchanged.elapsed();
        }
    }
    let per_step = |time: Duration| 1e3 * time.as_secs_f64() / steps as f64;
    let (fine_ms, coarse_ms) = (per_step(of_box), per_step(of_coarse));
    let exchange_ms = per_step(of_others) - coarse_ms;
    Ok(Point {
        engine: engine.name(),
        cells: side,
        fine_ms,
        coarse_ms,
        exchange_ms,
        exchange_share: exchange_ms / fine_ms,
    })
}
