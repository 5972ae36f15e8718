//! How much of the load the residual stiffness of fabric carries that is meant to carry tension only.

use super::read_out::Reduction::Mean;
use super::read_out::{When, columns};
use super::record::Record;
use super::reduce::second_half;
use super::shared::TIME;
use super::statistics::average;
use crate::case::Scene;
use crate::output::{AccountRow, Quantity, Results};
use crate::simulation::Simulation;

/// Share of the load that the residual stiffness may carry.
const LIMIT: f64 = 0.01;

columns! {
    /// The one column.
    COLUMNS of Simulation, in Scene: "Fabric that is meant to carry tension only";
    SHARE: "residual_stiffness_load_share", "1",
        "forces of the stiffness that slack and wrinkled fabric keeps, summed over the nodes, over those of all elements"
        => |simulation| {
            let cloth = simulation.cloth();
            cloth.and_then(|cloth| cloth.residual_load_share()).unwrap_or(f64::NAN)
        }, reduced Mean, when TENSION_ONLY;
}

static TENSION_ONLY: When<Scene> = When {
    words: "of an equilibrium the last sample is the result",
    holds: |scene| {
        let body = scene.body.as_ref();
        body.is_some_and(|body| body.structure.is_tension_only())
    },
};

/// The last sample of an equilibrium, else the mean over the second half of the run.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    for read_out in COLUMNS.reduced(scene, Mean) {
        let column = record.column(read_out);
        let first = if scene.equilibrium.is_some() {
            column.len().saturating_sub(1)
        } else {
            second_half(&record.column(&TIME)).unwrap_or(column.len())
        };
        let shares: Vec<f64> = column.into_iter().skip(first).collect();
        let known: Vec<f64> = shares.into_iter().filter(|share| !share.is_nan()).collect();
        results.insert(
            read_out,
            if known.is_empty() {
                Quantity::missing("nothing pulls at the fabric")
            } else {
                Quantity::new(average(&known)).with_note(&format!(
                    "{}; {}",
                    read_out.meaning,
                    if scene.equilibrium.is_some() {
                        "at the end"
                    } else {
                        "second half of the run"
                    }
                ))
            },
        );
    }
}

/// Whether that is as little as it should be.
pub(super) fn account(results: &Results, scene: &Scene) -> Option<AccountRow> {
    let share = results.value(&SHARE)?;
    let row = AccountRow::at_most(
        "residual stiffness",
        "share of the load that it carries",
        "1",
        share,
        LIMIT,
    );
    let detail = if share <= LIMIT {
        ""
    } else if let Some(wing) = scene.wing() {
        if wing.plan.rods.is_empty() {
            "it holds noses and tips open in place of the rods and wires of real wings, which this one lacks (structure.wing.rods): with less they fold, \
             and with it stresses come out too small"
        } else {
            "it holds open what the rods do not: with less, tips and slack parts fold, and with it stresses come out too small"
        }
    } else {
        "fabric carries what it should not: lower residual_stiffness"
    };
    Some(row.with_detail(detail.to_owned()))
}
