//! Checks of `[structure.lep_sim]`: a wing that LEparagliding Studio has drawn, under one pressure inside.

use super::body::{Body, BodyKind, ImportedWing};
use super::cable_material::check_material;
use super::fabric::check_fabric;
use super::file::{self, File};
use super::mesh_examination::{ExaminedMesh, FromFiles};
use super::problem::Problem;
use super::values::absent;
use crate::geometry::mesh::lep_sim;

const KEY: &str = "structure.lep_sim";

pub(super) fn check(
    file: &File,
    written: &file::LepSim,
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
    let inside = |is_skin: &bool| if *is_skin { pressure_pa } else { 0.0 };
    files
        .meshes
        .push(ExaminedMesh::of_wing(KEY, &path, &structure));
    let kind = BodyKind::ImportedWing(ImportedWing {
        rows: imported.rows,
        held: imported.held,
        inside_pa: imported.is_skin.iter().map(inside).collect(),
        volume_m3: imported.volume_m3,
        moved_max_m: imported.moved_max_m,
    });
    Ok(Body::at_rest(structure, kind))
}
