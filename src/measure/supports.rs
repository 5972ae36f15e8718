//! Supports that are moved: columns of the history, and results.

use crate::case::Scene;
use crate::measure::Record;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// Behind the name of a support: how far its middle is displaced, and the force with which it holds the structure; with their units.
const COLUMNS: [(&str, &str); 6] = [
    ("displacement_x_m", "m"),
    ("displacement_y_m", "m"),
    ("displacement_z_m", "m"),
    ("force_x_n", "N"),
    ("force_y_n", "N"),
    ("force_z_n", "N"),
];

/// Names of the columns.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = String> {
    scene
        .supports
        .iter()
        .flat_map(|support| COLUMNS.map(|(name, _)| format!("{}_{name}", support.name)))
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation) -> Vec<f64> {
    if simulation.scene().supports.is_empty() {
        return Vec::new();
    }
    let frame = simulation.structure_frame();
    let reactions_n = frame.structure.map_or(Vec::new(), |s| s.reactions_n);
    simulation
        .support_loads(&reactions_n)
        .flat_map(|(displacement_m, force_n)| [displacement_m.to_array(), force_n.to_array()])
        .flatten()
        .collect()
}

/// Where supports are at the end, and how they pull.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    for support in &scene.supports {
        for (name, unit) in COLUMNS {
            let name = format!("{}_{name}", support.name);
            let value = record.latest(&name).unwrap_or(f64::NAN);
            let quantity = Quantity::new(value, unit).with_note("at the end");
            results.insert(&name, quantity);
        }
    }
}
