//! Runs of one case with some of its keys varied: which there are, and what came out of them.

mod ladder;
mod order;
mod report;
mod vary;

pub use ladder::{Ladder, RESOLVED_SHARE, Rung, ladders, mark_unresolved};
pub use order::{Convergence, OnLattice, convergence};
pub use report::{Chosen, Outcome, Status, Sweep, markdown, write};
pub use vary::{AS_WRITTEN, Point, SHIFT_KEY, Vary, points};
