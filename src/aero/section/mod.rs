//! Sections: lift, drag and moment of an airfoil section in viscous flow, by a method of XFOIL's class.
//!
//! [`Section`] takes an outline and covers it with panels; [`Section::polar`] solves it at several angles. The flow is steady, plane and
//! incompressible. Outside, a linear-vorticity panel method (`influence`, `inviscid`, `wake`); along the surface and the wake, two-equation integral
//! boundary layers (`station`, `closure`, `amplification`, `interval`, `layers`); both together by Newton's method (`march`, `newton`, `polar`).
//!
//! Sources: Drela & Giles, AIAA J. 25 (1987) 1347; Drela, XFOIL, in Low Reynolds Number Aerodynamics, Springer LNE 54 (1989); Fidkowski, AIAA J. 60
//! (2022) 2961. Lengths are in chords, speeds in those of the stream, angles in radians.
//!
//! The constants of the closure, of the lag equation and of the limits in separated flow were written down as we know them from these works, and checked against XFOIL 6.99
//! (`validation`), not against the print of each; no code of others was opened.
//!
//! What it cannot do: separation far ahead of the trailing edge is outside of what the closure was fitted to, so lift beyond its largest is a
//! trend, not a number. Largest lift itself comes out up to a fifth too high at high Reynolds numbers. A laminar layer that separates and reaches
//! the trailing edge as such makes lift uncertain by some hundredths.

mod amplification;
mod closure;
mod dual;
mod error;
mod influence;
mod interval;
mod inviscid;
mod layers;
mod march;
mod newton;
mod outline;
mod panelling;
mod polar;
#[cfg(test)]
mod shapes;
mod station;
#[cfg(test)]
mod validation;
mod wake;

pub use error::SectionError;
pub use polar::{Conditions, InviscidState, Section, SectionState};
