//! Forces of a wing by itself over the angle of attack: what `ripstop polar` computes for `[aero.wing]`.
//!
//! At every angle the panels are solved with the wake along the stream, and the strips' lift is brought to that of their sections ([`crate::aero::decambering`]), once along the
//! branch that follows from small angles and once along the separated one. Lift and induced drag are those of the far wake, drag of the sections that of their
//! polars. Moments are those of the pressures and of the sections' drag, each strip's own replaced by its polar's where that has one. A polar that is not given is computed at three Reynolds numbers between those of the shortest and the longest chord, and taken between them.
//!
//! An angle at which sections and wing do not agree has no coefficients, but for what is left between both; nothing that follows reads it.

mod numbers;
mod sections;
mod solve;

pub use numbers::{Numbers, numbers};
pub use sections::{LEAST_REYNOLDS, SectionsOfWing, sections};
pub use solve::{Coefficients, Point, Polar, StripLoad, matrix_bytes, panels_and_strips, solve};
