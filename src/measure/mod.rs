//! Read-outs: time series, statistics and named results.

pub mod bodies;
pub mod catenary;
mod plate;
mod record;
mod results;
pub mod statistics;
mod wing;

pub use record::Record;
pub use results::results;
