//! `[output]`: what is written, and when.

use super::file::{self, File, Structure};
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
    refuse_unused(file, &written)?;
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
        picture_flow: quantities(
            "picture_flow",
            written.picture_flow,
            &FlowQuantity::ALL,
            FlowQuantity::name,
        )?,
        picture_arrows: usual::or("output.picture_arrows", written.picture_arrows, false),
        animation_interval_s: animation_interval(written.animation_interval_s, end_s)?,
        wing_panels: wing_panels(file, written.wing_panels),
        history_plots: usual::or("output.history_plots", written.history_plots, false),
    })
}

/// Something that a key needs: whether the case has it, what is said where it does not, and what brings it.
type Need = (bool, &'static str, &'static str);

/// Refuses keys that nothing in the case would read.
fn refuse_unused(file: &File, written: &file::Output) -> Result<(), Problem> {
    let of = |what: fn(&Structure) -> bool| file.structure.as_ref().is_some_and(what);
    let structure = file.structure.is_some();
    let bodies = !file.bodies.is_empty();
    let time: Need = (file.time.is_some(), "there is no motion", "add [time]");
    let air: Need = (file.air.is_some(), "there is no air", "add [air]");
    let any: Need = (
        structure,
        "there is no structure",
        "describe one in [structure]",
    );
    let fabric: Need = (
        of(|structure| !matches!(structure, Structure::Cable(_))),
        "there is no fabric",
        "describe a structure with fabric in [structure]",
    );
    let rigid: Need = (
        bodies,
        "there is no rigid body",
        "describe one in [bodies.NAME]",
    );
    let surface: Need = (
        structure || bodies,
        "nothing stands in the air",
        "describe a structure or a body",
    );
    let wing: Need = (
        file.wing().is_some(),
        "there is no wing",
        "describe a wing in [structure.wing]",
    );
    for (key, present, needs) in [
        (
            "sample_interval_s",
            written.sample_interval_s.is_some(),
            &[time][..],
        ),
        (
            "canopy_interval_s",
            written.canopy_interval_s.is_some(),
            &[any, time],
        ),
        (
            "bodies_interval_s",
            written.bodies_interval_s.is_some(),
            &[rigid],
        ),
        ("flow_interval_s", written.flow_interval_s.is_some(), &[air]),
        (
            "picture_times_s",
            written.picture_times_s.is_some(),
            &[time],
        ),
        (
            "picture_fabric",
            written.picture_fabric.is_some(),
            &[fabric],
        ),
        ("picture_flow", written.picture_flow.is_some(), &[air]),
        ("picture_arrows", written.picture_arrows.is_some(), &[air]),
        (
            "animation_interval_s",
            written.animation_interval_s.is_some(),
            &[time],
        ),
        (
            "history_plots",
            written.history_plots.is_some(),
            &[air, surface],
        ),
        ("wing_panels", written.wing_panels.is_some(), &[wing]),
    ] {
        let lacking = needs.iter().find(|(has, ..)| present && !has);
        if let Some((_, lack, remedy)) = lacking {
            return Err(Problem::new(
                format!("output.{key}"),
                format!("output.{key} has no effect: {lack}"),
                format!("remove it, or {remedy}"),
            ));
        }
    }
    Ok(())
}

/// Panels laid flat, of a wing.
fn wing_panels(file: &File, written: Option<bool>) -> bool {
    match written {
        Some(written) => written,
        None if file.wing().is_some() => usual::noted("output.wing_panels", false),
        None => false,
    }
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::case::{Choices, SHIPPED, parse};

    /// What a shipped case with a change is refused for; nothing where it is taken.
    fn refused(name: &str, change: &str) -> Option<String> {
        let (_, text) = SHIPPED.iter().find(|(known, _)| *known == name).unwrap();
        let choices = Choices {
            variant: None,
            overrides: vec![format!("output.{change}")],
        };
        let read = parse(name, text, Path::new("cases"), &choices);
        read.err().map(|error| error.to_string())
    }

    #[test]
    fn keys_that_nothing_reads_are_refused() {
        for (name, change, why) in [
            ("hencky-disc", "sample_interval_s=0.1", "there is no motion"),
            ("hencky-disc", "canopy_interval_s=0.1", "there is no motion"),
            ("hencky-disc", "picture_times_s=[0.0]", "there is no motion"),
            (
                "hencky-disc",
                "animation_interval_s=0.1",
                "there is no motion",
            ),
            ("sphere", "canopy_interval_s=0.5", "there is no structure"),
            (
                "sphere",
                "picture_fabric=[\"stress\"]",
                "there is no fabric",
            ),
            (
                "hanging-chain",
                "picture_fabric=[\"tension\"]",
                "there is no fabric",
            ),
            (
                "hanging-sheet",
                "bodies_interval_s=0.1",
                "there is no rigid body",
            ),
            ("hanging-sheet", "flow_interval_s=0.1", "there is no air"),
            (
                "hanging-sheet",
                "picture_flow=[\"speed\"]",
                "there is no air",
            ),
            ("hanging-sheet", "picture_arrows=true", "there is no air"),
            ("hanging-sheet", "history_plots=true", "there is no air"),
            (
                "taylor-green",
                "history_plots=true",
                "nothing stands in the air",
            ),
            ("hanging-sheet", "wing_panels=true", "there is no wing"),
        ] {
            let told = refused(name, change).unwrap_or_default();
            let key = change.split('=').next().unwrap();
            let expected = format!("output.{key} has no effect: {why}");
            assert!(told.contains(&expected), "{name}, {change}: {told}");
        }
    }

    #[test]
    fn keys_that_are_read_are_taken() {
        for (name, change) in [
            ("hencky-disc", "picture_fabric=[\"stress\"]"),
            ("hanging-sheet", "animation_interval_s=0.1"),
            ("hanging-sheet", "canopy_interval_s=0.1"),
            ("sphere", "bodies_interval_s=0.5"),
            ("sphere", "flow_interval_s=0.5"),
            ("sphere", "picture_arrows=true"),
            ("sphere", "history_plots=true"),
            ("taylor-green", "picture_flow=[\"vorticity\"]"),
            ("wing-school", "wing_panels=true"),
        ] {
            assert_eq!(refused(name, change), None, "{name}, {change}");
        }
    }
}
