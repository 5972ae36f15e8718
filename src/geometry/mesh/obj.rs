//! Triangle meshes from Wavefront OBJ files.
//!
//! Only `v` and `f` lines matter. They are read here, not by a library, because case files name nodes by their number in the
//! file: common readers renumber vertices, split those shared between objects, and round to single precision.

use std::path::Path;

use glam::DVec3;

/// Nodes and triangles of a mesh file.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Node positions in the file's order, in its unit times the scale given [m].
    pub positions_m: Vec<DVec3>,
    /// Node indices of every triangle, from 0; polygons are split into fans.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads all objects of an OBJ file as one mesh; the error says what is wrong with the file.
pub fn read(path: &Path, scale: f64) -> Result<Mesh, String> {
    parse(
        &std::fs::read_to_string(path).map_err(|error| error.to_string())?,
        scale,
    )
}

/// Reads the text of an OBJ file.
pub fn parse(text: &str, scale: f64) -> Result<Mesh, String> {
    let mut mesh = Mesh {
        positions_m: Vec::new(),
        triangles: Vec::new(),
    };
    for (number, line) in text.lines().enumerate() {
        let wrong = |what: &str| format!("line {}: {what}: `{}`", number + 1, line.trim());
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let coordinates: Vec<f64> =
                    words.take(3).filter_map(|word| word.parse().ok()).collect();
                let &[x, y, z] = coordinates.as_slice() else {
                    return Err(wrong("a vertex needs three numbers"));
                };
                let position = DVec3::new(x, y, z) * scale;
                if !position.is_finite() {
                    return Err(wrong("a vertex is not finite"));
                }
                mesh.positions_m.push(position);
            }
            Some("f") => {
                let corners: Option<Vec<u32>> = words
                    .map(|word| corner(word, mesh.positions_m.len()))
                    .collect();
                let corners = corners
                    .ok_or_else(|| wrong("a face names a vertex that is not defined before it"))?;
                if corners.len() < 3 {
                    return Err(wrong("a face needs three vertices"));
                }
                for k in 1..corners.len() - 1 {
                    mesh.triangles
                        .push([corners[0], corners[k], corners[k + 1]]);
                }
            }
            _ => {}
        }
    }
    if mesh.triangles.is_empty() {
        return Err("the file holds no faces".to_owned());
    }
    let mut used = vec![false; mesh.positions_m.len()];
    for &node in mesh.triangles.iter().flatten() {
        used[node as usize] = true;
    }
    match used.iter().position(|used| !used) {
        Some(node) => Err(format!(
            "vertex {} belongs to no face and would have no mass",
            node + 1
        )),
        None => Ok(mesh),
    }
}

/// Index of a corner such as `7`, `7/1/2` or `-1` (counted from the end).
fn corner(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 {
        count as i64 + number
    } else {
        number - 1
    };
    (0..count as i64).contains(&index).then_some(index as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertices keep the file's numbers and precision across objects, whatever the order of faces.
    #[test]
    fn numbers_are_those_of_the_file() {
        let text = "o first\nv 0 0 0.1\nv 1 0 0.9\nv 1 1 0\nv 0 1 0\nf 4/1/1 3//2 2 1\no second\nv 2 0 0\nf 3 -1 2\n";
        let mesh = parse(text, 2.0).unwrap();
        assert_eq!(mesh.positions_m.len(), 5);
        assert_eq!(mesh.positions_m[1], DVec3::new(2.0, 0.0, 1.8));
        assert_eq!(mesh.triangles, [[3, 2, 1], [3, 1, 0], [2, 4, 1]]);
    }

    #[test]
    fn faults_name_their_line() {
        for (text, part) in [
            ("v 0 0\n", "line 1"),
            ("v 0 0 0\nf 1 2 3\n", "line 2"),
            ("v 0 0 nan\n", "not finite"),
            ("v 0 0 0\nv 1 0 0\nf 1 2\n", "three vertices"),
            ("v 0 0 0\n", "no faces"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n", "vertex 4"),
        ] {
            let error = parse(text, 1.0).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
