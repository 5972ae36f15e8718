//! Frames and pictures that a run has written so far.

use super::animation;
use super::names::{frame, in_frames};
use crate::checkpoint::{CheckpointError, Reader};
use crate::simulation::Simulation;

/// What has been written so far, by a run that is resumed.
#[derive(Debug, Default)]
pub(super) struct Written {
    pub(super) canopy_times_s: Vec<f64>,
    pub(super) flow_times_s: Vec<f64>,
    pub(super) bodies_times_s: Vec<f64>,
    pub(super) timed_pictures: usize,
    pub(super) animation_frames: usize,
}

/// Number of a picture that is named so.
fn picture_number(name: &str) -> Option<usize> {
    let digits = name.strip_prefix("snapshot_")?.get(..3)?;
    digits.parse().ok()
}

impl Written {
    /// Takes the case's picture times for others than those that were drawn at: all before the present step count as drawn.
    pub(super) fn expect_pictures(&mut self, simulation: &Simulation) {
        let scene = simulation.scene();
        let step_s = scene.time.map_or(0.0, |time| time.step_s);
        let before_s = simulation.time_s() - 0.5 * step_s;
        let times = &scene.output.picture_times_s;
        self.timed_pictures = times.iter().filter(|t| **t <= before_s).count();
    }

    /// Names of all files.
    pub(super) fn names(&self) -> Vec<String> {
        let count = |length: usize, name: fn(usize) -> String| (0..length).map(name);
        count(self.canopy_times_s.len(), canopy_name)
            .chain(count(self.bodies_times_s.len(), bodies_name))
            .chain(count(self.flow_times_s.len(), flow_name))
            .chain(count(self.animation_frames, animation::frame_name))
            .chain(count(self.timed_pictures, |n| {
                format!("snapshot_{n:03}.png")
            }))
            .collect()
    }

    /// True for any picture of an instant that has been drawn.
    pub(super) fn has_picture(&self, name: &str) -> bool {
        picture_number(name).is_some_and(|number| number < self.timed_pictures)
    }

    /// True for any file of an instant of the air that has been written: one for every lattice, and what lists them.
    pub(super) fn has_flow(&self, name: &str) -> bool {
        let name = in_frames(name).unwrap_or(name);
        let number = name.strip_prefix("flow_").and_then(|rest| rest.get(..5));
        number
            .and_then(|digits| digits.parse::<usize>().ok())
            .is_some_and(|number| number < self.flow_times_s.len())
    }

    pub(super) fn restore(from: &Reader) -> Result<Self, CheckpointError> {
        Ok(Self {
            canopy_times_s: from.take("canopy_times")?,
            flow_times_s: from.take("flow_times")?,
            bodies_times_s: from.take("bodies_times")?,
            timed_pictures: from.take_exactly::<u64>("timed_pictures", 1)?[0] as usize,
            animation_frames: from.take_exactly::<u64>("animation_frames", 1)?[0] as usize,
        })
    }
}

pub(super) fn canopy_name(index: usize) -> String {
    frame(&format!("canopy_{index:05}.vtp"))
}

pub(super) fn bodies_name(index: usize) -> String {
    frame(&format!("bodies_{index:05}.vtp"))
}

/// All the air, or its outermost lattice.
pub(super) fn flow_name(index: usize) -> String {
    frame(&format!("flow_{index:05}.vti"))
}

/// What lists a lattice with its boxes of finer cells.
pub(super) fn flow_levels_name(index: usize) -> String {
    frame(&format!("flow_{index:05}.vtm"))
}
