//! Triangle meshes: files and quality.

pub mod lep_sim;
pub mod obj;
pub mod quality;
pub mod surface;
