//! The native engine: every stage of the plan on CPU threads, one file per stage.

pub mod cloth;
pub mod fluid;
pub mod immersed;
