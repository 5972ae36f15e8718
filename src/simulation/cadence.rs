//! How often the fabric is solved where the plan lets several steps of the air pass between its solves.
//!
//! A solve spans k steps. k is the largest up to the plan's for which no marker moves farther than [`MARKER_MOTION_LIMIT`] in them: first
//! judged by the velocities of the last solve, then by the new ones; a solve that turns out too fast is taken back and repeated with fewer
//! steps. So the limit holds in every span of more than one step, and k follows from the state alone.

use std::io;

use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::plan::MARKER_MOTION_LIMIT;

/// Section of a checkpoint.
const SECTION: &str = "structure_every";

/// Spans of the fabric's solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cadence {
    /// k of the plan.
    planned: u32,
    /// k of the present span.
    every: u32,
    /// Step of the next solve.
    next: u64,
    /// Spans so far.
    spans: u64,
    /// Spans with fewer steps than planned.
    shortened: u64,
    /// Steps of all spans.
    steps: u64,
}

impl Cadence {
    /// Solves from `first` on, at most `planned` steps apart.
    pub(super) const fn new(planned: u32, first: u64) -> Self {
        Self {
            planned,
            every: planned,
            next: first,
            spans: 0,
            shortened: 0,
            steps: 0,
        }
    }

    /// True if a span begins with this step.
    pub(super) const fn begins(&self, step: u64) -> bool {
        step >= self.next
    }

    /// k of the present span.
    #[must_use]
    pub const fn every(&self) -> u32 {
        self.every
    }

    /// Step that the span under way at `step` ends with.
    pub(super) fn end_of_span(&self, step: u64) -> u64 {
        self.next.max(step)
    }

    /// Steps of the present span that are gone before `step`.
    pub(super) fn gone(&self, step: u64) -> u32 {
        let left = self.next.saturating_sub(step);
        self.every - u32::try_from(left).map_or(self.every, |left| left.min(self.every))
    }

    /// Takes k for a span whose fastest marker moves with `speed` [cells per step].
    pub(super) fn begin(&mut self, speed: f64) {
        self.every = most_steps(speed).clamp(1, self.planned);
    }

    /// Takes a smaller k, if the solve just done lets a marker move with `speed` [cells per step] and that is too far in k steps.
    pub(super) fn shorten(&mut self, speed: f64) -> bool {
        let too_far = self.every > 1 && speed * f64::from(self.every) > MARKER_MOTION_LIMIT;
        if too_far {
            self.every = most_steps(speed).clamp(1, self.every - 1);
        }
        too_far
    }

    /// The span that begins with `step` is solved.
    pub(super) fn end(&mut self, step: u64) {
        self.next = step + u64::from(self.every);
        self.spans += 1;
        self.shortened += u64::from(self.every < self.planned);
        self.steps += u64::from(self.every);
    }

    /// Counts spans from here on.
    pub(super) const fn count_anew(&mut self) {
        (self.spans, self.shortened, self.steps) = (0, 0, 0);
    }

    /// k of the plan.
    #[must_use]
    pub const fn planned(&self) -> u32 {
        self.planned
    }

    /// Spans with fewer steps than planned.
    #[must_use]
    pub const fn shortened(&self) -> u64 {
        self.shortened
    }

    /// Spans so far.
    #[must_use]
    pub const fn spans(&self) -> u64 {
        self.spans
    }

    /// Mean k so far; `None` before the first solve.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.spans > 0).then(|| self.steps as f64 / self.spans as f64)
    }

    pub(super) fn save(&self, out: &mut Writer) -> io::Result<()> {
        out.put(
            SECTION,
            &[
                u64::from(self.every),
                self.next,
                self.spans,
                self.shortened,
                self.steps,
            ],
        )
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let stored: Vec<u64> = from.take_exactly(SECTION, 5)?;
        self.every = u32::try_from(stored[0])
            .ok()
            .filter(|every| (1..=self.planned).contains(every))
            .ok_or_else(|| from.damaged("the fabric's steps are out of range".to_owned()))?;
        [self.next, self.spans, self.shortened, self.steps] =
            [stored[1], stored[2], stored[3], stored[4]];
        Ok(())
    }
}

/// Steps in which a marker of that speed moves no farther than the limit.
fn most_steps(speed: f64) -> u32 {
    // Not a number, or no motion at all, gives the largest; a solve that is not finite ends the run by itself.
    let steps = (MARKER_MOTION_LIMIT / speed).floor();
    if steps.is_finite() {
        steps as u32
    } else {
        u32::MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the speeds, a span of several steps keeps within the limit, and a slow sheet gets what is planned.
    #[test]
    fn spans_keep_the_limit() {
        let mut cadence = Cadence::new(10, 5);
        assert!(!cadence.begins(4) && cadence.begins(5));
        for (before, after, expected) in [
            (0.0, 0.0, 10),
            (0.02, 0.024, 10),
            (0.03, 0.03, 8),
            (0.0, 0.06, 4),
            (0.04, 0.07, 3),
            (0.13, 0.13, 1),
            (0.3, 0.5, 1),
            (0.025, 0.0250001, 9),
        ] {
            cadence.begin(before);
            while cadence.shorten(after) {}
            assert_eq!(cadence.every(), expected, "{before} {after}");
            assert!(cadence.every() == 1 || after * f64::from(cadence.every()) <= 0.25);
        }
        assert_eq!(cadence.mean(), None);
        cadence.end(5);
        assert!(!cadence.begins(13) && cadence.begins(14));
        assert_eq!(
            (cadence.spans(), cadence.shortened(), cadence.mean()),
            (1, 1, Some(9.0))
        );
    }
}
