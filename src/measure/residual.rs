//! How much of the load the residual stiffness of fabric carries that is meant to carry tension only.

use super::Record;
use super::read_out::{self, ReadOut};
use crate::case::Scene;
use crate::output::{AccountRow, Quantity, Results};
use crate::simulation::Simulation;

/// Share of the load that the residual stiffness may carry.
const LIMIT: f64 = 0.01;

/// The one row.
const SHARE: [ReadOut<Simulation>; 1] = [ReadOut {
    name: "residual_stiffness_load_share",
    unit: "1",
    meaning: "forces of the stiffness that slack and wrinkled fabric keeps, summed over the nodes, over those of all elements",
    when: |scene| {
        let body = scene.body.as_ref();
        body.is_some_and(|body| body.structure.is_tension_only())
    },
    how: |simulation| {
        let cloth = simulation.cloth();
        cloth
            .and_then(|cloth| cloth.residual_load_share())
            .unwrap_or(f64::NAN)
    },
}];

/// Names of the columns.
pub(super) fn columns(scene: &Scene) -> Vec<String> {
    read_out::columns(&SHARE, scene)
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation) -> impl Iterator<Item = f64> {
    read_out::of_scene(&SHARE, simulation.scene()).map(|row| (row.how)(simulation))
}

/// The last sample of an equilibrium, else the mean over the second half of the run.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    for row in read_out::of_scene(&SHARE, scene) {
        let column = record.column(row.name);
        let first = if scene.equilibrium.is_some() {
            column.len().saturating_sub(1)
        } else {
            column.len() / 2
        };
        let shares: Vec<f64> = column.into_iter().skip(first).collect();
        let known: Vec<f64> = shares.into_iter().filter(|share| !share.is_nan()).collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        results.insert(
            row.name,
            if known.is_empty() {
                Quantity::missing(row.unit, "nothing pulls at the fabric")
            } else {
                Quantity::new(mean, row.unit).with_note(&format!(
                    "{}; {}",
                    row.meaning,
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
pub(super) fn account(results: &Results) -> Option<AccountRow> {
    let share = results.get(SHARE[0].name)?.value?;
    let row = AccountRow::at_most(
        "residual stiffness",
        "share of the load that it carries",
        "1",
        share,
        LIMIT,
    );
    Some(row.with_detail(if share > LIMIT {
        "fabric carries what it should not: lower residual_stiffness".to_owned()
    } else {
        String::new()
    }))
}
