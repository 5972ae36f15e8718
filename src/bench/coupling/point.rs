//! What a scheme of coupling comes to.

use serde::Serialize;

use super::scheme::{DEFAULT, Scheme};
use crate::bench::Engine;

/// Name of the rigid disk.
pub(super) const DISK: &str = "disk";

/// One scheme, measured. Means run over the second half of the time from release; not finite where the run broke down.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// `canopy` or `disk`.
    pub body: &'static str,
    /// Over-relaxation a on a flat sheet.
    pub over_relaxation: f64,
    /// Steps k of the air per solve of the fabric, at most.
    pub structure_every: u32,
    /// The same in the mean.
    pub mean_structure_every: f64,
    /// Steps of the running mean of u*; 1 without.
    pub averaging_steps: u32,
    /// Tolerance of the solver.
    pub tolerance: f64,
    /// Largest spacing of markers on a triangle [cells].
    pub marker_spacing_cells: f64,
    /// Passes of forcing.
    pub passes: u32,
    /// Mass of fabric and lines over that of the air in a cell's thickness on the fabric; not finite for the disk.
    pub mass_ratio: f64,
    /// Cells per D_0, or per diameter of the disk.
    pub cells_per_diameter: f64,
    /// Engine and precision.
    pub engine: String,
    /// Markers.
    pub markers: usize,
    /// Root of the area of a marker [cells].
    pub marker_distance_cells: f64,
    /// Steps.
    pub steps: u64,
    /// Fastest node of the whole run over the wind; zero for the disk.
    pub fastest: f64,
    /// Root mean square slip over the wind.
    pub slip: f64,
    /// Mean normal velocity of the air through the surface, downstream, over the wind.
    pub leakage: f64,
    /// Root mean square of the drag's change from step to step over the mean drag.
    pub drag_noise: f64,
    /// Largest difference of the force routes over the drag.
    pub force_imbalance: f64,
    /// Mean drag coefficient.
    pub drag_coefficient: f64,
    /// Mean D_p/D_0; not finite for the disk.
    pub projected_diameter_ratio: f64,
    /// Evaluations of the fabric's energy per step.
    pub evaluations_per_step: f64,
    /// Time of the fabric per step [ms]: medians, which other work on the machine disturbs little.
    pub cloth_ms: f64,
    /// The same of the stages between air and markers [ms].
    pub coupling_ms: f64,
    /// True if no other scheme of the body is as good in cost, slip and noise and better in one.
    pub unbeaten: bool,
}

impl Point {
    pub(super) fn new(
        body: &'static str,
        scheme: &Scheme,
        cells_per_diameter: f64,
        engine: &Engine,
    ) -> Self {
        Self {
            body,
            over_relaxation: scheme.over_relaxation,
            structure_every: scheme.structure_every,
            mean_structure_every: f64::NAN,
            averaging_steps: scheme.averaging_steps,
            tolerance: scheme.tolerance,
            marker_spacing_cells: scheme.marker_spacing_cells,
            passes: scheme.passes,
            mass_ratio: f64::NAN,
            cells_per_diameter,
            engine: engine.name(),
            markers: 0,
            marker_distance_cells: f64::NAN,
            steps: 0,
            fastest: f64::INFINITY,
            slip: f64::NAN,
            leakage: f64::NAN,
            drag_noise: f64::NAN,
            force_imbalance: f64::NAN,
            drag_coefficient: f64::NAN,
            projected_diameter_ratio: f64::NAN,
            evaluations_per_step: f64::NAN,
            cloth_ms: f64::NAN,
            coupling_ms: f64::NAN,
            unbeaten: false,
        }
    }

    pub(super) fn cost_ms(&self) -> f64 {
        self.cloth_ms + self.coupling_ms
    }

    /// What is not as in the default.
    pub(super) fn name(&self) -> String {
        let mut parts = vec![format!("a {:.3}", self.over_relaxation)];
        if self.body == DISK {
            parts.push(format!("passes {}", self.passes));
            return parts.join(", ");
        }
        parts.push(format!("k {}", self.structure_every));
        if self.averaging_steps > 1 {
            parts.push(format!("u* over {} steps", self.averaging_steps));
        }
        if self.tolerance != DEFAULT.tolerance {
            parts.push(format!("tolerance {:e}", self.tolerance));
        }
        if self.marker_spacing_cells != DEFAULT.marker_spacing_cells {
            parts.push(format!("markers {} cells", self.marker_spacing_cells));
        }
        parts.join(", ")
    }
}

/// Middle one of some values; not finite without any.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
