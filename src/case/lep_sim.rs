//! Checks of `[structure.lep_sim]`: a wing that LEparagliding Studio has drawn, under one pressure inside.

use super::Problem;
use super::file::{self, File};
use super::mesh_examination::{ExaminedMesh, FromFiles};
use super::scene::{Body, BodyKind, absent};
use super::structure::{check_fabric, check_material};
use crate::geometry::mesh::{lep_sim, quality};

const KEY: &str = "structure.lep_sim";

/// What is known of an imported wing beside its structure.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedWing {
    /// Row of every line, `[cable_count]`.
    pub rows: Vec<String>,
    /// Nodes where lines are held.
    pub held: Vec<u32>,
    /// Pressure inside, on the skin alone \[Pa\], `[triangle_count]`.
    pub inside_pa: Vec<f64>,
    /// Volume as drawn [m³].
    pub volume_m3: f64,
    /// Farthest that the end of a line or strap was moved to a node [m].
    pub moved_max_m: f64,
}

pub(super) fn check(
    file: &File,
    written: &file::LepSimTable,
    files: &mut FromFiles,
) -> Result<Body, Problem> {
    let key = |name: &str| format!("{KEY}.{name}");
    let fabric = check_fabric(file)?;
    let material = check_material(&key("line_material"), &written.line_material)?;
    let pressure_pa = file.equilibrium.as_ref().and_then(|e| e.pressure_pa);
    let Some(pressure_pa) = pressure_pa else {
        return Err(absent(
            "equilibrium.pressure_pa",
            "the wing is blown up by the same pressure in all cells, which acts on its skin alone",
        ));
    };
    if file.air.is_some() || file.time.is_some() {
        return Err(Problem::new(
            KEY,
            "an imported wing has a static equilibrium only: its intakes and ribs are not made for moving air",
            "remove [air] and [time]",
        ));
    }
    let path = files.folder.join(&written.file);
    let refused = |why: String| {
        Problem::new(
            key("file"),
            format!("cannot read the wing {}: {why}", path.display()),
            "give the lep-sim.json (version 1) that LEparagliding Studio writes beside its drawings, relative to the case file",
        )
    };
    let text = std::fs::read_to_string(&path).map_err(|error| refused(error.to_string()))?;
    let imported = lep_sim::read(&text, &fabric, &material).map_err(refused)?;
    let structure = imported.structure;
    let triangles: Vec<[u32; 3]> = structure.triangles.iter().map(|t| t.nodes).collect();
    let inside = |is_skin: &bool| if *is_skin { pressure_pa } else { 0.0 };
    files
        .meshes
        .push(ExaminedMesh::of_wing(KEY, &path, &structure));
    files.imported = Some(ImportedWing {
        rows: imported.rows,
        held: imported.held,
        inside_pa: imported.is_skin.iter().map(inside).collect(),
        volume_m3: imported.volume_m3,
        moved_max_m: imported.moved_max_m,
    });
    Ok(Body {
        quality: quality::measure(&structure.positions_m, &triangles),
        kind: BodyKind::ImportedWing,
        structure,
    })
}
