//! Triangle meshes from Wavefront OBJ files.
//!
//! Only `v` and `f` lines matter. They are read here, not by a library, because case files name nodes by their number in the
//! file: common readers renumber vertices, split those shared between objects, and round to single precision.

use std::borrow::Cow;
use std::path::Path;

use glam::DVec3;

use super::polygon;

/// Nodes and triangles of a mesh file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Node positions in the file's order, in its unit times the scale given [m].
    pub positions_m: Vec<DVec3>,
    /// Node indices of every triangle, from 0; polygons are covered by triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Faces as they are written: triangles of a polygon depend on its shape, too.
    pub faces: Faces,
}

/// Polygons by their corners.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Faces {
    /// Nodes of all of them, one after the other, from 0.
    corners: Vec<u32>,
    /// Where each one ends.
    ends: Vec<usize>,
}

impl Faces {
    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        let ranges = starts.zip(&self.ends);
        ranges.map(|(start, end)| &self.corners[*start..*end])
    }
}

/// Reads all objects of an OBJ file as one mesh; the error says what is wrong with the file.
pub fn read(path: &Path, scale: f64) -> Result<Mesh, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    // Names of objects and materials may be in any encoding.
    parse(&String::from_utf8_lossy(&bytes), scale)
}

/// Reads vertices and faces, but covers no face by triangles: those of another shape of the same mesh hold.
pub fn read_folded(path: &Path, scale: f64) -> Result<Mesh, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    parsed(&String::from_utf8_lossy(&bytes), scale, false)
}

/// Reads the text of an OBJ file.
pub fn parse(text: &str, scale: f64) -> Result<Mesh, String> {
    parsed(text, scale, true)
}

