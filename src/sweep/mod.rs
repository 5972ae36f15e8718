//! Runs of one case with some of its keys varied: which there are, and what came out of them.

mod contents;
mod ladder;
mod order;
mod report;
mod vary;

pub use contents::{Ladder, Outcome, Rung, Status, Sweep};
pub use ladder::{RESOLVED_SHARE, ladders, mark_unresolved};
pub use order::{Convergence, OnLattice, convergence};
pub use report::{Chosen, charts, markdown, write};
pub use vary::{AS_WRITTEN, Point, SHIFT_KEY, Vary, points};
