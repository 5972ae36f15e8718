//! Low-order aerodynamics: steady forces and surface pressures of wings in free flight.
//!
//! [`potential_flow`] is a panel method on closed surfaces ([`surface`]); [`vortex_lattice`] an independent method on mean surfaces.
//! [`section`] is the flow around a section with its boundary layers; [`polar`] and [`decambering`] bring in what viscosity does to sections, [`drag`] what lines and pilot add. Everything is in SI units.
//! `docs/low-order-aerodynamics.md` has the equations in order, what they cost and what they cannot do.

pub mod belloc;
mod chordwise;
pub mod decambering;
mod dense;
pub mod drag;
mod error;
mod forces;
pub mod influence;
pub mod polar;
pub mod potential_flow;
pub mod section;
pub mod surface;
mod velocity;
pub mod viscous_polar;
pub mod vortex_lattice;
pub mod wake;

pub use error::AeroError;
pub use forces::Forces;
