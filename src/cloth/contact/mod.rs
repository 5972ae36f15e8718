//! Contact of fabric with itself, as geometry: distances, barriers, pairs. [`crate::cpu::cloth`] makes forces of it.
//!
//! Incremental potential contact (Li et al. 2020; of shells: Li, Kaufman & Jiang 2021): fabric that comes closer than a thickness has an
//! energy that grows without bounds as the distance goes to zero. That energy takes part in the minimisation of the implicit step, so its forces
//! are equal and opposite. Fabric that has not crossed itself never does. Between trials of the line search no pair may go farther
//! than it safely can ([`advance`]).
//!
//! * [`distance`]: nearest points of a node and a triangle, and of two edges;
//! * [`barrier`]: energy, gradient and curvature of a pair;
//! * [`advance`]: how far a pair may go;
//! * [`grid`], [`pairs`]: which pairs are near;
//! * [`crossing`]: whether fabric has passed through itself.
//!
//! *Departures from the cited form*: the barrier is of the distance, not of its square, and has no offset: two fabrics begin to push at
//! the thickness and may come closer under load. Its stiffness follows from what holds the nodes (`cpu/cloth/contact.rs`), not from
//! a rule that adapts it within a step. The projected Hessian keeps the curvature along the normal only, which is positive; what
//! is left out (the turning of the normal) is negative for most pairs. Pairs that start closer than the thickness keep
//! their own. There is no friction. `docs/contact.md` says what it costs.

pub mod advance;
pub mod barrier;
mod check;
pub mod crossing;
pub mod distance;
pub mod grid;
pub mod pairs;

pub use check::{CLOSEST_START, ContactFault, LARGEST_THICKNESS, check};

/// That a structure's fabric meets itself, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Distance of the middle surfaces below which fabric pushes fabric [m].
    pub thickness_m: f64,
}
