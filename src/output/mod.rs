//! Files a run leaves behind: VTK frames, the CSV history and `summary.json`.
//!
//! Everything here works on host data in SI units and knows nothing of the solvers. Whole files are
//! written under a temporary name and renamed when complete (see [`write_atomically`]), so a reader
//! never meets a half-written one; the history, which grows, has its own rule (see
//! [`HistoryWriter`]).

mod account;
mod aligned;
mod atomic;
mod chart;
mod comparison;
mod device_use;
mod digits;
mod folder;
mod history;
mod patterns;
mod provenance;
mod pvd;
mod quantity;
mod read_out;
mod summary;
mod summary_table;
mod table;
mod validity;
mod vtk;
mod vtk_data;
mod xml;

pub use account::AccountRow;
pub use aligned::aligned;
pub use atomic::{OutputError, prepare_directory, remove_leftovers, write_atomically};
pub(crate) use chart::{COLOURS, SCALE};
pub use chart::{Chart, Series};
pub use comparison::{
    ComparisonRow, LatticeError, UNRESOLVED_CELLS, comparison_markdown, comparison_text,
    write_comparison,
};
pub use device_use::{DeviceCounts, DeviceLatency, DevicePass, DeviceStage, DeviceUse};
pub use digits::{
    NOTHING, UNRESOLVED, reference_text, significant, value_and_uncertainty, with_interval,
};
pub use folder::{FRAMES_FOLDER, files_of_run};
pub use history::HistoryWriter;
pub use patterns::{PatternPiece, write_patterns};
pub use provenance::{Provenance, Stamp};
pub use pvd::{Pvd, PvdEntry};
pub use quantity::{Quantity, Results};
pub use read_out::ReadOut;
pub use summary::{
    CaseInfo, LatticeSize, MillisecondsPerStep, Processor, SCHEMA_VERSION, StageTime, StopInfo,
    StructureEvery, Summary, write_summary,
};
pub(crate) use table::field;
pub use table::{write_table, write_text_table};
pub use validity::{Bound, ExpectedError, Supports, ValidityRow, When, mark};
pub use vtk::{write_bodies_vtp, write_canopy_vtp, write_flow, write_flow_vti};
