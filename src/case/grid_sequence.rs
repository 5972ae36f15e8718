//! Coarser grids that a run to the steady state begins on: `steady.grid_sequence`.

use std::path::Path;

use super::air::Flow;
use super::file::File;
use super::problem::Problem;
use super::scene::{self, Scene};
use super::values::readable;

/// Largest ratio of cell sizes from one grid to the next.
const LARGEST_RATIO: f64 = 4.0;

/// Most grids before the case's own.
const MOST_GRIDS: usize = 4;

const KEY: &str = "steady.grid_sequence";

/// The same scene on every coarser grid of the sequence, coarsest first; empty without a sequence.
pub(super) fn check(file: &File, scene: &Scene, folder: &Path) -> Result<Vec<Scene>, Problem> {
    let Some(ratios) = file.steady.as_ref().and_then(|s| s.grid_sequence.as_ref()) else {
        return Ok(Vec::new());
    };
    let wind = matches!(
        scene.air.as_ref().map(|air| &air.flow),
        Some(Flow::WindTunnel { speed_m_s, .. }) if *speed_m_s > 0.0
    );
    if scene.canopy().is_none() || !wind || scene.descent.is_some() {
        return Err(Problem::new(
            KEY,
            format!(
                "{KEY} leads to a steady state, which only a canopy in the wind of a tunnel has"
            ),
            format!("remove {KEY}"),
        ));
    }
    let falls = ratios
        .iter()
        .chain(&[1.0])
        .zip(ratios.iter().skip(1).chain(&[1.0]))
        .take(ratios.len())
        .all(|(&now, &next)| now > next && now <= LARGEST_RATIO * next);
    if ratios.is_empty() || ratios.len() > MOST_GRIDS || !falls {
        let written: Vec<String> = ratios.iter().map(|&ratio| readable(ratio)).collect();
        return Err(Problem::new(
            KEY,
            format!(
                "{KEY} = [{}] is no sequence from coarse to fine",
                written.join(", ")
            ),
            format!(
                "give one to {MOST_GRIDS} cell sizes as multiples of the case's own, falling, each at most {LARGEST_RATIO} times the next; \
                 [2.0] is usual"
            ),
        ));
    }
    ratios
        .iter()
        .map(|&ratio| {
            let mut coarser = file.clone();
            if let Some(resolution) = &mut coarser.resolution {
                if let Some(cells) = &mut resolution.cells_per_diameter {
                    *cells /= ratio;
                }
                if let Some(size) = &mut resolution.cell_size_m {
                    *size *= ratio;
                }
                // The structure stays in its place.
                if let Some(shift) = &mut resolution.shift_cells {
                    *shift = shift.map(|cells| cells / ratio);
                }
            }
            scene::check(&coarser, folder).map_err(|problem| Problem {
                message: format!(
                    "on the grid of {} times larger cells ({KEY}): {}",
                    readable(ratio),
                    problem.message
                ),
                ..problem
            })
        })
        .collect()
}
