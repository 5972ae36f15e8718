//! Lattices of the air, one in the other, for `ripstop check`.

use std::fmt::Write;

use super::Plan;
use super::duration::UPDATES_PER_SECOND_AND_THREAD;
use super::estimate::{LevelSizes, UPDATES_PER_EXCHANGED_CELL};
use crate::case::scene::Air;

/// Writes cells, bytes, share of the work and time of every lattice.
pub(super) fn write(
    out: &mut impl Write,
    plan: &Plan,
    air: &Air,
    threads: usize,
) -> std::fmt::Result {
    let levels = air.levels();
    let sizes = LevelSizes::of(air, &plan.placement);
    // What the exchange takes counts with the box.
    let updates: Vec<f64> = (levels.iter().zip(&sizes))
        .map(|(level, size)| {
            let exchanged = 0.5 * UPDATES_PER_EXCHANGED_CELL * level.shell_cells();
            (size.cells as f64 + exchanged) / air.finest_cells_across(level)
        })
        .collect();
    let all: f64 = updates.iter().sum();
    let steps = (plan.start_steps + plan.steps) as f64;
    for ((level, size), updates) in levels.iter().zip(&sizes).zip(&updates) {
        let cell_m = air.finest_cells_across(level) * air.units.cell_size_m;
        let [nx, ny, nz] = level.cells;
        let first_m = level.corner.map(|n| n as f64 * air.units.cell_size_m);
        let end_m: [f64; 3] = std::array::from_fn(|a| first_m[a] + level.cells[a] as f64 * cell_m);
        let name = match level.depth {
            0 => "outermost".to_owned(),
            depth => format!("box {depth}"),
        };
        let seconds = if plan.sizes.air_on_device {
            String::new()
        } else {
            let seconds = updates * steps / (UPDATES_PER_SECOND_AND_THREAD * threads as f64);
            format!(", about {seconds:.0} s")
        };
        writeln!(
            out,
            "    {name:<17} {nx} x {ny} x {nz} = {} of {cell_m:.4} m, x {:.3} to {:.3}, y {:.3} to {:.3}, z {:.3} to {:.3} m; {:.1} MB, {:.0} % of \
             the work{seconds}",
            size.cells,
            first_m[0],
            end_m[0],
            first_m[1],
            end_m[1],
            first_m[2],
            end_m[2],
            size.bytes as f64 / 1e6,
            100.0 * updates / all
        )?;
    }
    let updates = air.updates_per_step();
    let uniform: f64 = air.cells.iter().map(|n| *n as f64).product();
    writeln!(
        out,
        "    all of the finest {:.2e} cells would be {:.1} times the updates",
        uniform,
        uniform / updates
    )
}
