//! What hangs below a payload: columns of the history, and results.

use glam::DVec3;

use super::results::column_max;
use crate::case::Scene;
use crate::case::scene::PayloadBody;
use crate::measure::Record;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// Behind the name of a body: tension of its tether, and the angle of the tether from straight down; with their units.
const COLUMNS: [(&str, &str); 2] = [("tether_tension_n", "N"), ("tether_swing_deg", "deg")];

fn bodies(scene: &Scene) -> &[PayloadBody] {
    scene.descent.as_ref().map_or(&[], |d| &d.bodies)
}

/// Names of the columns.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = String> {
    let bodies = bodies(scene).iter();
    bodies.flat_map(|body| COLUMNS.map(|(name, _)| format!("{}_{name}", body.name)))
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
        let tension_n = cloth.structure.cable_state(cable, way.length()).tension_n;
        [tension_n, way.angle_between(DVec3::NEG_X).to_degrees()]
    });
    values.collect()
}

/// Largest of both from release on.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    let times = record.column("time_s");
    let released = times.iter().position(|&t| t >= 0.0).unwrap_or(0);
    for body in bodies(scene) {
        for (name, unit) in COLUMNS {
            let (time, value) = column_max(record, &format!("{}_{name}", body.name), released);
            let name = match name.rsplit_once('_') {
                Some((name, unit)) => format!("{}_{name}_max_{unit}", body.name),
                None => continue,
            };
            results.insert(
                &name,
                if value.is_finite() {
                    Quantity::new(value, unit).with_note(&format!("at {time:.4} s"))
                } else {
                    Quantity::missing(unit, "the run ended before two samples")
                },
            );
        }
    }
}
