//! Pictures of what is found in the meshes of a case, for `ripstop check --pictures`.

use std::path::{Path, PathBuf};

use super::RunError;
use crate::case::ExaminedMesh;
use crate::output::{prepare_directory, write_atomically};
use crate::render::{MarkedMesh, marked_mesh_png_bytes};

/// Colour of findings, and of open borders, which are none.
const FINDING: [u8; 3] = [196, 30, 36];
const BORDER: [u8; 3] = [20, 92, 180];

/// Draws each finding, and the open borders, of every mesh into a folder; returns the files.
///
/// # Errors
///
/// [`RunError`] where a picture cannot be drawn or written.
pub fn draw_findings(meshes: &[ExaminedMesh], folder: &Path) -> Result<Vec<PathBuf>, RunError> {
    prepare_directory(folder)?;
    let mut written = Vec::new();
    for mesh in meshes {
        let examination = &mesh.examination;
        let mut draw = |name: &str, picture: &MarkedMesh| -> Result<(), RunError> {
            let stem = format!("{}-{name}", mesh.key).replace(['.', '_'], "-");
            let path = folder.join(stem + ".png");
            let bytes = marked_mesh_png_bytes(picture)?;
            write_atomically(&path, |out| out.write_all(&bytes))?;
            written.push(path);
            Ok(())
        };
        let edges: Vec<[u32; 2]> = examination
            .borders
            .iter()
            .flat_map(|border| border.nodes.windows(2).map(|pair| [pair[0], pair[1]]))
            .collect();
        let plain = MarkedMesh {
            positions_m: &mesh.surface.positions_m,
            triangles: &mesh.surface.triangles,
            nodes: &[],
            edges: &edges,
            marked: &[],
            colour: BORDER,
            title: &format!("{}: open borders", mesh.file),
            caption: &format!(
                "{} open borders, {} pieces, {} triangles.",
                examination.borders.len(),
                examination.pieces.len(),
                examination.triangle_count
            ),
        };
        draw("open_borders", &plain)?;
        for finding in &examination.findings {
            let picture = MarkedMesh {
                positions_m: if finding.is_at_start {
                    &mesh.start_m
                } else {
                    &mesh.surface.positions_m
                },
                nodes: &finding.marks.nodes,
                edges: &finding.marks.edges,
                marked: &finding.marks.triangles,
                colour: FINDING,
                title: &format!("{}: {}", mesh.file, finding.kind.name()),
                caption: &finding.what,
                ..plain.clone()
            };
            draw(finding.kind.name(), &picture)?;
        }
    }
    Ok(written)
}
