//! `[output]`: what is written, and when.

use super::file::File;
use super::problem::Problem;
use super::usual;
use super::values::positive;
use crate::frame::{FabricQuantity, FlowQuantity};

/// What to write.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Panels of a wing laid flat.
    pub wing_panels: bool,
    /// Time between rows of `history.csv` [s].
    pub sample_interval_s: f64,
    /// Time between `canopy_*.vtp` files; absent: only the last.
    pub canopy_interval_s: Option<f64>,
    /// Time between `bodies_*.vtp` files; absent: only the last.
    pub bodies_interval_s: Option<f64>,
    /// Time between `flow_*.vti` files; absent: only the last.
    pub flow_interval_s: Option<f64>,
    /// Times of pictures besides the last [s].
    pub picture_times_s: Vec<f64>,
    /// What the fabric's colours show: one picture each.
    pub picture_fabric: Vec<FabricQuantity>,
    /// What the slice of air shows: one picture each.
    pub picture_flow: Vec<FlowQuantity>,
    /// Arrows of the air's velocity on the slice.
    pub picture_arrows: bool,
    /// Time between frames of `animation.png`; absent: none.
    pub animation_interval_s: Option<f64>,
    /// Charts of the history's main columns at the end.
    pub history_plots: bool,
}

/// Checks the table; intervals that are left out follow from the end of the run [s].
pub(super) fn check(file: &File, end_s: f64) -> Result<Output, Problem> {
    let written = file.output.clone().unwrap_or_default();
    let optional = |key: &str, value: Option<f64>| value.map(|v| positive(key, v)).transpose();
    Ok(Output {
        sample_interval_s: usual::or(
            "output.sample_interval_s",
            optional("output.sample_interval_s", written.sample_interval_s)?,
            end_s / 500.0,
        ),
        canopy_interval_s: optional("output.canopy_interval_s", written.canopy_interval_s)?,
        bodies_interval_s: optional("output.bodies_interval_s", written.bodies_interval_s)?,
        flow_interval_s: optional("output.flow_interval_s", written.flow_interval_s)?,
        picture_times_s: picture_times(usual::or(
            "output.picture_times_s",
            written.picture_times_s,
            Vec::new(),
        ))?,
        picture_fabric: quantities(
            "picture_fabric",
            written.picture_fabric,
            &FabricQuantity::ALL,
            FabricQuantity::name,
        )?,
        picture_flow: picture_flow(file, written.picture_flow)?,
        picture_arrows: usual::or("output.picture_arrows", written.picture_arrows, false),
        animation_interval_s: animation_interval(written.animation_interval_s, end_s)?,
        wing_panels: wing_panels(file, written.wing_panels)?,
        history_plots: usual::or("output.history_plots", written.history_plots, false),
    })
}

/// Panels laid flat; refused without a wing.
fn wing_panels(file: &File, written: Option<bool>) -> Result<bool, Problem> {
    let has_wing = file.wing().is_some();
    if written.is_some() && !has_wing {
        return Err(Problem::new(
            "output.wing_panels",
            "output.wing_panels has no effect: there is no wing",
            "remove it, or describe a wing in [structure.wing]",
        ));
    }
    Ok(match written {
        Some(written) => written,
        None if has_wing => usual::noted("output.wing_panels", false),
        None => false,
    })
}

/// What the slice of air shows; refused without air.
fn picture_flow(
    file: &File,
    written: Option<Vec<FlowQuantity>>,
) -> Result<Vec<FlowQuantity>, Problem> {
    if written.is_some() && file.air.is_none() {
        return Err(Problem::new(
            "output.picture_flow",
            "output.picture_flow has no effect: there is no air",
            "remove it, or add [air]",
        ));
    }
    quantities(
        "picture_flow",
        written,
        &FlowQuantity::ALL,
        FlowQuantity::name,
    )
}

/// Most frames of an animation.
const FRAME_LIMIT: f64 = 2_000.0;

fn animation_interval(written: Option<f64>, end_s: f64) -> Result<Option<f64>, Problem> {
    let key = "output.animation_interval_s";
    let interval = written.map(|v| positive(key, v)).transpose()?;
    match interval.filter(|interval| end_s / interval > FRAME_LIMIT) {
        None => Ok(interval),
        Some(interval) => Err(Problem::new(
            key,
            format!("{key} = {interval} makes {:.0} frames", end_s / interval),
            format!("at most {FRAME_LIMIT} are allowed: raise it"),
        )),
    }
}

/// Quantities to draw, each once; the first of `all` if nothing is said.
fn quantities<Q: Copy + PartialEq>(
    key: &str,
    written: Option<Vec<Q>>,
    all: &[Q],
    name: fn(Q) -> &'static str,
) -> Result<Vec<Q>, Problem> {
    let quantities = written.unwrap_or_else(|| {
        usual::noted(format!("output.{key}"), name(all[0]));
        all[..1].to_vec()
    });
    let repeated = (1..quantities.len()).find(|&i| quantities[..i].contains(&quantities[i]));
    if quantities.is_empty() || repeated.is_some() {
        let found = repeated.map_or("nothing".to_owned(), |i| {
            format!("{:?} twice", name(quantities[i]))
        });
        let names: Vec<&str> = all.iter().map(|&quantity| name(quantity)).collect();
        return Err(Problem::new(
            format!("output.{key}"),
            format!("output.{key} holds {found}"),
            format!(
                "name some of {}, each once, or leave the key out",
                names.join(", ")
            ),
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
