//! Time series of a run: one row per sample, the columns of `history.csv`.

mod samples;
mod series;
mod stored;

pub use samples::SAMPLES_FILE;
pub use series::Record;
