//! A rough duration of a run on the CPU.

use super::Plan;

/// Cell updates per second and thread assumed for estimates: a cautious figure for two threads of a server CPU with AVX2
/// (see `benches/results/`).
pub(super) const UPDATES_PER_SECOND_AND_THREAD: f64 = 4.5e7;

/// Seconds per marker and step assumed for interpolation and spreading on one thread.
const SECONDS_PER_MARKER: f64 = 0.5e-6;

/// Seconds per cut link and step assumed for finding, reading and returning (0.28 µs was measured on a closed wing, docs/results/2026-11-29-wings-on-more-lattices.md).
const SECONDS_PER_LINK: f64 = 0.3e-6;

/// Seconds per node, element and objective evaluation assumed for the fabric on one thread.
const SECONDS_PER_ELEMENT_EVALUATION: f64 = 0.05e-6;

/// Seconds per marker and evaluation assumed for the springs to the air.
const SECONDS_PER_MARKER_EVALUATION: f64 = 0.027e-6;

impl Plan {
    /// Rough duration on `threads` threads [s]; `None` for a static equilibrium, whose iterations are not known, where the evaluations of the
    /// fabric are not known, and on a device.
    #[must_use]
    pub fn estimated_seconds(&self, threads: usize) -> Option<f64> {
        let steps = (self.start_steps + self.steps) as f64;
        // These rates are the CPU's.
        if steps == 0.0 || self.sizes.air_on_device || self.placement.cloth_on_device() {
            return None;
        }
        let sizes = &self.sizes;
        let evaluations = match &self.evaluations {
            Some(known) => known.per_step(self.evaluation_limit)?,
            None => 0.0,
        };
        let elements = (sizes.nodes + sizes.triangles + sizes.cables) as f64;
        let per_evaluation = elements * SECONDS_PER_ELEMENT_EVALUATION
            + sizes.markers as f64 * SECONDS_PER_MARKER_EVALUATION;
        let per_step = (sizes.updates + sizes.exchange_updates) as f64
            / (UPDATES_PER_SECOND_AND_THREAD * threads as f64)
            + sizes.markers as f64 * SECONDS_PER_MARKER
            + sizes.links as f64 * SECONDS_PER_LINK / threads as f64;
        // Held while the wind rises.
        Some(steps * per_step + self.steps as f64 * evaluations * per_evaluation)
    }
}
