//! Triangle meshes: files and quality.

pub mod obj;
pub mod quality;
pub mod surface;
