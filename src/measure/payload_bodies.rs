//! What hangs below a payload: columns of the history, and results.

use glam::DVec3;

use super::read_out::Reduction::LargestAs;
use super::read_out::{ReadOut, columns};
use super::record::Record;
use super::reduce::{column_max, released};
use super::shared::TIME;
use crate::case::Scene;
use crate::case::scene::PayloadBody;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// A tether at a sample.
pub(super) struct Tether {
    tension_n: f64,
    /// From its upper to its lower end [m].
    way_m: DVec3,
}

columns! {
    /// Of every body below a payload.
    COLUMNS of Tether, in Scene: "Bodies below a payload";
    TETHER_TENSION: "{body}_tether_tension_n", "N", "tension of the body's tether"
        => |now| now.tension_n, reduced LargestAs("{body}_tether_tension_max_n");
    TETHER_SWING: "{body}_tether_swing_deg", "deg", "angle of the tether from straight down"
        => |now| now.way_m.angle_between(DVec3::NEG_X).to_degrees(), reduced LargestAs("{body}_tether_swing_max_deg");
}

fn bodies(scene: &Scene) -> &[PayloadBody] {
    scene.descent.as_ref().map_or(&[], |d| &d.bodies)
}

/// The columns of a scene.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = ReadOut> {
    bodies(scene)
        .iter()
        .flat_map(|body| COLUMNS.read_outs_of(scene, &body.name))
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation) -> Vec<f64> {
    let scene = simulation.scene();
    let Some(cloth) = simulation.cloth() else {
        return Vec::new();
    };
    let tether = |body: &PayloadBody| {
        let cable = &cloth.structure.cables[body.tether];
        let [above, below] = cable.nodes.map(|node| cloth.positions_m[node as usize]);
        Tether {
            tension_n: cloth.cable_tension_n(body.tether),
            way_m: below - above,
        }
    };
    let tethers: Vec<Tether> = bodies(scene).iter().map(tether).collect();
    tethers
        .iter()
        .flat_map(|tether| COLUMNS.values(scene, Some(tether)))
        .collect()
}

/// Largest of both from release on.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    let released = released(&record.column(&TIME));
    for body in bodies(scene) {
        for row in COLUMNS.of(scene) {
            let LargestAs(name) = row.reduced else {
                continue;
            };
            let (time, value) = column_max(record, &row.read_out.of(&body.name), released);
            results.insert(
                &row.read_out.named(name).of(&body.name),
                if value.is_finite() {
                    Quantity::new(value).with_note(&format!("at {time:.4} s"))
                } else {
                    Quantity::missing("the run ended before two samples")
                },
            );
        }
    }
}
