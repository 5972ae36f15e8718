//! Read-outs: time series, statistics, named results, and their comparison with the values of others.

pub mod bodies;
mod canopy_shape;
pub mod catenary;
mod comparison;
mod outline;
mod plate;
mod record;
mod results;
mod skirt;
mod spectrum;
pub mod statistics;
mod supports;
mod wing;
mod wing_trim;
mod wing_wind;

pub use comparison::{comparison, history_columns, result_names};
pub use record::Record;
pub use results::{results, skirt_spectrum};
pub use wing::{RowLoad, row_loads};
pub use wing_trim::cell_widths_m;
pub use wing_wind::{LOWER_SURFACE_COLUMNS, cell_columns, lower_surface_line};
