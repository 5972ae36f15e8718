//! Lines of a mesh: `structure.mesh.lines` and `structure.mesh.line_material`.

use std::path::Path;

use glam::{DQuat, DVec3};

use super::cable_material::check_material;
use super::file::MeshFile;
use super::problem::Problem;
use super::values::absent;
use crate::cloth::Structure;
use crate::frame::CableKind;
use crate::geometry::line_table;

/// Distance from a node, over the size of the mesh, at which a line counts as attached to it.
const NEAR: f64 = 1e-3;

/// Adds the lines that the table names, if there is one; their ends are held. The table is turned about its origin, which is then
/// moved.
pub(super) fn add(
    written: &MeshFile,
    folder: &Path,
    (rotation, position_m): (DQuat, DVec3),
    structure: &mut Structure,
) -> Result<(), Problem> {
    const KEY: &str = "structure.mesh.lines";
    const MATERIAL: &str = "structure.mesh.line_material";
    let (file, material) = match (&written.lines, &written.line_material) {
        (None, None) => return Ok(()),
        (Some(file), Some(material)) => (file, check_material(MATERIAL, material)?),
        (Some(_), None) => return Err(absent(MATERIAL, "lines are made of something")),
        (None, Some(_)) => return Err(absent(KEY, "line_material refers to it")),
    };
    let path = folder.join(file);
    let unreadable = |why: String| {
        Problem::new(
            KEY,
            format!("cannot read the table of lines {}: {why}", path.display()),
            "give comma-separated text with the columns x_m, y_m, z_m, end_x_m, end_y_m, end_z_m, length_m (docs/canopies.md)",
        )
    };
    let text = std::fs::read_to_string(&path).map_err(|error| unreadable(error.to_string()))?;
    let lines = line_table::parse(&text).map_err(unreadable)?;
    let fabric = structure.node_count();
    let places = structure.positions_m.clone();
    let low = places.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = places.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let near_m = NEAR * (high - low).length();
    for (number, line) in lines.iter().enumerate() {
        let [attached_m, end_m] =
            [line.attached_m, line.end_m].map(|place| rotation * place + position_m);
        let nearest = places
            .iter()
            .map(|place| place.distance(attached_m))
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((node, _)) = nearest.filter(|(_, distance)| *distance <= near_m) else {
            let apart = nearest.map_or(f64::NAN, |(_, distance)| distance);
            return Err(Problem::new(
                KEY,
                format!(
                    "line {} of {} is attached at {}, {apart:.3e} m from the nearest node of the mesh",
                    number + 1,
                    path.display(),
                    line.attached_m
                ),
                format!(
                    "give the place of a node at the start, in the mesh's own coordinates after scaling, within {near_m:.1e} m"
                ),
            ));
        };
        let known = structure.positions_m[fabric..]
            .iter()
            .position(|place| place.distance(end_m) <= near_m);
        let end = known.map_or_else(
            || {
                let end = structure.add_node(end_m) as usize;
                structure.held[end] = true;
                end
            },
            |known| fabric + known,
        );
        let kind = CableKind::SuspensionLine;
        structure.add_cable(
            &[node as u32, end as u32],
            &[line.length_m],
            &material,
            kind,
        );
    }
    Ok(())
}
