//! A sheet that cuts the lattice: what links between cells it cuts, and what comes back along them.
//!
//! A link joins the centre of cell A with that of its neighbour B = A + c. Where a triangle cuts it, air that leaves A along it comes back to A, and
//! air that leaves B to B. The two sides of the sheet touch each other in nothing else, however thin it is. With f the population that leaves
//! along d (c from A, −c from B; shifted by its weight w at rest), the returned one is
//!
//! r = s f + e − 6 w κ d·v,
//!
//! v the velocity of the sheet at the cut, or the mean of the triangles that share it (`src/cloth/patches.rs`). Half-way bounce-back has s = κ = 1 and e = 0 (Ladd 1994, doi:10.1017/S0022112094001771, density 1 in
//! the wall's term). By the distance q of the cut in links (Bouzidi, Firdaouss & Lallemand 2001, doi:10.1063/1.1399290), linear:
//!
//! * q < ½: s = 2q, e = (1 − 2q) times the population that arrives at the cell along d, κ = 1;
//! * q ≥ ½: s = κ = 1/2q, e = (1 − 1/2q) times the one that arrives behind the cell, along −d;
//!
//! half-way where the link behind is cut, too, or leads out of the air. *Departure*: what half-way bounce-back would have returned less what this returns goes to
//! the cell's population at rest, so that the air's mass stays exact. Half-way, and with both sides at one velocity, what one loses the other gains.
//!
//! The air gets the momentum −d (f + r), the sheet the opposite. That is affine in v with the positive semidefinite matrix 6 w κ d dᵀ. It is a convex part of the
//! fabric's implicit step ([`crate::cpu::cloth::TriangleReaction`]), so that the ratio of masses does not decide on stability.
//!
//! Two layers in one link enclose air that has no cell. Each layer feels its own outer side; between both stands a pressure that is carried
//! along the faces of the sheet from where they have cells ([`FacePressures`]). Mass: each side gets the mean velocity of both layers in place of its own.
//!
//! * [`search`]: which links are cut, and where;
//! * [`by_triangle`]: the cuts in the order of triangles;
//! * `cell_numbers`: numbers of the cells that images are taken from;
//! * [`cell_states`]: what left them, and the state of their air;
//! * [`bounce`]: what comes back;
//! * [`places`]: where it lies in memory;
//! * [`pockets`]: air shut in by folds;
//! * [`faces`]: pressures on both faces, as fields on nodes;
//! * `smoothing`: fields smoothed along the sheet;
//! * [`through`]: air through the fabric, and through openings narrower than the cells;
//! * [`slide`]: what comes back where the air slides along the surface;
//! * `surroundings`: the cells around a cut link, and which the mirror image of one is taken from;
//! * [`images`]: those of all sides where it slides;
//! * `blocks`: which of these hold their energy together, and share what they lose;
//! * [`energy`]: what the wall may give the air;
//! * [`reflections`]: what comes back to all of them, and the mass that the wall owes the air;
//! * [`boundary_layer`]: the stress that a wall along which the air slides gets from a model of layers thinner than a cell;
//! * `modelled`: what such a model needs to know of the air;
//! * [`stress`]: where that is taken from the air;
//! * [`standing_walls`]: what a device needs to answer by itself where no wall moves;
//! * [`spaces`]: which faces look at the same air.

mod blocks;
pub mod bounce;
pub mod boundary_layer;
pub mod by_triangle;
mod cell_box;
mod cell_numbers;
pub mod cell_states;
pub mod energy;
pub mod faces;
pub mod images;
mod modelled;
pub mod places;
pub mod pockets;
pub mod reflections;
pub mod search;
pub mod slide;
mod smoothing;
pub mod spaces;
pub mod standing_walls;
pub mod stress;
mod surroundings;
pub mod through;

pub use bounce::{Return, SIDES, Side};
pub use boundary_layer::BoundaryLayers;
pub use by_triangle::CutsByTriangle;
pub use cell_states::{CellState, CellStates};
pub use faces::FacePressures;
pub use images::Images;
pub use pockets::Pockets;
pub use reflections::Reflections;
pub use search::{Cut, CutLink, CutLinks, Domain, OutOfAir};
pub use standing_walls::StandingWalls;
pub use stress::{Changed, ChangedByPair, Stress};
pub use through::{Passage, Through};
