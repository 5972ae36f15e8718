//! `[output]`: what is written, and when.

use super::Problem;
use super::file::File;
use super::scene::{Output, positive};
use crate::frame::FabricQuantity;

/// Checks the table; intervals that are left out follow from the end of the run [s].
pub(super) fn check(file: &File, end_s: f64) -> Result<Output, Problem> {
    let written = file.output.clone().unwrap_or_default();
    let optional = |key: &str, value: Option<f64>| value.map(|v| positive(key, v)).transpose();
    Ok(Output {
        sample_interval_s: optional("output.sample_interval_s", written.sample_interval_s)?
            .unwrap_or(end_s / 500.0),
        canopy_interval_s: optional("output.canopy_interval_s", written.canopy_interval_s)?,
        bodies_interval_s: optional("output.bodies_interval_s", written.bodies_interval_s)?,
        flow_interval_s: optional("output.flow_interval_s", written.flow_interval_s)?,
        picture_times_s: picture_times(written.picture_times_s.unwrap_or_default())?,
        picture_fabric: picture_fabric(written.picture_fabric)?,
    })
}

/// What the fabric's colours show: its tension if nothing is said; each quantity once.
fn picture_fabric(written: Option<Vec<FabricQuantity>>) -> Result<Vec<FabricQuantity>, Problem> {
    let quantities = written.unwrap_or_else(|| vec![FabricQuantity::Tension]);
    let repeated = (1..quantities.len()).find(|&i| quantities[..i].contains(&quantities[i]));
    if quantities.is_empty() || repeated.is_some() {
        let found = repeated.map_or("nothing".to_owned(), |i| {
            format!("{:?} twice", quantities[i].name())
        });
        return Err(Problem::new(
            "output.picture_fabric",
            format!("output.picture_fabric holds {found}"),
            "name some of tension, stress, von_mises, shear_stress, wrinkles, each once, or leave the key out",
        ));
    }
    Ok(quantities)
}

/// Refuses times before release, or none at all; times beyond the end are simply not reached.
fn picture_times(times: Vec<f64>) -> Result<Vec<f64>, Problem> {
    match times.iter().find(|t| !(**t >= 0.0 && t.is_finite())) {
        None => Ok(times),
        Some(t) => Err(Problem::new(
            "output.picture_times_s",
            format!("output.picture_times_s holds {t}"),
            "give times from 0, the release, on",
        )),
    }
}
