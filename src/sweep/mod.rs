//! Runs of one case with some of its keys varied: which there are, and what came out of them.

mod report;
mod vary;

pub use report::{Chosen, Outcome, Status, Sweep, markdown, write};
pub use vary::{AS_WRITTEN, Point, Vary, points};
