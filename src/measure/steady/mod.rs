//! When is the mean drag known well enough, and from when on does it count?

pub mod bodies;
mod canopy;
mod detector;

pub(super) use canopy::BATCH;
pub use canopy::{SETTLING, SHORTEST_WINDOW, Window, coarse_grid_is_done, mean, window};
pub use detector::{Detector, Watched};
