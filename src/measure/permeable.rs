//! What passes permeable surfaces.

use super::read_out::Reduction::Mean;
use super::read_out::{When, columns};
use super::record::Record;
use super::reduce::second_half;
use super::shared::TIME;
use super::statistics::average;
use crate::case::Scene;
use crate::output::{Quantity, Results};

static PERMEABLE: When<Scene> = When {
    words: "",
    holds: |scene| {
        let fabric = scene.body.as_ref().map(|body| &body.structure);
        let permeable = fabric.is_some_and(|fabric| fabric.permeability.is_some())
            || scene.rigid_bodies.iter().any(|b| b.permeability.is_some());
        permeable && scene.air.is_some()
    },
};

columns! {
    /// Means over the permeable area.
    COLUMNS of [f64; 2], in Scene: "Permeable surfaces in air";
    THROUGH: "through_velocity_m_s", "m/s", "velocity of the air through the surface; along the normals of the triangles"
        => |now| now[0], reduced Mean, when PERMEABLE;
    THROUGH_OF_SLIP: "through_velocity_of_slip_m_s", "m/s", "the part of it that residual slip adds; what residual slip adds: the permeability of the method itself"
        => |now| now[1], reduced Mean, when PERMEABLE;
}

/// Means over the second half of the run.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    let Some(first) = second_half(&record.column(&TIME)) else {
        return;
    };
    for column in COLUMNS.reduced(scene, Mean) {
        let values = record.column(column);
        let what = column.detail().unwrap_or_default();
        let note = format!("mean over the permeable area, second half of the run; {what}");
        results.insert(
            column,
            Quantity::new(average(&values[first..])).with_note(&note),
        );
    }
}