fn parsed(text: &str, scale: f64, covers: bool) -> Result<Mesh, String> {
    if text.contains('\0') {
        return Err("it is not plain text: write it as OBJ in ASCII or UTF-8".to_owned());
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Old programs end lines with a carriage return alone.
    let text = if text.contains('\r') {
        Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
    } else {
        Cow::Borrowed(text)
    };
    let mut mesh = Mesh::default();
    // Line of each face.
    let mut lines: Vec<usize> = Vec::new();
    let mut has_free_forms = false;
    let mut rest = text.lines().enumerate();
    while let Some((number, line)) = rest.next() {
        let mut line = Cow::Borrowed(line);
        while let Some(begun) = line.trim_end().strip_suffix('\\') {
            let next = rest.next().map_or("", |(_, next)| next);
            line = Cow::Owned(format!("{begun} {next}"));
        }
        let wrong = |what: &str| wrong(number, &line, what);
        let words = line.split_whitespace();
        let mut words = words.take_while(|word| !word.starts_with('#'));
        match words.next() {
            Some("v") => {
                let mut coordinate = || words.next().and_then(|word| word.parse().ok());
                let (Some(x), Some(y), Some(z)) = (coordinate(), coordinate(), coordinate()) else {
                    return Err(wrong("a vertex needs three numbers"));
                };
                let position = DVec3::new(x, y, z) * scale;
                if !is_place(position) {
                    return Err(wrong("a vertex is not finite, or beyond 1e30 m"));
                }
                mesh.positions_m.push(position);
            }
            Some("f" | "fo") => {
                let begin = mesh.faces.corners.len();
                for word in words {
                    let corner = corner(word, mesh.positions_m.len());
                    let corner = corner.ok_or_else(|| wrong(NO_VERTEX))?;
                    mesh.faces.corners.push(corner);
                }
                if mesh.faces.corners.len() - begin < 3 {
                    return Err(wrong("a face needs three vertices"));
                }
                mesh.faces.ends.push(mesh.faces.corners.len());
                lines.push(number);
            }
            Some("surf" | "curv" | "cstype") => has_free_forms = true,
            _ => {}
        }
    }
    if lines.is_empty() {
        return Err(if has_free_forms {
            "the file holds free-form surfaces, but no faces: export it as a mesh of polygons"
        } else {
            "the file holds no faces"
        }
        .to_owned());
    }
    let of_line = |number: usize, what: &str| {
        wrong(number, text.lines().nth(number).unwrap_or_default(), what)
    };
    let mut used = vec![false; mesh.positions_m.len()];
    for (corners, line) in mesh.faces.iter().zip(&lines) {
        for corner in corners {
            match used.get_mut(*corner as usize) {
                Some(used) => *used = true,
                None => return Err(of_line(*line, NO_VERTEX)),
            }
        }
        if covers {
            cover(&mesh.positions_m, corners, &mut mesh.triangles)
                .ok_or_else(|| of_line(*line, "a face crosses itself"))?;
        }
    }
    match used.iter().position(|used| !used) {
        Some(node) => Err(format!(
            "vertex {} belongs to no face and would have no mass",
            node + 1
        )),
        None => Ok(mesh),
    }
}

const NO_VERTEX: &str = "a face names a vertex that is not there";

fn wrong(number: usize, line: &str, what: &str) -> String {
    format!("line {}: {what}: `{}`", number + 1, line.trim())
}

/// False for places that are no numbers, or so far away that areas and volumes would be none.
pub(super) fn is_place(place: DVec3) -> bool {
    const FARTHEST_M: f64 = 1e30;
    place.is_finite() && place.abs().max_element() <= FARTHEST_M
}

/// Adds the triangles of a face; `None` if it crosses itself.
pub(super) fn cover(
    positions_m: &[DVec3],
    corners: &[u32],
    triangles: &mut Vec<[u32; 3]>,
) -> Option<()> {
    if let &[a, b, c] = corners {
        triangles.push([a, b, c]);
        return Some(());
    }
    // Some programs write triangles as quads with one corner twice.
    let mut corners = corners.to_vec();
    corners.dedup();
    while corners.len() > 3 && corners.first() == corners.last() {
        corners.pop();
    }
    if let [first] | [first, _] = corners[..] {
        // It has no area, which is refused where triangles are looked at.
        let last = corners[corners.len() - 1];
        triangles.push([first, first, last]);
        return Some(());
    }
    let places: Vec<DVec3> = corners.iter().map(|n| positions_m[*n as usize]).collect();
    let numbers = polygon::triangles(&places)?;
    triangles.extend(numbers.iter().map(|t| t.map(|k| corners[k])));
    Some(())
}

/// Node index of one corner of a face, `7`, `7/1`, `7//3`, `7/1/3` or, from the vertices so far, `-1`.
fn corner(word: &str, nodes: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 {
        (nodes as i64).checked_add(number)?
    } else {
        number - 1
    };
    u32::try_from(index).ok()
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
        // The quad is not plane, and cut along its shorter diagonal.
        assert_eq!(mesh.triangles, [[2, 1, 0], [2, 0, 3], [2, 4, 1]]);
    }

    /// A face with one or two different corners is a triangle without area, which those who look at triangles refuse.
    #[test]
    fn no_face_vanishes() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2 2\nf 2 2 2 2\n";
        let mesh = parse(text, 1.0).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 0, 1], [1, 1, 1]]);
    }

    #[test]
    fn faults_name_their_line() {
        for (text, part) in [
            ("v 0 0\n", "line 1"),
            ("v 0 0 0\nf 1 2 3\n", "line 2"),
            ("v 0 0 0\nf 1 -2 1\n", "line 2"),
            ("v 0 0 0\nf 1 0 1\n", "line 2"),
            ("v 0 0 nan\n", "not finite"),
            ("v 0 0 -1.#IND\n", "three numbers"),
            ("v 1,5 0 0\n", "three numbers"),
            ("v 0 0 0\nv 1 0 0\nf 1 2\n", "three vertices"),
            ("v 0 0 0\n", "no faces"),
            ("v 0 0 0\ncstype bspline\nsurf 0 1 0 1 1\n", "free-form"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n", "vertex 4"),
            (
                "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 2 0\n\nf 1 2 \\\n3 4\n",
                "line 6: a face crosses itself",
            ),
            ("v\0 \0", "not plain text"),
        ] {
            let error = parse(text, 1.0).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
