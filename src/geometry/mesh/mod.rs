//! Triangle meshes: files, quality, and what is wrong with them.

pub mod doctor;
pub mod lep_sim;
pub mod obj;
pub mod quality;
pub mod surface;
