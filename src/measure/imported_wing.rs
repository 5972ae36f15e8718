//! What is read of a wing from a file: loads of its rows, and what its lines hold.

use std::collections::BTreeMap;

use glam::DVec3;

use super::read_out::results;
use super::wing::ROW_LOAD;
use crate::case::scene::ImportedWing;
use crate::frame::StructureFrame;
use crate::output::{Quantity, Results};

results! {
    /// Besides the loads of its rows.
    RESULTS: "Wings from files";
    HELD_FORCE: "held_force_n", "N", "force on the held lines; sum of the forces that hold the lines";
    VOLUME: "volume_m3", "m3", "volume; inside skin and intakes as drawn";
    MOVED_MAX: "moved_to_node_max_m", "m", "farthest that the end of a line or strap was moved to a node of the wing";
}

/// Adds the results.
pub(super) fn results(results: &mut Results, wing: &ImportedWing, structure: &StructureFrame) {
    // Lines that are held carry their row.
    let mut rows: BTreeMap<&str, f64> = BTreeMap::new();
    let lines = structure.cables.iter().zip(&structure.cable_tensions_n);
    for ((nodes, tension), row) in lines.zip(&wing.rows) {
        let load = rows.entry(row).or_default();
        if nodes.iter().any(|node| wing.held.contains(node)) {
            *load += tension;
        }
    }
    for (row, load) in rows {
        results.insert(
            &ROW_LOAD.of(row),
            Quantity::new(load).with_note("tension of its lines that are held, both halves"),
        );
    }
    let held: DVec3 = structure.reactions_n.iter().sum();
    results.tell(&HELD_FORCE, held.length());
    results.tell(&VOLUME, wing.volume_m3);
    results.tell(&MOVED_MAX, wing.moved_max_m);
}
