//! Meshes of canopies, sheets, cables and bodies, and mesh files.

pub mod airbag;
pub mod cable;
pub mod coupon;
pub mod fabric_surface;
pub mod line_table;
pub mod mesh;
pub mod parachute;
pub mod plate;
pub mod profile;
pub mod sheet;
pub mod spline;
pub mod surfaces;
pub mod table;
pub mod wing;
