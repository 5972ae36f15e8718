//! Meshes of canopies, sheets, cables and bodies, and mesh files.

pub mod cable;
pub mod mesh;
pub mod parachute;
pub mod sheet;
pub mod surfaces;
