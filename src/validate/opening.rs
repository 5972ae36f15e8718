//! An opening in an impermeable wall: resolved by cells, and too narrow for them, left open or covered by a panel with a discharge coefficient.
//!
//! A plate with a square hole of a third of the width stands across a duct that repeats along all axes (a grid of openings, a ninth of the
//! area open). A uniform force per mass drives the air along x: force times length is the pressure difference in the mean, whatever the
//! scheme does. The discharge coefficient C_d = v/√(2Δp/ρ) of the mean velocity v in the hole is to be that of sharp-edged thin grids
//! (Idelchik, Handbook of Hydraulic Resistance, diagram 8-1: Δp = ½ρv² (0.707 √(1 − f) + 1 − f)² at high Reynolds numbers, f the open share).
//! The kernel reaches two cells beyond the rim, so that a hole of a few cells is far too tight, and a panel in it makes up for what
//! it lacks only if its own coefficient is asked for: this is what `ripstop` does with openings narrower than about six cells.

use super::{Gate, Session, Stop, periodic, states};
use crate::immersed::permeable::{Permeable, Resistance};
use crate::lattice::Operator;
use crate::simulation::MarkerEngine;

/// Open share of the plate.
const OPEN: f64 = 1.0 / 9.0;

/// Speed in the hole that the force is chosen for [cells per step].
const SPEED: f64 = 0.06;

/// Markers per cell along y and along z.
const MARKERS_PER_CELL: usize = 2;

/// Where the plate is, in widths of the duct.
const PLATE: f64 = 0.523;

/// Mean over the last share of the steps.
const MEAN_OVER: usize = 2;

/// Largest error of the panel, and of the hole of 16 cells, whose coefficient falls with the cells that the kernel takes of its rim.
const BANDS: [f64; 2] = [0.1, 0.15];

/// What is in the hole.
#[derive(Clone, Copy, PartialEq)]
enum Hole {
    Open,
    Panel,
}

fn idelchik() -> f64 {
    1.0 / (0.707 * (1.0 - OPEN).sqrt() + 1.0 - OPEN)
}

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let resolved = session.size(12, 24);
    for (width, hole) in [
        (resolved, Hole::Open),
        (6, Hole::Open),
        (4, Hole::Open),
        (4, Hole::Panel),
        (3, Hole::Panel),
        (2, Hole::Panel),
    ] {
        let (cells, coefficient) = discharge(session, width, hole)?;
        let what = match hole {
            Hole::Open => "open",
            Hole::Panel => "panel",
        };
        let row = session
            .row(
                cells,
                format!("hole of {width} cells, {what}: discharge coefficient"),
                coefficient,
            )
            .reference(idelchik(), "Idelchik, diagram 8-1");
        match hole {
            Hole::Panel => {
                row.gate(Gate::Within(BANDS[0]));
            }
            Hole::Open if width == 24 => {
                row.gate(Gate::Within(BANDS[1]));
            }
            Hole::Open => {}
        }
    }
    Ok(())
}

/// Cells, and v/√(2Δp/ρ) in the mean.
fn discharge(session: &mut Session, width: usize, hole: Hole) -> Result<([usize; 3], f64), Stop> {
    let side = 3 * width;
    let cells = [2 * side, side, side];
    let wanted = idelchik();
    let pressure = 0.5 * (SPEED / wanted).powi(2);
    let start = SPEED * OPEN;
    let setup = periodic(cells, 0.5 + 3e-4, Operator::RecursiveRegularised);
    let mut air = session.air(setup, &|_| (0.0, [start, 0.0, 0.0]))?;
    let x = PLATE * side as f64;
    let (mut positions, mut in_hole) = (Vec::new(), Vec::new());
    let place = |i: usize| (i as f64 + 0.5) / MARKERS_PER_CELL as f64 - 0.5;
    let inside = |i: usize| (width..2 * width).contains(&(i / MARKERS_PER_CELL));
    for z in 0..side * MARKERS_PER_CELL {
        for y in 0..side * MARKERS_PER_CELL {
            let is_inside = inside(y) && inside(z);
            if is_inside && hole == Hole::Open {
                continue;
            }
            positions.push([x, place(y), place(z)]);
            in_hole.push(is_inside);
        }
    }
    let area = 1.0 / (MARKERS_PER_CELL * MARKERS_PER_CELL) as f64;
    let mut markers = MarkerEngine::new(&air, vec![area; positions.len()], 8.0 / 3.0)?;
    let acceleration = Some([pressure / cells[0] as f64, 0.0, 0.0]);
    // The jet passes the duct four times.
    let steps = (4 * cells[0]) * (1.0 / SPEED) as usize;
    let left = |_| Stop::Refused("the plate left the duct".to_owned());
    let (mut sum, mut samples) = (0.0, 0.0);
    for step in 0..steps {
        markers.send_markers(&air, &positions)?.map_err(left)?;
        markers.interpolate(&air, &positions)?.map_err(left)?;
        markers.fetch_air_velocities()?;
        let targets: Vec<[f64; 3]> = markers
            .air_velocities()
            .iter()
            .enumerate()
            .map(|(k, &velocity)| {
                if !in_hole[k] {
                    return [0.0; 3];
                }
                let panel = Permeable {
                    normal: [1.0, 0.0, 0.0],
                    resistance: Resistance {
                        viscous: 0.0,
                        inertial: 0.5 / (wanted * wanted) / (markers.stiffness(k) / area),
                    },
                };
                panel.through([0.0; 3], velocity)
            })
            .collect();
        markers.send_marker_forces(&targets);
        markers.spread(&targets);
        air.collide_stream(acceleration, Some(&markers))?;
        if step.is_multiple_of(64) {
            session.check_interrupt()?;
            if step * MEAN_OVER >= steps {
                let states = states(&air)?;
                let momentum: f64 = states.iter().map(|(excess, u)| (1.0 + excess) * u[0]).sum();
                sum += momentum / states.len() as f64;
                samples += 1.0;
            }
        }
    }
    session.progress_to(session.done + 1e-6 * (steps * cells.iter().product::<usize>()) as f64);
    Ok((cells, sum / samples / OPEN / (2.0 * pressure).sqrt()))
}
