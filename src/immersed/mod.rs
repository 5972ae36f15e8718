//! The immersed boundary: kernel, markers and the cells they touch. Pure formulas and lists, in lattice units.

pub mod folds;
pub mod kernel;
pub mod markers;
pub mod permeable;
pub mod strength;
pub mod touched;
