//! Read-outs: time series, statistics, named results, and their comparison with the values of others.

mod blockage;
pub mod bodies;
mod canopy_shape;
pub mod catenary;
mod comparison;
mod falling;
mod flown_ballooning;
mod imported_wing;
mod load_test;
mod outline;
mod payload_bodies;
mod plate;
mod read_out;
mod record;
mod residual;
mod results;
mod sail_support;
mod skirt;
mod solver;
mod spectrum;
pub mod statistics;
pub mod steady;
mod supports;
mod wing;
mod wing_lines;
mod wing_trim;
mod wing_wind;

pub use comparison::{comparison, history_columns, result_names};
pub use falling::unsettled_fall;
pub use flown_ballooning::{
    differences as ballooning_differences, flown_ballooning, width_ratios as cell_width_ratios,
};
pub use load_test::{
    LoadReading, Nearest, first_failure, key as part_key, line_names, parts as wing_parts,
    read as read_load_step,
};
pub use record::{Record, SAMPLES_FILE};
pub use results::{averaging, results, skirt_spectrum};
pub use sail_support::{
    SlackRegion, StandingRib, concentrations, slack_regions, standing_ribs,
    warnings as sail_warnings,
};
pub use solver::{FORCE_IMBALANCE_LIMIT, account};
pub use wing::{RowLoad, row_loads};
pub use wing_lines::LineName;
pub use wing_trim::cell_widths_m;
pub use wing_wind::{LOWER_SURFACE_COLUMNS, cell_columns, lower_surface_line};
