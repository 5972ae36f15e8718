//! What is read of a wing from a file: loads of its rows, and what its lines hold.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::case::scene::ImportedWing;
use crate::frame::StructureFrame;
use crate::output::{Quantity, Results};

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
            &format!("row_{row}_load_n"),
            Quantity::new(load, "N").with_note("tension of its lines that are held, both halves"),
        );
    }
    let held: DVec3 = structure.reactions_n.iter().sum();
    results.insert(
        "held_force_n",
        Quantity::new(held.length(), "N").with_note("sum of the forces that hold the lines"),
    );
    results.insert(
        "volume_m3",
        Quantity::new(wing.volume_m3, "m3").with_note("inside skin and intakes as drawn"),
    );
    results.insert(
        "moved_to_node_max_m",
        Quantity::new(wing.moved_max_m, "m")
            .with_note("farthest that the end of a line or strap was moved to a node of the wing"),
    );
}
