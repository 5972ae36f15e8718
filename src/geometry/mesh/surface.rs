//! Surfaces of rigid bodies from OBJ, STL and PLY files.
//!
//! STL names no nodes and exporters split them along seams, so nodes at the same place are joined; OBJ is read by [`super::obj`], STL by
//! the crate `stl_io`, PLY by `ply-rs-bw`.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};

use super::{obj, stl};
use crate::rigid::Surface;

/// Distance within which nodes are one, relative to the size of the mesh.
const SAME_PLACE: f64 = 1e-7;

/// Reads the surface in a file, by its extension, in the file's unit times `scale` [m]; the error says what is wrong with the file. Triangles
/// may be without area ([`without_area`]).
pub fn read(path: &Path, scale: f64) -> Result<Surface, String> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default();
    let surface = match extension.as_str() {
        "obj" => {
            let mesh = obj::read(path, scale)?;
            Surface {
                positions_m: mesh.positions_m,
                triangles: mesh.triangles,
            }
        }
        "stl" => stl::read(path, scale)?,
        "ply" => read_ply(path, scale)?,
        _ => return Err("its name does not end in .obj, .stl or .ply".to_owned()),
    };
    if surface.triangles.is_empty() {
        return Err("the file holds no triangles".to_owned());
    }
    let mut places = surface.positions_m.iter();
    if let Some(node) = places.position(|place| !obj::is_place(*place)) {
        return Err(format!("node {} is not finite, or beyond 1e30 m", node + 1));
    }
    Ok(joined(&surface))
}

/// Number of the first triangle that encloses no area, from 0.
#[must_use]
pub fn without_area(surface: &Surface) -> Option<usize> {
    let mut areas = surface.area_vectors_m2();
    areas.position(|area| area.length() == 0.0)
}

fn open(path: &Path) -> Result<BufReader<File>, String> {
    File::open(path)
        .map(BufReader::new)
        .map_err(|error| error.to_string())
}

fn read_ply(path: &Path, scale: f64) -> Result<Surface, String> {
    let ply = Parser::<DefaultElement>::new()
        .read_ply(&mut open(path)?)
        .map_err(|error| error.to_string())?;
    let mut surface = Surface::default();
    let vertices = ply
        .payload
        .get("vertex")
        .ok_or("it has no element `vertex`")?;
    for (number, vertex) in vertices.iter().enumerate() {
        let coordinate = |name: &str| match vertex.get(name) {
            Some(Property::Double(x)) => Ok(*x),
            other => other
                .and_then(Property::to_f32_lossy)
                .map(f64::from)
                .ok_or_else(|| format!("vertex {} has no number `{name}`", number + 1)),
        };
        let place = DVec3::new(coordinate("x")?, coordinate("y")?, coordinate("z")?);
        if !place.is_finite() {
            return Err(format!("vertex {} is not finite", number + 1));
        }
        surface.positions_m.push(place * scale);
    }
    let faces = ply.payload.get("face").ok_or("it has no element `face`")?;
    for (number, face) in faces.iter().enumerate() {
        let corners = ["vertex_indices", "vertex_index"]
            .iter()
            .find_map(|name| face.get(*name))
            .and_then(Property::to_u32_list)
            .ok_or_else(|| format!("face {} has no list `vertex_indices`", number + 1))?;
        let known = corners
            .iter()
            .all(|&node| (node as usize) < surface.positions_m.len());
        if corners.len() < 3 || !known {
            return Err(format!(
                "face {} does not name three or more existing vertices",
                number + 1
            ));
        }
        obj::cover(&surface.positions_m, &corners, &mut surface.triangles)
            .ok_or_else(|| format!("face {} crosses itself", number + 1))?;
    }
    Ok(surface)
}

/// The surface with nodes at the same place joined, and unused ones left out.
fn joined(surface: &Surface) -> Surface {
    let (low, high) = surface.bounds_m();
    let unit = SAME_PLACE * (high - low).max_element().max(f64::MIN_POSITIVE);
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut result = Surface::default();
    for &nodes in &surface.triangles {
        let nodes = nodes.map(|node| {
            let place = surface.positions_m[node as usize];
            let key = ((place - low) / unit).round().to_array().map(|x| x as i64);
            *numbers.entry(key).or_insert_with(|| {
                result.positions_m.push(place);
                result.positions_m.len() as u32 - 1
            })
        });
        result.triangles.push(nodes);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    /// The same tetrahedron in every format, with nodes split along its seams where the format allows.
    #[test]
    fn all_formats_agree() {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let folder = tempfile::tempdir().unwrap();
        let (mut obj, mut stl) = (String::new(), "solid body\n".to_owned());
        let mut ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
                       element face 4\nproperty list uchar int vertex_indices\nend_header\n"
            .to_owned();
        for [x, y, z] in corners {
            writeln!(ply, "{x} {y} {z}").unwrap();
        }
        for (number, face) in faces.iter().enumerate() {
            writeln!(ply, "3 {} {} {}", face[0], face[1], face[2]).unwrap();
            stl += "facet normal 0 0 0\nouter loop\n";
            for &corner in face {
                let [x, y, z] = corners[corner];
                writeln!(obj, "v {x} {y} {z}").unwrap();
                writeln!(stl, "vertex {x} {y} {z}").unwrap();
            }
            stl += "endloop\nendfacet\n";
            let first = 3 * number + 1;
            writeln!(obj, "f {} {} {}", first, first + 1, first + 2).unwrap();
        }
        stl += "endsolid body\n";
        for (name, text) in [("t.obj", obj), ("t.STL", stl), ("t.ply", ply)] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            let surface = read(&path, 2.0).unwrap();
            assert_eq!(surface.positions_m.len(), 4, "{name}");
            assert!(surface.is_closed(), "{name}");
            assert!((surface.volume_m3().0 - 8.0 / 6.0).abs() < 1e-12, "{name}");
        }
        let error = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            read(&path, 1.0).unwrap_err()
        };
        assert!(error("a.vtk", "").contains(".obj, .stl or .ply"));
        let flat = folder.path().join("a.obj");
        std::fs::write(&flat, "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
        assert_eq!(without_area(&read(&flat, 1.0).unwrap()), Some(0));
        assert!(!error("a.ply", "ply\nformat ascii 1.0\nelement vertex").is_empty());
        assert!(!error("a.stl", "solid a\nfacet normal 0 0").is_empty());
    }
}
