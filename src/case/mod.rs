//! Case files: TOML text → [`file::File`] (what is written) → [`scene::Scene`] (checked, SI, absent = `None`).
//!
//! Floors, from below: [`file`], what may be written; problems and checks of single values; one file for each topic, with its checked type and
//! its checks; [`scene`], which puts them together; [`load`], from the text to the checked case.

mod air;
mod bodies;
mod body;
mod cable_material;
mod comparison;
mod contact;
mod coupling;
mod density;
mod descent;
mod equilibrium;
mod error;
mod fabric;
mod faces;
pub mod file;
mod grid_sequence;
mod identity;
mod lattice_speed;
mod lep_sim;
mod load;
pub mod locate;
mod mesh;
pub mod mesh_examination;
mod mesh_lines;
mod motion;
mod output;
mod payload_bodies;
mod permeability;
mod plate;
mod problem;
mod reference;
mod rigging;
mod rims;
pub mod scene;
mod schema;
mod shift;
mod shipped;
mod solver;
mod specimens;
pub mod steady;
mod structure;
mod supports;
mod text;
mod through_faces;
mod time;
mod trim;
mod unused;
mod usual;
mod values;
pub mod wing;
pub mod wing_design;
mod wing_lines;
mod wing_tunnel;

pub use error::CaseError;
pub use identity::{changed_outputs, changed_physics};
pub use load::{Case, Choices, examine_meshes, load, parse};
pub use mesh_examination::ExaminedMesh;
pub use problem::Problem;
pub use reference::key_reference;
pub use scene::Scene;
pub use schema::{SCHEMA_DIRECTIVE, SCHEMA_FILE, schema_text};
pub use shipped::{SHIPPED, SHIPPED_FILES};
pub use text::{ABSENT, number_in};
pub use usual::Resolved;
