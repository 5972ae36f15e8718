//! Triangle meshes: files, quality, and what is wrong with them.

pub mod doctor;
pub mod lep_sim;
pub mod obj;
pub mod openings;
mod polygon;
pub mod quality;
pub mod sections;
mod stl;
pub mod surface;
