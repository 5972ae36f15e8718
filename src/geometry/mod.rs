//! Meshes of canopies, sheets and cables, and mesh files.

pub mod cable;
pub mod mesh;
pub mod parachute;
pub mod sheet;
