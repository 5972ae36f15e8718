//! Triangle meshes from Wavefront OBJ files (read by the `tobj` crate).

use std::path::Path;

use glam::DVec3;

/// Nodes and triangles of a mesh file.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Node positions, in the file's unit times the scale given [m].
    pub positions_m: Vec<DVec3>,
    /// Node indices of every triangle; polygons are split into fans.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads all objects of an OBJ file as one mesh; the error says what is wrong with the file.
pub fn read(path: &Path, scale: f64) -> Result<Mesh, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ..Default::default()
    };
    let mut file =
        std::io::BufReader::new(std::fs::File::open(path).map_err(|error| error.to_string())?);
    // Materials do not matter here, so a missing material library is no error.
    let (models, _) = tobj::load_obj_buf(&mut file, &options, |_| Ok(Default::default()))
        .map_err(|error| format!("not a readable OBJ file: {error}"))?;
    let mut mesh = Mesh {
        positions_m: Vec::new(),
        triangles: Vec::new(),
    };
    for model in models {
        let first = mesh.positions_m.len() as u32;
        mesh.positions_m.extend(
            model
                .mesh
                .positions
                .chunks_exact(3)
                .map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()) * scale),
        );
        mesh.triangles.extend(
            model
                .mesh
                .indices
                .chunks_exact(3)
                .map(|t| [first + t[0], first + t[1], first + t[2]]),
        );
    }
    if mesh.triangles.is_empty() {
        return Err("the file holds no triangles".to_owned());
    }
    Ok(mesh)
}
