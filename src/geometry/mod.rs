//! Meshes of canopies, sheets, cables and bodies, and mesh files.

pub mod airbag;
pub mod cable;
pub mod coupon;
pub mod fabric_surface;
pub mod mesh;
pub mod parachute;
pub mod sheet;
pub mod surfaces;
pub mod wing;
