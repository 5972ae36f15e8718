//! What may be written in a case file, in SI units with the unit in the key: mirrors of its tables, whose comments are the documentation of
//! the keys (`docs/case-files.md`, the JSON schema).

mod air;
mod bare_wing;
mod bodies;
mod canopy;
mod case_file;
mod comparison;
mod design;
mod design_mesh;
mod design_wing;
mod fabric;
mod friction;
mod nodes;
mod output;
mod payload;
mod refinement;
mod structure;
mod supports;
mod time;
mod wing;
mod wing_run;

pub use air::*;
pub use bare_wing::*;
pub use bodies::*;
pub use canopy::*;
pub use case_file::File;
pub use comparison::*;
pub use design::*;
pub use design_mesh::*;
pub use design_wing::*;
pub use fabric::*;
pub use friction::*;
pub use nodes::*;
pub use output::*;
pub use payload::*;
pub use refinement::*;
pub use structure::*;
pub use supports::*;
pub use time::*;
pub use wing::*;
pub use wing_run::*;
