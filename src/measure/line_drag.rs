//! Drag of suspension lines.

use super::read_out::Reduction::Mean;
use super::read_out::{When, columns};
use super::record::Record;
use super::reduce::second_half;
use super::shared::TIME;
use super::statistics::average;
use crate::case::Scene;
use crate::output::{Quantity, Results};

static HAS_DRAG: When<Scene> = When {
    words: "",
    holds: |scene| {
        let body = scene.body.as_ref();
        body.is_some_and(|body| body.structure.has_line_drag())
    },
};

columns! {
    /// The one column; its sample is the force along the wind [N].
    COLUMNS of f64, in Scene: "Lines with drag";
    LINE_DRAG: "line_drag_n", "N", "drag of lines along the wind; not given to the air" => |drag_n| *drag_n, reduced Mean, when HAS_DRAG;
}

/// Its mean over the second half of the run.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    for column in COLUMNS.reduced(scene, Mean) {
        let values = record.column(column);
        let Some(first) = second_half(&record.column(&TIME)) else {
            return;
        };
        let half = &values[first..];
        let note = "along the wind, second half of the run; not given to the air";
        results.insert(column, Quantity::new(average(half)).with_note(note));
    }
}
