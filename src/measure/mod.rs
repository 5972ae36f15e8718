//! Read-outs: time series, statistics, named results, and their comparison with the values of others.

mod air;
mod air_around_wing;
mod blockage;
mod bodies;
pub(crate) mod canopy;
pub(crate) mod canopy_shape;
mod catalogue;
pub mod catenary;
mod comparison;
mod contact;
mod energy;
pub(crate) mod extremes;
mod fabric;
pub(crate) mod falling;
mod filling;
pub mod flow_past_bodies;
mod flown_ballooning;
mod headline;
mod imported_wing;
mod impulses;
mod line_drag;
mod load_test;
pub(crate) mod opening;
mod outline;
mod payload_bodies;
mod permeable;
pub(crate) mod plate;
mod read_out;
mod record;
mod reduce;
mod residual;
mod results;
mod sail_support;
mod sampling;
pub(crate) mod shared;
mod skirt;
mod solver;
mod spectrum;
pub mod statistics;
pub mod steady;
pub(crate) mod strengths;
mod supports;
mod wall_images;
mod wing;
mod wing_lines;
mod wing_trim;
mod wing_walls;
pub(crate) mod wing_wind;

pub use bodies::watched;
pub use canopy::averaging;
pub use catalogue::{CHARTS, declared_result, declared_results, read_out_tables};
pub use comparison::{comparison, history_columns, result_names};
pub use falling::unsettled_fall;
pub use flown_ballooning::{
    differences as ballooning_differences, flown_ballooning, width_ratios as cell_width_ratios,
};
pub use headline::headline;
pub use load_test::{
    LoadReading, Nearest, first_failure, line_names, parts as wing_parts, read as read_load_step,
};
pub use opening::skirt_spectrum;
pub use read_out::{Group, ReadOut};
pub use record::{Record, SAMPLES_FILE};
pub use results::{averaging_window_s, results};
pub use sail_support::{
    SlackRegion, StandingRib, concentrations, slack_regions, standing_ribs,
    warnings as sail_warnings,
};
pub use solver::{FORCE_IMBALANCE_LIMIT, account};
pub use wing::{RowLoad, key as part_key, row_loads};
pub use wing_lines::LineName;
pub use wing_trim::cell_widths_m;
pub use wing_wind::{LOWER_SURFACE_COLUMNS, cell_columns, lower_surface_line};
