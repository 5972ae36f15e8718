//! The part of a case file that describes supports that are moved.

use serde::Deserialize;

use super::file::MotionTable;

/// `[supports.NAME]`: held nodes that are moved together.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupportTable {
    /// Two opposite corners of a box: the held nodes that start inside it are moved [m].
    pub box_m: Option<[[f64; 3]; 2]>,
    /// Or their numbers, from 1.
    pub nodes: Option<Vec<u32>>,
    /// How far they are moved [m].
    pub displacement_m: Option<[f64; 3]>,
    /// Time in which they are moved so far, at constant speed [s].
    pub ramp_time_s: Option<f64>,
    /// Or how they move.
    pub motion: Option<MotionTable>,
}
