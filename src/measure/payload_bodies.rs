//! What hangs below a payload: columns of the history, and results.

use glam::DVec3;

use super::results::column_max;
use crate::case::Scene;
use crate::case::scene::PayloadBody;
use crate::measure::Record;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// Behind the name of a body: tension of its tether, and the angle of the tether from straight down; the results of their largest values, and units.
const COLUMNS: [[&str; 3]; 2] = [
    ["tether_tension_n", "tether_tension_max_n", "N"],
    ["tether_swing_deg", "tether_swing_max_deg", "deg"],
];

fn bodies(scene: &Scene) -> &[PayloadBody] {
    scene.descent.as_ref().map_or(&[], |d| &d.bodies)
}

/// Names of the columns.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = String> {
    let bodies = bodies(scene).iter();
    bodies.flat_map(|body| COLUMNS.map(|[name, ..]| format!("{}_{name}", body.name)))
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation) -> Vec<f64> {
    let Some(cloth) = simulation.cloth() else {
        return Vec::new();
    };
    let bodies = bodies(simulation.scene()).iter();
    let values = bodies.flat_map(|body| {
        let cable = &cloth.structure.cables[body.tether];
        let [above, below] = cable.nodes.map(|node| cloth.positions_m[node as usize]);
        let way = below - above;
        [
            cloth.cable_tension_n(body.tether),
            way.angle_between(DVec3::NEG_X).to_degrees(),
        ]
    });
    values.collect()
}

/// Largest of both from release on.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    let times = record.column("time_s");
    let released = times.iter().position(|&t| t >= 0.0).unwrap_or(0);
    for body in bodies(scene) {
        for [column, result, unit] in COLUMNS {
            let (time, value) = column_max(record, &format!("{}_{column}", body.name), released);
            results.insert(
                &format!("{}_{result}", body.name),
                if value.is_finite() {
                    Quantity::new(value, unit).with_note(&format!("at {time:.4} s"))
                } else {
                    Quantity::missing(unit, "the run ended before two samples")
                },
            );
        }
    }
}
