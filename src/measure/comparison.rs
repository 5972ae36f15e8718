//! Results beside the values of others that a case names.

use super::record::Record;
use super::results::of_scene;
use crate::case::Scene;
use crate::case::scene::BodyKind;
use crate::cloth::Structure;
use crate::frame::{FabricState, StructureFrame};
use crate::output::{ComparisonRow, LatticeError, Quantity, ReadOut, Results};
use crate::statics::Statics;

/// Names of all results that a run of the scene will have.
#[must_use]
pub fn result_names(scene: &Scene) -> Vec<String> {
    let record = Record::at_rest(scene);
    let structure = scene.body.as_ref().map(|body| at_rest(&body.structure));
    let results = of_scene(scene, structure.as_ref(), &record, &Statics::default());
    results.iter().map(|(name, _)| name.to_owned()).collect()
}

/// Columns that the history of a run of the scene will have.
#[must_use]
pub fn history_columns(scene: &Scene) -> Vec<ReadOut> {
    Record::of(scene).columns().to_vec()
}

/// A structure that carries nothing.
fn at_rest(structure: &Structure) -> StructureFrame {
    let (nodes, triangles, cables) = (
        structure.node_count(),
        structure.triangles.len(),
        structure.cables.len(),
    );
    StructureFrame {
        positions_m: structure.positions_m.clone(),
        velocities_m_s: vec![glam::DVec3::ZERO; nodes],
        reactions_n: vec![glam::DVec3::ZERO; nodes],
        contact_forces_n: None,
        triangles: structure.triangles.iter().map(|t| t.nodes).collect(),
        principal_tensions_n_m: vec![[0.0; 2]; triangles],
        tension_directions: vec![glam::DVec3::ZERO; triangles],
        stress_pa: vec![0.0; triangles],
        true_stress_pa: vec![0.0; triangles],
        von_mises_pa: vec![0.0; triangles],
        shear_stress_pa: vec![0.0; triangles],
        shear_strain: vec![0.0; triangles],
        principal_strains: vec![[0.0; 2]; triangles],
        yield_stress_pa: structure.yield_stress_pa,
        rest_areas_m2: structure.triangles.iter().map(|t| t.rest_area_m2).collect(),
        states: vec![FabricState::Slack; triangles],
        cables: structure.cables.iter().map(|c| c.nodes).collect(),
        cable_kinds: structure.cables.iter().map(|c| c.kind).collect(),
        cable_tensions_n: vec![0.0; cables],
    }
}

/// Rows of the comparison, in the order of the results.
#[must_use]
pub fn comparison(scene: &Scene, results: &Results) -> Vec<ComparisonRow> {
    let lattice = lattice_error(scene);
    let row = |(name, quantity): (&str, &Quantity)| {
        let own = scene.comparisons.iter().filter(|c| c.quantity == name);
        own.map(|entry| {
            let mut row = ComparisonRow::new(name, quantity, entry.range, &entry.source, &lattice);
            row.note.clone_from(&entry.note);
            row
        })
        .collect::<Vec<_>>()
    };
    results.iter().flat_map(row).collect()
}

/// What a single run knows of the error of its lattice: nothing, if it has one.
fn lattice_error(scene: &Scene) -> LatticeError {
    let Some(air) = &scene.air else {
        return LatticeError::None;
    };
    let kind = scene.body.as_ref().map(|body| &body.kind);
    let (cells_per_diameter, key) = match kind {
        Some(BodyKind::Canopy(canopy)) => (
            Some(canopy.nominal_diameter_m / air.units.cell_size_m),
            "cells_per_diameter",
        ),
        Some(BodyKind::Wing(_)) => (None, "cells_per_chord"),
        _ => (None, "cell_size_m"),
    };
    LatticeError::OneLattice {
        cells_per_diameter,
        key: format!("resolution.{key}"),
    }
}
